"""Traction over frames against the exact batch solver, and what it adds against mechanics."""

import numpy as np
import pytest

from model.errors import ModelError
from model.quasistatic.frames import FrameSolutions, FrictionLaw, solve_frames
from model.support.frames import solve_support_frames
from model.traction.coulomb_kernel import FootLaw
from model.traction.frames import (
    REST_SPEED_M_S,
    Inertia,
    Pushes,
    SlidingFeet,
    TractionSolutions,
    near_answers,
    solve_traction_frames,
)
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from tests.model.coulomb_frames import frames

LEGS, FRAMES = 6, 300
RNG = np.random.default_rng(4)
ROUND = np.linspace(0, 2 * np.pi, LEGS, endpoint=False)
PLACE = np.stack([0.3 * np.cos(ROUND), 0.25 * np.sin(ROUND), np.zeros(LEGS)], axis=1)
POSITION = PLACE + RNG.normal(0, [0.02, 0.02, 0.004], (FRAMES, LEGS, 3))
SPEED = RNG.normal(0, [0.05, 0.02, 0.01], (FRAMES, LEGS, 3))
W = RNG.normal(0, 0.4, (LEGS, 2))
CONTACT = ContactParameters(np.full(LEGS, 2500.0), np.full(LEGS, 0.6), W)
WEIGHT = 64.0


VISCOUS = FootLaw(False)
CREEPING = FootLaw(True, REST_SPEED_M_S)


def exact(law: FrictionLaw) -> FrameSolutions:
    return solve_frames(FootMotion(POSITION, SPEED), CONTACT, WEIGHT, law=law)


def ours(
    law: FootLaw,
    *,
    push: tuple[float, float, float] = (0.0, 0.0, 0.0),
    drag: float = 0.0,
    give: FloatArray | None = None,
) -> TractionSolutions:
    load = exact(FrictionLaw.VISCOUS).load_n
    pushes = Pushes(np.tile(np.array(push), (FRAMES, 1)), drag)
    return solve_traction_frames(
        SlidingFeet(POSITION[..., :2], SPEED[..., :2], 0.6 * load, W[None]), law, pushes, 0.02, give
    )


def test_support_is_that_of_the_batch_solver() -> None:
    found = solve_support_frames(POSITION, np.zeros((FRAMES, LEGS)), CONTACT.stiffness, WEIGHT)
    theirs = exact(FrictionLaw.VISCOUS)
    assert np.array_equal(found.load_n, theirs.load_n)
    assert np.array_equal(found.pose, theirs.pose)
    with pytest.raises(ModelError, match="must be positive"):
        solve_support_frames(POSITION, np.zeros((FRAMES, LEGS)), CONTACT.stiffness, -1.0)
    outside = POSITION + np.array([1.0, 0.0, 0.0])
    tips = solve_support_frames(outside, np.zeros((FRAMES, LEGS)), CONTACT.stiffness, WEIGHT)
    assert not tips.valid.any()
    assert np.isnan(tips.load_n).all()


def test_viscous_is_that_of_the_batch_solver() -> None:
    found, theirs = ours(VISCOUS), exact(FrictionLaw.VISCOUS)
    assert np.allclose(found.velocity_B, theirs.velocity_B, atol=1e-13)
    scale = found.force_xy_B[..., 0] / np.where(
        theirs.load_n > 0, theirs.force_xy_B[..., 0], np.nan
    )
    assert np.nanmax(np.ptp(scale, axis=1), initial=0) < np.nanmedian(scale)  # one scale a frame
    spread = np.nanstd(scale, axis=1) / np.nanmean(scale, axis=1)
    assert np.nanmax(spread) < 1e-9


def test_coulomb_comes_to_the_exact_one_as_creep_vanishes() -> None:
    theirs = exact(FrictionLaw.COULOMB)
    errors = [
        np.sqrt(np.mean((ours(FootLaw(True, rest)).velocity_B - theirs.velocity_B) ** 2))
        for rest in (1e-3, 1e-4, 1e-5)
    ]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < 2e-5  # some frames are nearly flat there


