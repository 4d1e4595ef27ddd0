"""Bringing measured data in: columns mapped, everything odd reported, nothing dropped in silence."""

from pathlib import Path

import numpy as np
import pytest

from model.errors import RecordError
from record.log.export import export_trial
from record.log.from_trial import left_out, write_trial_log
from record.log.reader import LogContents, read_ticks
from record.trial.column_map import ColumnMap, read_column_map
from record.trial.import_table import ImportReport, import_tables
from record.trial.table_check import TableFinding
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial, read_trial, write_trial
from tests.record.test_trial import (
    BENCH,
    HEXAPOD,
    LEGS,
    SLIDER,
    assert_same,
    make_header,
    make_trial,
)


def bring(path: Path, columns: Path | None = None) -> tuple[Trial, ImportReport]:
    (one,) = import_tables(path, read_column_map(columns) if columns else ColumnMap())
    assert one.trial is not None
    return one.trial, one.report


def found(report: ImportReport, kind: str, column: str = "") -> TableFinding:
    """The one finding of that kind (in that column)."""
    (finding,) = [
        f for f in report.findings if f.kind == kind and (not column or f.column == column)
    ]
    return finding


def write_smooth(folder: Path, count: int = 300, **columns: np.ndarray) -> Path:
    """A plausible walk of one leg at 100 Hz, with columns changed as the test wants."""
    time_s = np.arange(count) / 100
    rng = np.random.default_rng(0)
    table = {
        "time_s": time_s,
        "command_HL_rad": 2 * time_s,
        "shaft_HL_rad": 2 * time_s + rng.normal(0, 1e-3, count),
        "force_HL_z_n": 10 + rng.normal(0, 0.1, count),
        "body_x_m": 0.1 * time_s + rng.normal(0, 1e-4, count),
        **columns,
    }
    path = folder / "walk.csv"
    np.savetxt(path, np.column_stack([*table.values()]), delimiter=",", header=",".join(table),
               comments="", fmt="%.17g")  # fmt: skip
    (folder / "walk.toml").write_text("[trial]\nlegs = ['HL']\nsample_rate_hz = 100\n")
    return path


def test_a_trial_comes_in_as_it_is(tmp_path: Path) -> None:
    trial = make_trial(make_header(HEXAPOD))
    write_trial(trial, tmp_path / "t.parquet")
    back, report = bring(tmp_path / "t.toml")
    assert_same(back, trial)
    assert report.dropped == ()
    assert (report.rows, report.kept) == (30, 30)


def test_good_data_raise_no_finding_but_what_is_absent(tmp_path: Path) -> None:
    _, report = bring(write_smooth(tmp_path))
    assert {finding.kind for finding in report.findings} == {"absent", "derived"}
    assert {f.column for f in report.findings} >= {"current_a", "foot_m", "body_angles_rad"}
    assert "missing: force_HL_x_n, force_HL_y_n" in found(report, "absent", "force_n").detail
    assert found(report, "absent", "current_a").detail == "not measured"


