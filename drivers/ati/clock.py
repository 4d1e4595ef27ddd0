"""From the unit's time stamps to the host's clock: offset and drift under a delay that varies.

Nothing but the records themselves tells about the unit's clock, and each comes with an unknown delay in
the air. Delays are never negative, so the host's receive times lie above a line, and the line is the
unit's clock plus the shortest delay there is (which nobody can see: it stays in the offset). The line
taken is the edge, under the middle of the data, of the lower convex hull of receive time against stamp;
of all lines below the points it is the nearest to them (Moon, Skelly and Towsley, INFOCOM 1999).

Only the lowest point of every second is kept, for ``WINDOW`` seconds: bounded memory, whatever the run.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from drivers.ati.packets import TICKS_PER_SECOND, U32

BUCKET_NS = 1_000_000_000
WINDOW = 128  # buckets
# A receive time this far below the line: the unit's clock was set forward.
EARLY_NS = 50_000_000
# Receive times above the line by this for so long and so many records: it was set back.
LATE_NS = 100_000_000
LATE_SPAN_NS = 2_000_000_000
LATE_RECORDS = 50
# Drift is told apart from jitter only over a while, and is never more than a bad quartz.
DRIFT_SPAN_NS = 10_000_000_000
LARGEST_DRIFT = 500e-6


@dataclass(frozen=True, slots=True)
class ClockEstimate:
    """How the unit's clock stands to the host's.

    Attributes:
        offset_ns: Host time less device time of the newest record, shortest delay included.
        drift_ppm: What the host's clock gains on the unit's, parts per million; NaN until
            ``DRIFT_SPAN_NS`` have been seen.
        jitter_ns: Mean delay beyond the shortest, over the last second.
        records: Records used since the last step.
        steps: Times the unit's clock was set, or the unit restarted.
        rollovers: Times the stamp wrapped.
    """

    offset_ns: int
    drift_ppm: float
    jitter_ns: float
    records: int
    steps: int
    rollovers: int


class DeviceClock:
    """Maps stamps to host time."""

    def __init__(self) -> None:
        self.steps = 0
        self.rollovers = 0
        self._begin()

    def _begin(self) -> None:
        self._first_ticks = 0
        self._ticks: int | None = None  # newest stamp, unwrapped
        self._first_host_ns = 0
        self._lowest: deque[tuple[int, int]] = deque(maxlen=WINDOW)  # device ns, host less device
        self._bucket = -1
        self._line = (0, 0.0, 0.0)  # device ns where it holds, level [ns], slope
        self._late_since_ns: int | None = None
        self._late_count = 0
        self._jitter_ns = float("nan")
        self._records = 0

    def add(self, device_ticks: int, host_ns: int) -> None:
        """Take a fresh record's stamp and the host time of its reception.

        Args:
            device_ticks: Stamp, 1/4096 s, u32.
            host_ns: Monotonic host time.
        """
        device_ns = self._unwrap(device_ticks, host_ns)
        gap_ns = host_ns - self._first_host_ns - device_ns
        if self._records and self._stepped(gap_ns - self._level(device_ns), host_ns):
            self.steps += 1
            self._begin()
            device_ns = self._unwrap(device_ticks, host_ns)
            gap_ns = 0
        self._keep(device_ns, gap_ns)
        excess = gap_ns - self._level(device_ns)
        share = 0.01 if self._records else 1.0
        before = self._jitter_ns if self._records else 0.0
        self._jitter_ns = before + share * (max(excess, 0.0) - before)
        self._records += 1

    def restart(self) -> None:
        """Forget everything: the unit has restarted."""
        self.steps += 1
        self._begin()

    def _unwrap(self, device_ticks: int, host_ns: int) -> int:
        if self._ticks is None:
            self._first_ticks = self._ticks = device_ticks
            self._first_host_ns = host_ns
        step = (device_ticks - self._ticks + U32 // 2) % U32 - U32 // 2
        reached = self._ticks + step
        if reached // U32 > self._ticks // U32:
            self.rollovers += 1
        self._ticks = reached
        return self._since_first_ns(reached)

    def _since_first_ns(self, ticks: int) -> int:
        return (ticks - self._first_ticks) * 1_000_000_000 // TICKS_PER_SECOND

    def _host_ns(self, ticks: int) -> int:
        device_ns = self._since_first_ns(ticks)
        return self._first_host_ns + device_ns + round(self._level(device_ns))

    def _stepped(self, excess_ns: float, host_ns: int) -> bool:
        if excess_ns < -EARLY_NS:
            return True
        if excess_ns < LATE_NS:
            self._late_since_ns, self._late_count = None, 0
            return False
        if self._late_since_ns is None:
            self._late_since_ns = host_ns
        self._late_count += 1
        return host_ns - self._late_since_ns >= LATE_SPAN_NS and self._late_count >= LATE_RECORDS

    def _keep(self, device_ns: int, gap_ns: int) -> None:
        bucket = device_ns // BUCKET_NS
        if bucket != self._bucket:
            self._bucket = bucket
            self._lowest.append((device_ns, gap_ns))
        elif gap_ns < self._lowest[-1][1]:
            self._lowest[-1] = (device_ns, gap_ns)
        else:
            return
        self._line = _line_below(self._lowest)

    def _level(self, device_ns: int) -> float:
        at_ns, level, slope = self._line
        return level + slope * (device_ns - at_ns)

    def host_ns(self, device_ticks: int) -> int | None:
        """Return the host time of a stamp near the newest one; None before the first record.

        It is later than the true time of the sample by the shortest delay, which cannot be seen.
        """
        if self._ticks is None or not self._records:
            return None
        step = (device_ticks - self._ticks + U32 // 2) % U32 - U32 // 2
        return self._host_ns(self._ticks + step)

    def estimate(self) -> ClockEstimate | None:
        """Return offset and drift as known now; None before the first record."""
        if self._ticks is None or not self._records:
            return None
        span_ns = self._lowest[-1][0] - self._lowest[0][0]
        stamp_ns = self._ticks * 1_000_000_000 // TICKS_PER_SECOND
        return ClockEstimate(
            offset_ns=self._host_ns(self._ticks) - stamp_ns,
            drift_ppm=self._line[2] * 1e6 if span_ns >= DRIFT_SPAN_NS else float("nan"),
            jitter_ns=self._jitter_ns,
            records=self._records,
            steps=self.steps,
            rollovers=self.rollovers,
        )


def _line_below(points: deque[tuple[int, int]]) -> tuple[int, float, float]:
    """Return a point and the slope of the hull edge under the middle of the points."""
    hull: list[tuple[int, int]] = []
    for point in points:
        while len(hull) >= 2 and _above(hull[-2], hull[-1], point):
            hull.pop()
        hull.append(point)
    if hull[-1][0] - hull[0][0] < DRIFT_SPAN_NS:
        lowest = min(points, key=lambda point: point[1])
        return lowest[0], float(lowest[1]), 0.0
    middle = sum(point[0] for point in points) / len(points)
    right = next(i for i in range(1, len(hull)) if hull[i][0] >= middle)
    (x0, y0), (x1, y1) = hull[right - 1], hull[right]
    slope = float(np.clip((y1 - y0) / (x1 - x0), -LARGEST_DRIFT, LARGEST_DRIFT))
    return x0, float(y0), slope


def _above(a: tuple[int, int], b: tuple[int, int], c: tuple[int, int]) -> bool:
    """Whether b lies on or above the line from a to c."""
    return (b[1] - a[1]) * (c[0] - a[0]) >= (c[1] - a[1]) * (b[0] - a[0])
