"""``gap apply`` and ``gap next`` for machines that are no legged robots."""

import json
import tomllib
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from gap.experiments.open_causes import discriminating_runs, open_sets
from gap.interfaces import Cause, Drive
from gap.machine_kinds import kind_named
from gap.machines.servo_bench.machine import with_causes
from gap.machines.servo_bench.simulator import servo_bench
from gap.machines.sliding_body.simulator import sliding_body
from gap.machines.sliding_body.simulator import with_causes as with_body_causes
from gap.search.candidates import Candidate
from record.trial.header import SERVO_BENCH
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial, write_trial
from robot.cli import main as cli
from robot.gap_report.answer import diagnosed_runs
from robot.gap_report.study import study_of
from robot.gap_report.trials import runs_of_diagnosis
from tests.gap.bench_trials import MOTOR, servo_trial, slide_trial
from tests.gap.mjcf_arms import arm_log

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "own_machine.py"
WEAK = MOTOR.replace("kp_duty_per_rad = 4.0", "kp_duty_per_rad = 2.0")
T = np.arange(400) / 50
THERE = (Cause("controller_gain", ("arm",), (0.5,)), Cause("play", ("arm",), (0.05,)))


def lacking(robot: str, name: str, hertz: float) -> Trial:
    command = 0.9 * np.sin(2 * np.pi * hertz * T)
    trial = servo_trial(robot, command)
    predicted = servo_bench([trial]).predict(trial, THERE, Drive.COMMAND)
    noise = np.random.default_rng(0).normal(0, 0.001, len(T))
    shaft = (command + predicted[:, 0] + noise)[:, None]
    header = replace(trial.header, robot_file=name, gait="")
    return replace(trial, header=header, shaft_rad=shaft, pwm=predicted[:, 1:2] + noise[:, None])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A diagnosis of runs of two machine's files."""
    folder = tmp_path_factory.mktemp("two")
    for number, (robot, name) in enumerate(((MOTOR, "strong.toml"), (WEAK, "weak.toml")) * 2):
        run = lacking(robot, name, 0.3 + 0.2 * number)
        write_trial(run, folder / f"run{number}.parquet")
    runs = sorted(map(str, folder.glob("run?.parquet")))
    out = str(folder / "d.json")
    assert cli.run(["gap", "diagnose", *runs, "--json", out, "--jobs", "1"]) == 0
    return folder