def test_rows_out_of_order_are_put_in_order_and_double_ones_listed(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text(
        "time_s,pwm_a\n0,0.1\n0.02,0.3\n0.01,0.2\n0.01,0.2\n,0.9\n0.02,0.4\nnan,\ninf,0.5\n"
    )
    trial, report = bring(tmp_path / "t.csv")
    np.testing.assert_array_equal(trial.time_s, [0, 0.01, 0.02])
    np.testing.assert_array_equal(trial.pwm[:, 0], [0.1, 0.2, 0.3])
    assert [(row.row, row.reason) for row in report.dropped] == [
        (4, "a copy of row 3"),
        (5, "it has no time"),
        (6, "another row at the time of row 2"),
        (7, "it has no time"),
        (8, "it has no time"),
    ]
    assert report.rows == report.kept + len(report.dropped)
    assert (found(report, "order").count, found(report, "order").first_row) == (1, 3)
    assert "no t.toml" in next(f for f in report.findings if "toml" in f.detail).detail


def test_a_column_map_scales_turns_and_shifts(tmp_path: Path) -> None:
    (tmp_path / "theirs.csv").write_text(
        "Stamp;pos 1;Fz;u;junk\n1000;90;1;50;7\n1010;180;oops;-50;7\n1020;;3;;7\n"
    )
    (tmp_path / "map.toml").write_text(
        """
        [table]
        delimiter = ";"
        [columns]
        time_s = { from = "Stamp", unit = "ms" }
        shaft_HL_rad = { from = "pos 1", unit = "deg", sign = -1, offset = 1.0 }
        force_HL_z_n = { from = "Fz", unit = "kgf", scale = 2 }
        pwm_HL = { from = "u", unit = "%" }
        [trial]
        gait = "tripod"
        legs = ["HL"]
        [noise]
        force_n = 0.5
        """
    )
    trial, report = bring(tmp_path / "theirs.csv", tmp_path / "map.toml")
    np.testing.assert_allclose(trial.time_s, [1.0, 1.01, 1.02])
    np.testing.assert_allclose(trial.shaft_rad[:, 0], [1 - np.pi / 2, 1 - np.pi, np.nan])
    np.testing.assert_allclose(trial.force_n[:, 0, 2], [19.6133, np.nan, 58.8399])
    np.testing.assert_allclose(trial.pwm[:, 0], [0.5, -0.5, np.nan])
    assert trial.header.gait == "tripod"
    assert trial.header.noise.force_n == 0.5
    unreadable = found(report, "unreadable", "Fz")
    assert (unreadable.count, unreadable.first_row) == (1, 2)
    assert "row 2 'oops'" in unreadable.detail
    assert found(report, "ignored", "junk").count == 3
    assert found(report, "missing", "pwm_HL").detail == "33.33% of samples are NaN"


WRONG_MAP = {
    "[columns]\nshaft_HL_rat = 'a'": r"shaft_HL_rat is no column of a trial; did you mean shaft_HL_rad",
    "[columns]\nshaft_HL_rad = 'pos1'": r"has no column pos1; did you mean pos",
    "[columns]\nshaft_HL_rad = { unit = 'deg' }": r"columns\.shaft_HL_rad\.from: is missing",
    "[columns]\nshaft_HL_rad = { from = 'pos', unit = 'grad' }": r"unit: 'grad' is not one of s, ms",
    "[columns]\nshaft_HL_rad = { from = 'pos', sign = 2 }": r"sign: must be 1 or -1, not 2",
    "[columns]\nshaft_HL_rad = { from = 'pos', scale = 0 }": r"scale: must not be 0",
    "[columns]\nshaft_HL_rad = { from = 'pos', scale = inf }": r"scale: must be finite, not inf",
    "[columns]\nshaft_HL_rad = { from = 'pos', offset = true }": r"offset: must be a number, not True",
    "[columns]\nshaft_HL_rad = { from = 'pos', units = 'm' }": r"units: is not a known key; did you",
    "[columns]\nshaft_HL_rad = 3": r"columns\.shaft_HL_rad: must be a table",
    "columns = 3": r"columns: must be a table",
    "[table]\ndelimiter = ';;'": r"delimiter: must be one character",
    "[column]": r"column: is not a known key; did you mean 'columns'",
    "[": r"is not valid TOML",
    "": r"has a time but no other known column; name its columns",
}


@pytest.mark.parametrize("text", WRONG_MAP)
def test_a_wrong_map_is_an_error_that_says_what_is_wrong(tmp_path: Path, text: str) -> None:
    (tmp_path / "t.csv").write_text("time_s,pos\n0,1\n")
    (tmp_path / "t.toml").write_text("[trial]\nlegs = ['HL']\n")
    (tmp_path / "map.toml").write_text(text)
    with pytest.raises(RecordError, match=WRONG_MAP[text]):
        bring(tmp_path / "t.csv", tmp_path / "map.toml")


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("pwm_a\n1\n", r'has no column time_s; name its time column in a map .*: time_s = "name"'),
        ("time_s,pwm_a\n,1\n", r"no row of .* has a time"),
        ("time_s,pwm_a\n", r"no row of .* has a time"),
    ],
)
def test_a_table_that_is_no_use_is_an_error(tmp_path: Path, table: str, words: str) -> None:
    (tmp_path / "t.csv").write_text(table)
    with pytest.raises(RecordError, match=words):
        bring(tmp_path / "t.csv")


