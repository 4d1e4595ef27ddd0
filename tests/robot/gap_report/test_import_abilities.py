"""What an import says can be asked of a run, from what each command needs."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap.coverage.blind_spots import blind_spots
from gap.coverage.coverage import coverage_of
from gap.interfaces import Cause, DataFault, Drive
from model.errors import GapError
from record.trial.import_table import ImportReport
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial, write_trial
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.gap_report import diagnose
from robot.gap_report.abilities import Ability, abilities, run_simulator
from robot.gap_report.blind import blind_json, blind_lines, sensors_of
from robot.gap_report.imports import TableReport, all_lines
from robot.virtual.twin_run import make_twin, plan_of, walk_fast
from tests.gap.mjcf_arms import arm_log


@pytest.fixture(scope="module")
def whole() -> Trial:
    config = load_robot()
    plan = plan_of(config, "tripod", None, 8.0, 0.0)
    return walk_fast(config, make_twin(config, (), 1), plan, lambda _: None)


def without(trial: Trial, *fields: str) -> Trial:
    return replace(trial, **{f: np.full_like(getattr(trial, f), np.nan) for f in fields})


def said(trial: Trial) -> dict[str, tuple[bool, str]]:
    return {one.question: (one.answered, one.words) for one in abilities(trial)}


def test_with_everything_measured_everything_can_be_asked(whole: Trial) -> None:
    answers = said(whole)
    assert {question: answered for question, (answered, _) in answers.items()} == {
        "odometry": True, "ground truth": True, "forces": True, "diagnosis": True,
    }  # fmt: skip
    # a step or a patch somewhere in the way, and a limit that is reached, show as well
    assert answers["diagnosis"][1].endswith("visible, in shafts, feet (markers), forces, body")


def test_each_no_names_what_is_missing(whole: Trial) -> None:
    assert said(without(whole, "force_n"))["forces"] == (
        False, "no sensors (force_J_x_n and so on)",
    )  # fmt: skip
    assert said(without(whole, "shaft_rad", "shaft_rad_s"))["odometry"][1].startswith("no shaft")
    assert not said(without(whole, "body_position_m"))["ground truth"][0]
    assert "without an attitude" in said(without(whole, "body_angles_rad"))["ground truth"][1]
    nameless = replace(whole, header=replace(whole.header, robot_text="", robot_file=""))
    assert "no robot file; add robot" in said(nameless)["diagnosis"][1]
    words = said(without(whole, "force_n"))["diagnosis"][1]
    assert "; not measured: forces; not visible: " in words
    assert "friction_level" in words
    named = words.split("not visible: ")[1].split(", ")
    visible, total = (int(one) for one in words.split(" effects")[0].split(" of "))
    assert len(named) == total - visible > 8, "every one is named"
    # a moment takes forces and feet: without feet only these are missing
    assert (
        said(without(whole, "foot_m"))["diagnosis"][1].split("; ")[1]
        == "not measured: feet (markers)"
    )


def test_fewer_effects_are_visible_with_fewer_sensors_and_never_one_more(whole: Trial) -> None:
    simulator = run_simulator(whole)
    counts = []
    seen = set(coverage_of(simulator, whole).visible)
    total = len(seen) + len(coverage_of(simulator, whole).hidden)
    for fields in (("foot_m",), ("foot_m", "force_n"), ("foot_m", "force_n", "body_position_m")):
        coverage = coverage_of(simulator, without(whole, *fields))
        assert set(coverage.visible) <= seen
        assert len(coverage.visible) + len(coverage.hidden) == total
        seen = set(coverage.visible)
        counts.append(len(seen))
    assert counts[0] > counts[1] >= counts[2] > 0
    # what only forces can show
    blind = coverage_of(simulator, without(whole, "force_n"))
    assert {"force_gain", "force_bias", "force_delay"} <= set(blind.hidden)


def test_the_command_prints_it_as_text_and_as_json(
    whole: Trial, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "run.parquet"
    write_trial(without(whole, "force_n"), table)
    assert cli.run(["import", str(table)]) == 0
    shown = capsys.readouterr().out
    assert "odometry      yes: shaft angles and speeds of all 6 joints" in shown
    assert "forces        no: no sensors" in shown
    assert "effects visible, in shafts, feet (markers), body; not measured: forces" in shown
    assert cli.run(["import", str(table), "--json"]) == 0
    answers = json.loads(capsys.readouterr().out)["can_be_asked"]
    assert [one["question"] for one in answers if not one["answered"]] == ["forces"]


def test_an_import_that_leaves_nothing_writes_nothing_and_is_a_bad_verdict(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "t.csv").write_text("time_s,shaft_L_rad\n0,1\n0.01,1\n")
    (tmp_path / "map.toml").write_text("[cut]\nfewest_rows = 9\n[trial]\nlegs = ['L']\n")
    words = ["import", str(tmp_path / "t.csv"), "--map", str(tmp_path / "map.toml")]
    assert cli.run([*words, "--out", str(tmp_path / "t.mcap")]) == ExitCode.VERDICT_FAILED
    assert "t.mcap is not written" in capsys.readouterr().err
    assert not (tmp_path / "t.mcap").exists()


def test_tables_are_counted_and_not_their_faults(tmp_path: Path) -> None:
    """A table may have a fault of a kind several times; and only the first few are asked what they can."""
    leg = DataFault("swapped", "force_L1_z_n", "is loaded when L2 should be", severe=True)
    faults = (leg, replace(leg, evidence="is loaded when L3 should be"))
    can = (Ability("odometry", True, "shafts"),)

    def table(number: int, own: tuple[DataFault, ...], asked: tuple[Ability, ...]) -> TableReport:
        report = ImportReport(tmp_path / f"run{number}.csv", "", 10, 10, (), ("time_s",), ())
        return TableReport(report, own, (), asked)

    lines = all_lines([table(0, faults, can), table(1, faults, can)])
    assert [one.split(": ")[0] for one in lines if "swapped" in one] == [
        "fault  swapped force_L1_z_n (severe) in all 2"
    ]
    assert "looked at" not in "\n".join(lines)
    lines = all_lines([table(0, faults, can), table(1, (), can), table(2, (), ())])
    assert any(
        "swapped force_L1_z_n (severe) in 1 of 3: run0: is loaded when L2" in x for x in lines
    )
    assert lines[-2].split(maxsplit=1) == ["uses", "looked at in 2 of 3 tables only:"]
    assert lines[-1].endswith("yes: shafts (2 of 2)")


MJCF = """
<mujoco><worldbody><body name="hip"><joint name="L1_yaw" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.01" mass="0.3"/></body></worldbody></mujoco>
"""
MJCF_MAP = """
[columns]
time_s = "t"
command_L1_yaw_rad = "goal"
shaft_L1_yaw_rad = "angle"
force_L1_z_n = "Fz"
[trial]
robot = "leg.xml"
[drive]
kind = "position"
kp_nm_rad = 20.0
kd_nm_s_rad = 0.5
torque_limit_nm = 6.0
"""


def test_the_leg_of_a_force_is_no_joint_of_an_mjcf(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A force names its leg, L1; the joints are those that have commands and shafts."""
    for name, text in (("leg.xml", MJCF), ("map.toml", MJCF_MAP)):
        (tmp_path / name).write_text(text)
    t = np.arange(400) / 100.0
    angle = 0.3 * np.sin(2.0 * t)
    rows = np.column_stack([t, angle, angle, 5.0 + np.cos(2.0 * t)])
    table = tmp_path / "run.csv"
    np.savetxt(table, rows, delimiter=",", header="t,goal,angle,Fz", comments="", fmt="%.6f")
    assert cli.run(["import", str(table), "--map", str(tmp_path / "map.toml"), "--json"]) == 0
    (diagnosis,) = json.loads(capsys.readouterr().out)["can_be_asked"]
    assert diagnosis["answered"], diagnosis["words"]
    assert "effects visible, in shafts" in diagnosis["words"]
    assert diagnosis["words"].endswith("as the simulator does not predict them: forces")


