"""Spring support against an independent convex minimiser, and against balance itself."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import linprog, minimize
from scipy.spatial import ConvexHull

from model.errors import ModelError
from model.quasistatic.frame import prepare, solve_frame
from model.values.arrays import FloatArray
from model.values.contact import Support
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters


@pytest.fixture(autouse=True, scope="module")
def _compiled() -> None:
    prepare()


def solve_support(feet: FloatArray, stiffness: FloatArray, load: float) -> Support:
    contact = ContactParameters(stiffness, np.ones(len(feet)), np.zeros((len(feet), 2)))
    return solve_frame(FootMotion(feet, np.zeros_like(feet)), contact, load).support


def energy_minimum(feet: FloatArray, stiffness: FloatArray, load: float) -> FloatArray:
    """Loads at the minimum of E(s), found without the contact search (BFGS, then Newton polish)."""
    rows = np.stack([-feet[:, 0], feet[:, 1], np.ones(len(feet))], axis=1)

    def energy(s: FloatArray) -> float:
        p = np.minimum(rows @ s + feet[:, 2], 0)
        return float(0.5 * stiffness @ p**2 + load * s[2])

    def gradient(s: FloatArray) -> FloatArray:
        p = np.minimum(rows @ s + feet[:, 2], 0)
        slope: FloatArray = rows.T @ (stiffness * p) + np.array([0, 0, load])
        return slope

    low = -feet[:, 2].max() - load / stiffness.min()
    best = minimize(energy, [0, 0, low], jac=gradient, method="BFGS", options={"gtol": 1e-10}).x
    for _ in range(60):
        p = rows @ best + feet[:, 2]
        down = p < 0
        hessian = rows[down].T @ (stiffness[down, None] * rows[down])
        best = best - 0.7 * np.linalg.lstsq(hessian, gradient(best), rcond=None)[0]
    return stiffness * np.maximum(-(rows @ best + feet[:, 2]), 0)


def balanced(feet: FloatArray, support: Support, load: float) -> bool:
    n = support.load_n
    lever = np.abs(feet[:, :2]).max()
    return bool(
        abs(n.sum() - load) < 1e-9 * load
        and abs(n @ feet[:, 0]) < 1e-9 * load * lever
        and abs(n @ feet[:, 1]) < 1e-9 * load * lever
        and (n >= 0).all()
    )


def springs_agree(feet: FloatArray, stiffness: FloatArray, support: Support, load: float) -> bool:
    p = -support.slope_x * feet[:, 0] + support.slope_y * feet[:, 1] + feet[:, 2] + support.height_m
    return bool(np.abs(stiffness * np.maximum(-p, 0) - support.load_n).max() < 1e-8 * load)


def random_poses(seed: int, count: int):  # type: ignore[no-untyped-def]
    rng = np.random.default_rng(seed)
    for number in range(count):
        legs = int(rng.integers(3, 13))
        feet = rng.uniform(-1, 1, (legs, 3)) * [1, 1, rng.choice([0, 1e-3, 0.01, 0.3])]
        if number % 4 == 0:  # feet on a grid: equal heights, feet in a row
            feet = np.round(feet, 1)
        stiffness = rng.uniform(0.5, 2, legs) * rng.choice([10, 2500])
        yield feet, stiffness, float(rng.uniform(0.1, 100))


def above_the_feet(feet: FloatArray) -> bool:
    """Whether the centre of mass is a convex combination of the feet (linear programme)."""
    legs = len(feet)
    equal = np.vstack([feet[:, :2].T, np.ones(legs)])
    found = linprog(np.zeros(legs), A_eq=equal, b_eq=[0, 0, 1], bounds=(0, None), method="highs")
    return bool(found.status == 0)


def test_loads_are_those_of_a_convex_minimiser() -> None:
    compared = 0
    for feet, stiffness, load in random_poses(seed=1, count=200):
        support = solve_support(feet, stiffness, load)
        if not support.converged:
            continue
        hull = ConvexHull(feet[:, :2], qhull_options="QJ")
        if (hull.equations[:, 2] > -0.05).any():
            continue  # near tipping BFGS is the one that fails
        compared += 1
        expected = energy_minimum(feet, stiffness, load)
        assert np.abs(support.load_n - expected).max() < 1e-7 * load
    assert compared > 100


def test_every_pose_is_balanced_or_tips() -> None:
    """Balance and the spring law together are the optimum of a convex problem: a certificate."""
    found = tipped = 0
    for feet, stiffness, load in random_poses(seed=2, count=2200):
        support = solve_support(feet, stiffness, load)
        if support.converged:
            found += 1
            assert balanced(feet, support, load)
            assert springs_agree(feet, stiffness, support, load)
        else:
            tipped += 1
            assert "tips" in support.reason
            assert np.isnan(support.load_n).all()
            # it is not above them either when they stand a little closer together
            assert not above_the_feet(0.999 * feet + 0.001 * feet.mean(axis=0))
    assert found > 1500
    assert tipped > 200


# On a grid of millimetres: feet coincide or are apart. Ones 1e-11 m apart have a pose that no rounding
# leaves alone; test_contact_oracle is for such.
millimetres = st.integers(-1000, 1000).map(lambda n: n / 1000)
feet_lists = st.lists(
    st.tuples(millimetres, millimetres, st.integers(-200, 200).map(lambda n: n / 1000)),
    min_size=3,
    max_size=10,
)


@given(feet_lists)
def test_a_leg_keeps_its_load_wherever_it_is_listed(points: list[tuple[float, ...]]) -> None:
    feet = np.array(points)
    stiffness = np.linspace(500, 900, len(feet))
    support = solve_support(feet, stiffness, 60.0)
    order = np.random.default_rng(0).permutation(len(feet))
    other = solve_support(feet[order], stiffness[order], 60.0)
    if support.converged and other.converged:
        assert other.load_n == pytest.approx(support.load_n[order], abs=1e-6)


@given(feet_lists, st.floats(0.1, 10))
def test_scaling_stiffness_and_load_together_leaves_the_pose(
    points: list[tuple[float, ...]], factor: float
) -> None:
    feet = np.array(points)
    stiffness = np.full(len(feet), 800.0)
    one = solve_support(feet, stiffness, 60.0)
    other = solve_support(feet, factor * stiffness, factor * 60.0)
    if one.converged and other.converged:
        assert other.height_m == pytest.approx(one.height_m, rel=1e-6, abs=1e-9)
        assert other.load_n == pytest.approx(factor * one.load_n, rel=1e-6, abs=1e-6)


SQUARE = np.array([[1, 1, 0], [1, -1, 0], [-1, 1, 0], [-1, -1, 0]], dtype=float)


def test_a_level_square_shares_the_load() -> None:
    support = solve_support(SQUARE - [0, 0, 0.5], np.full(4, 100.0), 40.0)
    assert support.load_n == pytest.approx([10, 10, 10, 10])
    assert support.height_m == pytest.approx(0.4)
    assert (support.slope_x, support.slope_y) == pytest.approx((0, 0), abs=1e-12)


def test_a_longer_front_lifts_the_nose() -> None:
    feet = SQUARE - np.array([0, 0, 0.5])
    feet[:2, 2] -= 0.01
    support = solve_support(feet, np.full(4, 1e5), 40.0)
    assert support.slope_x < 0, "slope_x > 0 lowers the nose (eqn:zpj)"


def test_two_feet_under_the_centre_of_mass_carry_it() -> None:
    feet = np.array([[0, 1, -1.0], [0, -1, -1.0], [1, 0, 0.5]])
    support = solve_support(feet, np.full(3, 100.0), 10.0)
    assert support.converged
    assert support.load_n == pytest.approx([5, 5, 0])


def test_one_leg_down_first_tilts_until_others_come() -> None:
    feet = np.array([[0.5, 0.5, -1.0], [-1, 0.2, -0.2], [0.2, -1, -0.2]])
    support = solve_support(feet, np.full(3, 1e4), 10.0)
    assert support.contact.all()
    assert balanced(feet, support, 10.0)


@pytest.mark.parametrize(
    ("feet", "words"),
    [
        (np.array([[1, 0, 0], [1, 1, 0], [1, -1, 0]], float), "tips"),
        (np.array([[1.0, 0, 0], [-1, 0, np.nan], [0, 1, 0]]), "not a number"),
    ],
)
def test_no_equilibrium_is_said_not_invented(feet: FloatArray, words: str) -> None:
    support = solve_support(feet, np.full(len(feet), 100.0), 10.0)
    assert not support.converged
    assert words in support.reason
    assert np.isnan(support.height_m)
    assert np.isnan(support.load_n).all()


def test_shapes_that_do_not_fit_are_a_mistake() -> None:
    with pytest.raises(ModelError, match="not those of 4 legs"):
        solve_support(SQUARE, np.ones(3), 1.0)
    with pytest.raises(ModelError, match=r"\(N, 3\)"):
        solve_support(np.zeros((0, 3)), np.ones(0), 1.0)
