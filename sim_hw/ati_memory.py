"""The virtual unit in memory: the real stream driver under a virtual clock, no sockets."""

from sim_hw.ati import VirtualWnet
from sim_hw.ati_console import ConsoleSession
from sim_hw.clock import VirtualClock


class MemoryDatagramLink:
    """``drivers.ati_links.DatagramLink`` to a virtual unit."""

    def __init__(self, unit: VirtualWnet, clock: VirtualClock) -> None:
        self._unit = unit
        self._clock = clock
        self._receiving = False

    def send(self, data: bytes) -> None:
        """Send one datagram."""
        if self._unit.handle_datagram(data, self._clock.now_ns()):
            self._receiving = True

    def receive(self) -> list[tuple[int, bytes]]:
        """Return what has arrived by now."""
        arrived = self._unit.poll(self._clock.now_ns())
        return arrived if self._receiving else []

    def close(self) -> None:
        """Nothing to give back."""


class MemoryTextLink:
    """``drivers.ati_links.TextLink`` to a virtual unit."""

    def __init__(self, unit: VirtualWnet, clock: VirtualClock) -> None:
        self._session = ConsoleSession(unit)
        self._clock = clock
        self._printed = bytearray(self._session.greeting())

    def write(self, data: bytes) -> None:
        """Send bytes."""
        self._printed += self._session.receive(data)

    def read(self, timeout_s: float) -> bytes:
        """Return what has been printed; takes the whole timeout when there is nothing."""
        if not self._printed:
            self._clock.advance(round(timeout_s * 1e9))
        data = bytes(self._printed)
        self._printed.clear()
        return data

    def close(self) -> None:
        """Nothing to give back."""
