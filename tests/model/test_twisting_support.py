"""Support on a chassis that twists, against the minimum of its energy; rows roll as their moments say."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from model.errors import ModelError
from model.quasistatic.frames import Reason
from model.support.frames import solve_support_frames
from model.support.twisting import solve_twisting_support, twist_of_rows
from model.values.arrays import FloatArray

SHAFT_X = np.array([0.2, 0.2, 0.0, 0.0, -0.2, -0.2])
STIFFNESS = np.array([4000.0, 5000.0, 4500.0, 4000.0, 3500.0, 4000.0])
WEIGHT_N = 80.0


def feet_of(seed: int, frames: int) -> FloatArray:
    """Feet below a body, (F, 6, 3); some of them are in the air."""
    rng = np.random.default_rng(seed)
    feet = np.zeros((frames, 6, 3))
    feet[..., 0] = SHAFT_X + rng.normal(0, 0.03, (frames, 6))
    feet[..., 1] = 0.2 * np.array([1, -1, 1, -1, 1, -1]) + rng.normal(0, 0.01, (frames, 6))
    feet[..., 2] = -0.1 + rng.normal(0, 0.004, (frames, 6))
    return feet


def energy_minimum(feet: FloatArray, twist_rad_nm: float) -> FloatArray:
    """Loads, then the angles of front and rear, by descent on springs, weight and torsion of two halves."""
    aside = np.outer(feet[:, 1], [1.0, 1.0]) * (SHAFT_X[:, None] == [0.2, -0.2])
    rows = np.column_stack([-feet[:, 0], feet[:, 1], np.ones(6), aside])
    torsion = np.diag([0.0, 0.0, 0.0, 2.0 / twist_rad_nm, 2.0 / twist_rad_nm])

    def pressed(s: FloatArray) -> FloatArray:
        p: FloatArray = np.minimum(rows @ s + feet[:, 2], 0.0)
        return p

    def energy(s: FloatArray) -> float:
        return float(0.5 * STIFFNESS @ pressed(s) ** 2 + WEIGHT_N * s[2] + 0.5 * s @ torsion @ s)

    def gradient(s: FloatArray) -> FloatArray:
        slope: FloatArray = rows.T @ (STIFFNESS * pressed(s)) + torsion @ s
        slope[2] += WEIGHT_N
        return slope

    start = [0.0, 0.0, 0.1 - WEIGHT_N / STIFFNESS.min(), 0.0, 0.0]
    best = minimize(energy, start, jac=gradient, method="BFGS", options={"gtol": 1e-9}).x
    for _ in range(80):
        down = pressed(best) < 0
        hessian = rows[down].T @ (STIFFNESS[down, None] * rows[down]) + torsion
        best = best - 0.7 * np.linalg.lstsq(hessian, gradient(best), rcond=None)[0]
    return np.concatenate([-STIFFNESS * pressed(best), best[3:]])


@pytest.mark.parametrize("twist_rad_nm", [0.002, 0.02, 0.05])
def test_loads_and_angles_are_those_of_least_energy(twist_rad_nm: float) -> None:
    feet = feet_of(3, 12)
    got, angle = solve_twisting_support(
        feet, np.zeros((1, 6)), STIFFNESS, WEIGHT_N, feet[..., 1],
        twist_of_rows(SHAFT_X, twist_rad_nm),
    )  # fmt: skip
    assert got.valid.all()
    assert (got.load_n == 0).any()
    assert np.abs(angle).max() > 1e-3
    for one, load, (rear, middle, front) in zip(feet, got.load_n, angle, strict=True):
        want = energy_minimum(one, twist_rad_nm)
        assert load == pytest.approx(want[:6], abs=1e-6 * WEIGHT_N)
        assert (front, rear) == pytest.approx(want[6:], abs=1e-9)
        assert middle == 0.0


@given(
    st.integers(0, 10_000),
    st.floats(1e-4, 0.05),
    st.lists(st.floats(-0.004, 0.004), min_size=6, max_size=6),
)
def test_feet_stand_where_rows_that_roll_put_them(
    seed: int, twist_rad_nm: float, ground: list[float]
) -> None:
    feet, level = feet_of(seed, 5), np.tile(ground, (5, 1))
    row, give = twist_of_rows(SHAFT_X, twist_rad_nm)
    got, angle = solve_twisting_support(feet, level, STIFFNESS, WEIGHT_N, feet[..., 1], (row, give))
    moved = feet.copy()
    moved[..., 2] += feet[..., 1] * angle[:, row]
    stiff = solve_support_frames(moved, level, STIFFNESS, WEIGHT_N)
    assert got.load_n == pytest.approx(stiff.load_n, abs=1e-6, nan_ok=True)
    moment = np.nan_to_num(got.load_n) * feet[..., 1]
    of_rows = np.stack([moment[:, row == k].sum(axis=1) for k in range(3)], axis=1)
    assert angle == pytest.approx(of_rows @ give, abs=1e-9)


def test_an_angle_that_is_not_found_is_no_answer() -> None:
    feet = feet_of(11, 4000)
    row, give = twist_of_rows(SHAFT_X, 1.0)
    got, angle = solve_twisting_support(
        feet, np.zeros((1, 6)), STIFFNESS, WEIGHT_N, feet[..., 1], (row, give)
    )
    assert 0 < got.valid.sum() < len(feet)
    assert set(got.reason[~got.valid].tolist()) == {Reason.NO_CONVERGENCE}
    assert np.isnan(got.load_n[~got.valid]).all()
    moment = got.load_n * feet[..., 1]
    of_rows = np.stack([moment[:, row == k].sum(axis=1) for k in range(3)], axis=1)
    assert angle[got.valid] == pytest.approx((of_rows @ give)[got.valid], abs=1e-8)


def test_a_frame_without_numbers_has_no_answer_and_spoils_no_other() -> None:
    feet = feet_of(5, 3)
    feet[1, 2, 2] = np.nan
    twist = twist_of_rows(SHAFT_X, 0.02)
    got, angle = solve_twisting_support(
        feet, np.zeros((1, 6)), STIFFNESS, WEIGHT_N, feet[..., 1], twist
    )
    assert got.valid.tolist() == [True, False, True]
    assert np.isnan(got.load_n[1]).all()
    alone, own = solve_twisting_support(
        feet[2:], np.zeros((1, 6)), STIFFNESS, WEIGHT_N, feet[2:, :, 1], twist
    )
    assert np.array_equal(got.load_n[2:], alone.load_n)
    assert np.array_equal(angle[2:], own)


@pytest.mark.parametrize(
    ("weight_n", "stiffness"), [(0.0, STIFFNESS), (WEIGHT_N, -STIFFNESS), (WEIGHT_N, STIFFNESS[:5])]
)
def test_what_no_robot_has_is_a_mistake(weight_n: float, stiffness: FloatArray) -> None:
    feet = feet_of(7, 2)
    with pytest.raises(ModelError):
        solve_twisting_support(
            feet, np.zeros((1, 6)), stiffness, weight_n, feet[..., 1], twist_of_rows(SHAFT_X, 0.02)
        )
