"""Ticks of a log as the arrays of a recording, without taking each message apart.

What comes out is what ``build_recording`` makes of the same ticks, to the bit. Ticks of older layouts, of a
rare form or with anything unusual in them are taken apart one by one.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import BoolArray, IntArray
from model.values.faults import Fault, FaultKind
from model.values.machine_names import MachineNames
from model.values.tick_rows import SensedRows
from record.log.blocks.message_form import Columns
from record.log.blocks.sensed_columns import feet_of, joined_rows, sensed_rows
from record.log.blocks.tick_forms import FormBook
from record.log.reader import TopicMessage
from record.log.recording import STACKS
from record.log.salvage import DAMAGE
from record.log.tick_message import LAYOUT, decode_tick

_DIAGONAL = [0, 2, 5]  # of a covariance whose lower half is kept row by row
Take = Callable[[Columns], NDArray[Any]]


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
    sensed: SensedRows | None = None


def _of(name: str) -> Take:
    return lambda columns: columns.of(name)


def _rows(name: str, width: int) -> Take:
    """A field of each foot, (B, N, width)."""
    return lambda columns: feet_of(columns.of(name), width)


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
    sensed: list[tuple[IntArray | list[int], SensedRows]] = []
    faults: list[tuple[int, tuple[Fault, ...]]] = []
    if all(message.layout == LAYOUT for message in messages):
        for places, columns in book.groups([message.data for message in messages], machine):
            left[places] = False
            faults += zip(places.tolist(), _faults(columns), strict=True)
            if with_sensed:
                sensed.append((places, sensed_rows(columns)))
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
    if ticks and with_sensed:
        sensed.append((alone, SensedRows.stacked([tick.sensed for tick in ticks])))
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
    rows = None
    if sensed:
        every = np.array(row)  # of what is kept, that at each place
        rows = joined_rows(int(kept.sum()), [(every[places], own) for places, own in sensed])
    return StackedTicks(arrays, kept, in_row, tuple(broken), rows)


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