@pytest.mark.parametrize("kind", ["mixed", "one", "turning"])
def test_feet_at_rest_hold_with_the_forces_of_slowest_creep(kind: str) -> None:
    """Where several feet rest the balance leaves forces open: both laws choose the same ones."""
    feet = frames(kind, 300, LEGS, np.random.default_rng(2))
    contact = ContactParameters(CONTACT.stiffness, np.linspace(0.4, 0.9, LEGS), W)
    whole = solve_frames(feet, contact, WEIGHT, law=FrictionLaw.COULOMB)
    still = Pushes(np.zeros((300, 3)))
    xy, speed = feet.position_m[..., :2], feet.velocity_m_s[..., :2]
    creep = [
        solve_traction_frames(
            SlidingFeet(xy, speed, contact.mu * whole.load_n, W[None]),
            FootLaw(True, rest),
            still,
            0.02,
        )
        for rest in (1e-6, 1e-8)
    ]
    several = whole.sticking.sum(axis=1) > 1
    assert several.sum() > 30
    apart = [np.abs(c.force_xy_B - whole.force_xy_B)[several].max(axis=(1, 2)) for c in creep]
    assert np.median(apart[1]) < 1e-5
    assert (apart[1] < apart[0] + 1e-6).mean() > 0.95
    close = [np.abs(c.velocity_B - whole.velocity_B)[several].max() for c in creep]
    assert close[1] < 1e-6


@pytest.mark.parametrize("flexible", [False, True])
@pytest.mark.parametrize("near", ["a little off", "elsewhere", "unknown", "with gaps"])
def test_an_answer_is_the_same_wherever_its_search_starts(flexible: bool, near: str) -> None:
    give = np.full((1, LEGS, 2), [2e-5, 1e-5]) if flexible else None
    limit = 0.6 * exact(FrictionLaw.VISCOUS).load_n
    feet = SlidingFeet(POSITION[..., :2], SPEED[..., :2], limit, W[None])
    pushes = Pushes(np.tile([3.0, -2.0, 0.4], (FRAMES, 1)), 20.0)
    plain = solve_traction_frames(feet, CREEPING, pushes, 0.02, give)
    off = {"a little off": 1.02, "elsewhere": -30.0}.get(near, 1.0)
    start = near_answers(off * plain.velocity_B, off * plain.force_xy_B)
    if near == "unknown":
        start[:] = np.nan
    if near == "with gaps":
        start[::3] = np.nan
    found = solve_traction_frames(feet, CREEPING, pushes, 0.02, give, near=start)
    assert np.abs(found.velocity_B - plain.velocity_B).max() < 1e-12
    assert np.abs(found.force_xy_B - plain.force_xy_B).max() < 1e-8
    with pytest.raises(ModelError, match="no answers near them"):
        solve_traction_frames(feet, CREEPING, pushes, 0.02, give, near=start[:, :-1])


@pytest.mark.parametrize("static_ratio", [1.0, 1.4])
@pytest.mark.parametrize("flexible", [False, True])
@pytest.mark.parametrize("pushed", [False, True])
def test_every_foot_obeys_its_law(static_ratio: float, flexible: bool, pushed: bool) -> None:
    period, law = 0.02, FootLaw(True, REST_SPEED_M_S, static_ratio, 0.01)
    give = np.full((1, LEGS, 2), [2e-5, 0.0]) if flexible else None
    limit = 0.6 * exact(FrictionLaw.VISCOUS).load_n
    push = Pushes(np.tile([3.0, -2.0, 0.4] if pushed else [0.0, 0.0, 0.0], (FRAMES, 1)), 20.0)
    xy, speed = POSITION[..., :2], SPEED[..., :2]
    found = solve_traction_frames(SlidingFeet(xy, speed, limit, W[None]), law, push, period, give)
    v, force = found.velocity_B[:, None], found.force_xy_B
    across = np.stack([-xy[..., 1], xy[..., 0]], axis=-1)
    slip = v[..., :2] + v[..., 2:] * across + speed
    if give is not None:
        slip = slip + give * np.diff(force, axis=0, prepend=0.0) / period
    down = limit > 0
    assert np.abs(slip - found.slip_B)[down].max() < 1e-10
    size = np.eye(2) + W[:, :, None] * W[:, None, :]
    pulled = np.einsum("kij,fkj->fki", size, slip)
    weaker = 1 + (static_ratio - 1) * np.exp(-(slip**2).sum(axis=2) / law.static_speed**2)
    h = limit * weaker / np.sqrt((pulled**2).sum(axis=2) + law.rest**2)
    wanted = -h[..., None] * np.einsum("kij,fkj->fki", size, pulled)
    assert np.abs(force - wanted).max() < (1e-10 if static_ratio == 1.0 else 1e-5)


def test_the_exact_law_is_for_stiff_feet_alone() -> None:
    for push, give in ((Pushes(np.ones((FRAMES, 3))), None), (None, np.full((1, LEGS, 2), 1e-5))):
        still = Pushes(np.zeros((FRAMES, 3))) if push is None else push
        with pytest.raises(ModelError, match="give a rest speed"):
            solve_traction_frames(
                SlidingFeet(POSITION[..., :2], SPEED[..., :2], np.ones((FRAMES, LEGS)), W[None]),
                FootLaw(True), still, 0.02, give,
            )  # fmt: skip


