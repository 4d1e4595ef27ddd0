"""Scatter of causes between runs: what all causes together say of one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import special, stats

from gap.residuals.moderated import UNKNOWN, Scatter, steadied, trigamma_inverse
from gap.search.novelty import chance_of
from gap.search.scatter import FEWEST_CAUSES, Usual, UsualScatter, pooled, usual_scatter
from model.values.arrays import FloatArray
from tests.gap.sizes_of_runs import walked

FREE, RUNS, TRIALS = 6.0, 6, 3
POSITIVE = st.floats(1e-3, 1e3)


def _variances(rng: np.random.Generator, count: int, free: float, middle: float) -> FloatArray:
    """True variances of causes: a scaled inverse chi-squared distribution."""
    return np.asarray(middle * free / rng.chisquare(free, count))


@pytest.mark.parametrize("free", [2.0, 6.0])
def test_how_much_causes_differ_is_recovered_from_few_runs_of_many(free: float) -> None:
    rng = np.random.default_rng(1)
    true = _variances(rng, 4000, free, 2.5)
    estimated = true * rng.chisquare(RUNS - 1, len(true)) / (RUNS - 1)
    one = usual_scatter(estimated, np.full(len(true), RUNS - 1.0), np.ones(len(true)))
    assert one.free == pytest.approx(free, rel=0.15)
    assert one.variance == pytest.approx(2.5, rel=0.08)


def test_causes_that_scatter_alike_are_one_known_variance() -> None:
    rng = np.random.default_rng(2)
    estimated = 0.4 * rng.chisquare(5, 300) / 5
    one = usual_scatter(estimated, np.full(300, 5.0), np.ones(300))
    assert one.free > 40
    assert one.variance == pytest.approx(0.4, rel=0.1)


def test_forms_of_one_cause_count_once() -> None:
    rng = np.random.default_rng(3)
    estimated = rng.chisquare(5, 20) / 5
    many = np.concatenate([estimated, np.repeat(estimated[0], 9)])
    weights = np.concatenate([[0.1], np.ones(19), np.full(9, 0.1)])
    once = usual_scatter(estimated, np.full(20, 5.0), np.ones(20))
    assert usual_scatter(many, np.full(29, 5.0), weights).variance == pytest.approx(
        once.variance, rel=0.1
    )


def test_a_few_causes_say_nothing_of_another() -> None:
    count = FEWEST_CAUSES - 1
    assert usual_scatter(np.ones(count), np.full(count, 5.0), np.ones(count)) == UNKNOWN
    own = Scatter(3.0, 7.0)
    assert steadied(own, UNKNOWN) == own
    assert UsualScatter().of(True).together == UNKNOWN


@given(POSITIVE, st.floats(1.0, 50.0), POSITIVE, st.floats(0.1, 1e6))
def test_a_steadied_scatter_lies_between_and_its_own_runs_have_half_a_say(
    own: float, free: float, other: float, by: float
) -> None:
    one = steadied(Scatter(own, free), Scatter(other, by))
    assert min(own, other) * (1 - 1e-9) <= one.variance <= max(own, other) * (1 + 1e-9)
    assert free <= one.free <= 2 * free * (1 + 1e-9)


@given(POSITIVE, POSITIVE)
def test_units_do_not_matter(factor: float, variance: float) -> None:
    rng = np.random.default_rng(4)
    seen, known, usual = 1 + rng.normal(size=3), rng.normal(size=6), Usual(Scatter(variance, 3.0))
    scale = np.sqrt(factor)
    here = chance_of(walked(seen), walked(known), (), 1, usual)
    larger = walked(scale * seen), walked(scale * known)
    assert chance_of(*larger, (), 1, usual.times(factor)) == pytest.approx(here, rel=1e-6)


@pytest.mark.parametrize("level", [0.05, 0.01])
def test_what_is_usual_keeps_the_level_over_causes_that_differ(level: float) -> None:
    """Healthy trials, the sign of a cause as they choose it: no more alarms than the level."""
    rng = np.random.default_rng(5)
    count, hits, alone = 4000, 0, 0
    usual = Usual(Scatter(1.0, FREE))
    for variance in _variances(rng, count, FREE, 1.0):
        seen, known = (np.sqrt(variance) * rng.normal(size=n) for n in (TRIALS, RUNS))
        turn = np.sign(seen.mean() - known.mean())
        sizes = walked(turn * seen), walked(turn * known)
        hits += chance_of(*sizes, (), 1, usual) < level
        alone += chance_of(*sizes, (), 1) < level
    for alarms in (hits, alone):
        assert alarms <= stats.binom.ppf(0.99, count, level)
        assert alarms >= stats.binom.ppf(0.01, count, 0.7 * level), (
            "no more careful than it must be"
        )


def test_the_same_gap_is_surer_with_what_is_usual() -> None:
    seen, known = walked([0.92, 0.72, 0.74]), walked([0.49, 0.45, 0.37, 0.35, 0.44, 0.46])
    own = pooled([seen, known], ())
    alone = chance_of(seen, known, (), 1)
    assert chance_of(seen, known, (), 1, Usual(Scatter(own.variance, 2.0))) < 0.4 * alone
    assert chance_of(seen, known, (), 1, Usual(Scatter(20 * own.variance, 7.0))) > alone


@given(st.floats(1e-5, 1e5))
def test_the_inverse_of_trigamma_is_its_inverse(value: float) -> None:
    assert special.polygamma(1, trigamma_inverse(value)) == pytest.approx(value, rel=1e-9)
