"""Effects of support, friction, dynamics and external forces against what the physics says by hand."""

from dataclasses import replace

import numpy as np
import pytest

from gap.interfaces import Cause, Drive
from model.effects.grid import make_grid, place
from model.effects.settings import settings_of
from model.effects.shafts import feet
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootMotion
from tests.gap.predictions import COULOMB, ML, Prediction, inside
from tests.gap.walks import cause, command_trial, machine, walk

WEIGHT = machine().size.weight_n
STIFFNESS = machine().contact.stiffness[0]
MU = machine().contact.mu[0]
BOTH = pytest.mark.parametrize("drive", Drive, ids=lambda d: d.value)


def arms(got: Prediction) -> FloatArray:
    """Places of the unloaded feet along x and y: markers, as legs give only along z here."""
    return got.feet[..., :2]


def load_centre(got: Prediction) -> FloatArray:
    """Where the ground's vertical forces act together, (F, 2)."""
    load = got["force_z"][..., None]
    centre: FloatArray = np.sum(load * arms(got), axis=1) / load.sum(axis=1)
    return centre


@BOTH
def test_a_stiffer_leg_carries_more_where_four_share(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    got = Prediction(trial, [cause("leg_stiffness", 1.5, legs=("ML",))], drive)
    base = Prediction(trial, [], drive)
    four = (base["force_z"] > 3).sum(axis=1) == 4
    shared = four & (base["force_z"][:, ML] > 3)
    before = base["force_z"][shared, ML]
    after = got["force_z"][shared, ML]
    assert (after != before).any()
    # of the energy's Hessian: the load moves with the stiffness in the sense of the load
    assert np.mean(after - before) > 0
    assert np.allclose(got["force_z"].sum(axis=1), base["force_z"].sum(axis=1), atol=1e-6)
    squeezed = got["foot_z"][:, ML] - base["foot_z"][:, ML]
    source = (Prediction(trial) if drive is Drive.MEASURED else got)["force_z"][:, ML]
    was = (Prediction(trial) if drive is Drive.MEASURED else base)["force_z"][:, ML] / STIFFNESS
    error = inside(squeezed - (source / (1.5 * STIFFNESS) - was))
    # touchdown of measured loads is averaged to frames before the spring is squeezed
    assert np.median(np.abs(error)) < 1e-6
    assert np.sqrt(np.mean(error**2)) < 0.05 * np.sqrt(np.mean(squeezed**2))


@BOTH
def test_soft_ground_sinks_and_markers_do_not_see_it(drive: Drive) -> None:
    trial = walk("tripod", 0.2, 8.0)
    got = Prediction(trial, [cause("ground_stiffness", 0.5)], drive)
    base = Prediction(trial, [], drive)
    three = ((base["force_z"] > 0).sum(axis=1) == 3) & ((got["force_z"] > 0).sum(axis=1) == 3)
    assert three.sum() > 20
    # three feet: statics alone gives the loads, each foot sinks by F / K more, the body with their plane
    assert np.allclose(got["force_z"][three], base["force_z"][three], atol=0.05)
    plane = np.array([
        np.linalg.solve(
            np.column_stack([np.ones(3), xy[down]]), load[down] / STIFFNESS
        )[0]
        for xy, load in zip(arms(base)[three], base["force_z"][three], strict=True)
        for down in [np.argsort(load)[-3:]]
    ])  # fmt: skip
    assert np.allclose(base["body_z"][three] - got["body_z"][three], plane, atol=3e-5)
    assert np.allclose(got["foot_z"][three], base["foot_z"][three], atol=3e-5)


@BOTH
def test_a_longer_leg_reaches_lower_and_takes_load(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    got = Prediction(trial, [cause("leg_length", 0.003, legs=("ML",))], drive)
    base = Prediction(trial, [], drive)
    free = (base["force_z"][:, ML] == 0) & (got["force_z"][:, ML] == 0)
    assert free.any()
    assert np.allclose((got["foot_z"] - base["foot_z"])[free, ML], -0.003, atol=1e-9)
    carried = (got["force_z"] - base["force_z"])[~free, ML]
    # no more than its own spring squeezed by all of it
    assert 0.5 < carried.max() <= 0.003 * STIFFNESS


def test_a_slope_leans_pulls_and_shifts_the_load() -> None:
    trial = walk("tripod", 0.2, 8.0)
    for law in ([], [COULOMB]):
        got = Prediction(trial, [*law, cause("ground_slope", 0.03, -0.02)])
        base = Prediction(trial, law)
        assert np.allclose(inside(got.force[..., 0].sum(axis=1)), 0.03 * WEIGHT, rtol=0.02)
        assert np.allclose(inside(got.force[..., 1].sum(axis=1)), -0.02 * WEIGHT, rtol=0.03)
        height = base["body_z"].mean()
        shift = inside(load_centre(got) - load_centre(base)).mean(axis=0)
        assert np.allclose(shift, [-0.03 * height, 0.02 * height], rtol=0.05)
        # the lean, but for what the shifted load adds
        assert np.isclose(np.median(got["pitch"] - base["pitch"]), -0.03, atol=0.012)
        assert np.isclose(np.median(got["roll"] - base["roll"]), -0.02, atol=0.012)
        assert inside(got["body_vx"]).mean() < inside(base["body_vx"]).mean()


@BOTH
def test_a_step_lifts_who_stands_on_it(drive: Drive) -> None:
    trial = walk("tripod", 0.2, 6.0)
    base = Prediction(trial, [], drive)
    over = Prediction(trial, [cause("ground_step", 0.006, -1.0)], drive)
    assert np.allclose(over["body_z"] - base["body_z"], 0.006, atol=1e-9)
    assert np.allclose(over["force_z"], base["force_z"], atol=1e-6)
    far = Prediction(trial, [cause("ground_step", 0.006, 3.0)], drive)
    assert np.allclose(far["body_z"], base["body_z"], atol=1e-9)
    at_front = Prediction(trial, [cause("ground_step", 0.006, 0.15)], drive)
    assert at_front["pitch"].mean() < base["pitch"].mean() - 0.003  # nose up


@BOTH
def test_loads_gather_about_the_centre_of_mass(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    got = Prediction(trial, [cause("com_offset", 0.012, -0.008)], drive)
    assert np.allclose(inside(load_centre(got)), [0.012, -0.008], atol=2e-4)
    assert np.allclose(got["force_z"].sum(axis=1), WEIGHT, rtol=1e-6)


@BOTH
def test_a_payload_weighs_where_it_sits(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    got = Prediction(trial, [cause("payload", 1.0, 0.1, -0.05)], drive)
    assert np.allclose(got["force_z"].sum(axis=1), WEIGHT + STANDARD_GRAVITY, rtol=1e-6)
    expected = np.array([0.1, -0.05]) * STANDARD_GRAVITY / (WEIGHT + STANDARD_GRAVITY)
    assert np.allclose(inside(load_centre(got)), expected, atol=2e-4)


@BOTH
def test_a_chassis_that_twists_evens_the_loads(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    got = Prediction(trial, [cause("chassis_twist", 0.01)], drive)
    base = Prediction(trial, [], drive)
    load = got["force_z"][..., None]
    centre = np.sum(load * arms(base), axis=1) / load.sum(axis=1)
    assert np.allclose(centre, load_centre(base), atol=2e-4)

    def twisting(p: Prediction) -> FloatArray:
        shafts = machine().legs.shaft_position
        middle = (shafts[:, 0].max() + shafts[:, 0].min()) / 2
        twist: FloatArray = np.sum(p["force_z"] * shafts[:, 1] * (shafts[:, 0] - middle), axis=1)
        return twist

    more_feet = (base["force_z"] > 3).sum(axis=1) > 3  # with three, statics allows no other loads
    assert np.mean(twisting(got)[more_feet] ** 2) < 0.95 * np.mean(twisting(base)[more_feet] ** 2)


def test_a_tripod_twists_the_ends_of_the_chassis_against_its_middle() -> None:
    """Three feet: statics fix the loads. A row rolls by half of what the whole bar gives for its moment."""
    give = 0.004
    trial = walk("tripod", 0.2, 6.0)
    got = Prediction(trial, [cause("chassis_twist", give)])
    base = Prediction(trial, [])
    legs = list(machine().legs.names)
    left = [legs.index(name) for name in ("FL", "HL", "MR")]
    load = got["force_z"]
    only = (load[:, left] > 3).all(axis=1) & ((load > 1e-6).sum(axis=1) == 3)
    only = np.convolve(only, np.ones(5), "same") > 4.5  # away from where feet change
    assert only.sum() > 20
    y = machine().legs.shaft_position[left[0], 1]
    rolled = give / 2 * load[:, left[0]] * y
    # the marker of the front foot rises with its end of the chassis
    rise = got["foot_z"][:, left[0]] - base["foot_z"][:, left[0]]
    assert np.allclose(rise[only], (rolled * y)[only], rtol=0.03, atol=3e-5)
    # and goes sideways with it, about the shafts' height
    aside = got["foot_y"][:, left[0]] - base["foot_y"][:, left[0]]
    assert np.allclose(
        aside[only], (-base["foot_z"][:, left[0]] * rolled)[only], rtol=0.05, atol=3e-5
    )
    # the middle of the chassis carries the body, which leans to where both its ends gave way
    lean = (got["roll"] - base["roll"])[only]
    ends = give / 2 * y * y * (load[:, left[0]] + load[:, left[1]])[only] / 2
    assert np.allclose(lean, -ends / (2 * y), rtol=0.1, atol=1e-4)


def test_a_slippery_foot_pulls_by_its_share() -> None:
    trial = walk("metachronal", 0.2, 6.0)
    for drive in Drive:
        got = Prediction(trial, [COULOMB, cause("foot_friction", 0.5, legs=("ML",))], drive)
        base = Prediction(trial, [COULOMB], drive)
        load = (base if drive is Drive.COMMAND else Prediction(trial))["force_z"][:, ML]
        pull = np.linalg.norm(got.force[:, ML, :2], axis=1)
        whole = np.linalg.norm(base.force[:, ML, :2], axis=1)
        assert (pull <= 0.5 * MU * load + 0.05).all()
        sliding = (whole > 0.98 * MU * load) & (load > 5)
        assert sliding.sum() > 20
        assert np.isclose(np.median(pull[sliding] / whole[sliding]), 0.5, atol=0.02)


@BOTH
def test_the_level_of_friction_is_blind_in_motion_and_plain_in_forces(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    for law in ([], [COULOMB]):
        got = Prediction(trial, [*law, cause("friction_level", 1.3)], drive)
        base = Prediction(trial, law, drive)
        for name in ("body_vx", "body_vy", "body_wz"):
            assert np.allclose(got[name], base[name], atol=1e-7)
        assert np.allclose(got["force_x"], 1.3 * base["force_x"], atol=1e-4)


def model_frames(law: FrictionLaw, **options: object) -> FloatArray:
    """Velocities of ``model.quasistatic.frames`` for the commands of the metachronal walk, exact foot
    speeds."""
    trial = command_trial("metachronal", 0.2, 6.0)
    rate = np.gradient(trial.command_rad, trial.time_s, axis=0)
    motion: FootMotion = leg_kinematics(machine()).feet(trial.command_rad, rate)
    return solve_frames(motion, machine().contact, WEIGHT, law=law, **options).velocity_B  # type: ignore[arg-type]


@pytest.mark.parametrize("law", FrictionLaw, ids=lambda e: e.value)
def test_laws_anisotropy_and_tilt_are_those_of_the_model(law: FrictionLaw) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    base = [COULOMB] if law is FrictionLaw.COULOMB else []
    w = np.tile([0.0, 1.0], (601, 6, 1))
    cases: tuple[tuple[list[Cause], dict[str, object]], ...] = (
        ([], {}),
        ([cause("friction_anisotropy", 0.0, 1.0)], {"anisotropy_B": w}),
        ([cause("tilt_coupling")], {"tilt_coupling": True}),
    )
    plain = model_frames(law)
    for causes, options in cases:
        ours = Prediction(trial, [*base, *causes])
        theirs = model_frames(law, **options)
        # means over a whole cycle: filters and sway leave them alone
        ahead = ours["body_vx"][12:138].mean()
        assert np.isclose(ahead, theirs[48:552, 0].mean(), atol=6e-5)
        if causes:
            by_us = ours["body_wz"] - Prediction(trial, base)["body_wz"]
            by_model = np.convolve((theirs - plain)[::4, 2], np.ones(7) / 7, "same")
            assert np.corrcoef(inside(by_us, 15), inside(by_model, 15))[0, 1] > 0.8


@BOTH
def test_coulomb_forces_stay_in_the_cone(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    got = Prediction(trial, [COULOMB], drive)
    load = Prediction(trial)["force_z"]
    pull = np.linalg.norm(got.force[..., :2], axis=2)
    # measured loads are averaged to the frames before they press, predicted ones after
    assert (pull <= MU * load + (0.05 if drive is Drive.COMMAND else 0.6)).all()
    slow = Prediction(trial, [], drive)
    assert np.abs(got["body_vx"] - slow["body_vx"]).max() > 5e-3


@BOTH
def test_a_resting_foot_grips_more_with_stiction(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    got = Prediction(trial, [COULOMB, cause("stiction", 1.4, 0.01)], drive)
    load = Prediction(trial)["force_z"]
    pull = np.linalg.norm(got.force[..., :2], axis=2)
    share = (pull / np.maximum(MU * load, 1e-9))[load > 5]
    assert 1.1 < share.max() <= 1.4 + 1e-6
    assert share.max() > 1.05 > np.median(share)


@pytest.mark.parametrize(("hz", "slow_m_s"), [(0.2, 0.005), (0.2, 0.01), (0.1, 0.005)])
def test_feet_with_stiction_grip_by_the_speed_at_which_they_were_seen_to_slide(
    hz: float, slow_m_s: float
) -> None:
    """A walk that was made with it gives its forces back: the body's sway is no slip."""
    stiction = cause("stiction", 1.4, slow_m_s)
    trial = walk("metachronal", hz, 12.0, [COULOMB, stiction])
    made = Prediction(trial, [COULOMB, stiction]).force[..., :2]
    with_it, without = (
        inside(Prediction(trial, causes, Drive.MEASURED).force[..., :2] - made)
        for causes in ([COULOMB, stiction], [COULOMB])
    )
    assert np.sqrt(np.mean(with_it**2)) < 0.25 * np.sqrt(np.mean(without**2))


def test_where_the_pose_was_lost_feet_with_stiction_grip_by_the_speed_that_balances() -> None:
    stiction = cause("stiction", 1.4, 0.005)
    trial = walk("metachronal", 0.2, 12.0, [COULOMB, stiction])
    made = Prediction(trial, [COULOMB, stiction]).force[..., :2]
    lost = trial.body_position_m.copy()
    lost[len(lost) // 2 :] = np.nan
    blind = replace(trial, body_position_m=lost)
    error = inside(Prediction(blind, [COULOMB, stiction], Drive.MEASURED).force[..., :2] - made)
    assert np.sqrt(np.mean(error**2)) < 0.25


@BOTH
def test_a_patch_under_all_feet_is_the_level_of_friction(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0)
    patch = Prediction(trial, [COULOMB, cause("friction_patch", 0.6, -1.0)], drive)
    level = Prediction(trial, [COULOMB, cause("friction_level", 0.6)], drive)
    assert np.allclose(patch["force_x"], level["force_x"], atol=1e-5)
    ahead = Prediction(trial, [COULOMB, cause("friction_patch", 0.6, 0.15)], drive)
    base = Prediction(trial, [COULOMB], drive)
    change = np.abs(ahead["force_x"] - base["force_x"]).max(axis=0)
    assert change.max() > 0.5


def test_a_round_foot_rolls_with_its_link() -> None:
    trial = walk("metachronal", 0.2, 6.0)
    radius = 0.02
    rolling = settings_of([cause("foot_rolling", radius)], machine().names, machine().size)
    grid = make_grid(trial.time_s)
    turn = feet(machine(), grid, place(grid, trial.time_s, trial.command_rad), rolling).turn_rad
    assert 0.25 < np.ptp(turn) < 1.5
    for drive in Drive:
        got = Prediction(trial, [COULOMB, cause("foot_rolling", radius)], drive)
        base = Prediction(trial, [COULOMB], drive)
        moved = inside(got["foot_x"] - base["foot_x"])
        assert np.allclose(moved, inside(radius * np.sin(turn)[::2]), atol=5e-5)
        lifted = inside(got["foot_z"] - base["foot_z"])
        assert np.allclose(lifted, inside(radius * (1 - np.cos(turn))[::2]), atol=2e-5)
        assert np.array_equal(got["force_z"], base["force_z"])
    # viscous feet carry the body by the mean, weighted with load, of radius times turning speed
    load = base["force_z"]
    rate = np.gradient(radius * turn, grid.period_s, axis=0)[::2]
    carried = -np.sum(load * rate, axis=1) / load.sum(axis=1)
    change = (
        Prediction(trial, [cause("foot_rolling", radius)])["body_vx"] - Prediction(trial)["body_vx"]
    )
    assert np.corrcoef(inside(change, 15), inside(carried, 15))[0, 1] > 0.8


@BOTH
def test_feet_hold_what_moves_the_mass(drive: Drive) -> None:
    heavy = cause("inertia_lag", 0.08)
    trial = walk("metachronal", 0.2, 8.0, [COULOMB, heavy])
    got = Prediction(trial, [COULOMB, heavy], drive)
    light = Prediction(trial, [COULOMB], drive)
    mass = 0.08 * MU * WEIGHT / 0.02  # friction brings it to a slip of 20 mm/s in 80 ms
    seen = Prediction(trial, [COULOMB, heavy], Drive.COMMAND)
    change = inside(np.gradient(seen["body_vx"], 0.04) - seen["body_wz"] * seen["body_vy"], 15)
    total = inside(got.force[..., 0].sum(axis=1), 15)
    assert np.isclose(np.polyfit(change, total, 1)[0], mass, rtol=0.2)  # velocities are smoothed
    assert np.corrcoef(change, total)[0, 1] > 0.9
    assert np.abs(inside(light.force[..., 0].sum(axis=1), 15)).max() < 1e-6
    # at the body's height: what speeds it up presses on the feet behind
    shift = inside(load_centre(got)[:, 0] - load_centre(light)[:, 0], 15)
    assert np.corrcoef(change, shift)[0, 1] < -0.4


@pytest.mark.parametrize("gait", ["tripod", "metachronal"])
def test_a_measured_motion_moves_the_mass_as_the_predicted_one_does(gait: str) -> None:
    """Its velocity is smoothed and so is the change of that; the force on the feet was not."""
    heavy = cause("inertia_lag", 0.08)
    trial = walk(gait, 0.2, 10.0, [COULOMB, heavy])
    made = Prediction(trial, [COULOMB, heavy], Drive.COMMAND).force
    told = Prediction(trial, [COULOMB, heavy], Drive.MEASURED).force
    for axis in (0, 1):
        true, found = (inside(one[..., axis].sum(axis=1), 15) for one in (made, told))
        assert np.polyfit(found, true, 1)[0] == pytest.approx(1.0, abs=0.08)
        assert np.corrcoef(found, true)[0, 1] > 0.95


@pytest.mark.parametrize("time_constant_s", [0.35, 0.5])
def test_a_mass_that_loads_overreact_to_is_still_predicted_from_commands(
    time_constant_s: float,
) -> None:
    """Passes that take all of what the last one found grow to 1e200 here: a heavy mass shifts loads."""
    heavy = cause("inertia_lag", time_constant_s)
    trial = walk("tripod", 0.2, 8.0)
    got = Prediction(trial, [heavy], Drive.COMMAND)
    assert np.isfinite(got.force).all()
    assert np.allclose(got.force[..., 2].sum(axis=1), WEIGHT, rtol=1e-6)
    mass = time_constant_s * MU * WEIGHT / 0.02
    change = inside(np.gradient(got["body_vx"], 0.04) - got["body_wz"] * got["body_vy"], 15)
    total = inside(got.force[..., 0].sum(axis=1), 15)
    assert np.isclose(np.polyfit(change, total, 1)[0], mass, rtol=0.2)
    assert np.corrcoef(change, total)[0, 1] > 0.9


@BOTH
def test_a_tether_is_held_by_the_feet_and_shifts_the_load(drive: Drive) -> None:
    trial = walk("tripod", 0.2, 6.0)
    for law in ([], [COULOMB]):
        got = Prediction(trial, [*law, cause("tether_force", -3.0, 2.0)], drive)
        base = Prediction(trial, law, drive)
        total = inside(got.force[..., :2].sum(axis=1))
        assert np.allclose(total, [3.0, -2.0], atol=0.05)
        height = base["body_z"].mean()
        shift = inside(load_centre(got) - load_centre(base)).mean(axis=0)
        assert np.allclose(shift, np.array([-3.0, 2.0]) * height / WEIGHT, rtol=0.1)
        assert inside(got["body_vx"]).mean() < inside(base["body_vx"]).mean()


@BOTH
def test_drag_is_held_by_the_feet(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0, [COULOMB, cause("drag", 60.0)])
    got = Prediction(trial, [COULOMB, cause("drag", 60.0)], drive)
    base = Prediction(trial, [COULOMB], drive)
    total = inside(got.force[..., 0].sum(axis=1), 15)
    # velocities are smoothed
    assert np.isclose(total.mean(), 60.0 * inside(got["body_vx"], 15).mean(), rtol=0.05)
    assert inside(got["body_vx"]).mean() < inside(base["body_vx"]).mean()
