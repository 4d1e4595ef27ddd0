"""Listening in on the wires of both devices, below the drivers: bytes, direction, time.

A read that waited in vain is noted as well, as no bytes: a replay has to know when a driver gave up. A
tap only appends to a list, so it costs a microsecond a piece and does not change the bytes.
"""

from collections import deque
from typing import Generic, TypeVar

from drivers.ati.links import DatagramLink, TextLink
from drivers.clock import Clock
from drivers.dynamixel.port import ClockedPort
from model.values.wire import Wire, WireBytes


class WireTap:
    """Collects what passes on all wires, in the order in which it passed."""

    def __init__(self) -> None:
        self._heard: deque[WireBytes] = deque()  # the force unit is repaired in another thread

    def listen(self, port: ClockedPort) -> None:
        """Listen to a servo port from now on."""
        port.tap = self._on_bus

    def _on_bus(self, direction: str, data: bytes, t_ns: int) -> None:
        self.note(WireBytes(t_ns, Wire.SERVO_BUS, direction == "tx", data))

    def note(self, heard: WireBytes) -> None:
        """Take one piece."""
        self._heard.append(heard)

    def take(self) -> tuple[WireBytes, ...]:
        """Return what was recorded since the last call, oldest first."""
        return tuple(self._heard.popleft() for _ in range(len(self._heard)))


Link = TypeVar("Link", DatagramLink, TextLink)


class _Tapped(Generic[Link]):
    """A link with a tap on it.

    Args:
        link: The link.
        tap: Where its traffic is noted.
        clock: Clock that stamps it, except for datagrams that arrive: those carry their stamp.
    """

    def __init__(self, link: Link, tap: WireTap, clock: Clock) -> None:
        self._link: Link = link
        self._tap = tap
        self._clock = clock

    def _note(self, wire: Wire, sent: bool, data: bytes) -> None:
        self._tap.note(WireBytes(self._clock.now_ns(), wire, sent, data))

    def close(self) -> None:
        """Close the link."""
        self._link.close()


class TappedDatagrams(_Tapped[DatagramLink]):
    """A ``DatagramLink`` with a tap on it."""

    def send(self, data: bytes) -> None:
        """Send one datagram."""
        self._note(Wire.FORCE_DATAGRAMS, True, data)
        self._link.send(data)

    def receive(self) -> list[tuple[int, bytes]]:
        """Return what has arrived."""
        arrived = self._link.receive()
        for t_ns, data in arrived:
            self._tap.note(WireBytes(t_ns, Wire.FORCE_DATAGRAMS, False, data))
        return arrived


class TappedText(_Tapped[TextLink]):
    """A ``TextLink`` with a tap on it."""

    def write(self, data: bytes) -> None:
        """Send bytes."""
        self._note(Wire.FORCE_CONSOLE, True, data)
        self._link.write(data)

    def read(self, timeout_s: float) -> bytes:
        """Return what has arrived."""
        data = self._link.read(timeout_s)
        self._note(Wire.FORCE_CONSOLE, False, data)
        return data