def test_the_causes_go_into_every_machine_s_file_and_the_gap_is_measured_again(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = folder / "corrected"
    words = ["gap", "apply", str(folder / "d.json"), "--out", str(out)]
    assert cli.run([*words[:-1], "one.toml"]) == 2
    assert "name 2 machine's files (strong.toml, weak.toml)" in capsys.readouterr().err
    assert cli.run(words) == 0
    said = capsys.readouterr().out
    assert f"written: {out / 'weak.toml'}" in said
    assert "of the gap is explained (diagnosis: 100%)" in said
    for name, kp in (("strong", 4.0), ("weak", 2.0)):
        written = tomllib.loads((out / f"{name}.toml").read_text())["joint"]["arm"]
        assert written["controller"]["kp_duty_per_rad"] == kp
        assert written["effects"]["controller_gain"]["ratio"] == pytest.approx(0.5, abs=0.01)
        assert written["effects"]["play"]["width_rad"] == pytest.approx(0.05, abs=0.002)
    assert cli.run(words) == 2
    assert "exists; choose another name" in capsys.readouterr().err


def test_a_diagnosis_of_one_joint_is_measured_again_at_that_joint(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What the other one lacks was no part of the question."""
    bench = MOTOR + MOTOR[MOTOR.index("[joint.arm]") :].replace("arm", "leg")
    for number in range(3):
        runs = [
            lacking(MOTOR, "bench.toml", 0.3 + 0.2 * number),
            servo_trial(MOTOR, 0.9 * np.sin(2 * np.pi * 0.3 * T), np.zeros(len(T))),
        ]
        columns = [TableColumn("time_s", T)]
        for name, one in zip(("arm", "leg"), runs, strict=True):
            columns.append(TableColumn(f"command_{name}_rad", one.command_rad[:, 0]))
            columns.append(TableColumn(f"shaft_{name}_rad", one.shaft_rad[:, 0]))
        header = replace(runs[0].header, joints=("arm", "leg"), robot_text=bench)
        write_trial(build_trial(header, tuple(columns)), tmp_path / f"run{number}.parquet")
    files = sorted(map(str, tmp_path.glob("run?.parquet")))
    out = str(tmp_path / "d.json")
    words = ["gap", "diagnose", *files, "--joint", "arm", "--json", out, "--jobs", "1"]
    assert cli.run(words) in {0, 1}
    told = json.loads(Path(out).read_text())
    assert told["causes"]
    capsys.readouterr()
    words = ["gap", "apply", out, "--out", str(tmp_path / "c.toml"), "--anyway", "--json"]
    assert cli.run(words) == 0
    found = json.loads(capsys.readouterr().out)["gap"]
    assert {one["joint"] for one in found["channels"]} == {"arm"}
    assert found["before"] == pytest.approx(told["gap"]["before_over_floor"], rel=1e-6)
    assert found["shrink"] == pytest.approx(told["gap"]["shrink"], abs=1e-6)


def test_what_a_models_file_cannot_hold_is_said(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A delay is of the drive: it explains a part that the corrected file does not."""
    write_trial(arm_log(6.0), tmp_path / "run.parquet")
    answer = json.loads((folder / "d.json").read_text())
    answer |= {"simulator": "mjcf", "files": [str(tmp_path / "run.parquet")], "ambiguous_with": []}
    answer |= {"trials": {"fitted": [0], "held_out": [0]}, "verdict": "explained"}
    sizes = {"command_delay": ("delay_s", 0.02), "coulomb_friction": ("coulomb_nm", 0.3)}
    answer["causes"] = [
        {"effect": effect, "legs": ["fore"], "parameters": {name: size}, "on_bound": []}
        for effect, (name, size) in sizes.items()
    ]
    (tmp_path / "d.json").write_text(json.dumps(answer))
    words = ["gap", "apply", str(tmp_path / "d.json"), "--out"]
    assert cli.run([*words, str(tmp_path / "a.xml")]) in {0, 1}
    left = "not written, as it is of the drive or the log, not of this file: command_delay\n"
    assert left in capsys.readouterr().out
    assert cli.run([*words, str(tmp_path / "b.xml"), "--json"]) in {0, 1}
    assert json.loads(capsys.readouterr().out)["not_written"] == ["command_delay"]


def test_a_corrected_file_says_what_the_causes_said_and_takes_more() -> None:
    trial = servo_trial(MOTOR, 0.9 * np.sin(2 * T))
    effects = servo_bench([trial]).effects
    once = with_causes(MOTOR, THERE, effects)
    corrected = replace(trial, header=replace(trial.header, robot_text=once))
    expected = servo_bench([trial]).predict(trial, THERE, Drive.COMMAND)
    assert np.array_equal(servo_bench([corrected]).predict(corrected, (), Drive.COMMAND), expected)
    twice = tomllib.loads(with_causes(once, THERE, effects))["joint"]["arm"]["effects"]
    assert twice["controller_gain"]["ratio"] == pytest.approx(0.25)
    assert twice["play"]["width_rad"] == pytest.approx(0.10)


def test_causes_of_a_sliding_body_go_into_its_file() -> None:
    push = np.cumsum(np.linspace(1.0, 0.1, 200))[:, None] * np.array([[0.006, 0.002]])
    trial = slide_trial(push)
    causes = (
        Cause("coulomb_friction", (), (0.25,)), Cause("speed_dependence", (), (0.3,)),
        Cause("ground_slope", (), (0.01, -0.02)), Cause("pose_delay", (), (0.02,)),
    )  # fmt: skip
    text = with_body_causes(trial.header.robot_text, causes, sliding_body([trial]).effects)
    assert "mass = 0.37" in text
    corrected = replace(trial, header=replace(trial.header, robot_text=text))
    expected = sliding_body([trial]).predict(trial, causes, Drive.COMMAND)
    own = sliding_body([corrected]).predict(corrected, (), Drive.COMMAND)
    np.testing.assert_allclose(own, expected, rtol=1e-12)


def test_the_next_run_of_a_bench_is_a_motion_within_its_range(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["gap", "next", str(folder / "d.json"), "--against", "supply_voltage@arm", "--json"]
    assert cli.run(words) in {0, 1}
    runs = json.loads(capsys.readouterr().out)["runs"]
    assert runs
    assert all(one["separation"] > 0 and one["command"] == "" for one in runs)
    assert any("the current (current_J_a) logged" in one["name"] for one in runs)
    assert not any("the duty" in one["name"] for one in runs), "it was logged already"


def test_alternatives_are_compared_beside_the_baseline_model_errors(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A run that settles it is ranked by the simulator that the diagnosis compares with."""
    answer = json.loads((folder / "d.json").read_text())
    gain, play = sorted(answer["causes"], key=lambda one: str(one["effect"]))
    there = Cause("play", ("arm",), (play["parameters"]["width_rad"],))
    open_rival = {"cause": 0, "effect": "supply_voltage", "form": "supply_voltage", "legs": ["arm"]}
    answer |= {"causes": [gain], "standing": [asdict(there)], "open_rivals": [open_rival]}
    answer["files"] = [str(folder / Path(name).name) for name in answer["files"]]
    file = tmp_path / "beside.json"
    file.write_text(json.dumps(answer))
    assert cli.run(["gap", "next", str(file), "--json"]) in {0, 1}
    found = json.loads(capsys.readouterr().out)
    runs = runs_of_diagnosis(diagnosed_runs(file))
    study = study_of(runs, runs.simulator(), (there,))
    effects = {one.name: one for one in study.simulator.effects}
    causes = (Cause("controller_gain", ("arm",), (gain["parameters"]["ratio"],)),)
    known, floor = study.predictor, study.floor(study.judging)
    rival = Candidate(effects["supply_voltage"], ("arm",))
    sets = open_sets(known, study.trials, floor, causes, [(0, rival)], study.judging)
    (size,) = (one["parameters"]["ratio"] for one in found["candidates"][1])
    assert size == pytest.approx(sets[1][0].values[0], rel=1e-9)
    propose = kind_named(SERVO_BENCH).propose
    assert propose is not None
    expected = discriminating_runs(known, floor, sets, propose(runs.trials))
    assert [one["name"] for one in found["runs"]] == [one.name for one in expected]
    assert [one["separation"] for one in found["runs"]] == pytest.approx(
        [one.separation for one in expected], rel=1e-6
    )


def test_a_machine_that_can_do_neither_says_so_in_a_sentence(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    answer = json.loads((folder / "d.json").read_text())
    answer |= {"simulator": "tendon", "machine": f"{EXAMPLE}:make", "ambiguous_with": []}
    answer["causes"] = [
        {"effect": "slack", "legs": ["arm"], "parameters": {"width_rad": 0.1}, "on_bound": []}
    ]
    file = tmp_path / "tendon.json"
    file.write_text(json.dumps(answer))
    assert cli.run(["gap", "apply", str(file), "--out", str(tmp_path / "x.toml")]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "a machine of kind own_machine has no way to write a cause into its file" in said
    assert cli.run(["gap", "next", str(file)]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "a machine of kind own_machine does not say which runs it could make" in said
    assert not (tmp_path / "x.toml").exists()
