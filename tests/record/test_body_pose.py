"""Poses as mocap systems write them: any form of a rotation gives the same trial; wrong ones are said."""

import tempfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from model.errors import RecordError
from model.values.arrays import FloatArray
from record.trial.body_pose import EULER, MATRIX, ORIENTATIONS, QUATERNION, BodyFrame, posed
from record.trial.column_map import read_column_map
from record.trial.import_table import Imported, import_tables
from record.trial.table_check import TableFinding
from record.trial.table_file import TableColumn
from record.trial.trial import BODY_ANGLES, BODY_POSITION

ANGLE = st.floats(-1.4, 1.4)
YAWS = st.lists(st.floats(-0.5, 0.5), min_size=2, max_size=30)


def walked(roll: float, pitch: float, steps: list[float]) -> FloatArray:
    """Roll, pitch and unwrapped yaw, (T, 3), that turn by less than half a turn a sample."""
    yaw = np.cumsum(steps) * 3
    return np.column_stack([np.full_like(yaw, roll), np.full_like(yaw, pitch), yaw])


def angles_of(columns: Mapping[str, FloatArray], frame: BodyFrame = BodyFrame()) -> FloatArray:  # noqa: B008
    findings: list[TableFinding] = []
    given_columns = [TableColumn(name, values) for name, values in columns.items()]
    out = {c.name: c.values for c in posed(given_columns, frame, findings)}
    assert not set(out) & set(ORIENTATIONS)
    return np.column_stack([out[name] for name in BODY_ANGLES])


@given(ANGLE, ANGLE, YAWS, st.integers(0, 2**31))
def test_every_form_of_a_rotation_gives_the_angles_back(
    roll: float, pitch: float, steps: list[float], seed: int
) -> None:
    angles = walked(roll, pitch, steps)
    turns = Rotation.from_euler("ZYX", angles[:, ::-1])
    flips = np.random.default_rng(seed).choice(
        [-1.0, 1.0], len(angles)
    )  # q and -q are one attitude
    quaternion = dict(zip(QUATERNION, turns.as_quat().T * flips, strict=True))
    matrix = dict(zip(MATRIX, turns.as_matrix().reshape(-1, 9).T, strict=True))
    euler = dict(zip(EULER, turns.as_euler("xyz").T, strict=True))
    start = angles[0, 2] - np.arctan2(np.sin(angles[0, 2]), np.cos(angles[0, 2]))
    for columns, frame in (
        (quaternion, BodyFrame()),
        (matrix, BodyFrame()),
        (euler, BodyFrame(euler_order="xyz")),
    ):
        back = angles_of(columns, frame)
        np.testing.assert_allclose(back[:, :2], angles[:, :2], atol=1e-9)
        np.testing.assert_allclose(back[:, 2], angles[:, 2] - start, atol=1e-9)


@given(ANGLE, ANGLE, YAWS, st.lists(st.floats(-0.3, 0.3), min_size=6, max_size=6))
def test_a_marker_beside_the_body_in_a_world_with_y_up_gives_the_body_back(
    roll: float, pitch: float, steps: list[float], mounted: list[float]
) -> None:
    """Forward by hand, in their words: their y is our z, their z our -y; the tracked frame as mounted."""
    angles = walked(roll, pitch, steps)
    body = Rotation.from_euler("ZYX", angles[:, ::-1])
    place = np.random.default_rng(0).normal(size=(len(angles), 3))
    mount = Rotation.from_euler("ZYX", [mounted[5], mounted[4], mounted[3]])
    tracked_at = place + body.apply(mounted[:3])
    theirs = np.column_stack([tracked_at[:, 0], tracked_at[:, 2], -tracked_at[:, 1]])
    to_theirs = Rotation.from_euler("X", -90, degrees=True)
    tracked = to_theirs * body * mount * to_theirs.inv()
    degrees = ", ".join(repr(float(value)) for value in np.degrees(mounted[3:]))
    columns = {
        **dict(zip(BODY_POSITION, theirs.T, strict=True)),
        **dict(zip(QUATERNION, tracked.as_quat().T, strict=True)),
    }
    frame = frame_of(f'up = "y"\nmarker_m = {mounted[:3]}\nmarker_rpy_deg = [{degrees}]')
    findings: list[TableFinding] = []
    out = {
        c.name: c.values
        for c in posed([TableColumn(n, v) for n, v in columns.items()], frame, findings)
    }
    np.testing.assert_allclose(np.column_stack([out[n] for n in BODY_POSITION]), place, atol=1e-9)
    back = np.column_stack([out[name] for name in BODY_ANGLES])
    np.testing.assert_allclose(np.exp(1j * back), np.exp(1j * angles), atol=1e-7)


def frame_of(body: str) -> BodyFrame:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.toml"
        path.write_text(f"[body]\n{body}\n")
        return read_column_map(path).body


GOLDEN = """\
t;X;Y;Z;qw;qx;qy;qz
0;100;50;-20;1;0;0;0
10;110;50;-20;0.70710678;0;0.70710678;0
20;120;50;-20;-0.70710678;0;-0.70710678;0
30;120;50;-20;0;0;0;0
"""
# y up, mm, a marker 5 cm above the body; yaw 0, then 90 deg to the left twice; then tracking is lost
GOLDEN_MAP = """
[table]
delimiter = ";"
[columns]
time_s = { from = "t", unit = "ms" }
[body]
position = ["X", "Y", "Z"]
unit = "mm"
quaternion_wxyz = ["qw", "qx", "qy", "qz"]
up = "y"
marker_m = [0.0, 0.0, 0.05]
"""


