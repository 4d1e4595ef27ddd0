"""A trial: measured data of one run of any machine, as arrays by joint.

The table on disk and its columns are described in ``docs/log.md``; ``read_trial`` and ``write_trial``
are each other's inverse.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np

from model.errors import RecordError
from model.values.arrays import BoolArray, FloatArray, readonly
from model.values.machine_names import MachineNames
from record.trial.header import TrialHeader
from record.trial.header_file import read_header, write_header
from record.trial.table_file import (
    SUFFIXES,
    DataTable,
    Names,
    TableColumn,
    axis_words,
    check_suffix,
    column_names,
    read_table,
)
from record.trial.table_writer import write_table

BODY_POSITION = ("body_x_m", "body_y_m", "body_z_m")
IMU = ("imu_yaw_rate_rad_s", "imu_roll_rad", "imu_pitch_rad")
BODY_ANGLES = ("body_roll_rad", "body_pitch_rad", "body_yaw_rad")
# Field of a trial to the names of its columns; in braces joint or leg, and the letters of axes.
COLUMNS: Mapping[str, Names] = {
    "command_rad": "command_{joint}_rad",
    "shaft_rad": "shaft_{joint}_rad",
    "shaft_rad_s": "shaft_{joint}_rad_s",
    "current_a": "current_{joint}_a",
    "voltage_v": "voltage_{joint}_v",
    "temperature_c": "temperature_{joint}_c",
    "pwm": "pwm_{joint}",
    "torque_nm": "torque_{joint}_nm",
    "foot_m": "foot_{leg}_{xyz}_m",
    "force_n": "force_{leg}_{xyz}_n",
    "body_position_m": BODY_POSITION,
    "body_angles_rad": BODY_ANGLES,
    "imu": IMU,
}


@dataclass(frozen=True, slots=True, eq=False)
class Trial:
    """One trial: T samples of J joints and N legs. What was not measured is NaN throughout.

    Attributes:
        header: Gait, rates, noise, the machine, its joints and its legs.
        time_s: Seconds, increasing, (T,).
        command_rad: Shaft angle asked for, unwrapped, (T, J).
        shaft_rad: Shaft angle, (T, J).
        shaft_rad_s: Shaft speed, (T, J).
        current_a: Motor current, (T, J).
        voltage_v: Supply voltage, (T, J).
        temperature_c: Servo temperature, (T, J).
        pwm: Duty, -1 to 1, (T, J).
        torque_nm: Torque at the shaft, (T, J).
        foot_m: Foot point in the body frame from a marker, so with the leg's compression, (T, N, 3).
        force_n: Ground's force on each foot, body axes, (T, N, 3).
        body_position_m: Body in the world, (T, 3).
        body_angles_rad: Roll, pitch, yaw of the body in the world, (T, 3): yaw about z, then pitch about y,
            then roll about x.
        imu: Yaw rate [rad/s], roll and pitch [rad] of an IMU in its own axes, (T, 3).
    """

    header: TrialHeader
    time_s: FloatArray
    command_rad: FloatArray
    shaft_rad: FloatArray
    shaft_rad_s: FloatArray
    current_a: FloatArray
    voltage_v: FloatArray
    temperature_c: FloatArray
    pwm: FloatArray
    torque_nm: FloatArray
    foot_m: FloatArray
    force_n: FloatArray
    body_position_m: FloatArray
    body_angles_rad: FloatArray
    imu: FloatArray

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, J of them."""
        return self.header.joints

    @property
    def legs(self) -> tuple[str, ...]:
        """Names of the legs, N of them; those of the joints where each leg has one; none without legs."""
        return self.header.names.legs

    def columns(self) -> tuple[TableColumn, ...]:
        """Return time and every column in which anything was measured."""
        columns = [TableColumn("time_s", self.time_s)]
        for place in trial_places(self.header.names):
            values = self.values(place)
            if not np.isnan(values).all():
                columns.append(TableColumn(place.column, values))
        return tuple(columns)

    @property
    def known_columns(self) -> tuple[str, ...]:
        """Names of the columns in which anything was measured, without time."""
        return tuple(column.name for column in self.columns()[1:])

    def values(self, place: "Place") -> FloatArray:
        """Return the samples of one column, (T,)."""
        array: FloatArray = getattr(self, place.field)[place.where]
        return array

    def only(self, joints: tuple[str, ...]) -> "Trial":
        """Return the trial with some of its joints, in its own order.

        Raises:
            RecordError: It has no such joint.
        """
        for name in joints:
            if name not in self.joints:
                raise RecordError(f"there is no joint {name}; there are {', '.join(self.joints)}")
        at = [i for i, name in enumerate(self.joints) if name in joints]
        names = tuple(self.joints[i] for i in at)
        each = {
            field: readonly(getattr(self, field)[:, at])
            for field, column in COLUMNS.items()
            if "{joint}" in column or ("{leg}" in column and self.header.names.one_joint_a_leg)
        }
        return replace(self, header=replace(self.header, joints=names), **each)

    def rows(self, keep: BoolArray) -> "Trial":
        """Return the trial with some of its samples, (T,) bool."""
        arrays = {name: readonly(getattr(self, name)[keep]) for name in ("time_s", *COLUMNS)}
        return Trial(self.header, **arrays)


