"""Two references: each is predicted by the other alone, so trials tell how much healthy runs scatter."""

import numpy as np
import pytest
from scipy import stats

from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.comparison.gap_evidence import compare
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause
from gap.residuals.energy_tests import together
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.toy import LIKE, UNLIKE, Toy, walked_day

# Healthy sets in which two references, taken for two energies, made their scatter too small.
ALARMED = (141, 170, 172, 187, 190, 210, 259, 291)
KINDS = ("a",) * 6


def _set(
    seed: int, wander: tuple[float, ...], causes: tuple[Cause, ...] = ()
) -> tuple[list[Trial], list[Trial]]:
    """Four trials, and two references of two gaits."""
    trials = [walked_day(at, 1000 * seed + at, wander, causes) for at in range(4)]
    return trials, [walked_day(at, 1000 * seed + 500 + at, wander) for at in (0, 3)]


def _alarms(seeds: range | tuple[int, ...], wander: tuple[float, ...]) -> int:
    verdicts = []
    for seed in seeds:
        trials, known = _set(seed, wander)
        verdicts.append(diagnose(trials, Toy(), known).verdict)
    return len(verdicts) - verdicts.count(Verdict.NO_GAP)


def _chance(trials: FloatArray, known: FloatArray, alike: FloatArray) -> float:
    chance = together(KINDS, trials, known, alike)
    assert chance is not None
    return chance.p


def test_the_difference_that_two_references_show_counts_once() -> None:
    """Energies of noise and of what differs from day to day: one number each in six channels."""
    rng, level = np.random.default_rng(1), 0.05
    once, twice = [], []
    for _ in range(1500):
        trials, difference = (np.log1p(3.0 * rng.chisquare(1, (runs, 6))) for runs in (3, 1))
        both = np.vstack([difference, difference + 0.01 * rng.standard_normal((1, 6))])
        once.append(_chance(trials, difference, trials))
        twice.append(_chance(trials, both, both))
    assert np.mean(np.array(once) < level) < level
    assert np.mean(np.array(twice) < level) > 0.7


def test_healthy_sets_of_which_two_references_show_one_difference_are_no_gap() -> None:
    assert _alarms(ALARMED, LIKE) <= 1


@pytest.mark.thorough
@pytest.mark.parametrize("wander", [LIKE, UNLIKE])
def test_false_alarms_with_two_references_of_unequal_joints_keep_the_aim(
    wander: tuple[float, ...],
) -> None:
    assert _alarms(range(101, 401), wander) <= stats.binom.ppf(0.975, 300, 0.05)


def test_trials_tell_how_much_causes_scatter_where_two_references_do_not() -> None:
    trials, known = _set(7, LIKE)
    both = compare(make_study(trials, Toy(), known), lambda _: None).known
    assert both is not None
    usual = both.search.alone.usual
    assert usual.joint.together.free > 0.0
    more = [walked_day(at, 7600 + at, LIKE) for at in (0, 1, 2, 3, 0, 1)]
    many = compare(make_study(trials, Toy(), more), lambda _: None).known
    assert many is not None
    ratio = usual.joint.together.variance / many.search.alone.usual.joint.together.variance
    assert 0.2 < ratio < 5.0


def test_a_joint_that_is_clearly_softer_is_named_with_two_references() -> None:
    soft = Cause("stiffness", ("b",), (0.6,))
    for seed in (11, 12, 13):
        trials, known = _set(seed, LIKE, (soft,))
        named = diagnose(trials, Toy(), known).causes
        assert [(one.effect, one.joints) for one in named] == [("stiffness", ("b",))]
