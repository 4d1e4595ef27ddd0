"""``--hold-out``, ``--machine`` and what is said before a diagnosis begins."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap.interfaces import Cause, Drive
from gap.machines.servo_bench.simulator import servo_bench
from record.trial.trial import Trial, read_trial, write_trial
from robot.cli import main as cli
from tests.gap.bench_trials import MOTOR, servo_trial

EXAMPLE = Path(__file__).resolve().parents[3] / "examples" / "own_machine.py"
T = np.arange(400) / 50
WAVES = {"slow": 0.3, "fast": 0.9, "steps": 0.5}


def bench_run(wave: str, gain: float) -> Trial:
    command = 0.9 * np.sin(2 * np.pi * WAVES[wave] * T)
    if wave == "steps":
        command = np.sign(command)
    trial = servo_trial(MOTOR, command, torque=np.cos(T))
    halved = Cause("controller_gain", ("arm",), (gain,))
    predicted = servo_bench([trial]).predict(trial, (halved,), Drive.COMMAND)
    noise = np.random.default_rng(len(wave)).normal(0, 0.001, len(T))
    header = replace(trial.header, gait="", conditions=(("trajectory", wave), ("load_kg", 0.5)))
    shaft = (command + predicted[:, 0] + noise)[:, None]
    return replace(trial, header=header, shaft_rad=shaft, pwm=predicted[:, 1:2] + noise[:, None])


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder = tmp_path_factory.mktemp("bench")
    for wave in WAVES:
        write_trial(bench_run(wave, 0.5), folder / f"{wave}.parquet")
    return [str(folder / f"{wave}.parquet") for wave in WAVES]


def test_what_is_held_out_is_chosen_and_said_first(
    runs: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["gap", "diagnose", *runs, "--hold-out", "trajectory=steps", "--jobs", "1"]
    assert cli.run(words) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(
        "fitted to slow.parquet, fast.parquet; held out for testing (trajectory="
    )
    assert "compared at 50 Hz; logged at 50 Hz" in lines
    assert lines.index("EXPLAINED") > lines.index("compared at 50 Hz; logged at 50 Hz")
    assert any("controller_gain at arm (ratio 0.50" in line for line in lines)
    assert any(line.startswith("held out for testing: steps.parquet") for line in lines)


@pytest.mark.parametrize(
    ("chosen", "words"),
    [
        (["trajectory=swim"], "no run is; trajectory is fast, slow, steps"),
        (["surface=mat"], "no run says surface; they say trajectory, load_kg: write it into [conditions]"),
        (["load_kg=0.5"], "holds out every run; leave some to fit to"),
        (["steps"], "write KEY=VALUE, trial=NAME or last-third"),
        (["last-third", "trial=slow"], "last-third is of every run"),
    ],
)  # fmt: skip
def test_a_choice_that_cannot_be_is_refused(
    runs: list[str], capsys: pytest.CaptureFixture[str], chosen: list[str], words: str
) -> None:
    options = [part for one in chosen for part in ("--hold-out", one)]
    assert cli.run(["gap", "diagnose", *runs, *options]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert words in said


@pytest.mark.parametrize(
    ("chosen", "first"),
    [
        ("trial=slow", "fitted to fast.parquet, steps"),
        ("last-third", "fitted to the first two thirds of slow"),
    ],
)
def test_runs_are_held_out_by_name_or_by_their_end(
    runs: list[str], capsys: pytest.CaptureFixture[str], chosen: str, first: str
) -> None:
    words = [
        "gap",
        "diagnose",
        "--alone",
        *runs,
        "--effect",
        "controller_gain",
        "--hold-out",
        chosen,
    ]
    assert cli.run(words) == 0
    capsys.readouterr()
    assert cli.run(["gap", "diagnose", *runs, "--hold-out", chosen, "--jobs", "1"]) == 0
    assert capsys.readouterr().out.startswith(first)


def test_a_missing_command_or_another_unit_of_time_is_said_at_once(
    runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    trial = read_trial(Path(runs[0]))
    header = replace(trial.header, sample_rate_hz=np.nan)
    for name, changed, words in (
        ("mute", replace(trial, command_rad=np.full((400, 1), np.nan)), "command_arm_rad is empty"),
        ("ms", replace(trial, header=header, time_s=1e3 * trial.time_s), "time is not in seconds"),
    ):
        file = tmp_path / f"{name}.parquet"
        write_trial(changed, file)
        out = tmp_path / "d.json"
        assert cli.run(["gap", "diagnose", str(file), "--json", str(out)]) == 2
        said = capsys.readouterr()
        assert words in " ".join(said.err.split())
        assert not out.exists()


def test_a_machine_of_one_s_own_is_diagnosed_by_the_command(
    runs: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["gap", "diagnose", *runs, "--machine", f"{EXAMPLE}:make", "--jobs", "1"]
    assert cli.run([*words, "--json", "-"]) in {0, 1}
    assert json.loads(capsys.readouterr().out)["simulator"] == "tendon"
    assert cli.run(["gap", "diagnose", *runs, "--machine", "nowhere.py:make"]) == 2
    assert "there is no file nowhere.py" in capsys.readouterr().err