@pytest.mark.parametrize("law", FrictionLaw, ids=lambda e: e.value)
@pytest.mark.parametrize("static_ratio", [1.0, 1.4])
@pytest.mark.parametrize("flexible", [False, True])
def test_forces_balance_push_and_drag(
    law: FrictionLaw, static_ratio: float, flexible: bool
) -> None:
    give = np.full((1, LEGS, 2), 5e-5) if flexible else None
    foot_law = FootLaw(law is FrictionLaw.COULOMB, REST_SPEED_M_S, static_ratio, 0.01)
    found = ours(foot_law, push=(3.0, -2.0, 0.4), drag=20.0, give=give)
    force, (x, y) = found.force_xy_B, np.moveaxis(POSITION[..., :2], -1, 0)
    assert found.valid.all()
    assert np.allclose(force[..., 0].sum(axis=1), -3.0 + 20 * found.velocity_B[:, 0], atol=1e-5)
    assert np.allclose(force[..., 1].sum(axis=1), 2.0 + 20 * found.velocity_B[:, 1], atol=1e-5)
    assert np.allclose((x * force[..., 1] - y * force[..., 0]).sum(axis=1), -0.4, atol=1e-5)


@pytest.mark.parametrize("law", FrictionLaw, ids=lambda e: e.value)
@pytest.mark.parametrize("flexible", [False, True])
def test_what_forces_leave_over_moves_the_mass(law: FrictionLaw, flexible: bool) -> None:
    mass, about_z, period = 4.0, 0.3, 0.02
    give = np.full((1, LEGS, 2), 5e-5) if flexible else None
    load = exact(FrictionLaw.VISCOUS).load_n
    inertia = Inertia(mass, about_z, np.full(3, np.nan))
    foot_law = FootLaw(law is FrictionLaw.COULOMB, REST_SPEED_M_S)
    pushes = Pushes(np.zeros((FRAMES, 3)), 5.0, 0.1, inertia)
    found = solve_traction_frames(
        SlidingFeet(POSITION[..., :2], SPEED[..., :2], 0.6 * load, W[None]),
        foot_law,
        pushes,
        period,
        give,
    )
    v, (x, y) = found.velocity_B, np.moveaxis(POSITION[..., :2], -1, 0)
    force = found.force_xy_B
    before, turn = v[:-1], v[:-1, 2] * period
    kept_x, kept_y = before[:, 0] + turn * before[:, 1], before[:, 1] - turn * before[:, 0]
    gain_x, gain_y = (v[1:, 0] - kept_x) / period, (v[1:, 1] - kept_y) / period
    spin = (v[1:, 2] - before[:, 2]) / period
    assert np.allclose(force[1:, :, 0].sum(axis=1), mass * gain_x + 5.0 * v[1:, 0], atol=1e-4)
    assert np.allclose(force[1:, :, 1].sum(axis=1), mass * gain_y + 5.0 * v[1:, 1], atol=1e-4)
    moment = (x * force[..., 1] - y * force[..., 0]).sum(axis=1)
    assert np.allclose(moment[1:], about_z * spin + 0.1 * v[1:, 2], atol=1e-4)


def test_a_sliding_mass_slows_by_friction_alone() -> None:
    """Feet at rest in a body that slides at 0.2 m/s: it loses mu g dt each frame."""
    feet = np.tile(np.array([[0.3, 0.0], [-0.15, 0.2], [-0.15, -0.2]]), (20, 1, 1))
    limit = np.full((20, 3), 10.0)
    first = np.array([0.2, 0.0, 0.0])
    law = FootLaw(True, 1e-7)
    walk = Pushes(np.zeros((20, 3)), inertia=Inertia(60.0, 5.0, first))
    found = solve_traction_frames(
        SlidingFeet(feet, np.zeros((20, 3, 2)), limit, np.zeros((1, 3, 2))), law, walk, 0.02
    )
    steps = np.arange(1, 21)
    assert np.allclose(found.velocity_B[:, 0], 0.2 - 30.0 / 60.0 * 0.02 * steps, atol=1e-5)
    apart = Pushes(np.zeros((20, 3)), inertia=Inertia(60.0, 5.0, first, since_s=0.1))
    alone = solve_traction_frames(
        SlidingFeet(feet, np.zeros((20, 3, 2)), limit, np.zeros((1, 3, 2))), law, apart, 0.02
    )
    assert np.allclose(alone.velocity_B[:, 0], 0.2 - 30.0 / 60.0 * 0.1, atol=1e-6)


