"""The inputs of ticks, from which a replay begins, read from columns: as ``decode_inputs`` has them."""

from collections.abc import Iterable, Iterator, Sequence

from model.values.faults import StopReason
from model.values.readings import ForceRecord, ImuRecord, PoseRecord, ServoReadings
from model.values.tick import Inputs, Intent, LoopTiming, Request
from record.log.blocks.message_form import Columns
from record.log.blocks.tick_columns import records_of
from record.log.cdr import HEADER
from record.log.tick_message import TickInputs

_SERVOS = (
    "position_ticks", "velocity_counts", "current_counts", "duty_counts", "voltage_counts",
    "servo_temperature_c", "error_byte", "hardware_error", "servo_valid", "servo_age_ns",
)  # fmt: skip
_NUMBER_BYTES, _COUNT_BYTES = 8, 4


def inputs_of(columns: Columns) -> list[TickInputs] | None:
    """Return time, number and inputs of each tick, without the truth; None where drivers found faults.

    Args:
        columns: Ticks of one form.
    """
    if columns.form.counts["input_faults"]:
        return None
    end = _end(columns)
    rows = zip(
        columns.of("t_ns").tolist(), columns.of("index").tolist(), _servos(columns), _forces(columns),
        _requests(columns), _timing(columns), records_of(columns, "pose_records", PoseRecord),
        records_of(columns, "imu_records", ImuRecord), strict=True,
    )  # fmt: skip
    return [
        TickInputs(
            t_ns, index, Inputs(servos, forces, request, timing, None, (), poses, imu=imu), end
        )
        for t_ns, index, servos, forces, request, timing, poses, imu in rows
    ]


def _end(columns: Columns) -> int:
    """Where the inputs end, counted from behind the header: with the last reading of the IMU."""
    form = columns.form
    if count := form.counts["imu_records"]:
        return form.places[f"imu_records.{count - 1}.pitch_rad"].at + _NUMBER_BYTES - len(HEADER)
    return form.begins["imu_records"] + _COUNT_BYTES


def _servos(columns: Columns) -> Iterator[ServoReadings | None]:
    attached, t_ns = columns.of("servos_attached").tolist(), columns.of("servos_t_ns").tolist()
    for there, now_ns, row in zip(
        attached, t_ns, zip(*map(columns.of, _SERVOS), strict=True), strict=True
    ):
        yield ServoReadings(now_ns, *row) if there else None


def _forces(columns: Columns) -> Sequence[tuple[ForceRecord, ...]]:
    records = records_of(columns, "force_records", ForceRecord)
    shaped = (
        tuple(
            ForceRecord(
                one.t_ns, one.device_ticks, one.sequence, one.status, one.battery, one.mask,
                one.counts.reshape(-1, 6), one.present, one.saturated,
            )
            for one in own
        )
        for own in records
    )  # fmt: skip
    return list(shaped)


def _requests(columns: Columns) -> Iterable[Request]:
    """The operator's wishes: the same for seconds, so that each is made once."""
    known: dict[tuple[int, bytes, float, float, int], Request] = {}
    gaits: Iterable[bytes] = map(bytes, columns.of("request_gait"))
    fields = (
        columns.of("request_intent").tolist(), gaits, columns.of("request_frequency_hz").tolist(),
        columns.of("request_steer").tolist(), columns.of("request_reason").tolist(),
    )  # fmt: skip
    for row in zip(*fields, strict=True):
        if row not in known:
            intent, gait, frequency_hz, steer, reason = row
            known[row] = Request(
                Intent(intent), gait[:-1].decode(), frequency_hz, steer, StopReason(reason)
            )
        yield known[row]


def _timing(columns: Columns) -> Iterator[LoopTiming]:
    names = ("deadline_ns", "lateness_ns", "missed", "busy_ns")
    for row in zip(*(columns.of(name).tolist() for name in names), strict=True):
        yield LoopTiming(*row)