def brought(folder: Path, table: str, column_map: str) -> Imported:
    (folder / "run.csv").write_text(table)
    (folder / "map.toml").write_text(column_map)
    (one,) = import_tables(folder / "run.csv", read_column_map(folder / "map.toml"))
    return one


def test_a_small_table_by_hand(tmp_path: Path) -> None:
    one = brought(tmp_path, GOLDEN, GOLDEN_MAP)
    assert one.trial is not None
    np.testing.assert_allclose(one.trial.time_s, [0, 0.01, 0.02, 0.03])
    np.testing.assert_allclose(
        one.trial.body_position_m[:3], [[0.1, 0.02, 0], [0.11, 0.02, 0], [0.12, 0.02, 0]], atol=1e-9
    )
    np.testing.assert_allclose(
        one.trial.body_angles_rad[:3], np.outer([0, 1, 1], [0, 0, np.pi / 2]), atol=1e-7
    )
    assert np.isnan(one.trial.body_angles_rad[3]).all()
    (bad,) = [f for f in one.report.findings if f.kind == "rotation"]
    assert (bad.count, bad.first_row) == (1, 4)
    assert "body_yaw_rad" in one.report.columns
    assert not set(ORIENTATIONS) & set(one.report.columns)


def test_places_alone_stay_places(tmp_path: Path) -> None:
    one = brought(
        tmp_path,
        "time_s,a,b,c\n0,1,2,3\n0.01,1,2,3.5\n",
        '[body]\nposition = ["a", "b", "c"]\naxes = ["y", "-x", "z"]',
    )
    assert one.trial is not None
    np.testing.assert_array_equal(one.trial.body_position_m, [[2, -1, 3], [2, -1, 3.5]])
    assert np.isnan(one.trial.body_angles_rad).all()


@pytest.mark.parametrize(
    ("table", "column_map", "words"),
    [
        (GOLDEN.replace("0.7", "5.7"), GOLDEN_MAP, "no quaternions of length 1: 3 of 4 rows"),
        (GOLDEN, GOLDEN_MAP.replace('"qz"]', '"qq"]'), "no column qq"),
        (GOLDEN, GOLDEN_MAP.replace(', "qz"]', "]"), "must name 4 columns, not 3"),
        (GOLDEN, GOLDEN_MAP.replace('up = "y"', 'axes = ["x", "z", "y"]'), "no right-handed frame"),
        (GOLDEN, GOLDEN_MAP.replace('up = "y"', 'up = "w"'), "must be one of z, y"),
        (GOLDEN, GOLDEN_MAP.replace('"mm"', '"mile"'), "'mile' is not one of"),
        (GOLDEN, GOLDEN_MAP.replace('up = "y"', 'order = "ABC"'), "must be three axes"),
        (
            GOLDEN,
            "\n".join(line for line in GOLDEN_MAP.splitlines() if "quaternion" not in line),
            "marker_m needs the body's attitude",
        ),
        (GOLDEN, GOLDEN_MAP.replace("[body]", 'body_x_m = "X"\n[body]'), "is named in [body] too"),
        (
            GOLDEN,
            GOLDEN_MAP.replace("[body]", 'body_yaw_rad = "qz"\n[body]'),
            "the attitude is there twice",
        ),
    ],
)
def test_a_wrong_map_or_table_is_refused_with_what_to_do(
    table: str, column_map: str, words: str, tmp_path: Path
) -> None:
    with pytest.raises(RecordError, match=words.replace("[", r"\[")):
        brought(tmp_path, table, column_map)


@pytest.mark.parametrize(
    ("column_map", "kind", "words"),
    [
        (GOLDEN_MAP.replace("wxyz", "xyzw"), "frame", "order of the quaternion (wxyz or xyzw)"),
        (GOLDEN_MAP.replace('up = "y"', ""), "frame", 'up = "y"'),
        (GOLDEN_MAP.replace(', unit = "ms"', ""), "unit", 'map them with unit = "ms"'),
        (GOLDEN_MAP.replace('unit = "mm"', ""), "jump", 'map them with unit = "mm"'),
    ],
)
def test_a_map_that_is_probably_wrong_is_said(
    column_map: str, kind: str, words: str, tmp_path: Path
) -> None:
    one = brought(tmp_path, GOLDEN, column_map)
    assert words in "; ".join(f.detail for f in one.report.findings if f.kind == kind)


@pytest.mark.parametrize("pitch", [np.pi / 2, -np.pi / 2])
def test_a_nose_straight_up_or_down_is_said_and_warns_nobody(
    pitch: float, recwarn: pytest.WarningsRecorder
) -> None:
    """Roll and yaw are one angle there: roll is 0, and the three still make the given attitude."""
    angles = np.array([[0.1, 0.2, 0.3], [0.4, pitch, 0.9], [0.0, pitch, -0.5]])
    turns = Rotation.from_euler("ZYX", angles[:, ::-1])
    columns = [TableColumn(*one) for one in zip(QUATERNION, turns.as_quat().T, strict=True)]
    findings: list[TableFinding] = []
    out = {c.name: c.values for c in posed(columns, BodyFrame(), findings)}
    back = np.column_stack([out[name] for name in BODY_ANGLES])
    np.testing.assert_allclose(back[0], angles[0], atol=1e-12)
    np.testing.assert_allclose(back[1:, 0], 0.0, atol=1e-7)
    again = Rotation.from_euler("ZYX", back[:, ::-1]).as_matrix()
    np.testing.assert_allclose(again, turns.as_matrix(), atol=2e-7)
    (said,) = [one for one in findings if "straight up or down" in one.detail]
    assert (said.kind, said.count, said.first_row) == ("rotation", 2, 2)
    assert not recwarn.list
