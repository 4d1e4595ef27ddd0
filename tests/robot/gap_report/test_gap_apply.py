"""``bigant gap apply`` and ``bigant gap next`` from a diagnosis on disk, and what they refuse."""

import json
import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gap.diagnosis.comparison.commissioning import commissioned_study
from gap.diagnosis.comparison.how_far import how_far
from gap.effect_file import read_effects
from gap.interfaces import Cause
from gap.residuals.hold_out import HoldOut
from model.effects.catalogue import STAGES
from record.trial.trial import write_trial
from robot.cli.main import run
from robot.config.robot_file import load_robot
from robot.gap_report.trials import read_runs
from robot.virtual.twin_rollout import twin_simulator
from tests.gap.walks import cause, walk

DOCS = Path(__file__).resolve().parents[3] / "docs" / "gap_effects.md"
WRONG = (
    cause("force_bias", 0.0, 0.0, -3.0, legs=("ML",)),
    cause("foot_friction", 0.5, legs=("FR",)),
)


def write_runs(folder: Path, causes: tuple[Cause, ...], count: int = 3) -> list[str]:
    """Runs of the chain with causes, as files."""
    paths = []
    for number in range(count):
        path = folder / f"run{number}.parquet"
        write_trial(walk("tripod", 0.2 + 0.05 * number, 7.0, causes, noise_seed=number), path)
        paths.append(str(path))
    return paths


def answer(folder: Path, files: list[str], **more: Any) -> Path:
    """A diagnosis in the shape that any program may write."""
    told = {
        "verdict": "explained",
        "where": {"stage": "sensing"},
        "causes": [
            {"effect": "force_bias", "legs": ["ML"], "parameters": {"z_n": -3.0}, "probability": 0.9},
            {"effect": "foot_friction", "legs": ["FR"], "parameters": {"ratio": 0.5}, "probability": 0.9},
        ],
        "ambiguous_with": [],
        "gap": {"before": 1.0, "after": 0.1, "noise_floor": 0.05, "shrink": 0.98},
        "files": files,
        **more,
    }  # fmt: skip
    path = folder / "diagnosis.json"
    path.write_text(json.dumps(told), encoding="utf-8")
    return path


