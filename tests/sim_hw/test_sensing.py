"""Sensors that err: forces, encoders and cameras, against what they should report."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from robot.config.robot_file import load_robot
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.host.world import World
from sim_hw.plant.plant import Plant
from sim_hw.twin.motion_capture import MotionCapture, Poses
from sim_hw.twin.sensing import ForceChannel
from tests.sim_hw.twins import WEIGHT, twin

CONFIG = load_robot()
MS = 1_000_000


def world(*texts: str) -> World:
    wrong = twin(*texts)
    return World(
        Plant(wrong.plant), FirmwareBank(6), CONFIG.servo_bus, CONFIG.force_sensor, wrong.sensors
    )


def standing(*texts: str) -> np.ndarray:
    robot = world(*texts)
    robot.advance_to(0)
    return robot.wrench(100 * MS)


def test_gain_bias_and_drift_are_on_top_of_the_truth() -> None:
    plain = standing()
    assert plain[:, 2].sum() == pytest.approx(WEIGHT, rel=0.01)
    assert standing("force_gain@ML:ratio=1.3")[1] == pytest.approx(1.3 * plain[1])
    biased = standing("force_bias@ML:x_n=1,y_n=0.5,z_n=-2")
    assert (biased - plain)[1, :3] == pytest.approx([1.0, 0.5, -2.0])
    leaking = standing("force_cross_talk@ML:x_share=0.1,y_share=-0.05")
    load_n = plain[1, 2]
    assert (leaking - plain)[1, :3] == pytest.approx([0.1 * load_n, -0.05 * load_n, 0.0])
    robot = world("force_drift@ML:n_per_s=0.5")
    robot.advance_to(0)
    first, later = robot.wrench(100 * MS), robot.wrench(1100 * MS)
    assert (later - first)[1, 2] == pytest.approx(0.5, abs=0.02)


def test_a_turned_transducer_reports_turned_axes() -> None:
    robot = world("force_rotation@ML:yaw_rad=0.3", "tether_force:x_n=8")
    robot.plant.push(np.array([0.0, 5.0, 0.0]), np.zeros(3))
    robot.advance_to(0)
    robot.advance_to(400 * MS)
    sensed = robot.wrench(410 * MS)[1, :2]
    true = robot.plant.foot_force_B[1, :2]
    c, s = np.cos(0.3), np.sin(0.3)
    assert sensed == pytest.approx([c * true[0] + s * true[1], c * true[1] - s * true[0]], abs=0.05)


def test_a_late_stream_reports_what_was() -> None:
    plain, late = world(), world("force_delay:delay_s=0.05")
    reports = []
    for robot in (plain, late):
        robot.advance_to(0)
        seen = []
        for tick in range(1, 40):
            if tick == 10:
                robot.plant.push(np.array([0.0, 0.0, -20.0]), np.zeros(3))
            seen.append(robot.wrench(tick * 10 * MS)[:, 2].sum())
        reports.append(np.array(seen))
    assert reports[1][8:] == pytest.approx(reports[0][3:-5], abs=1e-6)
    assert np.abs(reports[1] - reports[0]).max() > 5


def test_a_low_pass_is_two_thirds_there_after_its_time_constant() -> None:
    channel = ForceChannel(twin("force_lowpass:time_constant_s=0.1").sensors)
    channel.report(np.zeros((6, 6)), 0)
    for tick in range(1, 11):
        reading = channel.report(np.ones((6, 6)), tick * 10 * MS)
    assert reading == pytest.approx(np.full((6, 6), 1 - np.exp(-1)))


def test_an_encoder_scale_is_reported_and_not_followed() -> None:
    robot = world("encoder_scale@ML:ratio=1.01")
    robot.plant.leg_state[:, 2] = robot.plant.leg_state[:, 0] = 1.0
    turned = (robot.motors().ticks - CONFIG.servo_bus.zeros) * CONFIG.servo_bus.signs
    assert turned[1] / turned[0] == pytest.approx(1.01)
    assert robot.plant.motor_angle_rad[1] == 1.0


def turning(count: int = 400) -> Poses:
    """A body that goes ahead and turns, feet with it."""
    t_ns = np.arange(count) * 10 * MS
    yaw = 0.2 * np.sin(t_ns * 1e-9)
    position = np.stack([0.05 * t_ns * 1e-9, 0 * yaw, np.full(count, 0.12)], axis=1)
    turn = Rotation.from_euler("z", yaw[:, None])
    feet_b = np.arange(18).reshape(6, 3) * 0.01
    feet = position[:, None] + np.einsum("tij,nj->tni", turn.as_matrix(), feet_b)
    return Poses(t_ns, position, turn.as_quat(), feet)


def quiet(*texts: str) -> MotionCapture:
    from dataclasses import replace

    from record.trial.header import TrialNoise

    sensors = replace(twin(*texts).sensors, noise=TrialNoise(0.0, 0.0, 0.0, 0.0, 0.0))
    return MotionCapture(sensors, seed=0)


def test_cameras_that_are_right_see_what_is() -> None:
    truth = turning()
    seen = quiet().see_all(truth)
    assert seen.position_W == pytest.approx(truth.position_W)
    assert seen.foot_position_W == pytest.approx(truth.foot_position_W)


def test_the_marker_frame_is_turned_and_moved_in_the_body() -> None:
    truth = turning()
    turned = quiet("pose_yaw_offset:yaw_rad=0.05").see_all(truth)
    yaw = Rotation.from_quat(turned.quaternion_xyzw).as_euler("ZYX")[:, 0]
    assert yaw == pytest.approx(0.2 * np.sin(truth.t_ns * 1e-9) + 0.05, abs=1e-9)
    moved = quiet("pose_origin_offset:x_m=0.03,y_m=0.01").see_all(truth)
    arm = Rotation.from_quat(truth.quaternion_xyzw).inv().apply(moved.position_W - truth.position_W)
    assert arm == pytest.approx(np.tile([0.03, 0.01, 0.0], (400, 1)), abs=1e-12)
    assert moved.foot_position_W == pytest.approx(truth.foot_position_W), "feet are where they are"


def test_late_poses_and_a_fast_clock() -> None:
    truth = turning()
    late = quiet("pose_delay:delay_s=0.055").see_all(truth)
    assert late.position_W[100, 0] == pytest.approx(0.05 * (1.0 - 0.055), abs=1e-9)
    skewed = quiet("clock_skew:ratio=1.01").see_all(truth)
    assert skewed.position_W[300, 0] == pytest.approx(0.05 * 3.0 / 1.01, abs=1e-9)
    assert skewed.foot_position_W[300, 0, 0] < truth.foot_position_W[300, 0, 0]
    # right when the record begins, not when the cameras were switched on: else it would be late as well
    later = quiet("clock_skew:ratio=1.01").see_all(truth, int(truth.t_ns[100]))
    assert later.position_W[100, 0] == pytest.approx(truth.position_W[100, 0], abs=1e-12)
    assert later.position_W[300, 0] == pytest.approx(0.05 * (1.0 + 2.0 / 1.01), abs=1e-9)


def test_swapped_markers() -> None:
    truth = turning()
    seen = quiet("marker_swap@ML").see_all(truth)
    assert seen.foot_position_W[:, 1] == pytest.approx(truth.foot_position_W[:, 2])
    assert seen.foot_position_W[:, 2] == pytest.approx(truth.foot_position_W[:, 1])


@pytest.mark.parametrize("text", ["", "pose_delay:delay_s=0.055", "clock_skew:ratio=1.01"])
def test_sample_by_sample_is_all_at_once(text: str) -> None:
    truth, wrong = turning(60), twin(*([text] if text else []))
    plant = Plant(wrong.plant)
    one_by_one = MotionCapture(wrong.sensors, seed=3)
    whole = MotionCapture(wrong.sensors, seed=3).see_all(truth)
    from dataclasses import replace

    for at in range(60):
        one = replace(
            plant.truth(int(truth.t_ns[at])),
            position_W=truth.position_W[at],
            quaternion_xyzw=truth.quaternion_xyzw[at],
            foot_position_W=truth.foot_position_W[at],
        )
        seen = one_by_one.see(one)
        assert seen.position_W == pytest.approx(whole.position_W[at], abs=1e-12)
        assert seen.foot_position_W == pytest.approx(whole.foot_position_W[at], abs=1e-12)
        assert seen.quaternion_xyzw == pytest.approx(whole.quaternion_xyzw[at], abs=1e-12)
