"""A cause that was fitted to some trials is as large in those that were held out, if it is there."""

from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.comparison.gap_evidence import GapEvidence, compare
from gap.diagnosis.comparison.study import make_study
from gap.interfaces import Cause
from gap.residuals.hold_out import HoldOut
from gap.search.candidates import Candidate
from gap.search.cross_validation import unseen_score
from gap.search.fit import Fitted, fit_causes
from gap.search.novelty import Trials, chance_healthy, sizes_in_trials
from gap.search.options import fit_option
from record.trial.trial import Trial
from tests.gap.toy import CONDITIONS, Toy, toy_case, toy_references, toy_trial

SOFT = Cause("stiffness", ("c",), (0.9,))
WANDER = 0.03  # of each joint's stiffness, from run to run


def _compared(trials: list[Trial], hold_out: HoldOut | None = None) -> GapEvidence:
    references = toy_references(21, wander=WANDER)
    return compare(make_study(trials, Toy(), references, hold_out=hold_out), lambda _: None)


def _fit(comparison: GapEvidence) -> Fitted:
    evidence = comparison.evidence
    standing = unseen_score(evidence, fit_causes(evidence, ()))
    candidate = Candidate(evidence.effects[SOFT.effect], SOFT.joints)
    return fit_option(evidence, candidate, (SOFT,), standing).fitted


def _chances(comparison: GapEvidence) -> tuple[float, float]:
    """By trials that were fitted to, and by all."""
    evidence, known, fitted = comparison.evidence, comparison.known, _fit(comparison)
    assert known is not None
    assert known.held is not None
    usual = known.search.alone.usual
    some, every = (
        chance_healthy(trials, known.runs, fitted, fitted.causes[0], usual)
        for trials in (Trials(evidence), Trials(evidence, known.held))
    )
    return some, every


def test_a_cause_that_is_in_the_held_out_trial_is_surer_by_it() -> None:
    comparison = _compared(toy_case([SOFT], seed=21, wander=WANDER))
    assert comparison.known is not None
    fitted, held = _fit(comparison), comparison.known.held
    assert held is not None
    some = sizes_in_trials(Trials(comparison.evidence), fitted, fitted.causes[0])
    every = sizes_in_trials(Trials(comparison.evidence, held), fitted, fitted.causes[0])
    assert len(every) == len(some) + len(held.parts)
    assert every.values[: len(some)] == pytest.approx(some.values)
    assert every.values[len(some) :] == pytest.approx(1.0, abs=0.6)
    before, after = _chances(comparison)
    assert after < 0.7 * before


def test_a_cause_that_is_not_in_the_held_out_trial_is_less_sure_by_it() -> None:
    trials = toy_case([SOFT], seed=21, wander=WANDER)
    at = _compared(trials).study.held[0].trial
    hz, gait = trials[at].header.frequency_hz, trials[at].header.gait
    trials[at] = toy_trial([], hz, gait, seed=5)
    before, after = _chances(_compared(trials))
    assert after > 2.0 * before


def test_the_last_third_of_a_fitted_trial_is_no_run_of_its_own() -> None:
    trials = toy_case([SOFT], seed=21, wander=WANDER)
    cut = _compared(trials, HoldOut(last_third=True))
    assert cut.known is not None
    assert cut.known.held is None


def test_a_held_out_trial_of_a_gait_that_no_reference_has_does_not_count() -> None:
    trials = toy_case([SOFT], seed=21, wander=WANDER)
    other = replace(trials[-1].header, gait="another")
    trials[-1] = replace(trials[-1], header=other)
    comparison = _compared(trials, HoldOut(trials=(len(trials) - 1,)))
    assert comparison.known is not None
    assert comparison.known.held is None
    hz, gait = CONDITIONS[0]
    trials[-1] = toy_trial([SOFT], hz, gait, seed=6)
    comparison = _compared(trials, HoldOut(trials=(len(trials) - 1,)))
    assert comparison.known is not None
    assert comparison.known.held is not None
    assert np.isfinite(comparison.known.held.base).all()
