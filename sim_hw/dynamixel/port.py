"""An in-memory port for the SDK under a virtual clock: the real driver, no waiting.

Writing takes the wire time of the bytes; reading jumps to the next byte due, or to the end of the
timeout when nobody will answer. So a silent servo costs its full timeout in virtual time and next to
nothing in ours.
"""

from drivers.dynamixel.port import ClockedPort
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.interfaces import ServoWire

LATENCY_MS = 1.0
# What the SDK's own busy-wait loops let pass between two looks.
IDLE_STEP_NS = 100_000


class MemoryPort(ClockedPort):
    """A port with a virtual servo bus at its other end.

    Args:
        bus: The virtual bus.
        clock: The virtual clock that both live by.
        baud_rate: Baud rate of this end.
        latency_timer_s: Latency timer of the adapter as the system reports it, 0 if it has none.
    """

    def __init__(
        self,
        bus: ServoWire,
        clock: VirtualClock,
        baud_rate: int,
        latency_timer_s: float = 0.0,
    ) -> None:
        super().__init__("memory", baud_rate, clock)
        self._bus = bus
        self._virtual = clock
        self._received = b""
        self.latency_ms = LATENCY_MS
        if latency_timer_s > 0:
            self.latency_ms = self.latency_timer_ms = 1e3 * latency_timer_s

    def openPort(self) -> bool:  # noqa: N802 - the SDK's names
        """Open; what came while nobody listened is gone.

        Raises:
            ConnectionLost: The cable is out.
        """
        self._bus.replies(self._virtual.now_ns())
        self._received = b""
        self.is_open = True
        return True

    def getBytesAvailable(self) -> int:  # noqa: N802
        """Return how many bytes have arrived."""
        self._arrive()
        return len(self._received)

    def clearPort(self) -> None:  # noqa: N802
        """Drop what has arrived."""
        self._arrive()
        self._received = b""

    def writePort(self, packet: bytes) -> int:  # noqa: N802
        """Send bytes; takes their wire time."""
        data = bytes(packet)
        self._virtual.advance(round(len(data) * self.tx_time_per_byte * 1e6))
        self.note("tx", data)
        self._bus.receive(data, self._virtual.now_ns(), self.baudrate)
        return len(data)

    def readPort(self, length: int) -> bytes:  # noqa: N802
        """Return up to ``length`` bytes, letting time pass until there are some or it is over."""
        bus, clock = self._bus, self._virtual
        now_ns = clock.now_ns()
        arrived = self._received + bus.replies(now_ns)
        if not arrived:
            over_ns = now_ns + round(self.remaining_ms() * 1e6) + IDLE_STEP_NS
            due_ns = bus.next_reply_ns()
            clock.sleep_until_ns(over_ns if due_ns is None else min(due_ns, over_ns))
            now_ns = clock.now_ns()
            bus.poll(now_ns)
            arrived = bus.replies(now_ns)
        data, self._received = arrived[:length], arrived[length:]
        self.note("rx", data)
        return data

    def readAnswers(self, count: int, size: int) -> bytes:  # noqa: N802
        """Read the same at once, where all of them are under way and nobody listens to the pieces."""
        bus, clock = self._bus, self._virtual
        if self.tap is None and not self._received and isinstance(bus, VirtualServoBus):
            until_ns = clock.now_ns() + int(self.remaining_ms() * 1e6)
            data = bus.all_replies(count, size, clock, until_ns)
            if data is not None:
                self.note("rx", data)
                return data
        return super().readAnswers(count, size)

    def _arrive(self) -> None:
        self._received += self._bus.replies(self._virtual.now_ns())
