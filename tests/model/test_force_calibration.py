"""In-situ calibration: what was put in comes out, and what the data cannot tell is said."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from model.errors import ModelError
from model.fit.cross_talk import (
    StillPoses,
    balance_residual,
    fit_cross_talk,
    pose_groups,
    shared_directions,
    wrench_maps,
)
from model.fit.in_situ import SHARED, InSituResult, calibrate_in_situ, weak_axes
from model.fit.unloaded import fit_unloaded
from model.values.arrays import FloatArray
from model.values.force_calibration import (
    CalibrationOrigin,
    ForceCalibration,
    bias_only,
    fourier_rows,
)
from tests.model.standing import LEGS, places, sensed, still, true_faults, true_wrenches

NOISE = np.array([0.002, 0.002, 0.004, 1e-4, 1e-4, 1e-4])  # of a mean of a hundred samples

LOAD = np.array([8.0, 8.0, 8.0, 1.0, 1.0, 1.0])  # of a foot [N, N m]


def scaled(correction: FloatArray) -> FloatArray:
    shares: FloatArray = correction * LOAD / LOAD[:, None]
    return shares


def make(
    seed: int, poses: int, noise: float = 1.0
) -> tuple[ForceCalibration, FloatArray, StillPoses]:
    random = np.random.default_rng(seed)
    faults = true_faults(random)
    angle, wrench, in_air, lever = true_wrenches(random, poses)
    read = sensed(faults, angle, wrench, noise * NOISE * random.standard_normal(wrench.shape))
    return faults, wrench, still(angle, read, in_air, lever)


@cache
def calibrated() -> tuple[ForceCalibration, FloatArray, StillPoses, InSituResult]:
    """Faults, true wrenches, poses, and what the calibration makes of these."""
    faults, wrench, poses = make(1, 240)
    return faults, wrench, poses, calibrate_in_situ(poses, places(), LEGS, max_harmonics=3)


def test_the_made_up_poses_balance_the_weight() -> None:
    _, wrench, poses = make(0, 30)
    assert np.abs(balance_residual(wrench, poses, places())).max() < 1e-9


def test_offset_gravity_and_cross_talk_are_recovered() -> None:
    faults, _, _, result = calibrated()
    found = result.calibration
    angle = np.tile(np.linspace(-3, 3, 50)[:, None], (1, 6))
    error = found.unloaded_wrench(angle) - faults.unloaded_wrench(angle)
    assert np.abs(error[..., :3]).max() < 0.02, "N"
    assert np.abs(error[..., 3:]).max() < 1e-3, "N m"
    missed = scaled(found.correction - faults.correction)
    assert np.sqrt((scaled(faults.correction) ** 2).mean()) > 0.028
    assert np.sqrt((missed**2).mean()) < 0.008, "cross-talk, of 0.03"


def test_without_point_feet_only_what_the_balance_tells_is_recovered() -> None:
    faults, _, poses = make(1, 240)
    result = calibrate_in_situ(poses, places(), LEGS, max_harmonics=3, point_feet=False)
    assert SHARED in result.warnings
    missed = scaled(result.calibration.correction - faults.correction).ravel()
    shared = shared_directions(places(), LOAD)
    tellable = missed - shared @ (shared.T @ missed)
    assert np.sqrt((missed**2).mean()) > 0.01
    assert np.sqrt((tellable**2).mean()) < 0.005, "of 0.03"


def test_foot_wrenches_are_nearer_to_the_truth_than_with_offsets_only() -> None:
    _, wrench, poses, result = calibrated()
    offsets = calibrate_in_situ(poses, places(), LEGS, max_harmonics=0, cross_talk=False)
    errors = []
    for calibration in (offsets.calibration, result.calibration):
        found = calibration.foot_wrench(poses.sensed, poses.angle_rad)
        off = (found - wrench)[~poses.in_air]
        errors.append((np.sqrt((off[:, :3] ** 2).mean()), np.sqrt((off[:, 3:] ** 2).mean())))
    assert errors[1][0] < 0.3 * errors[0][0], "force"
    assert errors[1][1] < 0.3 * errors[0][1], "moment"
    assert errors[1][0] < 0.12, "N, of feet that push with some 8 N"


def test_an_error_that_all_sensors_share_leaves_the_balance_alone() -> None:
    """Twice the horizontal forces of all sensors: no balance of a robot at rest can see it."""
    _, wrench, poses = make(0, 30)
    spots = places()
    maps = wrench_maps(spots)
    doubled = np.linalg.inv(maps) @ np.diag([2.0, 2.0, 1, 1, 1, 1]) @ maps
    seen = np.einsum("nij,pnj->pni", doubled, wrench)
    assert np.abs(seen - wrench).max() > 5
    assert np.abs(balance_residual(seen, poses, spots)).max() < 1e-9


def test_residuals_on_left_out_poses_fall_to_the_noise() -> None:
    *_, result = calibrated()
    assert result.held_out >= 50
    for before, gravity, after in zip(result.before, result.stage_one, result.after, strict=True):
        assert before.standing_n > 0.5
        assert after.standing_n < 0.03, "five sensors' noise and what the fit adds, N"
        assert after.standing_nm < 0.01
        assert after.air_n < 0.02
        assert gravity.air_n < before.air_n / 5


def test_perfect_sensors_need_no_correction() -> None:
    random = np.random.default_rng(3)
    angle, wrench, in_air, lever = true_wrenches(random, 120)
    read = wrench + NOISE * random.standard_normal(wrench.shape)
    poses = still(angle, read, in_air, lever)
    result = calibrate_in_situ(poses, places(), LEGS, max_harmonics=3)
    assert result.calibration.harmonics == 0, "noise is not taken for gravity"
    assert np.abs(result.calibration.unloaded[..., 0]).max() < 0.01
    found = scaled(result.calibration.correction)
    assert np.sqrt((found**2).mean()) < 2e-3, "of the load, where cross-talk is 0.03"
    assert np.abs(found).max() < 0.01, "the largest of 216 entries"


def test_a_direction_without_load_is_named_and_stays_at_zero() -> None:
    """Feet that only push up and never turn the sensor: nothing shows how Fx, Fy read."""
    random = np.random.default_rng(4)
    faults, _, poses = make(4, 120)
    _, wrench, in_air, _ = true_wrenches(random, 120)
    wrench[..., :2] = 0.0
    wrench[..., 3:] = 0.0
    read = sensed(faults, poses.angle_rad, wrench, NOISE * random.standard_normal(wrench.shape))
    bare = replace(poses, sensed=read, in_air=in_air)
    result = calibrate_in_situ(bare, places(), LEGS, max_harmonics=1, point_feet=False)
    assert SHARED in result.warnings
    assert result.cross_talk is not None
    told = "\n".join(result.warnings)
    for leg in LEGS:
        assert f"{leg}: the poses do not tell how a load in Fx, Fy" in told
    assert weak_axes(result.cross_talk.resolution)[:, :2].all()


def test_a_leg_that_was_never_lifted_is_named() -> None:
    _, _, poses = make(5, 60)
    in_air = poses.in_air.copy()
    in_air[:, 2] = False
    with pytest.raises(ModelError, match="legs FL never stood still in the air"):
        calibrate_in_situ(replace(poses, in_air=in_air), places(), LEGS, max_harmonics=1)


def test_too_few_poses_are_refused() -> None:
    _, _, poses = make(6, 240)
    few = poses.part(np.arange(240) < 4)
    with pytest.raises(ModelError, match="different standing poses are too few"):
        fit_cross_talk(few.sensed, few, places(), point_feet=False)


def test_one_pose_many_times_is_one_pose() -> None:
    _, _, poses = make(7, 12)
    angle = np.repeat(poses.angle_rad[:1], 9, axis=0) + 2 * np.pi
    groups = pose_groups(np.vstack([poses.angle_rad[:1], angle, poses.angle_rad[1:]]))
    assert groups[:10].tolist() == [0] * 10
    assert groups[10:].tolist() == list(range(1, 12))


# Stage one.


def test_gravity_on_a_full_turn_is_fitted_and_the_order_found() -> None:
    random = np.random.default_rng(8)
    angle = random.uniform(-np.pi, np.pi, 60)
    truth = random.standard_normal((6, 5))
    read = fourier_rows(angle, 2) @ truth.T + 1e-3 * random.standard_normal((60, 6))
    fit = fit_unloaded(angle, read)
    assert fit.harmonics == 2
    assert fit.condition < 3
    assert np.abs(fit.coefficients - truth).max() < 2e-3
    assert fit.residual_rms == pytest.approx(1e-3, rel=0.4)
    assert fit.widest_gap_rad < 1.0


def test_an_arc_says_so() -> None:
    angle = np.linspace(np.pi - 1.2, np.pi + 1.2, 30)
    read = np.random.default_rng(9).standard_normal((30, 6)) * 1e-3
    read += np.cos(angle)[:, None]
    fit = fit_unloaded(angle, read)
    assert fit.widest_gap_rad == pytest.approx(2 * np.pi - 2.4)
    assert fit.gap_centre_rad == pytest.approx(0.0, abs=1e-9)
    assert fit.condition > 5
    assert (fit.standard_error(0.0) > 3 * fit.standard_error(np.pi)).all(), "extrapolation costs"


def test_the_condition_number_is_that_of_the_design() -> None:
    angle = np.linspace(2.0, 4.0, 25)
    read = fourier_rows(angle, 1) @ np.ones((3, 6)) + 1e-4 * np.random.default_rng(1).normal(
        size=(25, 6)
    )
    fit = fit_unloaded(angle, read, max_harmonics=1)
    assert fit.condition == pytest.approx(np.linalg.cond(fourier_rows(angle, 1)))


def test_a_single_sample_has_no_error_estimate() -> None:
    fit = fit_unloaded(np.zeros(1), np.ones((1, 6)))
    assert fit.coefficients[:, 0] == pytest.approx(1.0)
    assert np.isnan(fit.standard_error(0.0)).all()


# The calibration itself.


@given(st.integers(0, 2**32 - 1))
def test_foot_wrench_undoes_the_faults(seed: int) -> None:
    random = np.random.default_rng(seed)
    faults = true_faults(random, harmonics=2)
    angle = random.uniform(-9, 9, (4, 6))
    wrench = random.uniform(-50, 50, (4, 6, 6))
    read = sensed(faults, angle, wrench, np.zeros_like(wrench))
    assert faults.foot_wrench(read, angle) == pytest.approx(wrench, abs=1e-9)


def test_an_unknown_angle_only_hurts_where_gravity_depends_on_it() -> None:
    steady = bias_only(LEGS, CalibrationOrigin(("",) * 6), np.ones((6, 6)), np.zeros((6, 6)))
    nowhere = np.full(6, np.nan)
    assert steady.foot_wrench(np.full((6, 6), 3.0), nowhere) == pytest.approx(2.0)
    unloaded = np.zeros((6, 6, 3))
    unloaded[2, 4, 1] = 0.1
    turning = replace(steady, unloaded=unloaded)
    wrench = turning.foot_wrench(np.ones((6, 6)), nowhere)
    assert np.isnan(wrench[2]).any()
    assert np.isfinite(wrench[[0, 1, 3, 4, 5]]).all()


def test_wrong_shapes_are_refused() -> None:
    with pytest.raises(ModelError, match="needs unloaded"):
        ForceCalibration(LEGS, ("",) * 6, np.zeros((6, 6, 2)), np.zeros((6, 6, 6)),
                         np.zeros((6, 6)), "bias", "", ())  # fmt: skip


@pytest.mark.parametrize("up", [None, (1, -1, 1, -1, -1, 1)])
def test_wrench_maps_keep_power(up: tuple[int, ...] | None) -> None:
    """A wrench and the motion of its point: the same power in either frame (virtual work)."""
    random = np.random.default_rng(10)
    spots = replace(places(), up=None if up is None else np.array(up))
    maps = wrench_maps(spots)
    for leg in range(6):
        wrench, twist = random.standard_normal(6), random.standard_normal(6)
        yaw = spots.yaw_rad[leg]
        turn = np.array(
            [[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1.0]]
        )
        if up is not None:  # half a turn about the sensor's own x axis
            turn = turn @ np.diag([1, up[leg], up[leg]])
        speed = twist[:3] + np.cross(twist[3:], spots.origin_B[leg])
        at_sensor = wrench[:3] @ (turn.T @ speed) + wrench[3:] @ (turn.T @ twist[3:])
        assert maps[leg] @ wrench @ twist == pytest.approx(at_sensor)
