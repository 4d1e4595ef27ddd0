"""Constants of the diagnosis: every one is measured at half and at twice its value, and set before use."""

import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.gap.constants.changes import OF_LEGGED, OF_PROBABILITIES, half_and_twice, known
from benchmarks.gap.constants.figures import JudgedCase, counts, differences
from benchmarks.gap.constants.saved_answers import again
from gap.check.cases import CONTROL, OUTSIDE, SINGLE, CaseAnswer, CheckedCase, Named, Truth
from gap.diagnosis.alternatives.probability import Fit, blur_of, none_of_them, weight_of
from gap.search.cross_validation import Advantage
from model.parameters.toml_table import parse_toml

ROOT = Path(__file__).resolve().parents[2]
MEASURED = parse_toml((ROOT / "docs" / "gap_constants.toml").read_text(encoding="utf-8"), "data")
TRUTH = Truth("delay", "drive", "", (("delay_s", 0.02),))


def test_every_constant_is_measured_at_half_and_twice_the_value_that_it_has() -> None:
    rows, legged = (
        MEASURED[section]["constants"] for section in ("small_machines", "legged_cases")
    )
    assert not set(rows) & set(OF_LEGGED), "what only legged robots have is measured on these"
    assert set(OF_LEGGED) <= set(legged)
    assert {name: row["value"] for name, row in (legged | rows).items()} == known()
    for name, row in (*rows.items(), *legged.items()):
        assert row["value"] == known()[name]
        changes = half_and_twice(name, row["value"])
        assert (row["half"]["at"], row["twice"]["at"]) == pytest.approx(
            tuple(one.value for one in changes), abs=1e-6
        )


def test_constants_of_probabilities_are_measured_on_legged_robots_too() -> None:
    rows = MEASURED["legged"]["constants"]
    assert {name: row["value"] for name, row in rows.items()} == {
        name: known()[name] for name in OF_PROBABILITIES
    }


def test_no_share_is_doubled_to_one_or_more() -> None:
    bounded = ("SHOWN", "MOSTLY", "WHOLE_SHARE", "NONE_LIKELY", "OPEN_LEVEL", "FALSE_ALARMS", "TRIMMED",
               "JOINT_UNLIKE", "GAIT_CORRELATION", "CAUSES_PART", "NEAR_AS_GOOD",
               "GRIP_LARGEST")  # fmt: skip
    for name in bounded:
        half, twice = half_and_twice(name, known()[name])
        assert 0.0 < half.value < known()[name] < twice.value < 1.0, name


def test_vibration_stays_below_what_frames_can_show() -> None:
    half, twice = half_and_twice("VIBRATES_FASTER", known()["VIBRATES_FASTER"])
    assert 0.0 < half.value < known()["VIBRATES_FASTER"] < twice.value < 0.5


@pytest.fixture(scope="module")
def printed() -> list[str]:
    """What a fresh process says of a constant before, when and after it is changed."""
    code = """
from benchmarks.gap.constants import figures, judged
from benchmarks.gap.constants.changes import Change, known
print([name for name in known() if judged.users_of(name)])
change = Change('TEMPERATURE', 7.0)
judged.set_before_use(change)
from gap.diagnosis.alternatives import probability
judged.check_used(change)
print(float(probability.TEMPERATURE))
judged.set_before_use(Change('TEMPERATURE', 8.0))
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode != 0
    return [*done.stdout.splitlines(), done.stderr]


def test_no_constant_is_in_use_before_it_is_changed(printed: list[str]) -> None:
    assert printed[0] == "[]", printed


def test_a_changed_constant_reaches_the_modules_that_are_imported_after_it(
    printed: list[str],
) -> None:
    assert printed[1] == "7.0", printed


def test_a_constant_that_is_in_use_cannot_be_changed(printed: list[str]) -> None:
    assert "TEMPERATURE is in use by gap.diagnosis.alternatives.probability" in printed[2]


def judged(kind: str, verdict: str, *effects: str) -> JudgedCase:
    named = tuple(
        Named(one, (), (("delay_s", 0.021),), 0.9, (("delay_s", 0.002),)) for one in effects
    )
    answer = CaseAnswer(verdict, "drive", named, (), 0.0, 1.0, 1.0)
    truths = () if kind == CONTROL else (TRUTH,)
    return JudgedCase(
        CheckedCase("case", kind, truths, answer, 9.0, 1.0), {}, {"delay delay_s": 0.01}
    )


def test_right_answers_and_differences_are_counted() -> None:
    before = [judged(SINGLE, "explained", "delay"), judged(CONTROL, "no_gap"),
              judged(OUTSIDE, "unexplained", "lag")]  # fmt: skip
    after = [judged(SINGLE, "ambiguous", "lag"), judged(CONTROL, "no_gap"),
             judged(OUTSIDE, "explained", "lag")]  # fmt: skip
    assert counts(before).right == 3
    found = counts(after)
    assert (found.right, found.first, found.healthy, found.outside) == (1, 0, 1, 0)
    assert differences(after, before).verdicts == 2
    assert differences(after, before).causes == 1
    assert differences(after, before).visible_sizes == 1.0


def test_judging_an_answer_again_with_the_same_constants_changes_nothing() -> None:
    half = {"effect": "lag", "joints": [], "of": ["delay", []], "behind": 0.5, "behind_error": 1.0}
    fit = {
        "closed": 0.9,
        "excess_after": 1.1,
        "worst_after": 1.2,
        "p_after": 0.5,
        "nats_after": 3.0,
    }
    none = none_of_them(Fit(**fit), 1, referenced=True)
    weight = weight_of(Advantage(0.5, 1.0), blur_of(Advantage(0.5, 1.0), 3.0, 40.0))
    own = (1.0 - none) / (2.0 + weight)  # one more effect is like it, and was not fitted
    cause = {"effect": "delay", "legs": [], "probability": own, "on_bound": [], "nats": 40.0}
    found = {
        "fit": fit, "none_of_these": none, "causes": [cause], "gap": {"shrink": 0.9},
        "rivals": [{**half, "probability": own * weight}],
    }  # fmt: skip
    named = (Named("delay", (), (), own),)
    answer = CaseAnswer("explained", "drive", named, (), none, 0.9, 1.0)
    case = JudgedCase(CheckedCase("a", SINGLE, (TRUTH,), answer, 0.0, 0.0), found, {})
    (one,) = again(case).checked.answer.named
    assert one.probability == pytest.approx(own)
