"""The error of a number is that of the runs: what differs from day to day is in it."""

import itertools
from dataclasses import replace

import numpy as np

from gap.constants import FORCES_DIFFER, MODELS_DIFFER
from gap.diagnosis.comparison.study import Study, make_study
from gap.interfaces import Cause, Drive
from gap.residuals.parts import whole_parts
from gap.residuals.predictions import Predictor
from gap.search.fit import fit_causes
from gap.search.standard_errors import standard_errors
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.test_selection import evidences
from tests.gap.toy import CONDITIONS, EFFECTS, Toy, toy_references, toy_trial
from tests.gap.walks import cause, simulator, walk

BY_NAME = {effect.name: effect for effect in EFFECTS}
OFFSET = 0.3
DAY_TO_DAY = 0.03


def _found(seed: int, days: float) -> tuple[float, float]:
    """An offset found in four runs whose own offsets differ from day to day, and its standard error."""
    rng = np.random.default_rng(seed)

    def runs(size: float, count: int, first: int) -> list[Trial]:
        return [
            toy_trial([Cause("offset", ("a",), (size + days * rng.normal(),))],
                      *CONDITIONS[i % len(CONDITIONS)], seed=1000 * seed + first + i)
            for i in range(count)
        ]  # fmt: skip

    evidence, known = evidences(Toy(), runs(OFFSET, 4, 0), runs(0.0, 6, 100))
    fitted = fit_causes(evidence, (Cause("offset", ("a",), (OFFSET,)),))
    parameter = BY_NAME["offset"].parameters[0]
    error = (
        float(standard_errors(evidence, known.runs if known else None, fitted)[0])
        * parameter.spread
    )
    return fitted.causes[0].values[0], error


def test_errors_cover_the_truth_as_often_as_they_say() -> None:
    z = [
        (value - OFFSET) / error
        for value, error in (_found(seed, DAY_TO_DAY) for seed in range(20))
    ]
    assert 0.4 < np.std(z) < 1.6


def test_runs_that_differ_make_the_error_larger() -> None:
    assert _found(1, DAY_TO_DAY)[1] > 3 * _found(1, 0.0)[1]


def test_what_all_references_show_of_a_cause_makes_its_error_larger() -> None:
    trials = [
        toy_trial([Cause("offset", ("a",), (OFFSET,))], *at, seed=i)
        for i, at in enumerate(CONDITIONS)
    ]
    evidence, known = evidences(Toy(), trials, toy_references())
    assert known is not None
    fitted = fit_causes(evidence, (Cause("offset", ("a",), (OFFSET,)),))

    def squared(own_rad: tuple[float, ...]) -> float:
        """Square of the error, where references have offsets that others do not predict."""
        healthy, at = known.runs, np.arange(len(known.runs.simulator.channels)) == 0
        whiteners = tuple(
            replace(one, expected=one.expected - own * at)
            for one, own in zip(healthy.whiteners, itertools.cycle(own_rad), strict=False)
        )
        found = standard_errors(evidence, replace(healthy, whiteners=whiteners), fitted)[0]
        return float((found * BY_NAME["offset"].parameters[0].spread) ** 2)

    usual, alike = squared((0.0,)), squared((0.1,))
    assert 0.5 * 0.1**2 / 3 < alike - usual < 0.1**2 / 3  # forces show the offset as well
    # what differs from run to run, and is none in the mean, is in their scatter
    assert squared((0.1, -0.1)) < 0.1**2 / 3


def test_one_run_alone_is_judged_by_its_noise() -> None:
    trial = toy_trial([Cause("offset", ("a",), (OFFSET,))], *CONDITIONS[0], seed=3)
    evidence, known = evidences(Toy(), [trial], [])
    assert known is None
    fitted = fit_causes(evidence, (Cause("offset", ("a",), (OFFSET,)),))
    (error,) = standard_errors(evidence, None, fitted)
    assert 0 < error**2 - (MODELS_DIFFER * fitted.away[0]) ** 2 < 0.1**2
    assert len(standard_errors(evidence, None, fit_causes(evidence, ()))) == 0


def test_what_acts_through_forces_is_known_less_well_than_what_is_drawn() -> None:
    trial = toy_trial([Cause("offset", ("a",), (OFFSET,))], *CONDITIONS[0], seed=3)
    errors = {}
    for by_forces in (False, True):
        catalogue = tuple(replace(one, by_forces=by_forces) for one in EFFECTS)
        evidence, _ = evidences(Toy(catalogue), [trial], [])
        fitted = fit_causes(evidence, (Cause("offset", ("a",), (OFFSET,)),))
        (errors[by_forces],) = standard_errors(evidence, None, fitted)
        assert errors[by_forces] >= (FORCES_DIFFER if by_forces else MODELS_DIFFER) * abs(
            fitted.away[0]
        )
    assert errors[True] > errors[False]


def test_channels_that_want_different_numbers_make_the_error_larger() -> None:
    trials = [
        toy_trial([Cause("delay", (), (0.05,))], *CONDITIONS[i % len(CONDITIONS)], seed=30 + i)
        for i in range(4)
    ]
    # from commands alone, so that angles and forces show it
    evidence = Study(Predictor(Toy(), trials), whole_parts(Toy(), trials)).evidence(Drive.COMMAND)
    fitted = fit_causes(evidence, (Cause("delay", (), (0.05,)),))
    names = np.array([one.name for one in evidence.simulator.channels])
    shown = {name for name in names if np.abs(fitted.slopes[:, :, names == name]).max() > 0.1}
    assert len(shown) > 1
    usual = standard_errors(evidence, None, fitted)[0]
    run = evidence.block_part[evidence.block_of_frame]
    wrong = 0.3 * fitted.away[0] * np.outer(np.ones(len(run)), names == "angle")

    def error(more: FloatArray) -> float:
        left = fitted.residual + more * fitted.slopes[0]
        return float(standard_errors(evidence, None, replace(fitted, residual=left))[0])

    apart, each_its_own = error(wrong), error(wrong * np.where(run % 2, 1.0, -1.0)[:, None])
    assert 0.1 * fitted.away[0] < apart < 0.3 * fitted.away[0]
    assert 0.5 * apart < each_its_own < 2.0 * apart  # as the scatter of runs, and not once more
    assert error(np.zeros_like(wrong)) == usual


def test_the_error_of_a_limit_does_not_grow_with_how_far_off_no_limit_is() -> None:
    """Its size by itself says nothing: no limit may be at ten or at a thousand."""
    truth = cause("servo_speed_limit", 1.2, legs=("ML",))
    trials = [walk("tripod", f, 8.0, (truth,), noise_seed=i) for i, f in enumerate((0.2, 0.3))]
    references = [walk("tripod", f, 8.0, noise_seed=5 + i) for i, f in enumerate((0.2, 0.3, 0.2))]
    study = make_study(trials, simulator(), references)
    evidence, known = study.evidence(study.local), study.healthy_evidence(study.local)
    fitted = fit_causes(evidence, (truth,))
    effect = evidence.effects[truth.effect]
    error = standard_errors(evidence, known, fitted)[0] * effect.parameters[0].spread
    assert abs(fitted.causes[0].values[0] - 1.2) < 0.01
    assert error < 0.06