# What is odd, one thing at a time: it is found, in its place, and nothing is changed.


def with_value(at: slice, value: float, base: np.ndarray) -> np.ndarray:
    changed = base.astype(float).copy()
    changed[at] = value
    return changed


NOISE = np.random.default_rng(1).normal(0, 1e-3, 300)
T = np.arange(300) / 100
ODD = {
    "range": ("force_HL_z_n", with_value(slice(50, 53), 3e4, 10 + NOISE), 3, 51, "3e+04"),
    "jump": ("body_x_m", np.where(T >= 1.5, 2.0, 0.0) + NOISE, 1, 151, "largest step"),
    "stuck": ("force_HL_z_n", with_value(slice(100, 250), 9.5, 10 + NOISE), 150, 101, "last digit"),
    "missing": ("force_HL_z_n", with_value(slice(0, 75), np.nan, 10 + NOISE), 75, 1, "25.00%"),
    "gap": ("time_s", np.where(T >= 1, T + 0.5, T), 1, 101, "the longest 0.51 s"),
    "rate": ("time_s", 2 * T, 300, 0, "50 Hz, the header says 100 Hz"),
}


@pytest.mark.parametrize("kind", ODD)
def test_what_is_odd_is_found(tmp_path: Path, kind: str) -> None:
    column, values, count, first_row, words = ODD[kind]
    trial, report = bring(write_smooth(tmp_path, 300, **{column: values}))
    finding = found(report, kind)
    assert (finding.column, finding.count, finding.first_row) == (column, count, first_row)
    assert words in finding.detail
    assert report.dropped == ()
    kept = {c.name: c.values for c in trial.columns()}[column]
    np.testing.assert_array_equal(kept, values, err_msg="reported, not changed")


def test_a_shaft_that_stays_while_its_command_moves_is_stuck(tmp_path: Path) -> None:
    shaft = with_value(slice(100, 200), 2.0, 2 * T + NOISE)
    _, report = bring(write_smooth(tmp_path, shaft_HL_rad=shaft))
    assert found(report, "stuck", "shaft_HL_rad").count == 100
    still = np.full(300, 1.0)
    _, report = bring(write_smooth(tmp_path, shaft_HL_rad=still, command_HL_rad=still))
    assert not [f for f in report.findings if f.kind == "stuck"], "it was told to stay"


def test_a_shaft_that_holds_between_steps_of_its_command_is_not_stuck(tmp_path: Path) -> None:
    """It rests bit for bit until shortly after the next step, and follows then; nor is a step a jump."""
    command = np.where(T < 1.5, 0.0, 0.8)
    shaft = np.where(T < 1.52, 0.0, 0.8 - 0.8 * np.exp(-(T - 1.52) / 0.1))
    _, report = bring(write_smooth(tmp_path, command_HL_rad=command, shaft_HL_rad=shaft))
    assert not [f for f in report.findings if f.kind in {"stuck", "jump"}]
    late = np.where(T < 2.0, 0.0, 0.8 - 0.8 * np.exp(-(T - 2.0) / 0.1))
    _, report = bring(write_smooth(tmp_path, command_HL_rad=command, shaft_HL_rad=late))
    assert found(report, "stuck", "shaft_HL_rad").count > 0, "half a second after the step"


