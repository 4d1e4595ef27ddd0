"""One clock for everything that waits, so that tests and virtual hardware can own time."""

import time
from typing import Protocol


class Clock(Protocol):
    """Monotonic time in integer nanoseconds, and the only way to wait."""

    def now_ns(self) -> int:
        """Return the time now."""
        ...

    def sleep_until_ns(self, t_ns: int) -> None:
        """Return once ``now_ns() >= t_ns``; at once if that is already so."""
        ...


class MonotonicClock:
    """The machine's monotonic clock: it never steps, whatever NTP does."""

    def now_ns(self) -> int:
        """Return ``CLOCK_MONOTONIC``."""
        return time.monotonic_ns()

    def sleep_until_ns(self, t_ns: int) -> None:
        """Sleep to an absolute deadline (``time.sleep`` uses clock_nanosleep from 3.11 on)."""
        while (left := t_ns - time.monotonic_ns()) > 0:
            time.sleep(left * 1e-9)
