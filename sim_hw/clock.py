"""Virtual time: waiting takes none, and the same run takes the same time every time."""


class VirtualClock:
    """A clock that moves only when someone waits or a wire carries bytes.

    Args:
        start_ns: Time at the beginning.
    """

    def __init__(self, start_ns: int = 0) -> None:
        self._now_ns = start_ns

    def now_ns(self) -> int:
        """Return the virtual time."""
        return self._now_ns

    def sleep_until_ns(self, t_ns: int) -> None:
        """Jump to a time; nothing happens if it has passed."""
        self._now_ns = max(self._now_ns, t_ns)

    def advance(self, duration_ns: int) -> None:
        """Let time pass."""
        if duration_ns < 0:
            raise ValueError("time does not run backward")
        self._now_ns += duration_ns
