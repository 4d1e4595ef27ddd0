"""Coulomb's law: frames that prove their own answers, a million in ``make soak``; the paper's method."""

import numpy as np
import pytest

from model.quasistatic.frames import FrameSolutions, FrictionLaw, Reason, solve_frames
from model.support.kernel import ROWS, SPEED_X, X, Y
from model.traction.coulomb_frame import balance_frame, balance_space
from model.traction.coulomb_kernel import FootLaw
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from tests.model.coulomb_frames import KINDS, frames, trouble
from tests.model.oracles.coulomb import solve_coulomb_reference
from tests.soaked import THOROUGH, soaked

WEIGHT_N = 60.0
LEGS = (3, 4, 6, 12, 50)
PER_CASE = (500, 10_000)  # 2 x 10 kinds x 5 numbers of legs: a million in all in soak


def contact_of(legs: int, mu: FloatArray, w: FloatArray | None = None) -> ContactParameters:
    return ContactParameters(np.full(legs, 2500.0), mu, np.zeros((legs, 2)) if w is None else w)


def coulomb(feet: FootMotion, contact: ContactParameters) -> FrameSolutions:
    return solve_frames(feet, contact, WEIGHT_N, law=FrictionLaw.COULOMB)


@pytest.mark.parametrize("per_case", soaked(PER_CASE, lambda count: count < 1000, mark=THOROUGH))
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("legs", LEGS)
def test_no_frame_fails_and_every_answer_proves_itself(kind: str, legs: int, per_case: int) -> None:
    rng = np.random.default_rng([LEGS.index(legs), KINDS.index(kind)])
    for mu in (np.full(legs, 0.6), rng.uniform(0.2, 1.2, legs)):
        feet = frames(kind, per_case, legs, rng)
        answer = coulomb(feet, contact_of(legs, mu))
        assert set(np.unique(answer.reason)) <= {Reason.FINE, Reason.TIPS}
        fine = answer.valid
        assert fine.mean() > 0.9
        balance, cone, lost = trouble(
            feet.position_m[fine],
            answer.load_n[fine],
            mu,
            answer.slip_B[fine],
            answer.force_xy_B[fine],
        )
        assert balance.max() <= 1e-8, "forces and moment balance"
        assert cone.max() <= 1e-12, "no force leaves its cone"
        assert lost.max() <= 1e-9, "sliding feet are braked by all of mu N, straight"


def test_slips_belong_to_the_velocity_and_sticking_feet_rest() -> None:
    feet = frames("mixed", 2000, 6, np.random.default_rng(3))
    answer = coulomb(feet, contact_of(6, np.full(6, 0.6)))
    v, q = answer.velocity_B[:, None, :], feet.position_m
    slip = np.stack([v[..., 0] - v[..., 2] * q[..., 1], v[..., 1] + v[..., 2] * q[..., 0]], axis=2)
    np.testing.assert_allclose(slip + feet.velocity_m_s[..., :2], answer.slip_B, atol=1e-10)
    assert (answer.slip_B[answer.sticking] == 0.0).all()
    assert 0.1 < answer.sticking.mean() < 0.9


def test_where_the_papers_method_converges_it_agrees() -> None:
    mu = np.full(6, 0.6)
    feet = frames("random", 200, 6, np.random.default_rng(4))
    answer = coulomb(feet, contact_of(6, mu))
    start = solve_frames(feet, contact_of(6, mu), WEIGHT_N).velocity_B
    converged = 0
    for i in range(200):
        theirs = solve_coulomb_reference(
            feet.position_m[i, :, :2],
            feet.velocity_m_s[i, :, :2],
            answer.load_n[i],
            mu,
            start[i],
        )
        if theirs.converged:
            converged += 1
            size = np.linalg.norm(answer.velocity_B[i])
            assert np.linalg.norm(theirs.velocity_B - answer.velocity_B[i]) < 3e-3 * size
    assert converged > 150


