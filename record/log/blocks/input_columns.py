"""The inputs of many ticks as arrays, read from columns: what a controller is replayed from."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import readonly
from model.values.input_rows import InputRows, RecordRows, RequestRows, ServoRows, TimingRows
from model.values.readings import ImuRecord, PoseRecord
from record.log.blocks.message_form import Columns, in_order
from record.log.blocks.sensed_columns import records_of
from record.log.cdr import HEADER

_SERVOS = (
    "servos_t_ns", "position_ticks", "velocity_counts", "current_counts", "duty_counts",
    "voltage_counts", "servo_temperature_c", "error_byte", "hardware_error", "servo_valid",
    "servo_age_ns",
)  # fmt: skip
_REQUEST = ("request_intent", "request_frequency_hz", "request_steer")
_TIMING = ("deadline_ns", "lateness_ns", "missed", "busy_ns")
_RECORD = ("t_ns", "counts", "present", "saturated")
_NUMBER_BYTES, _COUNT_BYTES = 8, 4


def input_rows(count: int, groups: Sequence[tuple[list[int], Columns]]) -> InputRows | None:
    """Read the inputs of ticks as rows.

    Args:
        count: How many ticks.
        groups: Those of each usual form: their places, and they themselves.

    Returns:
        None if there are none of a usual form, or drivers found faults in all of these.
    """
    usual = [(at, columns) for at, columns in groups if not columns.form.counts["input_faults"]]
    if not usual:
        return None

    def together(*names: str) -> list[NDArray[Any]]:
        return [in_order(count, [(at, own.of(name)) for at, own in usual]) for name in names]

    known = np.zeros(count, dtype=bool)
    gaits, ends = [""] * count, [0] * count
    poses: list[tuple[PoseRecord, ...]] = [()] * count
    imu: list[tuple[ImuRecord, ...]] = [()] * count
    for places, columns in usual:
        known[places] = columns.of("servos_attached")
        seen, turned = (
            records_of(columns, "pose_records", PoseRecord),
            records_of(columns, "imu_records", ImuRecord),
        )
        end = _end(columns)
        for k, (place, gait) in enumerate(zip(places, _gaits(columns), strict=True)):
            gaits[place], poses[place], imu[place], ends[place] = gait, seen[k], turned[k], end
    t_ns, index = together("t_ns", "index")
    intent, frequency_hz, steer = together(*_REQUEST)
    return InputRows(
        known, t_ns, index, ServoRows(*together(*_SERVOS)),
        RequestRows(intent, frequency_hz, steer, gaits), TimingRows(*together(*_TIMING)),
        _records(count, usual), poses, imu, ends,
    )  # fmt: skip


def _gaits(columns: Columns) -> list[str]:
    """Names of the gaits that are wished: mostly the same in all ticks of a form."""
    texts = columns.of("request_gait")
    if (texts == texts[0]).all():
        return [bytes(texts[0])[:-1].decode()] * len(texts)
    return [bytes(text)[:-1].decode() for text in texts]


def _records(count: int, groups: Sequence[tuple[list[int], Columns]]) -> RecordRows:
    there, t_ns = np.zeros(count, dtype=bool), np.zeros(count, dtype=np.int64)
    counts = np.zeros((count, 6, 6), dtype=np.int64)
    present, saturated = np.zeros((2, count, 6), dtype=bool)
    for places, columns in groups:
        newest = columns.form.counts["force_records"] - 1
        if newest >= 0:
            t, own, one, other = (columns.of(f"force_records.{newest}.{name}") for name in _RECORD)
            there[places], t_ns[places], counts[places] = True, t, own.reshape(-1, 6, 6)
            present[places], saturated[places] = one, other
    rows = map(readonly, (there, t_ns, counts, present, saturated))
    return RecordRows(*rows)


def _end(columns: Columns) -> int:
    """Where the inputs end, counted from behind the header: with the last reading of the IMU."""
    form = columns.form
    if count := form.counts["imu_records"]:
        return form.places[f"imu_records.{count - 1}.pitch_rad"].at + _NUMBER_BYTES - len(HEADER)
    return form.begins["imu_records"] + _COUNT_BYTES
