"""Traction: balance, least dissipation, symmetry, and the cases that have no answer."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from model.errors import ModelError
from model.parameters.robot import ContactParameters
from model.quasistatic.frame import solve_frame
from model.traction.viscous import connection, solve_traction
from model.values.arrays import FloatArray
from model.values.contact import Support, Traction
from model.values.legs import FootMotion


def carried(load: FloatArray) -> Support:
    return Support(True, "", 0.1, 0.0, 0.0, load, load > 0, 0)


def frame(seed: int, legs: int = 6):  # type: ignore[no-untyped-def]
    rng = np.random.default_rng(seed)
    feet = rng.uniform(-0.4, 0.4, (legs, 3))
    velocity = rng.uniform(-0.1, 0.1, (legs, 3))
    load = np.where(rng.random(legs) < 0.3, 0.0, rng.uniform(1, 20, legs))
    load[:3] = rng.uniform(1, 20, 3)
    return feet, velocity, load, rng.uniform(0.3, 0.9, legs), rng.uniform(-0.5, 0.5, (legs, 2))


def moment_z(feet: FloatArray, force: FloatArray) -> float:
    return float(np.sum(feet[:, 0] * force[:, 1] - feet[:, 1] * force[:, 0]))


@given(st.integers(0, 10_000), st.integers(3, 12))
def test_forces_and_moment_balance(seed: int, legs: int) -> None:
    feet, velocity, load, mu, anisotropy = frame(seed, legs)
    traction = solve_traction(feet, velocity, carried(load), mu, anisotropy)
    force = traction.force_B
    assert np.abs(force[:, :2].sum(axis=0)).max() < 1e-9 * load.sum()
    assert abs(moment_z(feet, force)) < 1e-9 * load.sum()
    assert (force[load == 0] == 0).all()
    assert np.isnan(traction.slip_B[load == 0]).all()


@pytest.mark.parametrize("seed", range(20))
def test_the_velocity_dissipates_least(seed: int) -> None:
    feet, velocity, load, mu, anisotropy = frame(seed)
    drag = (mu * load)[:, None, None] * (
        np.eye(2) + anisotropy[:, :, None] * anisotropy[:, None, :]
    )

    def dissipation(u: FloatArray) -> float:
        turning = u[2] * np.column_stack([-feet[:, 1], feet[:, 0]])
        slip = u[:2] + turning + velocity[:, :2]
        return float(np.einsum("ki,kij,kj->", slip, drag, slip))

    least = minimize(dissipation, np.zeros(3), method="BFGS", options={"gtol": 1e-12}).x
    traction = solve_traction(feet, velocity, carried(load), mu, anisotropy)
    assert traction.velocity_B == pytest.approx(least, abs=1e-6)


def test_the_papers_line_of_feet_gives_the_mean() -> None:
    feet = np.array([[0.0, y, 0] for y in (-1.0, 0.0, 1.0, 0.5, -0.5)])
    velocity = np.zeros((5, 3))
    velocity[:, 0] = [-3.0, -1.0, -3.0, -2.0, -2.0]  # even about the middle: no turning
    traction = solve_traction(feet, velocity, carried(np.ones(5)), np.ones(5), np.zeros((5, 2)))
    assert traction.velocity_B == pytest.approx([2.2, 0, 0], abs=1e-12)


def test_feet_that_agree_do_not_slip() -> None:
    feet, velocity, load, mu, anisotropy = frame(3)
    velocity[:, :2] = [-0.05, 0.02]
    traction = solve_traction(feet, velocity, carried(load), mu, anisotropy)
    assert traction.velocity_B == pytest.approx([0.05, -0.02, 0], abs=1e-12)
    assert np.nanmax(np.abs(traction.slip_B)) < 1e-12
    assert np.abs(traction.force_B[:, :2]).max() < 1e-6


@given(st.integers(0, 1000), st.floats(0.1, 10))
def test_scaling_all_friction_leaves_the_motion(seed: int, factor: float) -> None:
    feet, velocity, load, mu, anisotropy = frame(seed)
    one = solve_traction(feet, velocity, carried(load), mu, anisotropy)
    other = solve_traction(feet, velocity, carried(load), factor * mu, anisotropy)
    assert other.velocity_B == pytest.approx(one.velocity_B, abs=1e-9)


@given(st.integers(0, 1000), st.floats(-3, 3))
def test_turning_the_axes_turns_the_answer(seed: int, angle: float) -> None:
    feet, velocity, load, mu, anisotropy = frame(seed)
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, s], [-s, c]])

    def turned(vectors: FloatArray) -> FloatArray:
        out = vectors.copy()
        out[:, :2] = vectors[:, :2] @ turn
        return out

    one = solve_traction(feet, velocity, carried(load), mu, anisotropy)
    other = solve_traction(turned(feet), turned(velocity), carried(load), mu, turned(anisotropy))
    assert other.velocity_B[:2] == pytest.approx(one.velocity_B[:2] @ turn, abs=1e-9)
    assert other.velocity_B[2] == pytest.approx(one.velocity_B[2], abs=1e-9)
    assert other.force_B == pytest.approx(turned(one.force_B), abs=1e-7)


def test_the_connection_is_linear_and_is_what_the_solution_uses() -> None:
    feet, velocity, load, mu, anisotropy = frame(7)
    matrix = connection(feet[:, :2], load, mu, anisotropy).matrix
    assert matrix.shape == (3, 6, 2)
    by_hand = np.tensordot(matrix, velocity[:, :2], axes=2)
    traction = solve_traction(feet, velocity, carried(load), mu, anisotropy)
    assert traction.velocity_B == pytest.approx(by_hand)


def test_forces_come_near_coulombs_when_all_feet_slip_alike() -> None:
    feet = np.array([[0.2, 0.2, 0], [0.2, -0.2, 0], [-0.2, 0.2, 0], [-0.2, -0.2, 0]])
    velocity = np.zeros((4, 3))
    velocity[:, 0] = [0.1, -0.1, -0.1, 0.1]  # crossed: they cannot all be followed
    traction = solve_traction(
        feet, velocity, carried(np.full(4, 10.0)), np.full(4, 0.6), np.zeros((4, 2))
    )
    horizontal = np.linalg.norm(traction.force_B[:, :2], axis=1)
    assert horizontal == pytest.approx(np.full(4, 6.0), rel=0.02)


def none_of(traction: Traction, words: str) -> bool:
    return (
        not traction.valid
        and words in traction.reason
        and bool(np.isnan(traction.velocity_B).all())
        and bool(np.isnan(traction.force_B).all())
    )


def test_what_has_no_answer_is_said() -> None:
    feet, velocity, load, mu, anisotropy = frame(1)
    tipped = Support(False, "it tips", np.nan, np.nan, np.nan, load, load > 0, 0)
    assert none_of(solve_traction(feet, velocity, tipped, mu, anisotropy), "it tips")
    single = np.array([9.0, 0, 0, 0, 0, 0])
    alone = solve_traction(feet, velocity, carried(single), mu, anisotropy)
    assert none_of(alone, "fewer than two feet")
    heap = np.zeros_like(feet)
    piled = solve_traction(heap, velocity, carried(load), mu, anisotropy)
    assert none_of(piled, "in one point")
    velocity[0, 0] = np.nan
    unknown = solve_traction(feet, velocity, carried(load), mu, anisotropy)
    assert none_of(unknown, "not a number")


def test_shapes_that_do_not_fit_are_a_mistake() -> None:
    with pytest.raises(ModelError, match="anisotropy"):
        connection(np.zeros((4, 2)), np.ones(4), np.ones(3), np.zeros((4, 2)))


def test_one_frame_of_the_whole_model() -> None:
    feet = np.array([[0.3, 0.2, -0.1], [0.3, -0.2, -0.1], [-0.3, 0.2, -0.1], [-0.3, -0.2, -0.1]])
    velocity = np.tile([-0.04, 0.0, 0.0], (4, 1))
    contact = ContactParameters(np.full(4, 2500.0), np.full(4, 0.6), np.zeros((4, 2)))
    solution = solve_frame(FootMotion(feet, velocity), contact, 40.0)
    assert solution.support.load_n == pytest.approx(np.full(4, 10.0))
    assert solution.traction.velocity_B == pytest.approx([0.04, 0, 0], abs=1e-12)