def test_the_frame_before_changes_the_way_but_not_the_answer() -> None:
    """Hot-started in order, in reverse, and each frame alone."""
    t = np.linspace(0, 1, 400)[:, None]
    angle = np.arange(6) * np.pi / 3
    feet = np.zeros((400, 6, 3))
    feet[..., 0] = 0.3 * np.cos(angle) + 0.05 * np.sin(7 * t + angle)
    feet[..., 1] = 0.3 * np.sin(angle)
    feet[..., 2] = -0.15 + 0.001 * np.cos(5 * t + 2 * angle)
    speed = np.asarray(np.gradient(feet, axis=0)) * 100
    contact = contact_of(6, np.linspace(0.4, 0.9, 6))
    onward = coulomb(FootMotion(feet, speed), contact)
    back = coulomb(FootMotion(feet[::-1], speed[::-1]), contact)
    np.testing.assert_allclose(onward.velocity_B, back.velocity_B[::-1], atol=1e-11)
    for i in (0, 57, 399):
        alone = coulomb(FootMotion(feet[i : i + 1], speed[i : i + 1]), contact)
        np.testing.assert_allclose(alone.velocity_B[0], onward.velocity_B[i], atol=1e-11)
        np.testing.assert_allclose(alone.force_xy_B[0], onward.force_xy_B[i], atol=1e-8)


@pytest.mark.parametrize("kind", ["random", "uneven", "mixed", "one"])
def test_the_last_digit_of_a_speed_changes_no_force(kind: str) -> None:
    """The feet of "uneven" slip up to a million times slower than the fastest one."""
    rng = np.random.default_rng(8)
    contact = contact_of(6, np.full(6, 0.6))
    feet = frames(kind, 3000, 6, rng)
    nudged = feet.velocity_m_s * (1 + 2e-16 * rng.choice([-1, 1], feet.velocity_m_s.shape))
    one, other = coulomb(feet, contact), coulomb(FootMotion(feet.position_m, nudged), contact)
    alone = one.unique & other.unique
    assert alone.sum() > 10
    assert (one.sticking[alone] == other.sticking[alone]).all()
    away = np.abs(one.force_xy_B[alone] - other.force_xy_B[alone]).max()
    assert away < 2e-8  # N; 9e-6 while rounding sent a frame to another solver


def test_several_feet_at_rest_leave_forces_undetermined() -> None:
    feet = frames("rigid", 50, 6, np.random.default_rng(5))
    answer = coulomb(feet, contact_of(6, np.full(6, 0.6)))
    assert answer.valid.all()
    assert (answer.sticking == answer.contact).all()
    assert not answer.unique.any()
    random = coulomb(
        frames("random", 300, 6, np.random.default_rng(5)), contact_of(6, np.full(6, 0.6))
    )
    assert random.unique.all()


def test_an_even_number_in_a_row_has_a_range_of_medians() -> None:
    """Four equal feet that only slide along x: any speed between the middle two will do."""
    feet = np.array([[0.3, 0.2, -0.1], [0.3, -0.2, -0.1], [-0.3, 0.2, -0.1], [-0.3, -0.2, -0.1]])
    speed = np.zeros((4, 3))
    speed[:, 0] = [-0.04, -0.04, -0.01, -0.01]
    answer = coulomb(FootMotion(feet[None], speed[None]), contact_of(4, np.full(4, 0.5)))
    assert answer.valid.all()
    assert not answer.unique.any()
    assert 0.01 <= answer.velocity_B[0, 0] <= 0.04
    assert abs(answer.force_xy_B[0].sum(axis=0)).max() < 1e-8 * WEIGHT_N


