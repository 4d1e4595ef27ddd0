"""``bigant gap demo``: what it makes, what it prints, and how it judges its own answer."""

import json
import re
import shlex
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.answer.named_cause import NamedCause, Value
from gap.diagnosis.comparison.trend import UNKNOWN
from robot.cli import main as cli
from robot.console.arguments import parsed
from robot.gap_report.demo import compared, demo_runs, run_words
from robot.requests.gap import WORN_SPRING, GapDemoRequest
from robot.requests.sim import SimRunRequest
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import parse_effect

WORN = parse_effect(WORN_SPRING, EFFECTS)


def cause(
    effect: str = "leg_stiffness", leg: str = "MR", value: float = 0.70, error: float = 0.02
) -> NamedCause:
    sizes = (Value("ratio", "", value, error, 1.0, on_bound=False),)
    return NamedCause(
        effect, (leg,), "support", sizes, 1.0, 9.0, 1.0, 0.9, 0.9, 0.9, "", "", effect, UNKNOWN, 1.0
    )


def answer(*causes: NamedCause, verdict: Verdict = Verdict.EXPLAINED) -> Diagnosis:
    return cast(Diagnosis, SimpleNamespace(causes=causes, verdict=verdict))


@pytest.mark.parametrize(
    ("found", "right", "words"),
    [
        (answer(cause()), True, "ratio: 0.70 +- 0.02 found, 0.69 injected: within its error"),
        (answer(cause(value=0.76)), True, "3.5 times its error away"),
        (answer(cause(leg="ML")), False, "wrong: it was leg_stiffness at MR"),
        (answer(cause(effect="leg_length")), False, "found     leg_length at MR"),
        (answer(cause(), verdict=Verdict.AMBIGUOUS), False, "but the verdict is AMBIGUOUS"),
        (answer(cause(), cause("leg_length")), False, "but so is what was not injected"),
        (answer(verdict=Verdict.NO_GAP), False, "found     nothing (NO GAP)"),
    ],
)
def test_an_answer_is_judged_by_what_was_injected(
    found: Diagnosis, right: bool, words: str
) -> None:
    lines, judged = compared(WORN, found)
    assert judged is right
    assert words in "\n".join(lines)


def test_a_healthy_robot_and_an_unlisted_effect_have_right_answers_of_their_own() -> None:
    assert compared(None, answer(verdict=Verdict.NO_GAP)) == (
        ["injected  nothing wrong", "found     nothing (NO GAP)", "right: nothing is wrong"], True
    )  # fmt: skip
    assert not compared(None, answer(cause()))[1]
    unlisted = next(kind for kind in EFFECTS if not kind.catalogued)
    strange = parse_effect(
        f"{unlisted.name}@MR" if unlisted.scope == "leg" else unlisted.name, EFFECTS
    )
    assert compared(strange, answer(verdict=Verdict.UNEXPLAINED))[1]
    assert not compared(strange, answer(cause()))[1]


def test_each_printed_command_is_the_request_that_is_carried_out(tmp_path: Path) -> None:
    request = GapDemoRequest(out=tmp_path / "two words", seconds=20.0)
    runs = demo_runs(request)
    everything = (*runs.trials, *runs.references)
    for one in everything:
        words = shlex.split(shlex.join(run_words(one)))
        assert parsed(cli.full_parser().parse_args(words[1:]), SimRunRequest) == one
    assert len({one.seed for one in everything}) == len({one.out for one in everything}) == 8
    conditions = [
        [(one.gait, one.frequency_hz) for one in each] for each in (runs.trials, runs.references)
    ]
    assert conditions[0] == conditions[1], "a reference for every condition"
    assert all(one.effect == (WORN_SPRING,) for one in runs.trials)
    assert not any(one.effect for one in runs.references)
    assert not any(one.effect for one in demo_runs(replace(request, effect="none")).trials)


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        ("leg_stifness@MR", "did you mean leg_stiffness?"),
        ("leg_stiffness", "acts on one leg; write leg_stiffness@LEG"),
        ("leg_stiffness@XY", "'XY' is no leg"),
        ("leg_stiffness@MR:ratio=9", "must be from 0.2 to 4"),
    ],
)
def test_a_wrong_effect_is_refused_before_a_folder_is_made(
    effect: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "demo"
    assert cli.run(["gap", "demo", "--effect", effect, "--out", str(out)]) == 2
    assert words in capsys.readouterr().err
    assert not out.exists()


def test_a_folder_or_file_that_is_there_is_not_touched(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    used, file = tmp_path / "used", tmp_path / "file"
    used.mkdir()
    (used / "mine.txt").write_text("mine")
    file.write_text("mine")
    for out in (used, file):
        assert cli.run(["gap", "demo", "--out", str(out)]) == 4
        assert "is there already; name another folder" in capsys.readouterr().err
    assert [one.name for one in used.iterdir()] == ["mine.txt"]


@pytest.mark.soak
@pytest.mark.long
def test_the_tutorial_s_first_diagnosis(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The claim of docs/tutorial.md, on shorter runs and in one process."""
    out = tmp_path / "demo"
    assert cli.run(["gap", "demo", "--seconds", "14", "--jobs", "1", "--out", str(out)]) == 0
    told = capsys.readouterr().out
    assert "\nEXPLAINED\n" in told
    assert re.search(r"right: fault and leg are those that were injected\n", told)
    found: dict[str, Any] = json.loads((out / "diagnosis.json").read_text())
    assert found["verdict"] == "explained"
    (one,) = found["causes"]
    assert (one["effect"], one["legs"]) == ("leg_stiffness", ["MR"])
    assert abs(one["parameters"]["ratio"] - 0.69) <= 2 * one["errors"]["ratio"]
    assert found["gap"]["shrink"] > 0.8
    assert len(list(out.glob("*.parquet"))) == 8
    assert "<html" in (out / "diagnosis.html").read_text()