def test_a_command_that_is_not_unwrapped_or_in_another_unit_still_jumps(tmp_path: Path) -> None:
    wrapped = np.mod(4 * T, 2 * np.pi)
    _, report = bring(write_smooth(tmp_path, command_HL_rad=wrapped))
    assert "it is not unwrapped" in found(report, "jump", "command_HL_rad").detail
    degrees = np.rad2deg(np.sin(6 * T))
    _, report = bring(write_smooth(tmp_path, command_HL_rad=degrees))
    assert 'unit = "deg"' in found(report, "jump", "command_HL_rad").detail


def test_an_angle_that_was_not_unwrapped_is_named(tmp_path: Path) -> None:
    wrapped = np.mod(4 * T, 2 * np.pi)
    _, report = bring(write_smooth(tmp_path, shaft_HL_rad=wrapped))
    assert "it is not unwrapped" in found(report, "jump", "shaft_HL_rad").detail


def test_a_foot_in_the_air_is_not_a_stuck_sensor_but_zeros_throughout_are(tmp_path: Path) -> None:
    swing = np.where(T < 1.5, 0.0, 10 + NOISE)
    _, report = bring(write_smooth(tmp_path, force_HL_z_n=swing))
    assert not [f for f in report.findings if f.kind == "stuck"]
    _, report = bring(write_smooth(tmp_path, force_HL_z_n=np.zeros(300)))
    assert "if it was not measured, leave the column out" in found(report, "stuck").detail


# A trial as a log.


def smooth_trial(header_text: str, count: int = 40) -> Trial:
    rng = np.random.default_rng(2)
    trial = make_trial(make_header(header_text, notes="by hand"), count)
    columns = [
        TableColumn(column.name, rng.normal(0, 0.5, count))
        for column in trial.columns()[1:]
        if not column.name.startswith("torque")
    ]
    columns.append(TableColumn("time_s", np.arange(count) / 100))
    return build_trial(trial.header, tuple(columns))


def test_a_trial_goes_through_a_log_and_back(tmp_path: Path) -> None:
    trial = smooth_trial(HEXAPOD)
    assert left_out(trial) == ()
    write_trial_log(trial, tmp_path / "t.mcap")
    export_trial(tmp_path / "t.mcap", tmp_path / "back.parquet", LogContents())
    back = read_trial(tmp_path / "back.parquet")
    assert repr(back.header) == repr(trial.header)
    np.testing.assert_allclose(back.time_s, trial.time_s, atol=1e-9)
    for name in ("command_rad", "shaft_rad", "shaft_rad_s", "current_a", "pwm", "force_n"):
        np.testing.assert_array_equal(getattr(back, name), getattr(trial, name), err_msg=name)
    np.testing.assert_allclose(back.foot_m, trial.foot_m, atol=1e-9)
    np.testing.assert_allclose(back.body_position_m, trial.body_position_m, atol=1e-9)
    np.testing.assert_allclose(back.body_angles_rad, trial.body_angles_rad, atol=1e-9)


def test_what_was_not_measured_is_not_made_up(tmp_path: Path) -> None:
    columns = (
        TableColumn("time_s", np.array([0.0, 0.1])),
        TableColumn("shaft_HL_rad", np.array([1, np.nan])),
    )
    write_trial_log(build_trial(make_header(HEXAPOD), columns), tmp_path / "t.mcap")
    contents = LogContents()
    first, second = read_ticks(tmp_path / "t.mcap", contents)
    assert contents.metadata["hardware"] == "imported"
    assert first.joints.valid.tolist() == [True] + 5 * [False]
    assert not second.joints.valid.any()
    assert np.isnan(second.joints.angle_rad).all()
    assert first.inputs.truth is None
    assert first.inputs.servos is None
    assert not first.forces.valid.any()
    assert not first.dead_reckoning.valid
    assert not first.contact.traction.valid
    assert first.contact.traction.reason == "imported data: the model was not run"


