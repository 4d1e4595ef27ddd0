"""The body's pose as others write it down: quaternions, rotation matrices, other axes, an offset marker.

    [body]
    position = ["X", "Y", "Z"]                # or [columns] body_x_m = "X" and so on
    unit = "mm"
    quaternion_wxyz = ["qw", "qx", "qy", "qz"]  # or quaternion_xyzw; matrix, 9 columns row by row; euler
    up = "y"                                    # of a system whose y axis points up
    marker_m = [0.10, 0.0, 0.05]                # where the tracked frame lies in the body,
    marker_rpy_deg = [0.0, 0.0, 90.0]           # and how it is turned there

Rotations turn the tracked frame into the world. ``docs/log.md`` has all keys.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from model.errors import ConfigError, RecordError
from model.motion.attitude import nose_vertical, roll_pitch_yaw
from model.parameters.toml_table import Table
from model.values.arrays import BoolArray, FloatArray
from record.trial.table_check import TableFinding
from record.trial.table_file import TableColumn
from record.trial.trial import BODY_ANGLES, BODY_POSITION

QUATERNION = tuple(f"body_quaternion_{axis}" for axis in "xyzw")
MATRIX = tuple(f"body_matrix_{row}{column}" for row in "xyz" for column in "xyz")
EULER = tuple(f"body_euler_{number}" for number in "123")
# Columns of an orientation that a table may have; a trial has roll, pitch and yaw in their place.
ORIENTATIONS = (*QUATERNION, *MATRIX, *EULER)
UP = {"z": ("x", "y", "z"), "y": ("x", "-z", "y")}
NORM_TOLERANCE = 0.01
MOST_BAD = 0.5  # share of rows that are no rotations, from which on the columns are others
LYING_RAD = math.radians(60)  # no walking robot is tilted so far for half of a run
IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
Rows = tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True)
class BodyFrame:
    """How the axes of a tracking system and of what it tracks lie to ours.

    Attributes:
        axes: Their vectors in our axes, 3 x 3: ours = axes @ theirs.
        marker_m: Where the tracked frame lies in the body frame.
        marker_turn: How it is turned there, 3 x 3: tracked frame to body.
        euler_order: Of ``euler``, as scipy names it: capitals turn about axes that turn along.
    """

    axes: Rows = IDENTITY
    marker_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    marker_turn: Rows = IDENTITY
    euler_order: str = "ZYX"

    @property
    def same(self) -> bool:
        """Whether their axes are ours and the tracked frame is the body."""
        return (self.axes, self.marker_turn) == (IDENTITY, IDENTITY) and not any(self.marker_m)


BodyColumns = Mapping[str, tuple[str, str]]  # our column to theirs and the unit


def read_body(table: Table) -> tuple[BodyFrame, BodyColumns]:
    """Read the table [body]: the frame, and which columns it names.

    Raises:
        ConfigError: Something in it means nothing.
    """
    unit, angle_unit = table.maybe_text("unit") or "m", table.maybe_text("angle_unit") or "rad"
    named: dict[str, tuple[str, str]] = {}
    for key, ours, their_unit in (
        ("position", BODY_POSITION, unit),
        ("quaternion_xyzw", QUATERNION, "1"),
        ("quaternion_wxyz", (QUATERNION[3], *QUATERNION[:3]), "1"),
        ("matrix", MATRIX, "1"),
        ("euler", EULER, angle_unit),
    ):
        if table.has(key):
            theirs = table.texts(key)
            if len(theirs) != len(ours):
                raise ConfigError(
                    table.name(key), f"must name {len(ours)} columns, not {len(theirs)}"
                )
            named |= {one: (other, their_unit) for one, other in zip(ours, theirs, strict=True)}
    order = table.maybe_text("order") or "ZYX"
    try:
        Rotation.from_euler(order, np.zeros(3))
    except ValueError as error:
        raise ConfigError(
            table.name("order"), f'{order!r} must be three axes, such as "ZYX"'
        ) from error
    turn = Rotation.from_euler("ZYX", _numbers(table, "marker_rpy_deg")[::-1], degrees=True)
    frame = BodyFrame(
        axes=_axes(table),
        marker_m=_numbers(table, "marker_m"),
        marker_turn=_rows(np.round(turn.as_matrix(), 15)),
        euler_order=order,
    )
    table.done()
    return frame, named


def _rows(matrix: FloatArray) -> Rows:
    return tuple(tuple(float(value) for value in row) for row in matrix + 0.0)


def _numbers(table: Table, key: str) -> tuple[float, ...]:
    return tuple(table.numbers(key, (3,)).tolist()) if table.has(key) else (0.0, 0.0, 0.0)


def _axes(table: Table) -> Rows:
    """Their axes in ours: ``up``, or each of ours by the name of theirs."""
    if table.has("up") and table.has("axes"):
        raise ConfigError(table.name("axes"), "says more than up; leave up out")
    words = table.texts("axes") if table.has("axes") else UP.get(table.maybe_text("up") or "z")
    if words is None:
        raise ConfigError(table.name("up"), f"must be one of {', '.join(UP)}")
    rows = np.zeros((3, 3))
    for row, word in zip(rows, words, strict=False):
        if word.lstrip("+-") in tuple("xyz"):
            row["xyz".index(word[-1])] = -1.0 if word[0] == "-" else 1.0
    if len(words) != 3 or not np.isclose(np.linalg.det(rows), 1.0):
        raise ConfigError(
            table.name("axes"),
            f"{list(words)} is no right-handed frame; say which of their axes is our x (ahead), y (left) "
            'and z (up), such as ["x", "-z", "y"]',
        )
    return _rows(rows)


def posed(
    columns: Iterable[TableColumn], frame: BodyFrame, findings: list[TableFinding]
) -> Iterator[TableColumn]:
    """Yield columns of a trial: orientations become roll, pitch and yaw, poses those of the body.

    Args:
        columns: Columns of a trial, or of ``ORIENTATIONS``.
        frame: Their axes and their marker.
        findings: What is no rotation is added here.

    Raises:
        RecordError: Most rows are no rotations, or a marker's offset needs an attitude that is not there.
    """
    held: dict[str, TableColumn] = {}
    for column in columns:
        if column.name in (*ORIENTATIONS, *BODY_POSITION, *BODY_ANGLES):
            held[column.name] = column
        else:
            yield column
    if frame.same and not set(held) & set(ORIENTATIONS):
        yield from held.values()
    elif held:
        yield from _body_columns({n: column.values for n, column in held.items()}, frame, findings)


def _body_columns(
    held: Mapping[str, FloatArray], frame: BodyFrame, findings: list[TableFinding]
) -> Iterator[TableColumn]:
    count = len(next(iter(held.values())))
    turns = _attitudes(held, frame, findings)
    axes = np.array(frame.axes)
    if turns is not None:
        turns = axes @ turns @ axes.T @ np.array(frame.marker_turn).T
        angles = _angles(turns)
        findings += [*_lying(turns), *_vertical(turns)]
        yield from map(TableColumn, BODY_ANGLES, angles.T)
    place = [held.get(name) for name in BODY_POSITION]
    if all(one is None for one in place):
        return
    given = np.column_stack([np.full(count, np.nan) if one is None else one for one in place])
    ours = _placed(given, axes)
    if any(frame.marker_m):
        if turns is None:
            raise RecordError(
                "body.marker_m needs the body's attitude: name its quaternion, matrix or angles"
            )
        ours = ours - turns @ np.array(frame.marker_m)
    yield from (
        TableColumn(name, values)
        for name, values in zip(BODY_POSITION, ours.T, strict=True)
        if np.isfinite(values).any()
    )


def _placed(given: FloatArray, axes: FloatArray) -> FloatArray:
    """Places in our axes, (T, 3); one that is not known harms no other."""
    ours = np.empty_like(given)
    for row, values in zip(axes, ours.T, strict=True):
        at = int(np.argmax(np.abs(row)))
        values[:] = row[at] * given[:, at]
    return ours


def _attitudes(
    held: Mapping[str, FloatArray], frame: BodyFrame, findings: list[TableFinding]
) -> FloatArray | None:
    """Return rotations as they were given, (T, 3, 3), NaN where there is none; None without any."""
    kinds = [names for names in (QUATERNION, MATRIX, EULER, BODY_ANGLES) if set(names) & set(held)]
    if not kinds:
        return None
    if len(kinds) > 1:
        both = " and ".join(names[0] for names in kinds)
        raise RecordError(f"the attitude is there twice ({both} and so on); map one of them")
    (names,) = kinds
    if missing := [name for name in names if name not in held]:
        raise RecordError(f"the body's attitude lacks {', '.join(missing)}; map all of its columns")
    rows = np.column_stack([held[name] for name in names])
    known: BoolArray = np.asarray(np.isfinite(rows).all(axis=1))
    turns = np.full((len(rows), 3, 3), np.nan)
    if names == QUATERNION:
        known = sound_quaternions(rows, "body", findings)
        turns[known] = Rotation.from_quat(rows[known]).as_matrix()
    elif names == MATRIX:
        matrices = rows.reshape(-1, 3, 3)
        off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        proper = (off < NORM_TOLERANCE) & (
            np.nan_to_num(np.linalg.det(np.nan_to_num(matrices))) > 0
        )
        known = _sound(
            known & proper, known & ~proper, off, ("body", "rotation matrices"), findings
        )
        turns[known] = matrices[known]
    else:
        order, given = frame.euler_order, rows[known]
        if names == BODY_ANGLES:  # roll, pitch, yaw: about z, then y, then x
            order, given = "ZYX", given[:, ::-1]
        turns[known] = Rotation.from_euler(order, given).as_matrix()
    return turns


def sound_quaternions(rows: FloatArray, whose: str, findings: list[TableFinding]) -> BoolArray:
    """Return which quaternions, (T, 4), are rotations, (T,); the others are missing, and listed.

    Raises:
        RecordError: Most are not.
    """
    known: BoolArray = np.asarray(np.isfinite(rows).all(axis=1))
    size = np.linalg.norm(rows, axis=1)
    proper = np.abs(size - 1) < NORM_TOLERANCE
    words = (whose, "quaternions of length 1")
    return _sound(known & proper, known & ~proper, size, words, findings)


def _sound(
    sound: BoolArray,
    bad: BoolArray,
    size: FloatArray,
    words: tuple[str, str],
    findings: list[TableFinding],
) -> BoolArray:
    """Return which rows are rotations; those that are not are listed under whose they are and their kind.

    Raises:
        RecordError: Most are not.
    """
    if not bad.any():
        return sound
    whose, kind = words
    worst, first = float(size[np.flatnonzero(bad)[0]]), int(np.flatnonzero(bad)[0]) + 1
    known = int(bad.sum() + sound.sum())
    if bad.sum() > MOST_BAD * known:
        raise RecordError(
            f"the {whose}'s attitude is no {kind}: {int(bad.sum())} of {known} rows are off, the "
            f"first (row {first}) by its size {worst:.3g}; check which columns are named, and their order"
        )
    detail = f"no {kind} (the first has size {worst:.3g}); taken as missing"
    findings.append(TableFinding("rotation", whose, int(bad.sum()), first, detail))
    return sound


def _angles(turns: FloatArray) -> FloatArray:
    """Roll, pitch and unwrapped yaw, (T, 3)."""
    angles = np.full((len(turns), 3), np.nan)
    known = np.isfinite(turns).all(axis=(1, 2))
    if known.any():
        angles[known] = roll_pitch_yaw(Rotation.from_matrix(turns[known]))
        angles[known, 2] = np.unwrap(angles[known, 2])
    return angles


def _vertical(turns: FloatArray) -> list[TableFinding]:
    """Say where roll and yaw are one angle."""
    vertical = np.flatnonzero(nose_vertical(turns))
    if not len(vertical):
        return []
    words = (
        "the nose points straight up or down, where roll and yaw are one angle: roll is 0, yaw takes all "
        "of it; if the body lay level, check the order of the quaternion and which axis points up"
    )
    return [TableFinding("rotation", "body", len(vertical), int(vertical[0]) + 1, words)]


def _lying(turns: FloatArray) -> list[TableFinding]:
    """Say that the body lies on its side all the time, which is a frame that was taken for another."""
    upright = turns[np.isfinite(turns[:, 2, 2]), 2, 2]
    tilt = float(np.arccos(np.clip(np.median(upright), -1, 1))) if len(upright) else 0.0
    if tilt < LYING_RAD:
        return []
    words = (
        f"the body is tilted by {math.degrees(tilt):.0f} deg half of the time: check the order of the "
        'quaternion (wxyz or xyzw), and which axis points up (up = "y")'
    )
    return [TableFinding("frame", "body", len(upright), 0, words)]
