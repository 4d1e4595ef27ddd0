"""Counts of what happened on the servo bus: the driver counts, everybody else gets a frozen copy."""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field, fields

# Upper edges of the round trip histogram [us]; one more class holds what is beyond the last.
ROUND_TRIP_EDGES_US = (500, 1000, 2000, 3000, 5000, 10_000, 20_000, 50_000)
# Upper edges of the jitter histogram [us], the same way.
JITTER_EDGES_US = (20, 50, 100, 200, 500, 1000, 2000, 5000, 10_000, 20_000)


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
        jitters: Sync reads per class of ``JITTER_EDGES_US``: by how much the time from one request
            to the next differed from the time before it. The first two reads have none.
        largest_jitter_us: Largest such difference.
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
    jitters: tuple[int, ...]
    largest_jitter_us: int

    @property
    def median_round_trip_us(self) -> int | None:
        """Upper edge of the class that the median round trip falls into; None without a read."""
        return share_below(self.round_trips, ROUND_TRIP_EDGES_US, 0.5, self.longest_round_trip_us)


def share_below(
    counts: Sequence[int], edges_us: Sequence[int], share: float, largest_us: int
) -> int | None:
    """Return a duration that a share of all counted ones does not exceed [us].

    Args:
        counts: Count of each class, one more than edges.
        edges_us: Upper edges.
        share: 0 to 1.
        largest_us: Largest duration counted; the answer for the open class.

    Returns:
        The upper edge of the class in question, None if nothing has been counted.
    """
    total, seen = sum(counts), 0
    for count, edge in zip(counts, (*edges_us, largest_us), strict=True):
        seen += count
        if total and seen >= share * total:
            return min(edge, largest_us)
    return None


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
    largest_jitter_us: int = 0
    round_trips: list[int] = field(default_factory=lambda: [0] * (len(ROUND_TRIP_EDGES_US) + 1))
    jitters: list[int] = field(default_factory=lambda: [0] * (len(JITTER_EDGES_US) + 1))
    _began_ns: int | None = None
    _interval_ns: int | None = None

    def note_begin(self, t_ns: int) -> None:
        """Take the time at which a sync read began."""
        if self._began_ns is not None:
            interval_ns = t_ns - self._began_ns
            if self._interval_ns is not None:
                jitter_us = abs(interval_ns - self._interval_ns) // 1000
                self.jitters[bisect_right(JITTER_EDGES_US, jitter_us)] += 1
                self.largest_jitter_us = max(self.largest_jitter_us, jitter_us)
            self._interval_ns = interval_ns
        self._began_ns = t_ns

    def note_round_trip(self, duration_ns: int) -> None:
        """Count one complete sync read."""
        duration_us = duration_ns // 1000
        self.round_trips[bisect_right(ROUND_TRIP_EDGES_US, duration_us)] += 1
        self.longest_round_trip_us = max(self.longest_round_trip_us, duration_us)

    def snapshot(self) -> BusStats:
        """Return the counts as they are now."""
        counts = {one.name: getattr(self, one.name) for one in fields(BusStats)}
        histograms = {"round_trips": tuple(self.round_trips), "jitters": tuple(self.jitters)}
        return BusStats(**counts | histograms)