@pytest.mark.parametrize(
    ("kind", "text", "joints"),
    [("servo_bench", BENCH, ("arm", "wrist")), ("sliding_body", SLIDER, ())],
)
def test_other_machines_make_logs_too(
    tmp_path: Path, kind: str, text: str, joints: tuple[str, ...]
) -> None:
    trial = make_trial(make_header(text, kind=kind, joints=joints, gait=""), 10)
    trial = build_trial(trial.header, tuple(
        TableColumn(c.name, 0.2 * np.nan_to_num(c.values))
        for c in trial.columns() if "torque" not in c.name
    ))  # fmt: skip
    write_trial_log(trial, tmp_path / "t.mcap")
    export_trial(tmp_path / "t.mcap", tmp_path / "back.csv", LogContents())
    back = read_trial(tmp_path / "back.csv")
    assert (back.header.kind, back.joints) == (kind, joints)
    np.testing.assert_array_equal(back.pwm, trial.pwm)
    np.testing.assert_allclose(back.body_angles_rad, trial.body_angles_rad, atol=1e-9)


@pytest.mark.parametrize("start_s", [-0.5, 0.0, 1.7e9])
def test_times_before_zero_and_unix_times_fit_in_a_log(tmp_path: Path, start_s: float) -> None:
    times = start_s + np.arange(5) / 4
    columns = (TableColumn("time_s", times), TableColumn("pwm_HL", np.arange(5) / 10))
    write_trial_log(build_trial(make_header(), columns), tmp_path / "t.mcap")
    ticks = list(read_ticks(tmp_path / "t.mcap"))
    assert set(np.diff([t.t_ns for t in ticks]).tolist()) == {250_000_000}
    assert ticks[0].t_ns >= 0


def test_what_a_log_has_no_place_for_is_named() -> None:
    assert "torque_HL_nm" in left_out(make_trial(make_header()))
    feet = (TableColumn("time_s", np.zeros(1)), TableColumn("foot_HL_x_m", np.ones(1)))
    assert left_out(build_trial(make_header(), feet)) == (
        "foot points where the body's pose is not known",
    )
    partly = (TableColumn("time_s", np.zeros(1)), TableColumn("body_x_m", np.ones(1)))
    assert left_out(build_trial(make_header(), partly)) == ()
    tilted = (TableColumn("time_s", np.zeros(1)), TableColumn("body_roll_rad", np.ones(1)))
    assert left_out(build_trial(make_header(), tilted)) == (
        "roll and pitch where not all three angles are known",
    )


@pytest.mark.parametrize(
    "known",
    [
        ("body_x_m", "body_y_m"),
        ("body_x_m", "body_y_m", "body_z_m"),
        ("body_x_m", "body_y_m", "body_yaw_rad"),
        ("body_yaw_rad",),
    ],
)
def test_poses_known_in_part_are_kept_in_a_log_part_by_part(
    known: tuple[str, ...], tmp_path: Path
) -> None:
    time_s = np.arange(5) / 100
    given = {name: 0.3 + np.arange(5) * (at + 1) for at, name in enumerate(known)}
    columns = [TableColumn(name, values) for name, values in given.items()]
    trial = build_trial(make_header(HEXAPOD), [TableColumn("time_s", time_s), *columns])
    write_trial_log(trial, tmp_path / "t.mcap")
    export_trial(tmp_path / "t.mcap", tmp_path / "back.parquet", LogContents())
    back = {c.name: c.values for c in read_trial(tmp_path / "back.parquet").columns()}
    assert set(back) == {"time_s", *known}
    for name, values in given.items():
        wanted = values
        if name == "body_yaw_rad":  # a log holds turns, not how many
            wanted = np.unwrap(np.arctan2(np.sin(values), np.cos(values)))
        np.testing.assert_allclose(back[name], wanted, atol=1e-12)


def test_samples_closer_than_a_nanosecond_make_no_log(tmp_path: Path) -> None:
    columns = (TableColumn("time_s", np.array([0.0, 1e-10])), TableColumn("pwm_HL", np.zeros(2)))
    with pytest.raises(RecordError, match="counts nanoseconds"):
        write_trial_log(build_trial(make_header(joints=LEGS), columns), tmp_path / "t.mcap")
    assert list(tmp_path.iterdir()) == []
