"""A cause is new by runs of the same gait alone, where a gait shows something like it in healthy runs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from gap.constants import SHOWN
from gap.residuals.moderated import UNKNOWN
from gap.search.clear_size import clear_size
from gap.search.gait_by_gait import gait_by_gait
from gap.search.novelty import chance_of
from gap.search.scatter import NOTHING_USUAL
from gap.search.sizes import Sizes
from tests.gap.sizes_of_runs import walked

TRIALS, REFERENCES = "tmm", "ttmm"


def test_a_patch_that_healthy_runs_show_in_one_gait_is_new_by_the_other() -> None:
    """Sizes of a patch of half the friction in a reality of which only the body's pose is measured."""
    seen = walked([1.31, 0.94, 0.91], TRIALS)
    known = walked([1.09, 1.05, -0.03, 0.00], REFERENCES)
    one_gait = walked(seen.values), walked(known.values)
    assert chance_of(*one_gait, (), 1) > 0.2
    assert chance_of(seen, known, (), 1) < 1e-3


def test_what_healthy_runs_show_in_their_gait_is_not_new() -> None:
    seen = walked([1.08, -0.02, 0.01], TRIALS)
    known = walked([1.09, 1.05, -0.03, 0.00], REFERENCES)
    assert chance_of(seen, known, (), 1) > 0.3


def test_what_is_smaller_than_in_healthy_runs_is_not_new() -> None:
    seen, known = walked([-0.5, -0.6, -0.5], TRIALS), walked([0.1, 0.0, 0.0, 0.1], REFERENCES)
    assert chance_of(seen, known, (), 1) == 1.0


@pytest.mark.parametrize("gaits_differ", [0.0, 3.0, 100.0])
@pytest.mark.parametrize("joints", [0, 5])
def test_healthy_trials_keep_the_level_however_much_gaits_differ(
    gaits_differ: float, joints: int
) -> None:
    rng, count, level, hits = np.random.default_rng(11), 1500, 0.05, 0
    for _ in range(count):
        of_gait = dict(zip("tm", np.sqrt(gaits_differ) * rng.normal(size=2), strict=True))

        def sizes(gaits: str, of: dict[str, float] = of_gait) -> Sizes:
            return walked([of[gait] + rng.normal() for gait in gaits], gaits)

        seen, known = sizes(TRIALS), sizes(REFERENCES)
        others = [sizes(REFERENCES) for _ in range(joints)]
        each = gait_by_gait(seen, known, others, UNKNOWN)
        assert each is not None
        turn = np.sign(each.ahead)
        seen, known = (Sizes(turn * one.values, one.gaits) for one in (seen, known))
        hits += chance_of(seen, known, others, 1) < level
    assert hits <= stats.binom.ppf(0.99, count, level)


@given(st.lists(st.floats(-1.0, 1.0), min_size=7, max_size=7), st.floats(0.0, 5.0))
def test_the_second_test_costs_at_most_a_factor_of_two(scatter: list[float], ahead: float) -> None:
    seen = walked([ahead + one for one in scatter[:3]], TRIALS)
    known = walked(scatter[3:], REFERENCES)
    together = chance_of(walked(seen.values), walked(known.values), (), 1)
    assert chance_of(seen, known, (), 1) <= 2.0 * together + 1e-12


@pytest.mark.parametrize(
    ("trials", "references"), [("ttt", "tttt"), ("www", "ttmm"), ("t", "tm"), ("tm", "tm")]
)
def test_runs_that_cannot_be_compared_gait_by_gait_are_compared_together(
    trials: str, references: str
) -> None:
    rng = np.random.default_rng(12)
    seen, known = (walked(rng.normal(size=len(g)), g) for g in (trials, references))
    assert gait_by_gait(seen, known, (), UNKNOWN) is None


@pytest.mark.parametrize("gaits_differ", [0.0, 100.0])
def test_a_size_said_to_be_clear_is_new_as_often_as_promised(gaits_differ: float) -> None:
    rng, count, level, hits = np.random.default_rng(13), 600, 1e-3, 0
    for _ in range(count):
        of_gait = dict(zip("tm", np.sqrt(gaits_differ) * rng.normal(size=2), strict=True))
        seen, known = (
            walked([of_gait[gait] + rng.normal() for gait in gaits], gaits)
            for gaits in ("ttmm", "tttmmm")
        )
        size = clear_size(seen, known, (), 1, NOTHING_USUAL, level, float(SHOWN))
        there = Sizes(seen.values + size, seen.gaits)
        hits += chance_of(there, known, (), 1) < level
    assert hits / count > float(SHOWN) - 0.04
