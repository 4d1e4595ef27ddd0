"""Counts of what happened on the servo bus: the driver counts, everybody else gets a frozen copy."""

from bisect import bisect_right
from dataclasses import dataclass, field

# Upper edges of the round trip histogram [us]; one more class holds what is beyond the last.
ROUND_TRIP_EDGES_US = (500, 1000, 2000, 3000, 5000, 10_000, 20_000, 50_000)


@dataclass(frozen=True, slots=True)
class BusStats:
    """What happened on the bus since it was opened.

    Attributes:
        requests: Requests sent, of any kind.
        reads: Sync reads of all servos.
        timeouts: Answers that did not come in time, counted per servo.
        crc_errors: Damaged answers: wrong CRC, length or stuffing, or cut short.
        late_replies: Answers that came after their time was over, and were dropped.
        foreign_replies: Answers of a servo or of a length that nobody asked for, dropped.
        status_errors: Answers that report an error other than the alert bit.
        noise_bytes: Bytes outside any frame.
        round_trips: Complete sync reads per class of ``ROUND_TRIP_EDGES_US``.
        longest_round_trip_us: Longest complete sync read.
    """

    requests: int
    reads: int
    timeouts: int
    crc_errors: int
    late_replies: int
    foreign_replies: int
    status_errors: int
    noise_bytes: int
    round_trips: tuple[int, ...]
    longest_round_trip_us: int


@dataclass(slots=True)
class BusCounters:
    """The driver's own counters; see ``BusStats`` for what each counts."""

    requests: int = 0
    reads: int = 0
    timeouts: int = 0
    crc_errors: int = 0
    late_replies: int = 0
    foreign_replies: int = 0
    status_errors: int = 0
    noise_bytes: int = 0
    longest_round_trip_us: int = 0
    _round_trips: list[int] = field(default_factory=lambda: [0] * (len(ROUND_TRIP_EDGES_US) + 1))

    def note_round_trip(self, duration_ns: int) -> None:
        """Count one complete sync read."""
        duration_us = duration_ns // 1000
        self._round_trips[bisect_right(ROUND_TRIP_EDGES_US, duration_us)] += 1
        self.longest_round_trip_us = max(self.longest_round_trip_us, duration_us)

    def snapshot(self) -> BusStats:
        """Return the counts as they are now."""
        return BusStats(
            requests=self.requests,
            reads=self.reads,
            timeouts=self.timeouts,
            crc_errors=self.crc_errors,
            late_replies=self.late_replies,
            foreign_replies=self.foreign_replies,
            status_errors=self.status_errors,
            noise_bytes=self.noise_bytes,
            round_trips=tuple(self._round_trips),
            longest_round_trip_us=self.longest_round_trip_us,
        )