@pytest.mark.parametrize("law", [VISCOUS, FootLaw(True, 1e-3)])
def test_a_push_moves_a_body_at_rest(law: FootLaw) -> None:
    """Half of what friction holds: either law creeps, on the scale of its rest."""
    feet = np.tile(np.array([[0.3, 0.0], [-0.15, 0.2], [-0.15, -0.2]]), (2, 1, 1))
    still, limit = np.zeros((2, 3, 2)), np.full((2, 3), 10.0)
    push = Pushes(np.tile([15.0, 0.0, 0.0], (2, 1)))
    found = solve_traction_frames(
        SlidingFeet(feet, still, limit, np.zeros((1, 3, 2))), law, push, 0.02
    )
    assert np.allclose(found.force_xy_B, [-5.0, 0.0])
    creep = 1e-3 / np.sqrt(3.0) if law.coulomb else 1e-3
    assert np.allclose(found.velocity_B, [creep, 0.0, 0.0])


def test_a_foot_that_gives_springs_before_it_slides() -> None:
    """Three feet, one alone pulled along x at a steady speed: its force grows by speed / compliance."""
    feet = np.tile(np.array([[0.3, 0.0], [-0.2, 0.2], [-0.2, -0.2]]), (50, 1, 1))
    speed = np.zeros((50, 3, 2))
    speed[:, 0, 0], speed[:, 1:, 0] = -0.002, 0.001  # balanced: feet pull against each other
    limit = np.full((50, 3), 10.0)
    law = FootLaw(True, 1e-7)
    give = np.full((1, 3, 2), 1e-4)
    still = Pushes(np.zeros((50, 3)))
    found = solve_traction_frames(
        SlidingFeet(feet, speed, limit, np.zeros((1, 3, 2))), law, still, 0.02, give
    )
    ahead = found.force_xy_B[:, 0, 0]
    # all stick: relative motion 0.003 m/s stretches one spring in series with two in parallel
    rate = 0.003 / (1e-4 * 1.5)
    assert np.allclose(ahead[:15], rate * 0.02 * np.arange(1, 16), rtol=0.01)
    assert np.isclose(ahead[-1], 10.0, rtol=1e-3)  # then it slides
    assert np.allclose(found.force_xy_B[:, 1:, 0].sum(axis=1), -ahead, atol=1e-6)


def test_frames_without_answer_leave_the_others_alone() -> None:
    whole = ours(CREEPING)
    load = exact(FrictionLaw.VISCOUS).load_n.copy()
    load[100, 1:] = 0.0
    speed = SPEED[..., :2].copy()
    speed[150, 0, 0] = np.nan
    still = Pushes(np.zeros((FRAMES, 3)))
    found = solve_traction_frames(
        SlidingFeet(POSITION[..., :2], speed, 0.6 * load, W[None]), CREEPING, still, 0.02
    )
    assert np.flatnonzero(~found.valid).tolist() == [100, 150]
    assert np.isnan(found.velocity_B[[100, 150]]).all()
    rest = found.valid
    assert np.allclose(found.velocity_B[rest], whole.velocity_B[rest], atol=1e-9)


def test_shapes_that_do_not_fit_are_refused() -> None:
    limit, few = np.ones((FRAMES, LEGS)), Pushes(np.zeros((FRAMES - 1, 3)))
    give = np.zeros((2, LEGS, 2))
    with pytest.raises(ModelError, match="do not fit"):
        solve_traction_frames(SlidingFeet(POSITION[..., :1], SPEED, limit, W[None]), VISCOUS)
    with pytest.raises(ModelError, match="do not fit"):
        solve_traction_frames(SlidingFeet(POSITION, SPEED, limit, W[None][:0]), VISCOUS)
    with pytest.raises(ModelError, match="do not fit"):
        solve_traction_frames(SlidingFeet(POSITION, SPEED, limit, W[None]), VISCOUS, few)
    with pytest.raises(ModelError, match="do not fit"):
        solve_traction_frames(SlidingFeet(POSITION, SPEED, limit, W[None]), VISCOUS, give_m_n=give)


def test_feet_of_one_rigid_motion_slip_under_a_push() -> None:
    """Nothing slips until it is pushed: the ansatz has no forces of its own to begin its scale from."""
    feet = np.array([[[0.0, 0.25], [-0.2, -0.25], [0.2, -0.25]]])
    speed = np.tile([-0.0256, 0.0], (1, 3, 1))
    push = Pushes(np.array([[-3.0, 2.0, 0.0]]))
    w = np.zeros((1, 3, 2))
    found = solve_traction_frames(
        SlidingFeet(feet, speed, np.array([[19.0, 8.0, 11.0]]), w), FootLaw(False, 5e-5), push, 0.02
    )
    assert np.allclose(found.force_xy_B.sum(axis=1), [3.0, -2.0], atol=0.02)
