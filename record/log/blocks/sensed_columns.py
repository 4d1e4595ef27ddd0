"""What was sensed in ticks, read from columns."""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from model.values.arrays import IntArray
from model.values.machine_names import MachineNames
from model.values.readings import ImuRecord, PoseRecord
from model.values.tick_rows import ForceRows, JointRows, SensedRows
from record.log.blocks.message_form import Columns, form_of, in_order
from record.log.blocks.tick_forms import TICK, FormBook
from record.log.tick_message import TICK_DEFINITIONS, decode_tick

_JOINTS = (
    "joints_t_ns", "angle_rad", "rate_rad_s", "current_a", "duty", "voltage_v", "temperature_c",
    "joints_valid",
)  # fmt: skip
Places = IntArray | list[int]
T = TypeVar("T")


def feet_of(values: NDArray[Any], width: int) -> NDArray[Any]:
    """A field of each foot, (B, N, width), of rows (B, N width)."""
    return values.reshape(len(values), values.shape[1] // width, width)


def sensed_rows(columns: Columns) -> SensedRows:
    """Return what was sensed in ticks of one form."""
    return SensedRows(
        columns.of("t_ns"),
        JointRows(*map(columns.of, _JOINTS)),
        ForceRows(
            columns.of("forces_t_ns"), feet_of(columns.of("force_n"), 3), columns.of("force_valid")
        ),
        records_of(columns, "pose_records", PoseRecord),
        records_of(columns, "imu_records", ImuRecord),
    )


def joined_rows(count: int, parts: Sequence[tuple[Places, SensedRows]]) -> SensedRows:
    """Return ticks of several forms in order.

    Args:
        count: How many.
        parts: Places, and the ticks there; together all of them.

    Raises:
        ValueError: They are of robots with unequal legs or joints.
    """
    if len(parts) == 1:
        return parts[0][1]

    def together(fields: Sequence[str], of: str = "") -> list[NDArray[Any]]:
        whole = [(at, getattr(own, of) if of else own) for at, own in parts]
        return [in_order(count, [(at, getattr(own, name)) for at, own in whole]) for name in fields]

    poses: list[tuple[PoseRecord, ...]] = [()] * count
    imu: list[tuple[ImuRecord, ...]] = [()] * count
    for places, own in parts:
        for place, seen, turned in zip(
            np.asarray(places).tolist(), own.poses, own.imu, strict=True
        ):
            poses[place], imu[place] = seen, turned
    (t_ns,) = together(["t_ns"])
    return SensedRows(
        t_ns, JointRows(*together(list(JointRows.__slots__), "joints")),
        ForceRows(*together(list(ForceRows.__slots__), "forces")), poses, imu,
    )  # fmt: skip


def sensed_messages(
    messages: Sequence[bytes], machine: MachineNames, book: FormBook
) -> tuple[list[int], list[int], SensedRows]:
    """Read ticks of today's layout, at least one.

    Args:
        messages: The ticks.
        machine: Names of joints and legs.
        book: Forms met so far in this log; learns new ones.

    Returns:
        Their numbers, where the estimate begins in each (counted from behind the header), and what was
        sensed.

    Raises:
        ValueError: One is damaged.
    """
    count = len(messages)
    numbers, begins, left = [0] * count, [0] * count, set(range(count))
    parts: list[tuple[Places, SensedRows]] = []
    for places, columns in book.groups(messages, machine):
        parts.append((places, sensed_rows(columns)))
        begin = columns.form.begins["estimate"]
        for place, number in zip(places.tolist(), columns.of("index").tolist(), strict=True):
            numbers[place], begins[place] = number, begin
        left.difference_update(places.tolist())
    for place in sorted(left):
        whole = decode_tick(messages[place])
        parts.append(([place], SensedRows.stacked([whole.sensed])))
        form = form_of(messages[place], TICK_DEFINITIONS, TICK)
        numbers[place], begins[place] = whole.index, form.begins["estimate"]
    return numbers, begins, joined_rows(count, parts)


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
