"""``bigant.diagnose`` with a machine of one's own, as a file or as a function, and chosen held-out runs."""

import runpy
from pathlib import Path
from typing import Any

import pytest

import bigant

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "own_machine.py"


@pytest.fixture(scope="module")
def lab() -> dict[str, Any]:
    """What is in the example of a lab's own machine."""
    return runpy.run_path(str(EXAMPLE))


def test_a_function_and_its_file_give_the_same_answer(lab: dict[str, Any]) -> None:
    run = lab["made_up_trial"](stretch=0.06)
    by_function = bigant.diagnose(run, machine=lab["make"])
    by_file = bigant.diagnose(run, machine=f"{EXAMPLE}:make")
    assert by_function.sentence == by_file.sentence
    value, error = by_function.parameters["tendon_stretch finger"]["rad_per_nm"]
    assert abs(value - 0.06) < 3 * error


def test_the_runs_that_judge_can_be_chosen(lab: dict[str, Any]) -> None:
    runs = [lab["made_up_trial"](stretch=0.06, seed=seed) for seed in range(3)]
    chosen = bigant.diagnose(runs, machine=lab["make"], hold_out=["trial=run 1", "trial=run 3"])
    assert "held out for testing: run 1, run 3" in repr(chosen)
    thirds = bigant.diagnose(runs, machine=lab["make"], hold_out="last-third")
    assert "last third" in repr(thirds)


@pytest.mark.parametrize(
    ("hold_out", "words"),
    [("trial=run 9", "no run is; trial is run 1"), ("run 1", "write KEY=VALUE, trial=NAME")],
)
def test_a_choice_that_no_run_meets_is_refused(
    lab: dict[str, Any], hold_out: str, words: str
) -> None:
    runs = [lab["made_up_trial"](stretch=0.06, seed=seed) for seed in range(2)]
    with pytest.raises(bigant.BigantError, match=words):
        bigant.diagnose(runs, machine=lab["make"], hold_out=hold_out)
