"""Traction: balance, least dissipation, symmetry, and the cases that have no answer."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize

from model.errors import ModelError
from model.quasistatic.frame import solve_frame
from model.quasistatic.frames import Reason
from model.traction.coulomb_kernel import FootLaw
from model.traction.frames import (
    Pushes,
    SlidingFeet,
    TractionSolutions,
    prepare,
    solve_traction_frames,
)
from model.values.arrays import FloatArray
from model.values.contact import Support
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from tests.model.oracles.traction import connection, solve_traction


@pytest.fixture(autouse=True, scope="module")
def _compiled() -> None:
    prepare()


def slide(
    feet: FloatArray, velocity: FloatArray, load: FloatArray, mu: FloatArray, w: FloatArray
) -> TractionSolutions:
    """One frame under the viscous ansatz, with given loads."""
    flat, still = slice(None, 2), Pushes(np.zeros((1, 3)))
    return solve_traction_frames(
        SlidingFeet(feet[None, :, flat], velocity[None, :, flat], (mu * load)[None], w[None]),
        FootLaw(False),
        still,
        0.02,
    )


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
    force = slide(feet, velocity, load, mu, anisotropy).force_xy_B[0]
    assert np.abs(force.sum(axis=0)).max() < 1e-9 * load.sum()
    assert abs(moment_z(feet, force)) < 1e-9 * load.sum()
    assert (force[load == 0] == 0).all()


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
    traction = slide(feet, velocity, load, mu, anisotropy)
    assert traction.velocity_B[0] == pytest.approx(least, abs=1e-6)


def test_the_papers_line_of_feet_gives_the_mean() -> None:
    feet = np.array([[0.0, y, 0] for y in (-1.0, 0.0, 1.0, 0.5, -0.5)])
    velocity = np.zeros((5, 3))
    velocity[:, 0] = [-3.0, -1.0, -3.0, -2.0, -2.0]  # even about the middle: no turning
    traction = slide(feet, velocity, np.ones(5), np.ones(5), np.zeros((5, 2)))
    assert traction.velocity_B[0] == pytest.approx([2.2, 0, 0], abs=1e-12)


def test_feet_that_agree_do_not_slip() -> None:
    feet, velocity, load, mu, anisotropy = frame(3)
    velocity[:, :2] = [-0.05, 0.02]
    traction = slide(feet, velocity, load, mu, anisotropy)
    assert traction.velocity_B[0] == pytest.approx([0.05, -0.02, 0], abs=1e-12)
    assert np.abs(traction.slip_B[0, load > 0]).max() < 1e-12
    assert np.abs(traction.force_xy_B).max() < 1e-6


@given(st.integers(0, 1000), st.floats(0.1, 10))
def test_scaling_all_friction_leaves_the_motion(seed: int, factor: float) -> None:
    feet, velocity, load, mu, anisotropy = frame(seed)
    one = slide(feet, velocity, load, mu, anisotropy)
    other = slide(feet, velocity, load, factor * mu, anisotropy)
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

    one = slide(feet, velocity, load, mu, anisotropy)
    other = slide(turned(feet), turned(velocity), load, mu, turned(anisotropy))
    assert other.velocity_B[0, :2] == pytest.approx(one.velocity_B[0, :2] @ turn, abs=1e-9)
    assert other.velocity_B[0, 2] == pytest.approx(one.velocity_B[0, 2], abs=1e-9)
    assert other.force_xy_B[0] == pytest.approx(turned(one.force_xy_B[0]), abs=1e-7)


def test_the_connection_is_linear_and_is_what_the_solution_uses() -> None:
    feet, velocity, load, mu, anisotropy = frame(7)
    matrix = connection(feet[:, :2], load, mu, anisotropy).matrix
    assert matrix.shape == (3, 6, 2)
    by_hand = np.tensordot(matrix, velocity[:, :2], axes=2)
    traction = slide(feet, velocity, load, mu, anisotropy)
    assert traction.velocity_B[0] == pytest.approx(by_hand)


@pytest.mark.parametrize("seed", range(20))
def test_numpy_agrees(seed: int) -> None:
    feet, velocity, load, mu, anisotropy = frame(seed, 3 + seed)
    ours = slide(feet, velocity, load, mu, anisotropy)
    carried = Support(True, "", 0.1, 0.0, 0.0, load, load > 0, 0)
    theirs = solve_traction(feet, velocity, carried, mu, anisotropy)
    np.testing.assert_allclose(ours.velocity_B[0], theirs.velocity_B, rtol=0, atol=1e-12)
    down = load > 0
    np.testing.assert_allclose(ours.slip_B[0, down], theirs.slip_B[down], rtol=0, atol=1e-12)
    np.testing.assert_allclose(ours.force_xy_B[0], theirs.force_B[:, :2], rtol=0, atol=1e-9)


def test_forces_come_near_coulombs_when_all_feet_slip_alike() -> None:
    feet = np.array([[0.2, 0.2, 0], [0.2, -0.2, 0], [-0.2, 0.2, 0], [-0.2, -0.2, 0]])
    velocity = np.zeros((4, 3))
    velocity[:, 0] = [0.1, -0.1, -0.1, 0.1]  # crossed: they cannot all be followed
    traction = slide(feet, velocity, np.full(4, 10.0), np.full(4, 0.6), np.zeros((4, 2)))
    horizontal = np.linalg.norm(traction.force_xy_B[0], axis=1)
    assert horizontal == pytest.approx(np.full(4, 6.0), rel=0.02)


def none_of(traction: TractionSolutions, reason: Reason) -> bool:
    return (
        traction.reason.tolist() == [reason]
        and not traction.valid.any()
        and bool(np.isnan(traction.velocity_B).all())
        and bool(np.isnan(traction.force_xy_B).all())
    )


def test_what_has_no_answer_is_said() -> None:
    feet, velocity, load, mu, anisotropy = frame(1)
    unloaded = np.full_like(load, np.nan)
    assert none_of(slide(feet, velocity, unloaded, mu, anisotropy), Reason.NOT_A_NUMBER)
    single = np.array([9.0, 0, 0, 0, 0, 0])
    assert none_of(slide(feet, velocity, single, mu, anisotropy), Reason.TOO_FEW_FEET)
    heap = np.zeros_like(feet)
    assert none_of(slide(heap, velocity, load, mu, anisotropy), Reason.ONE_POINT)
    velocity[0, 0] = np.nan
    assert none_of(slide(feet, velocity, load, mu, anisotropy), Reason.NOT_A_NUMBER)


def test_what_one_frame_lacks_is_said_in_words() -> None:
    feet, velocity, _, mu, anisotropy = frame(1)
    feet[:, 2] = -0.1
    contact = ContactParameters(np.full(6, 2500.0), mu, anisotropy)
    tipped = solve_frame(FootMotion(feet + np.array([2.0, 0, 0]), velocity), contact, 40.0).traction
    assert not tipped.valid
    assert "no support: the centre of mass is not above the feet" in tipped.reason
    piled = solve_frame(FootMotion(np.zeros((6, 3)), velocity), contact, 40.0).traction
    assert "in one point" in piled.reason
    alone = np.array([[0.0, 0, -0.1], [0.3, 0.2, 0.5]])
    pair = ContactParameters(np.full(2, 2500.0), mu[:2], anisotropy[:2])
    single = solve_frame(FootMotion(alone, velocity[:2]), pair, 40.0).traction
    assert "fewer than two feet" in single.reason
    velocity[0, 0] = np.nan
    unknown = solve_frame(FootMotion(feet, velocity), contact, 40.0).traction
    assert "not a number" in unknown.reason
    for traction in (tipped, piled, single, unknown):
        assert np.isnan(traction.velocity_B).all()
        assert np.isnan(traction.force_B).all()


def test_shapes_that_do_not_fit_are_a_mistake() -> None:
    still = Pushes(np.zeros((1, 3)))
    flat = np.zeros((1, 4, 2))
    with pytest.raises(ModelError, match="do not fit"):
        solve_traction_frames(
            SlidingFeet(flat, flat, np.ones((1, 4)), flat[:, :3]), FootLaw(False), still, 0.02
        )


def test_one_frame_of_the_whole_model() -> None:
    feet = np.array([[0.3, 0.2, -0.1], [0.3, -0.2, -0.1], [-0.3, 0.2, -0.1], [-0.3, -0.2, -0.1]])
    velocity = np.tile([-0.04, 0.0, 0.0], (4, 1))
    contact = ContactParameters(np.full(4, 2500.0), np.full(4, 0.6), np.zeros((4, 2)))
    solution = solve_frame(FootMotion(feet, velocity), contact, 40.0)
    assert solution.support.load_n == pytest.approx(np.full(4, 10.0))
    assert solution.traction.velocity_B == pytest.approx([0.04, 0, 0], abs=1e-12)