def test_torque_that_was_logged_is_compared_with_a_model_s() -> None:
    run = arm_log(2.0)
    torque = [TableColumn(f"torque_{one}_nm", np.ones(len(run.time_s))) for one in run.joints]
    columns = [TableColumn("time_s", run.time_s)]
    for at, one in enumerate(run.joints):
        columns += [
            TableColumn(f"command_{one}_rad", run.command_rad[:, at]),
            TableColumn(f"shaft_{one}_rad", run.shaft_rad[:, at]),
        ]
    for more, words in ([], "visible, in shafts"), (torque, "visible, in shafts, torque"):
        (diagnosis,) = abilities(build_trial(run.header, (*columns, *more)))
        assert diagnosis.words.endswith(words), diagnosis.words


# What runs cannot show, said before they are judged.

BODY = ("body_position_m", "body_angles_rad")
SHAFT_EFFECTS = {
    "command_delay", "servo_lag", "servo_speed_limit", "servo_compliance", "gear_backlash",
    "gear_backlash_in_loop", "gear_backlash_dragged", "joint_friction", "encoder_scale",
}  # fmt: skip


def test_with_every_sensor_nothing_hides(whole: Trial) -> None:
    spots = blind_spots(run_simulator(whole), [whole])
    assert spots.missing == ()
    assert spots.effects == ()
    assert blind_lines(spots) == []
    assert blind_json(spots)["not_excited"] == []


