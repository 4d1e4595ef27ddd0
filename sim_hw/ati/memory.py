"""The virtual unit in memory: the real stream driver under a virtual clock, no sockets."""

from sim_hw.ati.console import open_console
from sim_hw.ati.unit import WnetWire
from sim_hw.clock import VirtualClock

LOCAL_PORT = 49152  # that the unit sees commands come from


class MemoryDatagramLink:
    """``drivers.ati.links.DatagramLink`` to a virtual unit.

    Args:
        unit: The unit, or the wire to it.
        clock: The virtual clock that both live by.
    """

    def __init__(self, unit: WnetWire, clock: VirtualClock) -> None:
        self._unit = unit
        self._clock = clock
        self._receiving = False

    def send(self, data: bytes) -> None:
        """Send one datagram."""
        if self._unit.command(data, self._clock.now_ns(), LOCAL_PORT):
            self._receiving = True

    def receive(self) -> list[tuple[int, bytes]]:
        """Return what has arrived by now."""
        arrived = self._unit.poll(self._clock.now_ns())
        return arrived if self._receiving else []

    def close(self) -> None:
        """Nothing to give back."""


class MemoryTextLink:
    """``drivers.ati.links.TextLink`` to a virtual unit."""

    def __init__(self, unit: WnetWire, clock: VirtualClock) -> None:
        self._console = open_console(unit)
        self._clock = clock

    def write(self, data: bytes) -> None:
        """Send bytes."""
        self._console.give(data, self._clock.now_ns())

    def read(self, timeout_s: float) -> bytes:
        """Return what has been printed; lets time pass until there is something or it is over."""
        over_ns = self._clock.now_ns() + round(timeout_s * 1e9)
        while not (data := self._console.take(self._clock.now_ns())):
            due_ns = self._console.next_due_ns()
            now_ns = self._clock.now_ns()
            if now_ns >= over_ns:
                return b""
            # a session that says "now" and has nothing gets a moment rather than a busy loop
            next_ns = over_ns if due_ns is None else max(due_ns, now_ns + 1000)
            self._clock.sleep_until_ns(min(next_ns, over_ns))
        return data

    def close(self) -> None:
        """Nothing to give back."""
