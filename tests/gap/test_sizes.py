"""Sizes of causes in runs of several gaits: how much gaits differ, and what that does to a comparison."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import linalg, stats

from gap.residuals.moderated import Scatter
from gap.search.novelty import chance_of
from gap.search.scatter import Usual
from gap.search.sizes import (
    SHARES,
    ahead_of,
    design,
    likeliest_share,
    scatter_of,
)
from tests.gap.sizes_of_runs import walked

REFERENCES, TRIALS = "ttmmtm", "tmmt"
GAITS = st.text("tmw", min_size=1, max_size=8)
SHARE = st.sampled_from(SHARES)


@given(GAITS, GAITS, SHARE, st.integers(0, 2**31))
def test_means_and_scatter_are_those_of_whitened_least_squares(
    seen: str, known: str, share: float, seed: int
) -> None:
    """An oracle: ordinary least squares of sizes that the Cholesky factor has made independent."""
    sizes = np.random.default_rng(seed).normal(size=len(seen) + len(known))
    names = np.array(list(seen + known))
    root = np.linalg.cholesky(np.eye(len(names)) + share * (names[:, None] == names))
    groups = np.zeros((len(names), 2))
    groups[: len(seen), 0] = groups[len(seen) :, 1] = 1.0
    rows, goal = (linalg.solve_triangular(root, one, lower=True) for one in (groups, sizes))
    means = np.linalg.lstsq(rows, goal, rcond=None)[0]
    one, other = walked(sizes[: len(seen)], seen), walked(sizes[len(seen) :], known)
    ahead, variance = ahead_of(one, other, share)
    assert ahead == pytest.approx(means[0] - means[1], abs=1e-9)
    turn = np.array([1.0, -1.0])
    assert variance == pytest.approx(float(turn @ np.linalg.inv(rows.T @ rows) @ turn), rel=1e-9)
    square, free = scatter_of([one, other], share)
    assert square == pytest.approx(float(((goal - rows @ means) ** 2).sum()), abs=1e-9)
    assert free == len(names) - 2


@given(GAITS, st.integers(0, 2**31))
def test_gaits_that_do_not_differ_leave_plain_means(gaits: str, seed: int) -> None:
    sizes = np.random.default_rng(seed).normal(size=len(gaits))
    square, free = scatter_of([walked(sizes, gaits)], 0.0)
    assert square == pytest.approx(float(((sizes - sizes.mean()) ** 2).sum()), abs=1e-12)
    assert free == len(gaits) - 1
    ahead, variance = ahead_of(walked(sizes, gaits), walked([]), 0.0)
    assert (ahead, variance) == pytest.approx((float(sizes.mean()), 1.0 + 1.0 / len(gaits)))


@pytest.mark.parametrize("share", [0.0, 1.0, 10.0])
def test_how_much_gaits_differ_is_recovered_from_many_causes(share: float) -> None:
    rng = np.random.default_rng(7)
    changes = []
    for _ in range(400):
        spread, of_gait = rng.lognormal(), dict(zip("tm", rng.normal(size=2), strict=True))
        between = np.array([of_gait[gait] for gait in REFERENCES])
        sizes = spread * (rng.normal(size=6) + np.sqrt(share) * between + 3.0)
        changes.append([walked(sizes, REFERENCES)])
    likeliest = likeliest_share(changes, np.ones(400))
    assert abs(SHARES.index(likeliest) - SHARES.index(share)) <= 1


def test_runs_of_one_gait_do_not_say_how_much_gaits_differ() -> None:
    rng = np.random.default_rng(8)
    changes = [[walked(rng.normal(size=5))] for _ in range(30)]
    assert likeliest_share(changes, np.ones(30)) == 0.0
    assert likeliest_share([], np.ones(0)) == 0.0


@pytest.mark.parametrize("share", [1.0, 30.0])
def test_a_patch_that_friction_imitates_in_one_gait_is_told_from_a_real_one(share: float) -> None:
    """Sizes of a patch of one reality: 0.7 in tripod references and 0.1 in metachronal ones."""
    seen = walked([0.91, 0.98, 0.95], "tmm")
    known = walked([0.71, 0.71, 0.14, 0.06, 0.76, 0.63], "ttmmtt")
    plain = chance_of(walked(seen.values), walked(known.values), (), 1)
    assert chance_of(seen, known, (), 1, Usual(Scatter(0.0, 0.0, share))) < 0.2 * plain


@pytest.mark.parametrize("assumed", [0.0, 1.0, 30.0])
@pytest.mark.parametrize("trials", [TRIALS, "tttt"])
def test_alarms_keep_the_level_even_if_gaits_differ_less_than_it_is_said(
    assumed: float, trials: str
) -> None:
    """Sizes that do not differ between gaits, compared as if they did: no more alarms than the level."""
    rng, count, level = np.random.default_rng(9), 3000, 0.05
    hits = 0
    for _ in range(count):
        seen, known = rng.normal(size=4), rng.normal(size=6)
        turn = np.sign(ahead_of(walked(seen, trials), walked(known, REFERENCES), assumed)[0])
        sizes = walked(turn * seen, trials), walked(turn * known, REFERENCES)
        hits += chance_of(*sizes, (), 1, Usual(Scatter(0.0, 0.0, assumed))) < level
    assert hits <= stats.binom.ppf(0.99, count, 1.3 * level)


def test_another_gait_than_any_reference_has_is_judged_with_care() -> None:
    """Where gaits differ, a trial of a new gait may differ from references without a cause."""
    seen, known = walked([1.0, 1.1, 0.9], "www"), walked([0.1, -0.1, 0.0, 0.1, 0.1, 0.0], "ttmmtm")
    alike, differ = (
        chance_of(seen, known, (), 1, Usual(Scatter(0.0, 0.0, share))) for share in (0.0, 30.0)
    )
    assert alike < 1e-3 < differ


def test_a_design_is_made_once() -> None:
    assert design((("t", "m"),), 1.0) is design((("t", "m"),), 1.0)
