"""Ticks of a log as the arrays of a recording, without taking each message apart.

What comes out is what ``build_recording`` makes of the same ticks, to the bit. Ticks of older layouts, of a
rare form or with anything unusual in them are taken apart one by one.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from types import MappingProxyType
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import BoolArray
from model.values.faults import Fault, FaultKind
from model.values.legs import FootForces, JointState
from model.values.machine_names import MachineNames
from model.values.readings import ImuRecord, PoseRecord
from model.values.tick import SensedTick
from record.log.blocks.message_form import Columns, form_of
from record.log.blocks.tick_forms import TICK, FormBook
from record.log.reader import TopicMessage
from record.log.recording import STACKS
from record.log.salvage import DAMAGE
from record.log.tick_message import LAYOUT, TICK_DEFINITIONS, decode_tick

_DIAGONAL = [0, 2, 5]  # of a covariance whose lower half is kept row by row
_JOINTS = (
    "angle_rad",
    "rate_rad_s",
    "current_a",
    "duty",
    "voltage_v",
    "temperature_c",
    "joints_valid",
)
Take = Callable[[Columns], NDArray[Any]]
T = TypeVar("T")


@dataclass(frozen=True, slots=True, eq=False)
class StackedTicks:
    """Ticks as arrays.

    Attributes:
        arrays: By the field of ``Recording``, a row for each tick that could be read.
        kept: Which messages could be read.
        faults: Row, and fault; in order.
        broken: Which messages could not be read, and why.
        sensed: What was sensed in each tick that could be read, if that was asked for.
    """

    arrays: Mapping[str, NDArray[Any]]
    kept: BoolArray
    faults: tuple[tuple[int, Fault], ...]
    broken: tuple[tuple[int, Exception], ...]
    sensed: tuple[SensedTick, ...] = ()


def _of(name: str) -> Take:
    return lambda columns: columns.of(name)


def _rows(name: str, width: int) -> Take:
    """A field of each foot, (B, N, width)."""
    return lambda columns: _feet(columns.of(name), width)


def _feet(values: NDArray[Any], width: int) -> NDArray[Any]:
    return values.reshape(len(values), values.shape[1] // width, width)


def _beside(*parts: Callable[[Columns], NDArray[Any]]) -> Take:
    """Single numbers beside each other, (B, n)."""
    return lambda columns: np.column_stack([part(columns) for part in parts])


def _part(name: str, *which: int) -> Take:
    return lambda columns: columns.of(name)[:, which]


def _seconds(name: str) -> Take:
    return lambda columns: columns.of(name) * 1e-9


def _estimated(take: Take) -> Take:
    """What the estimator says; without it there is nothing to take."""
    return lambda c: take(c) if c.form.counts["estimate"] else np.empty(0)


def _true(take: Take) -> Take:
    """The truth where it is known, else NaN."""

    def known(columns: Columns) -> NDArray[Any]:
        values, there = take(columns), columns.of("truth_known")
        if not there.all():
            values = np.where(there.reshape(-1, *[1] * (values.ndim - 1)), values, np.nan)
        return values

    return known


def _imu(columns: Columns) -> NDArray[Any]:
    count = columns.form.counts["imu_records"]
    if not count:
        return np.empty(0)
    newest = f"imu_records.{count - 1}"
    names = ("yaw_rate_rad_s", "roll_rad", "pitch_rad")
    return np.column_stack([columns.of(f"{newest}.{name}") for name in names])


_PLANAR = "estimate.0.planar"
# By the field of ``Recording``. Nothing to take, an empty array, leaves what is absent.
TAKEN: Mapping[str, Take] = MappingProxyType({
    "mode": _of("mode"),
    "stop_reason": _of("stop_reason"),
    "gait_phase": _of("gait_phase"),
    "angle_rad": _of("angle_rad"),
    "rate_rad_s": _of("rate_rad_s"),
    "current_a": _of("current_a"),
    "temperature_c": _of("temperature_c"),
    "sent_angle_rad": _of("sent_angle_rad"),
    "force_n": _rows("force_n", 3),
    "predicted_force_n": _rows("force_b", 3),
    "predicted_velocity_B": _of("velocity_b"),
    "predicted_slip_B": _rows("slip_b", 2),
    "dead_reckoning_pose": _beside(
        _of("dead_reckoning_position_m"), _of("dead_reckoning_yaw_rad")
    ),
    "estimate_pose": _estimated(_part(_PLANAR, 0, 1, 2)),
    "estimate_pose_sd": _estimated(
        lambda columns: np.sqrt(columns.of("estimate.0.pose_covariance")[:, _DIAGONAL])
    ),
    "estimate_velocity_B": _estimated(_part(_PLANAR, 3, 4, 5)),
    "estimate_force_n": _estimated(_rows("estimate.0.force_b", 3)),
    "estimate_health": _estimated(_of("estimate.0.health")),
    "gyro_bias": _estimated(
        _beside(_of("estimate.0.gyro_bias"), _of("estimate.0.gyro_bias_sd"))
    ),
    "imu": _imu,
    "truth_position_W": _true(_of("truth_position_w")),
    "truth_quaternion_xyzw": _true(_of("truth_quaternion_xyzw")),
    "truth_velocity_B": _true(
        _beside(_part("truth_velocity_b", 0, 1), _part("truth_angular_velocity_b", 2))
    ),
    "truth_foot_velocity_W": _true(_rows("truth_foot_velocity_w", 3)),
    "truth_force_n": _true(_rows("truth_foot_force_b", 3)),
    "truth_contact": lambda columns: columns.of("truth_contact") & columns.of("truth_known")[:, None],
    "lateness_s": _seconds("lateness_ns"),
    "busy_s": _seconds("busy_ns"),
    "missed": _of("missed"),
})  # fmt: skip


def stack_messages(
    messages: Sequence[TopicMessage],
    machine: MachineNames,
    book: FormBook,
    *,
    with_sensed: bool = False,
) -> StackedTicks:
    """Stack the ticks in messages into arrays.

    Args:
        messages: The ticks.
        machine: Names of joints and legs.
        book: Forms met so far in this log; learns new ones.
        with_sensed: Whether to return what was sensed, too.
    """
    legs, joints = len(machine.legs), len(machine.joints)
    arrays = {name: stack.empty(len(messages), legs, joints) for name, stack in STACKS.items()}
    left = np.ones(len(messages), dtype=bool)
    sensed: dict[int, SensedTick] = {}
    faults: list[tuple[int, tuple[Fault, ...]]] = []
    if all(message.layout == LAYOUT for message in messages):
        for places, columns in book.groups([message.data for message in messages], machine):
            left[places] = False
            faults += zip(places.tolist(), _faults(columns), strict=True)
            if with_sensed:
                sensed.update(zip(places.tolist(), _sensed(columns), strict=True))
            for name, take in TAKEN.items():
                values = take(columns)
                if values.size:
                    arrays[name][places] = values
    alone, ticks, broken = [], [], []
    for place in np.flatnonzero(left).tolist():
        try:
            ticks.append(decode_tick(messages[place].data, messages[place].layout))
        except DAMAGE as error:
            broken.append((place, error))
        else:
            alone.append(place)
    if with_sensed:
        sensed.update(zip(alone, (tick.sensed for tick in ticks), strict=True))
    if ticks:
        for name, stack in STACKS.items():
            arrays[name][alone] = stack.of(ticks, legs, joints)
    kept = np.ones(len(messages), dtype=bool)
    kept[[place for place, _ in broken]] = False
    faults += zip(alone, (tick.faults for tick in ticks), strict=True)
    row = (np.cumsum(kept) - 1).tolist()
    in_row = tuple(
        (row[place], fault) for place, own in sorted(faults, key=itemgetter(0)) for fault in own
    )
    if broken:
        arrays = {name: values[kept] for name, values in arrays.items()}
    in_order = tuple(tick for _, tick in sorted(sensed.items()))
    return StackedTicks(arrays, kept, in_row, tuple(broken), in_order)


class SensedMessage(NamedTuple):
    """What an estimator needs of a tick's message.

    Attributes:
        number: That of the tick.
        tick: What was sensed in it.
        estimate_at: Where its estimate begins, counted from behind the header.
    """

    number: int
    tick: SensedTick
    estimate_at: int


def sensed_messages(
    messages: Sequence[bytes], machine: MachineNames, book: FormBook
) -> list[SensedMessage]:
    """Return what was sensed in ticks of today's layout.

    Args:
        messages: The ticks.
        machine: Names of joints and legs.
        book: Forms met so far in this log; learns new ones.

    Raises:
        ValueError: One is damaged.
    """
    sensed: dict[int, SensedMessage] = {}
    for places, columns in book.groups(messages, machine):
        index, begin = columns.of("index").tolist(), columns.form.begins["estimate"]
        for place, number, tick in zip(places.tolist(), index, _sensed(columns), strict=True):
            sensed[place] = SensedMessage(number, tick, begin)
    for place, data in enumerate(messages):
        if place not in sensed:
            whole, form = decode_tick(data), form_of(data, TICK_DEFINITIONS, TICK)
            sensed[place] = SensedMessage(whole.index, whole.sensed, form.begins["estimate"])
    return [sensed[place] for place in range(len(messages))]


def _faults(columns: Columns) -> list[tuple[Fault, ...]]:
    """Return the faults of each tick."""
    by_number = []
    for number in range(columns.form.counts["faults"]):
        kind, source, detail = (
            columns.of(f"faults.{number}.{name}") for name in ("kind", "source", "detail")
        )
        by_number.append([
            Fault(FaultKind(code), *(bytes(text[:-1]).decode() for text in texts))
            for code, *texts in zip(kind.tolist(), source, detail, strict=True)
        ])  # fmt: skip
    return list(zip(*by_number, strict=True)) if by_number else [()] * len(columns)


def _sensed(columns: Columns) -> Iterator[SensedTick]:
    """What was sensed in each tick."""
    t_ns = columns.of("t_ns").tolist()
    joints = zip(columns.of("joints_t_ns").tolist(), *map(columns.of, _JOINTS), strict=True)
    forces = zip(
        columns.of("forces_t_ns").tolist(), _rows("force_n", 3)(columns), columns.of("force_valid"),
        strict=True,
    )  # fmt: skip
    poses, imu = (
        records_of(columns, "pose_records", PoseRecord),
        records_of(columns, "imu_records", ImuRecord),
    )
    for row, (now_ns, joint, force) in enumerate(zip(t_ns, joints, forces, strict=True)):
        yield SensedTick(now_ns, JointState(*joint), FootForces(*force), poses[row], imu[row])


def records_of(columns: Columns, name: str, make: type[T]) -> list[tuple[T, ...]]:
    """Return the records of one sequence in each tick, oldest first."""
    count = columns.form.counts[name]
    if not count:
        return [()] * len(columns)
    begin = f"{name}.0."
    fields = [
        field.removeprefix(begin) for field in columns.form.places if field.startswith(begin)
    ]  # in the order of the dataclass, which is that of the message
    by_number = []
    for number in range(count):
        values = (columns.of(f"{name}.{number}.{field}") for field in fields)
        listed = (one.tolist() if one.ndim == 1 else one for one in values)
        by_number.append([make(*row) for row in zip(*listed, strict=True)])
    return list(zip(*by_number, strict=True))