def test_apply_writes_the_file_and_measures_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = answer(tmp_path, write_runs(tmp_path, WRONG))
    out = tmp_path / "corrected.toml"
    assert run(["gap", "apply", str(path), "--out", str(out)]) == 0
    told = capsys.readouterr().out
    assert "contact.mu[FR]" in told
    assert "[effects.force_bias.ML]" in told
    assert "subtracted from the reading" in told
    closed = re.search(r"  (\d+)% \[\d+%, \d+%\] of the gap is explained \(diagnosis: 98%\)", told)
    assert closed
    assert int(closed.group(1)) > 95
    config = load_robot(out)
    assert config.effects == (cause("force_bias", 0.0, 0.0, -3.0, legs=("ML",)),)
    assert config.parameters.contact.mu[5] == pytest.approx(0.3)
    again = tmp_path / "again.toml"
    assert run(["gap", "apply", str(path), "--out", str(again), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["keys"] == [
        {"key": "contact.mu[FR]", "before": 0.6, "after": 0.3, "why": "foot_friction at FR"}
    ]
    assert found["gap"]["after"] < 0.3 * found["gap"]["before"]
    assert again.read_text(encoding="utf-8") == out.read_text(encoding="utf-8")


def test_a_wrong_cause_does_not_pass(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    files = write_runs(tmp_path, (cause("force_bias", 0.0, 0.0, 3.0, legs=("ML",)),))
    worse = [{"effect": "force_bias", "legs": ["ML"], "parameters": {"z_n": -3.0}}]
    path = answer(tmp_path, files, causes=worse)
    assert run(["gap", "apply", str(path), "--out", str(tmp_path / "c.toml")]) == 1
    assert "NOT SMALLER" in capsys.readouterr().out


LAG = cause("servo_lag", 0.06)


def test_apply_has_the_figure_of_the_diagnosis_beside_baseline_model_errors(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Servos that lag in healthy runs, too, are of the simulator that the diagnosis compares with."""
    files = write_runs(tmp_path, (*WRONG, LAG))
    (tmp_path / "healthy").mkdir()
    references = write_runs(tmp_path / "healthy", (LAG,))
    runs = read_runs(list(map(Path, files)), list(map(Path, references)))
    held, simulator = HoldOut((1,)), runs.simulator()
    study = commissioned_study(
        runs.trials, simulator, runs.references, hold_out=held, standing=(LAG,)
    )
    far = how_far(study.held_evidence(), WRONG, seed=3)
    gap = {
        "shrink": far.shrink, "shrink_interval": [far.low, far.high], "before_over_floor": far.before,
    }  # fmt: skip
    path = answer(
        tmp_path, [*files, *references], references=3, standing=[asdict(LAG)], gap=gap, seed=3,
        trials={"fitted": [0, 2], "held_out": [1]},
    )  # fmt: skip
    assert run(["gap", "apply", str(path), "--out", str(tmp_path / "c.toml"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["gap"]
    assert found["before"] == pytest.approx(far.before, rel=1e-6)
    assert found["after"] == pytest.approx(far.after, rel=1e-5)
    assert found["shrink_interval"] == pytest.approx([far.low, far.high], rel=1e-5)
    assert found["as_in_diagnosis"]


@pytest.mark.parametrize(
    ("shrink", "interval", "words"),
    [
        (-0.64, [-0.71, -0.58], "-64% [-71%, -58%] on these runs: the share has the other sign"),
        (0.5, [0.4, 0.6], "50% [40%, 60%] on these runs: the share is outside its interval"),
    ],
)
def test_a_share_that_the_diagnosis_did_not_measure_does_not_pass(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    shrink: float,
    interval: list[float],
    words: str,
) -> None:
    gap = {"shrink": shrink, "shrink_interval": interval, "before_over_floor": 2.0}
    path = answer(tmp_path, write_runs(tmp_path, WRONG), gap=gap)
    assert run(["gap", "apply", str(path), "--out", str(tmp_path / "c.toml")]) == 1
    told = " ".join(capsys.readouterr().out.split())
    assert (
        f"NOT AS IN THE DIAGNOSIS, which measured {words} before the correction the RMS is" in told
    )
    assert re.search(r"in the diagnosis 2\S*: the runs, the robot file", told)
    assert "do not use this file before you have diagnosed again" in told


@pytest.mark.parametrize(
    ("more", "options", "words"),
    [
        ({"causes": [], "verdict": "no_gap"}, [], "there is nothing to apply"),
        ({"verdict": "unexplained"}, [], "--anyway"),
        ({"severe_data_faults": ["shaft_ML_rad"]}, [], "severe faults (shaft_ML_rad)"),
        ({"simulator": "servo_bench"}, [], "say what machine it is"),
        ({"causes": [{"effect": "worn_crank", "legs": ["ML"]}]}, [], "needs --effects FILE.py"),
        ({"causes": [{"effect": "drag", "parameters": {"n_s_per_m": 300.0},
                      "on_bound": ["n_s_per_m"]}]}, [], "is on its bound"),
        ({"files": ["gone.parquet"]}, [], "give it with --robot"),
        ({}, ["--out", "corrected.txt"], "must end in .toml"),
        ({"gap": None}, [], "is no diagnosis"),
    ],
)  # fmt: skip
def test_what_cannot_be_applied_is_refused_in_one_line(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    more: dict[str, Any],
    options: list[str],
    words: str,
) -> None:
    path = answer(tmp_path, **{"files": [], **more})
    assert run(["gap", "apply", str(path), "--out", str(tmp_path / "c.toml"), *options]) not in {
        0,
        1,
    }
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert words in lines[0]
    assert not (tmp_path / "c.toml").exists()


@pytest.mark.parametrize("command", ["apply", "next"])
def test_a_file_of_another_kind_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], command: str
) -> None:
    """A run where a diagnosis is wanted, and a page where a run is."""
    page, out = tmp_path / "walk.html", ["--out", str(tmp_path / "c.toml")]
    page.write_text("<p>")
    if command == "apply":
        assert run(["gap", "apply", "walk.mcap", *out]) != 0
        words = "walk.mcap is a run; give the file of: bigant gap diagnose --json"
    else:
        assert run(["gap", "next", str(page)]) != 0
        words = "walk.html is no run: runs end in .parquet, .csv, .toml, .mcap"
    assert words in capsys.readouterr().err


def test_without_its_runs_a_diagnosis_is_applied_but_not_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = answer(tmp_path, ["gone.parquet"]), tmp_path / "c.toml"
    assert run(["gap", "apply", str(path), "--robot", "config/bigant.toml", "--out", str(out)]) == 0
    assert "not measured again" in capsys.readouterr().out
    assert load_robot(out).effects


def test_next_ranks_runs_with_their_commands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    delay = cause("command_delay", 0.04)
    files = write_runs(tmp_path, (delay,), 2)
    found = [{"effect": "command_delay", "legs": [], "parameters": {"delay_s": 0.04}}]
    path = answer(tmp_path, files, causes=found, ambiguous_with=[["command_delay", "servo_lag"]])
    assert run(["gap", "next", str(path)]) == 0
    told = capsys.readouterr().out
    assert "servo_lag (time_constant_s 0.04" in told
    assert re.search(r"1\. (tripod|metachronal) at", told)
    assert "   bigant drive --gait " in told
    assert run(["gap", "next", str(path), "--json", "--against", "servo_speed_limit"]) == 0
    ranked = json.loads(capsys.readouterr().out)
    assert [c[0]["effect"] for c in ranked["candidates"]] == [
        "command_delay", "servo_lag", "servo_speed_limit",
    ]  # fmt: skip
    worth = [one["separation"] * one["runs"] / one["minutes"] for one in ranked["runs"]]
    assert worth == sorted(worth, reverse=True)
    assert all(one["command"].startswith("bigant drive --gait") for one in ranked["runs"])
    calm = answer(tmp_path, files, causes=found)
    assert run(["gap", "next", str(calm)]) == 0
    assert "nothing is left open" in capsys.readouterr().out


@pytest.mark.soak
def test_next_proposes_the_runs_of_the_diagnosis_and_apply_has_its_figure(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """From healthy runs of two gaits that all have a lag, which no diagnosis may call new."""

    def walked(name: str, first: int, *causes: Cause) -> list[str]:
        paths = []
        for number, gait in enumerate(("tripod", "metachronal") * 2):
            path = tmp_path / f"{name}{number}.parquet"
            made = walk(gait, 0.15 + 0.05 * (number // 2), 12.0, causes, noise_seed=first + number)
            write_trial(made, path)
            paths.append(str(path))
        return paths

    soft = cause("leg_stiffness", 0.8, legs=("MR",))
    files, healthy = walked("run", 0, LAG, soft), walked("healthy", 9, LAG)
    told, out = tmp_path / "d.json", tmp_path / "c.toml"
    words = ["gap", "diagnose", *files, "--reference", *healthy, "--json", str(told), "--jobs", "1"]
    assert run(words) == 0
    found = json.loads(told.read_text(encoding="utf-8"))
    assert any(one["effect"] == "servo_lag" for one in found["standing"])
    capsys.readouterr()
    assert run(["gap", "apply", str(told), "--out", str(out), "--json"]) == 0
    again = json.loads(capsys.readouterr().out)["gap"]
    assert again["shrink"] == pytest.approx(found["gap"]["shrink"], abs=1e-4)
    assert again["before"] == pytest.approx(found["gap"]["before_over_floor"], rel=1e-4)
    against = [] if found["next"] else ["--against", "leg_length@MR"]
    assert run(["gap", "next", str(told), "--json", *against]) == 0
    runs = json.loads(capsys.readouterr().out)["runs"]
    if found["next"]:
        assert [one["name"] for one in runs] == [one["name"] for one in found["next"]]
        assert runs[0]["separation"] == pytest.approx(found["next"][0]["separation"], rel=1e-3)


@pytest.fixture
def example(tmp_path: Path) -> Path:
    """The effect of the documentation."""
    found = re.search(r"```python\n(.*?)```", DOCS.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    path = tmp_path / "worn_crank.py"
    path.write_text(found.group(1), encoding="utf-8")
    return path


@pytest.mark.soak
def test_an_effect_of_a_users_own_in_diagnose_and_next(
    tmp_path: Path, example: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    added = read_effects(example, STAGES, ())
    files = []
    for number in range(2):
        path = tmp_path / f"run{number}.parquet"
        wrong = (cause("worn_crank", 0.004, legs=("ML",)),)
        made = walk("tripod", 0.25 + 0.05 * number, 6.0, wrong, noise_seed=number, added=added)
        write_trial(made, path)
        files.append(str(path))
    told, page = tmp_path / "d.json", tmp_path / "d.html"
    asked = ["--effects", str(example), "--json", str(told), "--html", str(page), "--jobs", "1"]
    assert run(["gap", "diagnose", *files, *asked]) == 0
    text = page.read_text(encoding="utf-8")
    for words in ("worn_crank at ML", "phase from", "class='map'", "class='chain'", "<svg"):
        assert words in text
    assert "worn_crank at ML" in capsys.readouterr().out
    found = json.loads(told.read_text(encoding="utf-8"))
    named = {(one["effect"], *one["legs"]): one["parameters"] for one in found["causes"]}
    assert np.isclose(named["worn_crank", "ML"]["play_m"], 0.004, rtol=0.1)
    assert (
        run(["gap", "next", str(told), "--effects", str(example), "--against", "leg_length@ML"])
        == 0
    )
    assert "worn_crank at ML (play_m 0.0" in capsys.readouterr().out


@pytest.mark.soak
def test_a_diagnosis_of_mujoco_is_measured_again_in_mujoco(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The chain has another gap: its share is none of the simulator that was diagnosed."""
    path = answer(tmp_path, write_runs(tmp_path, WRONG, 2), simulator="mujoco")
    runs = read_runs([tmp_path / "run0.parquet", tmp_path / "run1.parquet"])
    mujoco = runs.made_by(lambda own: twin_simulator(own[0].header.robot_text))
    far = how_far(commissioned_study(runs.trials, mujoco).held_evidence(), WRONG, seed=0)
    run(["gap", "apply", str(path), "--out", str(tmp_path / "c.toml"), "--json"])
    found = json.loads(capsys.readouterr().out)["gap"]
    assert found["before"] == pytest.approx(far.before, rel=1e-6)
    assert found["after"] == pytest.approx(far.after, rel=1e-3)