def test_without_a_sensor_its_own_effects_hide_and_the_sensor_is_named(whole: Trial) -> None:
    simulator = run_simulator(whole)
    spots = blind_spots(simulator, [without(whole, "force_n")])
    totals = tuple(f"total_{kind}_{axis}" for kind in ("force", "moment") for axis in "xyz")
    assert spots.missing == ("force_z", "force_x", "force_y", *totals, "pull_z", "grip")
    hidden = {one.effect for one in spots.effects}
    own = {e.name for e in simulator.effects if e.name.startswith("force_")}
    # the common scale of friction is invisible without newtons (gap-contract, 4)
    assert own | {"friction_level"} <= hidden
    assert hidden.isdisjoint({"payload", "com_offset", "leg_length", "servo_lag"})
    text = "\n".join(blind_lines(spots))
    assert text.startswith("not measured: force sensors; these runs cannot show, whatever is wrong")
    assert "friction_level" in text
    assert "to be seen with force sensors" in text
    listed = blind_json(spots)["cannot_be_seen"]
    assert {"effect": "friction_level", "sensors": ("force sensors",)} in listed  # type: ignore[operator]


def test_without_markers_no_force_sensor_is_said_to_be_missing(whole: Trial) -> None:
    """The moment of forces needs both; only what is missing is named."""
    spots = blind_spots(run_simulator(whole), [without(whole, "foot_m")])
    assert {"foot_x", "total_moment_x"} <= set(spots.missing)
    assert sensors_of(spots.missing, spots.missing) == ("foot markers",)


def test_vertical_forces_alone_are_no_missing_sensors(whole: Trial) -> None:
    """Only the other axes are missing, and that is what is said."""
    force = whole.force_n.copy()
    force[..., :2] = np.nan
    trial = replace(whole, force_n=force)
    assert said(trial)["forces"] == (True, f"of {', '.join(whole.legs)}, without x and y")
    (line, *_) = blind_lines(blind_spots(run_simulator(whole), [trial]))
    assert line.startswith("not measured: horizontal foot forces; these runs")


def test_joints_alone_show_what_moves_shafts_and_nothing_else(whole: Trial) -> None:
    simulator = run_simulator(whole)
    spots = blind_spots(simulator, [without(whole, "force_n", "foot_m", *BODY)])
    hidden = {one.effect for one in spots.effects}
    assert {e.name for e in simulator.effects} - hidden == SHAFT_EFFECTS
    assert "the body's pose" in blind_lines(spots)[0]
    body = blind_spots(simulator, [without(whole, "force_n", "foot_m", "shaft_rad", "shaft_rad_s")])
    assert "encoder_scale" in {one.effect for one in body.effects}
    assert "payload" not in {one.effect for one in body.effects}


def at_leg(trial: Trial, leg: int, *fields: str) -> Trial:
    """The trial without what was measured at one leg."""
    values = {field: getattr(trial, field).copy() for field in fields}
    for value in values.values():
        value[:, leg] = np.nan
    return replace(trial, **values)


def test_places_on_the_ground_hide_as_well_where_nothing_says_how_far_it_walked(
    whole: Trial,
) -> None:
    spots = blind_spots(run_simulator(whole), [without(whole, "force_n", "foot_m", *BODY)])
    sensors = {one.effect: sensors_of(one.channels, spots.missing) for one in spots.effects}
    assert "the body's pose" in sensors["ground_step"]
    assert "force sensors" in sensors["friction_patch"]
    assert all(sensors.values())


