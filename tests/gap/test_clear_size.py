"""The size that a report says it would have seen is seen in the share of cases that it promises."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gap.constants import SHOWN
from gap.residuals.moderated import Scatter
from gap.search.clear_size import clear_size, clear_square
from gap.search.cross_validation import Advantage
from gap.search.novelty import chance_of
from gap.search.options import worth, worth_size
from gap.search.scatter import NOTHING_USUAL, HealthyScatter
from gap.search.sizes import Sizes
from tests.gap.sizes_of_runs import walked

LEVEL = 1e-4  # of one candidate of hundreds


def _seen_in(parameters: int, joints: int, scale: float, seed: int, count: int = 800) -> float:
    """How often a cause is new whose size is the one that is said to be clear in the same runs."""
    rng = np.random.default_rng(seed)
    hits = 0
    for _ in range(count):
        seen, known = (walked(scale * rng.standard_normal(runs)) for runs in (3, 4))
        others = [walked(rng.standard_normal(4)) for _ in range(joints)]
        size = clear_size(seen, known, others, parameters, NOTHING_USUAL, LEVEL, float(SHOWN))
        there = Sizes(seen.values + size, seen.gaits)
        hits += chance_of(there, known, others, parameters) < LEVEL
    return hits / count


@pytest.mark.parametrize(
    ("parameters", "joints", "scale"),
    [
        (1, 0, 1.0),
        pytest.param(3, 0, 1.0, marks=pytest.mark.soak),
        pytest.param(1, 5, 1.0, marks=pytest.mark.soak),
        (3, 5, 1.0),
    ],
)
def test_a_size_said_to_be_clear_is_new_as_often_as_promised(
    parameters: int, joints: int, scale: float
) -> None:
    assert _seen_in(parameters, joints, scale, seed=parameters + joints) == pytest.approx(
        float(SHOWN), abs=0.04
    )


def test_at_a_joint_that_is_unlike_the_others_it_is_new_nearly_as_often() -> None:
    assert _seen_in(1, 5, 3.0, seed=8) > 0.8


def test_trials_that_scatter_more_hide_more_and_so_do_more_numbers() -> None:
    known = walked([0.1, -0.2, 0.2, -0.1])

    def size(scale: float, parameters: int) -> float:
        seen = walked(scale * np.array([0.2, -0.1, -0.1]))
        return clear_size(seen, known, (), parameters, NOTHING_USUAL, LEVEL, float(SHOWN))

    assert size(5.0, 1) > 1.5 * size(1.0, 1)
    assert size(1.0, 3) > 1.3 * size(1.0, 1)
    assert size(0.0, 1) == pytest.approx(
        clear_size(walked([7.0] * 3), known, (), 1, NOTHING_USUAL, LEVEL, float(SHOWN))
    ), "only the scatter of the trials counts"


@given(st.floats(0.01, 100.0), st.floats(0.1, 10.0), st.floats(2.0, 30.0), st.integers(1, 4))
def test_the_square_is_where_the_chance_is_the_level(
    variance: float, unlike: float, free: float, parameters: int
) -> None:
    one = HealthyScatter(Scatter(variance, 2 * free), Scatter(variance * unlike, free))
    square = clear_square(one, parameters, LEVEL)
    assert one.chance(square, parameters) == pytest.approx(LEVEL, rel=1e-3)


def test_without_runs_to_compare_nothing_is_clear() -> None:
    nothing, known = walked([]), walked([0.1, -0.1])
    for seen, there in ((nothing, known), (known, nothing)):
        assert clear_size(seen, there, (), 1, NOTHING_USUAL, LEVEL, 0.9) == np.inf


@pytest.mark.parametrize(("blocks", "parameters"), [(4, 1), (40, 1), (40, 3)])
def test_a_change_of_the_size_that_is_worth_it_is_found_in_noise_as_often_as_promised(
    blocks: int, parameters: int
) -> None:
    """Gains of blocks, each of a part of the change; their scatter is known."""
    rng = np.random.default_rng(blocks)
    size = worth_size(parameters, blocks, float(SHOWN))
    gains = 0.5 * size**2 + size * rng.standard_normal(4000)
    found = [worth(Advantage(float(one), size), parameters, blocks) for one in gains]
    assert np.mean(found) == pytest.approx(float(SHOWN), abs=0.02)