def test_the_heaviest_foot_of_two_stays() -> None:
    feet = np.array([[0.1, 0.1, -0.1], [-0.3, -0.3, -0.1], [0.0, 0.0, 0.5]])
    speed = np.array([[0.1, -0.1, 0.0], [-0.2, 0.1, 0.0], [0.0, 0.0, 0.0]])
    answer = coulomb(FootMotion(feet[None], speed[None]), contact_of(3, np.full(3, 0.5)))
    assert answer.load_n[0, 0] > answer.load_n[0, 1]
    assert answer.sticking[0].tolist() == [True, False, False]
    arm = feet[1, :2] - feet[0, :2]
    slip = answer.slip_B[0, 1]
    assert abs(arm[0] * slip[1] - arm[1] * slip[0]) < 1e-9, "it only slides along the line"


@pytest.mark.parametrize("seed", range(5))
def test_anisotropic_feet_pull_more_along_w(seed: int) -> None:
    rng = np.random.default_rng(seed)
    feet = frames("random", 400, 6, rng)
    w = rng.normal(scale=0.7, size=(6, 2))
    mu = np.full(6, 0.5)
    answer = coulomb(feet, contact_of(6, mu, w))
    assert answer.valid.all()
    weight_axes = np.eye(2) + w[:, :, None] * w[:, None, :]  # L
    inverse = np.linalg.inv(weight_axes)
    pulled = np.einsum("kij,fkj->fki", inverse, answer.force_xy_B)
    limit = mu * answer.load_n
    assert (np.linalg.norm(pulled, axis=2) <= limit * (1 + 1e-9) + 1e-9).all()
    sliding = np.einsum("kij,fkj->fki", weight_axes, answer.slip_B)
    power = limit * np.linalg.norm(sliding, axis=2) + (pulled * sliding).sum(axis=2)
    assert np.abs(power[~answer.sticking]).max() < 1e-9
    balance, _, _ = trouble(feet.position_m, answer.load_n, mu, answer.slip_B, answer.force_xy_B)
    assert balance.max() < 1e-8


def test_the_paper_reference_says_when_it_fails() -> None:
    """A body without slip: the smoothed law is at its singular point."""
    feet = np.array([[0.3, 0.2], [0.3, -0.2], [-0.3, 0.0]])
    answer = solve_coulomb_reference(
        feet, np.zeros((3, 2)), np.full(3, 20.0), np.full(3, 0.6), np.full(3, 0.1)
    )
    assert answer.searches >= 1
    assert answer.converged is False or answer.imbalance < 1e-6


@pytest.mark.parametrize("fast_m_s", [0.01, 0.2])
def test_any_forces_that_hold_feet_at_rest_leave_the_velocity_and_balance(fast_m_s: float) -> None:
    """Forces of feet at rest are open: whoever does not ask which gets the same motion, and a balance."""
    place = np.array([[-0.2, 0.25], [0.0, 0.27], [0.2, 0.25], [-0.2, -0.25], [0.2, -0.25]])
    loads, mu = np.array([10.0, 20.0, 12.0, 14.0, 16.0]), np.full(5, 0.6)
    work = np.zeros((ROWS, 5))
    work[X], work[Y] = place.T
    work[SPEED_X] = -0.03
    work[SPEED_X, 1] -= fast_m_s
    answers = []
    for creep in (True, False):
        twist, rest = np.empty(3), np.zeros(5, dtype=np.bool_)
        slip, force = np.zeros((5, 2)), np.zeros((5, 2))
        reason, _ = balance_frame(
            work, loads, mu, FootLaw(True, 0.0, 1.0, 1.0, 1.0), np.empty(0), slip[:0], False, twist,
            slip, force, rest, creep, balance_space(5),
        )  # fmt: skip
        assert reason == 0
        assert rest.tolist() == [True, False, True, True, True]
        np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-9)
        moment = place[:, 0] * force[:, 1] - place[:, 1] * force[:, 0]
        assert moment.sum() == pytest.approx(0.0, abs=1e-9)
        assert (np.hypot(*force.T) <= 0.6 * loads * (1 + 1e-12)).all()
        answers.append(np.concatenate([twist, slip.ravel(), force[1]]))
    np.testing.assert_allclose(answers[1], answers[0], atol=1e-12)
