"""What enters the step in many ticks, as arrays: a row a tick."""

from collections.abc import Sequence
from dataclasses import dataclass

from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.readings import ImuRecord, PoseRecord, ServoReadings


@dataclass(frozen=True, slots=True, eq=False)
class ServoRows:
    """``ServoReadings`` of T ticks: times are (T,), all else (T, J)."""

    t_ns: IntArray
    position_ticks: IntArray
    velocity_counts: IntArray
    current_counts: IntArray
    duty_counts: IntArray
    voltage_counts: IntArray
    temperature_c: IntArray
    error_byte: IntArray
    hardware_error: IntArray
    valid: BoolArray
    age_ns: IntArray

    def readings(self, k: int) -> ServoReadings:
        """Return those of tick k."""
        rows = (getattr(self, name)[k] for name in ServoRows.__slots__[1:])
        return ServoReadings(int(self.t_ns[k]), *rows)


@dataclass(frozen=True, slots=True, eq=False)
class RequestRows:
    """The operator's wishes in T ticks: codes of their intents, (T,), their gaits, and (T,) numbers."""

    intent: IntArray
    frequency_hz: FloatArray
    steer: FloatArray
    gait: Sequence[str]


@dataclass(frozen=True, slots=True, eq=False)
class TimingRows:
    """``LoopTiming`` of T ticks, (T,) each."""

    deadline_ns: IntArray
    lateness_ns: IntArray
    missed: IntArray
    busy_ns: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class RecordRows:
    """The newest force record of T ticks.

    Attributes:
        there: Whether there is one, (T,).
        t_ns: Its time, (T,).
        counts: Of all transducers, (T, 6, 6).
        present: Which of them are in it, (T, 6).
        saturated: Which of them are saturated, (T, 6).
    """

    there: BoolArray
    t_ns: IntArray
    counts: IntArray
    present: BoolArray
    saturated: BoolArray


@dataclass(frozen=True, slots=True, eq=False)
class InputRows:
    """Inputs of T ticks. Rows of ticks that are not ``known`` mean nothing.

    Attributes:
        known: Of a usual form, with servos attached and without faults of drivers, (T,).
        t_ns: Times of the ticks, (T,).
        index: Their numbers, (T,).
        servos: What the servos reported.
        request: The operator's wishes.
        timing: Of the loop.
        records: Newest force records.
        poses: Absolute poses received, of each.
        imu: Readings of an inertial unit, of each.
        ends: Where the inputs end in each message, counted from behind the header.
    """

    known: BoolArray
    t_ns: IntArray
    index: IntArray
    servos: ServoRows
    request: RequestRows
    timing: TimingRows
    records: RecordRows
    poses: Sequence[tuple[PoseRecord, ...]]
    imu: Sequence[tuple[ImuRecord, ...]]
    ends: Sequence[int]

    def __len__(self) -> int:
        return len(self.known)
