"""The reader is told of currents that are not those of the references, and of nothing less."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.comparison.motor_current import current_words, mean_currents
from gap.diagnosis.comparison.study import Study, make_study
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause
from record.trial.trial import Trial
from tests.gap.toy import JOINTS, Toy, toy_case, toy_references

USUAL_A = 0.2


def _drawing(trials: Sequence[Trial], factors: Sequence[float], seed: int) -> list[Trial]:
    """Trials whose motors draw so many times the usual current, either way, a tenth more or less."""
    rng = np.random.default_rng(seed)
    made = []
    for one in trials:
        run = USUAL_A * np.asarray(factors) * (1 + 0.1 * rng.uniform(-1, 1, len(JOINTS)))
        signs = rng.choice([-1.0, 1.0], one.current_a.shape)
        made.append(replace(one, current_a=run * signs))
    return made


def _study(factors: Sequence[float], references: int = 4) -> Study:
    trials = _drawing(toy_case(), factors, 1)
    known = _drawing(toy_references()[:references], (1.0, 1.0, 1.0), 2)
    return make_study(trials, Toy(), known)


@pytest.mark.parametrize("factor", [3.0, 0.2])
def test_a_joint_that_draws_other_currents_is_named_with_both(factor: float) -> None:
    said = current_words(_study((1.0, factor, 1.0)))
    assert f" {JOINTS[1]} {USUAL_A * factor:.1g}" in said
    assert "(0.2 A)" in said
    assert f" {JOINTS[0]} " not in said.split(":")[1].split("in the mean")[0]


def test_what_days_and_counts_differ_by_is_not_told() -> None:
    assert not current_words(_study((1.2, 0.8, 1.0)))
    trials = _drawing(toy_case(), (0.05, 0.05, 0.05), 1)
    known = _drawing(toy_references(), (0.01, 0.01, 0.01), 2)
    assert not current_words(make_study(trials, Toy(), known)), "a few counts of the register"


def test_without_currents_or_with_few_references_nothing_is_told() -> None:
    assert not current_words(make_study(toy_case(), Toy(), toy_references()))
    assert not current_words(_study((3.0, 3.0, 3.0), references=2))
    assert np.isnan(mean_currents(toy_case())).all()


def test_one_run_that_is_like_the_references_is_enough_to_say_nothing() -> None:
    trials = _drawing(toy_case(), (3.0, 3.0, 3.0), 1)
    trials[0] = _drawing(trials[:1], (1.0, 1.0, 1.0), 3)[0]
    known = _drawing(toy_references(), (1.0, 1.0, 1.0), 2)
    assert not current_words(make_study(trials, Toy(), known))


def test_no_gap_comes_with_it_and_a_named_cause_without() -> None:
    known = _drawing(toy_references(3), (1.0, 1.0, 1.0), 2)
    healthy = diagnose(_drawing(toy_case((), 3), (5.0, 1.0, 1.0), 1), Toy(), known)
    assert healthy.verdict is Verdict.NO_GAP
    assert any("motor currents" in one for one in healthy.warnings)
    soft = toy_case([Cause("stiffness", ("c",), (0.8,))], 3)
    named = diagnose(_drawing(soft, (5.0, 1.0, 1.0), 1), Toy(), known)
    assert named.causes
    assert not any("motor currents" in one for one in named.warnings)
