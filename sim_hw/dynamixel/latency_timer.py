"""A USB adapter that hands replies over when its latency timer says so, as FTDI chips do.

The chip keeps what it receives until 62 bytes are there or its timer runs out; 16 ms is the usual setting,
1 ms a good one. The timer is taken for a free-running grid (assumed).
"""

from collections import deque

from model.errors import ConnectionLost
from sim_hw.interfaces import ServoWire

PACKET_BYTES = 62


class LatencyTimer:
    """``sim_hw.interfaces.ServoWire`` behind an adapter.

    Args:
        wire: The wire.
        period_s: The timer.
    """

    def __init__(self, wire: ServoWire, period_s: float) -> None:
        self._wire = wire
        self._period_ns = round(period_s * 1e9)
        self._kept = bytearray()
        self._flush_ns = 0  # when what is kept goes to the host
        self._ready: deque[tuple[int, bytes]] = deque()

    def poll(self, t_ns: int) -> None:
        """Let time pass."""
        self._wire.poll(t_ns)

    def receive(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        """Take bytes from the host; they are not delayed."""
        self._wire.receive(data, t_ns, baud_rate)

    def next_reply_ns(self) -> int | None:
        """When there may be something to read."""
        if self._ready:
            return self._ready[0][0]
        times = [self._wire.next_reply_ns(), self._flush_ns if self._kept else None]
        return min((t for t in times if t is not None), default=None)

    def replies(self, t_ns: int) -> bytes:
        """Return what the adapter has handed over by a time.

        Raises:
            ConnectionLost: The adapter is unplugged; what it kept is gone.
        """
        try:
            self._collect(t_ns)
        except ConnectionLost:
            self._kept.clear()
            self._ready.clear()
            raise
        handed = bytearray()
        while self._ready and self._ready[0][0] <= t_ns:
            handed += self._ready.popleft()[1]
        return bytes(handed)

    def _collect(self, t_ns: int) -> None:
        while (due_ns := self._wire.next_reply_ns()) is not None and due_ns <= t_ns:
            self._take(self._wire.replies(due_ns), due_ns)
        self._take(self._wire.replies(t_ns), t_ns)
        if self._kept and self._flush_ns <= t_ns:
            self._flush(len(self._kept), self._flush_ns)

    def _take(self, data: bytes, t_ns: int) -> None:
        if not data:
            return
        if self._kept and self._flush_ns <= t_ns:
            self._flush(len(self._kept), self._flush_ns)
        if not self._kept:
            self._flush_ns = -(-t_ns // self._period_ns) * self._period_ns
        self._kept += data
        while len(self._kept) >= PACKET_BYTES:
            self._flush(PACKET_BYTES, t_ns)

    def _flush(self, count: int, t_ns: int) -> None:
        self._ready.append((t_ns, bytes(self._kept[:count])))
        del self._kept[:count]