def test_an_effect_that_forces_hardly_show_is_to_be_seen_with_them(whole: Trial) -> None:
    """What hides without a sensor and not with it, hides for want of it."""
    spots = blind_spots(run_simulator(whole), [without(whole, "force_n")])
    assert blind_json(spots)["not_excited"] == []
    assert "tilt_coupling" in "".join(blind_lines(spots))


def test_without_commands_effects_of_shafts_are_to_be_seen_with_commands(whole: Trial) -> None:
    spots = blind_spots(run_simulator(whole), [without(whole, "command_rad")])
    assert blind_json(spots)["not_measured"] == ("command",)
    first, second = blind_lines(spots)
    assert first == "not measured: commands; these runs cannot show, whatever is wrong"
    assert {"servo_lag", "command_delay", "joint_friction"} <= set(
        second.split(" (")[0].strip().split(", ")
    )
    assert second.endswith("(to be seen with commands)")
    assert "not measured: commands" in said(without(whole, "command_rad"))["diagnosis"][1]


@pytest.mark.parametrize(
    ("fields", "missing", "effects"),
    [
        (("shaft_rad", "shaft_rad_s"), "joint angles of HL", "encoder_scale"),
        (("force_n",), "force sensors of HL", "force_gain"),
        (("foot_m",), "foot markers of HL", ""),
    ],
)
def test_what_one_leg_lacks_is_said_with_the_leg(
    whole: Trial, fields: tuple[str, ...], missing: str, effects: str
) -> None:
    spots = blind_spots(run_simulator(whole), [at_leg(whole, 0, *fields)])
    first, *hidden = blind_lines(spots)
    assert first.startswith(f"not measured: {missing}; ")
    assert any(line.startswith("  at HL: ") and effects in line for line in hidden) or not effects
    assert {one["effect"] for one in blind_json(spots)["cannot_be_seen_at"]} >= {effects} - {""}  # type: ignore[attr-defined]


def test_legs_that_lack_the_same_sensor_are_named_together(whole: Trial) -> None:
    trial = at_leg(at_leg(whole, 0, "force_n"), 2, "force_n", "foot_m")
    first, hidden = blind_lines(blind_spots(run_simulator(whole), [trial]))
    assert "force sensors of FL, HL" in first or "force sensors of HL, FL" in first
    assert "foot markers of FL" in first
    assert hidden.startswith("  at HL, FL: force_gain, ")


def test_runs_without_anything_measured_are_refused_with_what_is_missing(
    whole: Trial, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "walk.parquet"
    everything = ("command_rad", "shaft_rad", "shaft_rad_s", "force_n", "foot_m", *BODY)
    write_trial(without(whole, *everything), path)
    assert cli.run(["gap", "diagnose", str(path)]) != ExitCode.OK
    told = capsys.readouterr()
    assert "these runs cannot show" not in told.out
    missing = "commands, joint angles, foot markers, force sensors, the body's pose"
    assert "there is nothing to diagnose: without commands or joint angles" in told.err
    assert f"not measured: {missing}" in told.err


def test_a_shaft_gives_under_predicted_loads_where_none_were_measured(whole: Trial) -> None:
    simulator = run_simulator(whole)
    soft = (Cause("servo_compliance", (), (0.02,)),)
    changes = []
    for trial in (whole, without(whole, "force_n")):
        apart = simulator.predict(trial, soft, Drive.MEASURED) - simulator.predict(
            trial, (), Drive.MEASURED
        )
        changes.append(apart[20:-20, :6].ravel())
    assert np.std(changes[0]) > 1e-3
    assert np.corrcoef(changes[0], changes[1])[0, 1] > 0.8
    assert np.std(changes[1]) == pytest.approx(np.std(changes[0]), rel=0.25)


def test_it_is_said_before_the_runs_are_judged(
    whole: Trial,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "walk.parquet"
    write_trial(without(whole, "force_n", "foot_m"), path)

    def judge(*_: object) -> None:
        raise GapError("judged")

    monkeypatch.setattr(diagnose, "diagnosis_of", judge)
    assert cli.run(["gap", "diagnose", str(path)]) != 0
    told = capsys.readouterr()
    assert "not measured: foot markers, force sensors" in told.out
    assert "friction_level" in told.out
    assert "judged" in told.err
