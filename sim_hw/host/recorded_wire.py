"""Devices that answer with recorded bytes: hardware in the loop without hardware.

The traffic of a run lies on one tape, in the order in which it passed. Whoever sends must send what
lies next on the tape; whoever reads gets what was received then, in the same pieces, and the virtual
clock goes to the time at which it came. Order decides, not time, so that a computer that is faster or
slower than the recorded one makes no difference. Reads in vain lie on the tape too: that is how a
driver's giving up and an answer that came too late are kept apart.
"""

from collections.abc import Sequence

from drivers.dynamixel.port import ClockedPort
from model.errors import BigantError
from model.values.wire import Wire, WireBytes
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.port import IDLE_STEP_NS


class Diverged(BigantError):  # noqa: N818 - a finding, and no mistake
    """The driver sent something else than what was recorded.

    Args:
        recorded: What lies next on the tape, None at its end.
        sent: What the driver sent instead.
        place: Number of the piece on the tape.
    """

    def __init__(self, recorded: WireBytes | None, sent: WireBytes, place: int) -> None:
        super().__init__("the driver sends something else than what was recorded")
        self.recorded = recorded
        self.sent = sent
        self.place = place


class Tape:
    """The recorded traffic of all wires, played once.

    Args:
        pieces: The traffic, in its order.
        clock: Goes to the time of each piece that is played.
    """

    def __init__(self, pieces: Sequence[WireBytes], clock: VirtualClock) -> None:
        self.pieces = tuple(pieces)
        self.clock = clock
        self.place = 0
        self.skipped: list[WireBytes] = []

    @property
    def next(self) -> WireBytes | None:
        """What comes next, None at the end."""
        return self.pieces[self.place] if self.place < len(self.pieces) else None

    def incoming(self, wire: Wire) -> WireBytes | None:
        """Return the next piece if it was received on this wire."""
        piece = self.next
        return piece if piece is not None and piece.wire is wire and not piece.sent else None

    def pop(self) -> WireBytes:
        """Play the next piece; its time has come."""
        piece = self.pieces[self.place]
        self.place += 1
        self.clock.sleep_until_ns(piece.t_ns)
        return piece

    def sent(self, wire: Wire, data: bytes) -> None:
        """Take what a driver sends.

        Raises:
            Diverged: It is not what was recorded.
        """
        while (waiting := self.next) is not None and not waiting.sent:
            played = self.pop()
            if played.data:  # an answer that the driver did not wait for
                self.skipped.append(played)
        expected = self.next
        if expected is None or expected.wire is not wire or expected.data != data:
            raise Diverged(expected, WireBytes(self.clock.now_ns(), wire, True, data), self.place)
        self.pop()


class RecordedPort(ClockedPort):
    """A servo port that plays a tape."""

    def __init__(self, tape: Tape, baud_rate: int, latency_ms: float) -> None:
        super().__init__("the recorded bus", baud_rate, tape.clock)
        self.latency_ms = latency_ms
        self._tape = tape
        self._rest = b""

    def openPort(self) -> bool:  # noqa: N802 - the SDK's names
        """Open."""
        self.is_open = True
        return True

    def getBytesAvailable(self) -> int:  # noqa: N802
        """Return how many bytes were there to be read at this place of the tape."""
        piece = self._tape.incoming(Wire.SERVO_BUS)
        return len(self._rest) + (0 if piece is None else len(piece.data))

    def clearPort(self) -> None:  # noqa: N802
        """Drop what was left of a piece that has been read in part."""
        self._rest = b""

    def writePort(self, packet: bytes) -> int:  # noqa: N802
        """Send bytes: they must be the recorded ones.

        Raises:
            Diverged: They are not.
        """
        data = bytes(packet)
        self._tape.sent(Wire.SERVO_BUS, data)
        self.note("tx", data)
        return len(data)

    def readPort(self, length: int) -> bytes:  # noqa: N802
        """Return what this read gave then; after the last one in vain, let the timeout pass."""
        data = self._rest
        if not data:
            if self._tape.incoming(Wire.SERVO_BUS) is not None:
                data = self._tape.pop().data
            if not data and self._tape.incoming(Wire.SERVO_BUS) is None:
                # no more reads: the driver gave up here, if only a moment after the read was noted
                wait_ns = round(self.remaining_ms() * 1e6) + IDLE_STEP_NS
                self._tape.clock.advance(wait_ns)
        data, self._rest = data[:length], data[length:]
        self.note("rx", data)
        return data


class RecordedDatagrams:
    """``drivers.ati.links.DatagramLink`` that plays a tape."""

    def __init__(self, tape: Tape) -> None:
        self._tape = tape

    def send(self, data: bytes) -> None:
        """Send one datagram: it must be the recorded one."""
        self._tape.sent(Wire.FORCE_DATAGRAMS, data)

    def receive(self) -> list[tuple[int, bytes]]:
        """Return the datagrams that were received at this place of the tape."""
        arrived: list[tuple[int, bytes]] = []
        while self._tape.incoming(Wire.FORCE_DATAGRAMS) is not None:
            piece = self._tape.pop()
            arrived.append((piece.t_ns, piece.data))
        return arrived

    def close(self) -> None:
        """Nothing to give back."""


class RecordedText:
    """``drivers.ati.links.TextLink`` that plays a tape."""

    def __init__(self, tape: Tape) -> None:
        self._tape = tape

    def write(self, data: bytes) -> None:
        """Send bytes: they must be the recorded ones."""
        self._tape.sent(Wire.FORCE_CONSOLE, data)

    def read(self, timeout_s: float) -> bytes:
        """Return what this read gave then; where there was none, let the timeout pass."""
        if self._tape.incoming(Wire.FORCE_CONSOLE) is not None:
            return self._tape.pop().data
        self._tape.clock.advance(round(timeout_s * 1e9))
        return b""

    def close(self) -> None:
        """Nothing to give back."""