@dataclass(frozen=True, slots=True)
class Place:
    """Where a column lies in a trial.

    Attributes:
        column: Name of the column.
        field: Field of the trial.
        index: Index behind the sample.
        joint: Its joint or leg, empty for the body.
    """

    column: str
    field: str
    index: tuple[int, ...]
    joint: str

    @property
    def where(self) -> tuple[slice | int, ...]:
        """Index of the whole column in the field's array."""
        return (slice(None), *self.index)


def trial_places(machine: MachineNames) -> Iterator[Place]:
    """Yield every column that a machine with these joints and legs can have, but for time."""
    for field, names in COLUMNS.items():
        axes = axis_words(names, machine)
        indices = product(*(range(len(words)) for words in axes))
        for column, index in zip(column_names(names, machine), indices, strict=True):
            yield Place(column, field, index, axes[0][index[0]] if isinstance(names, str) else "")


def build_trial(header: TrialHeader, columns: Iterable[TableColumn]) -> Trial:
    """Put columns into a trial; what is not among them is NaN.

    Args:
        header: The header; its joints and legs say which columns are known.
        columns: ``time_s`` and any others of the trial table, float64; taken one after the other.

    Raises:
        RecordError: A column is not known.
    """
    places = {place.column: place for place in trial_places(header.names)}
    arrays: dict[str, FloatArray] = {}
    time_s, unknown = np.zeros(0), []
    for column in columns:
        if not arrays:
            arrays = _nothing_measured(len(column.values), header.names)
        if column.name == "time_s":
            time_s = np.array(column.values, dtype=np.float64)
        elif column.name in places:
            place = places[column.name]
            arrays[place.field][place.where] = column.values
        else:
            unknown.append(column.name)
    if unknown:
        raise RecordError(
            f"{', '.join(sorted(unknown))}: no column of a trial of joints {', '.join(header.joints)}; "
            "bring the table in with: bigant import TABLE --columns MAP.toml"
        )
    return Trial(
        header,
        time_s=readonly(time_s),
        **{name: readonly(array) for name, array in arrays.items()},
    )


def _nothing_measured(count: int, machine: MachineNames) -> dict[str, FloatArray]:
    shapes = {field: map(len, axis_words(names, machine)) for field, names in COLUMNS.items()}
    return {field: np.full((count, *shape), np.nan) for field, shape in shapes.items()}


def read_trial(path: Path) -> Trial:
    """Read a trial.

    Args:
        path: NAME.parquet or NAME.csv with NAME.toml next to it, or that NAME.toml.

    Raises:
        RecordError: A file is missing or wrong; a table that is not quite a trial goes through
            ``bigant import``.
    """
    path = trial_table(path)
    table = read_table(path, numbers=True)
    header = read_header(path.with_suffix(".toml"), table.names)
    if "time_s" not in table.names:
        raise RecordError(f"{path} has no column time_s")
    trial = build_trial(header, _numbers(table))
    if not _increases(trial.time_s):
        raise RecordError(
            f"time_s of {path} does not increase everywhere; repair it: bigant import {path} --out FILE"
        )
    return trial


def _increases(time_s: FloatArray) -> bool:
    return bool(np.isfinite(time_s).all() and np.all(np.diff(time_s) > 0))


def trial_table(path: Path) -> Path:
    """Return the table of a trial that may be named by its TOML.

    Raises:
        RecordError: There is none.
    """
    if path.suffix != ".toml":
        check_suffix(path)
        return path
    for suffix in SUFFIXES:
        if path.with_suffix(suffix).is_file():
            return path.with_suffix(suffix)
    raise RecordError(f"there is no {path.stem}.parquet or {path.stem}.csv beside {path}")


def _numbers(table: DataTable) -> tuple[TableColumn, ...]:
    return tuple(TableColumn(name, table.numbers(name)) for name in table.names)


def write_trial(trial: Trial, path: Path) -> None:
    """Write a trial: the table, NAME.toml next to it, and the machine's file.

    Args:
        trial: The trial.
        path: NAME.parquet or NAME.csv.

    Raises:
        RecordError: Time does not increase, the header contradicts itself, a file cannot be written, or
            another machine's file of the same name is there.
    """
    check_suffix(path)
    if not _increases(trial.time_s):
        raise RecordError(
            f"{path} is not written: time_s does not increase everywhere; put it in order"
        )
    write_header(trial.header, path.with_suffix(".toml"))
    write_table(path, trial.columns())
