"""The paper's small examples: median and mean, the friction family, the force field, the search."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from model.errors import ModelError
from model.quasistatic.frame import prepare, solve_frame
from model.quasistatic.frames import FrictionLaw
from model.support.path import search_path
from model.systems.paper_examples import (
    ansatz_error,
    balance_velocity,
    coulomb_balance,
    force_share,
    total_force,
)
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters


@pytest.fixture(autouse=True, scope="module")
def _compiled() -> None:
    prepare()
    balance_velocity(np.eye(2), np.ones(2), FrictionLaw.COULOMB)


def on_line(body: FloatArray | float, feet: FloatArray, law: FrictionLaw) -> FloatArray:
    """Total force on a line, in units of one foot's mu N."""
    return total_force(np.asarray(body)[..., None], feet[:, None], np.ones(len(feet)), law)[..., 0]


SPEEDS = st.lists(st.integers(-1000, 1000).map(lambda n: n / 1000), min_size=1, max_size=15)


@given(SPEEDS)
def test_coulomb_balances_at_minus_the_median(speeds: list[float]) -> None:
    feet = np.array(speeds)
    low, high = coulomb_balance(feet)
    assert (low + high) / 2 == pytest.approx(-np.median(feet), abs=1e-12)
    if len(feet) % 2:
        assert low == high
    # a foot at rest can take anything up to mu N: the feet that slip must not ask for more
    for body in (low, (low + high) / 2, high):
        at_rest = np.sum(np.abs(body + feet) < 1e-12)
        assert abs(on_line(body, feet, FrictionLaw.COULOMB)) <= at_rest + (
            0 if len(feet) % 2 else 1e-12
        )


@given(SPEEDS)
def test_nothing_outside_the_interval_balances(speeds: list[float]) -> None:
    feet = np.array(speeds)
    low, high = coulomb_balance(feet)
    outside = on_line(np.array([low - 1e-4, high + 1e-4]), feet, FrictionLaw.COULOMB)
    assert outside[0] > 0 > outside[1]


@given(SPEEDS)
def test_the_ansatz_balances_at_minus_the_mean(speeds: list[float]) -> None:
    feet = np.array(speeds)
    assert on_line(-feet.mean(), feet, FrictionLaw.VISCOUS) == pytest.approx(0.0, abs=1e-12)


def test_an_even_number_of_legs_leaves_a_choice() -> None:
    low, high = coulomb_balance(np.array([-0.3, -0.1, 0.2, 0.4]))
    assert (low, high) == (-0.2, 0.1)
    between = np.linspace(low + 1e-6, high - 1e-6, 50)
    feet = np.array([-0.3, -0.1, 0.2, 0.4])
    assert on_line(between, feet, FrictionLaw.COULOMB) == pytest.approx(0, abs=1e-15)


def test_the_family_goes_from_coulomb_to_viscous() -> None:
    speed = np.array([0.01, 0.3, 1.0, 4.0])
    np.testing.assert_allclose(force_share(speed, 0.0), 1.0)
    np.testing.assert_allclose(force_share(speed, 1e-12), 1.0, rtol=1e-7)
    np.testing.assert_allclose(force_share(speed, 1e12), speed, rtol=1e-10)
    np.testing.assert_allclose(force_share(speed, np.inf), speed)


@given(st.floats(1e-9, 1e9))
def test_all_members_agree_at_unit_speed(eps: float) -> None:
    assert force_share(1.0, eps) == pytest.approx(1.0)
    assert force_share(0.0, eps) == 0.0


def test_every_member_is_smooth_at_rest_but_coulomb_jumps() -> None:
    tiny = 1e-9
    assert force_share(tiny, 1e-3) < 2e-9  # slope 1 at rest, whatever eps
    assert force_share(tiny, 0.0) == pytest.approx(1.0)


def test_the_ansatz_is_two_percent_off_across_and_twenty_along() -> None:
    across = ansatz_error(np.array([[0.0, 0.2], [0.0, -0.2]]))
    along = ansatz_error(np.array([[0.2, 0.0], [-0.2, 0.0]]))
    np.testing.assert_allclose(across, np.sqrt(1.04) - 1, rtol=1e-12)
    np.testing.assert_allclose(along, 0.2, rtol=1e-12)
    assert across[0] == pytest.approx(0.0198, abs=1e-4)


