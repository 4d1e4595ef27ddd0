"""An IMU that prints lines, over UDP or a serial port: a yaw gyro alone, or with roll and pitch.

One reading a line, UTF-8::

    t_unix_s yaw_rate [roll pitch]

in s, rad/s, rad, about the IMU's own axes: z for the yaw rate; a vector of the IMU is turned into the
world's by roll about x first, then pitch about y, then yaw about z. ``nan`` stands for what is not known;
as a time it says that the sender has no clock, and the reading is of when it arrived. Lines that begin with
``#`` are for people.
"""

from math import isinf, isnan, nan, pi

from drivers.clock import Clock
from drivers.lines.receiver import LineReceiver, stamp_ns
from drivers.lines.sources import LineSource
from model.values.faults import Fault, FaultKind
from model.values.readings import ImuRecord

SOURCE = "imu"  # in faults
MOST_READINGS = 16  # in one read; of more the newest count
GYRO_ALONE, WITH_TILT = 2, 4  # words in a line
FASTEST_RAD_S = 35.0  # 2000 degrees a second, the range of a common chip
# A sound gyro has noise: so many equal readings in a row, over so long, are of one that is stuck.
STUCK_READINGS = 50
STUCK_S = 1.0
REPORT_NS = 1_000_000_000  # a trouble that lasts is reported this often


def parse_imu(line: str, offset_ns: int, now_ns: int) -> ImuRecord:
    """Read one line.

    Args:
        line: The line.
        offset_ns: UNIX time less the loop's clock.
        now_ns: The loop's clock, for a line without a time.

    Raises:
        ValueError: It makes no sense; says why.
    """
    words = line.split()
    if len(words) not in {GYRO_ALONE, WITH_TILT}:
        raise ValueError(f"{len(words)} numbers in place of {GYRO_ALONE} or {WITH_TILT}")
    time_s, *numbers = (float(word) for word in words)
    if any(isinf(number) for number in (time_s, *numbers)):
        raise ValueError("all numbers must be finite or nan")
    rate, roll, pitch = [*numbers, nan, nan][:3]
    if abs(rate) > FASTEST_RAD_S:
        raise ValueError(f"a yaw rate of {rate:g} rad/s; it has to be in rad/s")
    if abs(roll) > pi or abs(pitch) > pi:
        raise ValueError(f"roll {roll:g} and pitch {pitch:g} rad; they have to be in rad")
    t_ns = now_ns if isnan(time_s) else stamp_ns(words[0], offset_ns)
    return ImuRecord(t_ns, rate, roll, pitch)


def imu_line(record: ImuRecord, offset_ns: int) -> str:
    """Return a reading as a line, without its end; the other way round than ``parse_imu``."""
    seconds, nanoseconds = divmod(record.t_ns + offset_ns, 1_000_000_000)
    words = [f"{seconds}.{nanoseconds:09d}", repr(record.yaw_rate_rad_s)]
    if not (isnan(record.roll_rad) and isnan(record.pitch_rad)):
        words += [repr(record.roll_rad), repr(record.pitch_rad)]
    return " ".join(words)


class ImuListener:
    """Receives an IMU; never waits.

    Args:
        source: Where its lines come from.
        clock: The loop's clock.
        unix_ns: UNIX time at this moment.
        stale_s: Readings older than this are not used, and a silence of this length is a fault.
    """

    def __init__(self, source: LineSource, clock: Clock, unix_ns: int, stale_s: float) -> None:
        offset_ns = unix_ns - clock.now_ns()
        self._clock = clock
        self._stale_ns = round(stale_s * 1e9)
        self._lines = LineReceiver(
            source,
            lambda line: parse_imu(line, offset_ns, clock.now_ns()),
            clock,
            kind=FaultKind.IMU_BAD,
            name=SOURCE,
            most=MOST_READINGS,
        )
        self._newest_ns: int | None = None  # when the newest reading of use was measured
        self._since_ns: int | None = None  # when it was first asked
        self._reported_ns: dict[FaultKind, int] = {}
        self._same: tuple[float, ...] = ()
        self._same_count = 0
        self._same_ns = 0

    def read(self) -> tuple[tuple[ImuRecord, ...], tuple[Fault, ...]]:
        """Return the readings since the last read that are of use, and faults."""
        now_ns = self._clock.now_ns()
        first = self._since_ns is None
        if self._since_ns is None:
            self._since_ns = now_ns
        records, bad = self._lines.read()
        if first:  # what came while nobody listened is neither a fault nor of use
            bad = ()
        fresh = tuple(one for one in records if abs(now_ns - one.t_ns) <= self._stale_ns)
        stuck = [self._is_stuck(one) for one in fresh]
        usable = tuple(one for one, is_stuck in zip(fresh, stuck, strict=True) if not is_stuck)
        if usable:
            self._newest_ns = max(one.t_ns for one in usable)
        faults = [*bad]
        if True in stuck:
            words = f"{self._same_count} readings in a row are the same; it is stuck"
            faults.append(Fault(FaultKind.IMU_BAD, SOURCE, words))
        faults += self._silence(now_ns, records, fresh)
        return usable, tuple(fault for fault in faults if self._to_report(fault.kind, now_ns))

    def _silence(
        self, now_ns: int, records: tuple[ImuRecord, ...], fresh: tuple[ImuRecord, ...]
    ) -> list[Fault]:
        if fresh:
            return []
        if records:
            late_s = (now_ns - records[-1].t_ns) * 1e-9
            words = f"its newest reading is {late_s:.2g} s old; its clock and ours must agree"
            return [Fault(FaultKind.IMU_STALE, SOURCE, words)]
        since_ns = self._newest_ns if self._newest_ns is not None else self._since_ns
        assert since_ns is not None
        silent_ns = now_ns - since_ns
        if silent_ns <= self._stale_ns:
            return []
        never = "" if self._newest_ns is not None else ", and none ever came"
        return [
            Fault(FaultKind.IMU_STALE, SOURCE, f"no reading for {silent_ns * 1e-9:.1f} s{never}")
        ]

    def _is_stuck(self, record: ImuRecord) -> bool:
        values = (record.yaw_rate_rad_s, record.roll_rad, record.pitch_rad)
        if repr(values) != repr(self._same):  # NaN is like NaN here
            self._same, self._same_count, self._same_ns = values, 0, record.t_ns
        self._same_count += 1
        lasted_s = (record.t_ns - self._same_ns) * 1e-9
        return self._same_count > STUCK_READINGS and lasted_s > STUCK_S

    def _to_report(self, kind: FaultKind, now_ns: int) -> bool:
        """Whether a fault of this kind is due: a trouble that lasts is one a second, not one a tick."""
        last_ns = self._reported_ns.get(kind)
        if last_ns is not None and now_ns - last_ns < REPORT_NS:
            return False
        self._reported_ns[kind] = now_ns
        return True

    def close(self) -> None:
        """Give the source back."""
        self._lines.close()