@given(st.floats(0, 0.2), st.floats(0, 2 * np.pi))
def test_within_a_fifth_the_ansatz_is_never_more_than_a_fifth_off(r: float, a: float) -> None:
    assert ansatz_error(r * np.array([np.cos(a), np.sin(a)])) <= 0.2 + 1e-12


FEET = st.lists(
    st.tuples(st.integers(-50, 50), st.integers(-50, 50)), min_size=3, max_size=8, unique=True
).map(lambda pairs: np.array(pairs) / 100.0)


@given(FEET)
def test_the_coulomb_balance_is_the_least_dissipation(feet: FloatArray) -> None:
    grip = np.linspace(1.0, 2.0, len(feet))
    found = balance_velocity(feet, grip, FrictionLaw.COULOMB)

    def cost(v: FloatArray) -> float:
        return float(grip @ np.linalg.norm(v + feet, axis=1))

    start = -feet.mean(axis=0)
    best = minimize(cost, start, method="Nelder-Mead", options={"xatol": 1e-6}).fun
    assert cost(found) <= best + 1e-9


@given(FEET)
def test_the_viscous_field_is_a_cone_about_the_mean(feet: FloatArray) -> None:
    grip = np.linspace(1.0, 2.0, len(feet))
    zero = balance_velocity(feet, grip, FrictionLaw.VISCOUS)
    around = zero + np.array([[0.1, 0.0], [0.0, 0.1], [-0.1, 0.0]])
    force = total_force(around, feet, grip, FrictionLaw.VISCOUS)
    np.testing.assert_allclose(np.linalg.norm(force, axis=1), 0.1 * grip.sum())


def test_the_coulomb_field_jumps_where_a_foot_comes_to_rest() -> None:
    feet = np.array([[0.1, 0.0], [-0.2, 0.1], [0.0, -0.3], [0.3, 0.2]])
    grip = np.ones(4)
    for foot in -feet:
        near = foot + 1e-9 * np.array([[1.0, 0.0], [-1.0, 0.0]])
        coulomb = total_force(near, feet, grip, FrictionLaw.COULOMB)
        viscous = total_force(near, feet, grip, FrictionLaw.VISCOUS)
        assert np.hypot(*(coulomb[0] - coulomb[1])) == pytest.approx(2.0, abs=1e-6)
        assert np.hypot(*(viscous[0] - viscous[1])) < 1e-7


def test_the_path_of_the_search_ends_at_the_support() -> None:
    rng = np.random.default_rng(3)
    ended = 0
    for _ in range(300):
        count = int(rng.integers(3, 13))
        feet = rng.uniform(-1, 1, (count, 3)) * [1, 1, rng.choice([1e-3, 0.01, 0.3])]
        stiffness = rng.uniform(0.5, 2, count) * 1000
        contact = ContactParameters(stiffness, np.ones(count), np.zeros((count, 2)))
        support = solve_frame(FootMotion(feet, np.zeros_like(feet)), contact, 60.0).support
        if not support.converged:
            with pytest.raises(ModelError, match="tips"):
                search_path(feet, stiffness, 60.0)
            continue
        ended += 1
        path = search_path(feet, stiffness, 60.0)
        height = feet[:, 2] + path.pose[-1, 2]
        height += -path.pose[-1, 0] * feet[:, 0] + path.pose[-1, 1] * feet[:, 1]
        np.testing.assert_allclose(stiffness * np.maximum(-height, 0), support.load_n, atol=1e-6)
        assert (path.contact[-1] == support.contact).all()
    assert ended > 100


def test_the_path_switches_one_foot_a_stop_and_only_at_zero_height() -> None:
    rng = np.random.default_rng(8)
    feet = np.array([[x, y, 0.0] for y in (0.25, -0.25) for x in (-0.2, 0.0, 0.2)])
    feet[:, 2] = -0.15 + rng.uniform(-0.03, 0.03, 6)
    path = search_path(feet, np.full(6, 2500.0), 64.0)
    assert len(path.pose) > 2
    for stop in range(1, len(path.pose) - 1):
        foot = path.switched[stop]
        changed = path.contact[stop] != path.contact[stop - 1]
        assert np.flatnonzero(changed).tolist() == [foot]
        slope_x, slope_y, height = path.pose[stop]
        p = -slope_x * feet[foot, 0] + slope_y * feet[foot, 1] + feet[foot, 2] + height
        assert abs(p) < 1e-12
    assert path.switched[0] == path.switched[-1] == -1
