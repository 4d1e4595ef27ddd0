"""The virtual IMU: what it makes of a known motion, and that it only watches the plant."""

from dataclasses import replace
from math import isnan

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from model.values.arrays import FloatArray
from model.values.readings import ImuRecord
from robot.config.robot_file import load_robot
from robot.virtual.open import VirtualSettings, open_twin
from sim_hw.assumed import ImuAssumed
from sim_hw.host.world import World
from sim_hw.twin.imu import VirtualImu

QUIET = ImuAssumed(yaw_rate_bias_rad_s=0.0, yaw_rate_noise_rad_s=0.0, tilt_noise_rad=0.0)
PERIOD_NS = 10_000_000


def readings(
    assumed: ImuAssumed, angles: FloatArray, seed: int = 0, period_ns: int = PERIOD_NS
) -> tuple[ImuRecord, ...]:
    """What it reports of yaw, pitch, roll at each period, (T, 3)."""
    imu = VirtualImu(assumed, seed)
    turns = Rotation.from_euler("ZYX", angles).as_quat()
    for k, turn in enumerate(turns):
        assert k * period_ns >= imu.due_ns
        imu.sample(k * period_ns, turn)
    return imu.arrived(len(angles) * period_ns)


def test_a_known_motion_is_reported_as_it_is() -> None:
    t = 0.01 * np.arange(300)
    yaw = 0.4 * np.sin(2 * t) + 3.0  # across half a turn
    level = readings(QUIET, np.column_stack([yaw, 0 * t, 0 * t]))
    assert [one.t_ns for one in level] == [PERIOD_NS * k for k in range(1, 300)]
    rates = np.array([one.yaw_rate_rad_s for one in level])
    np.testing.assert_allclose(3.0 + 0.01 * np.cumsum(rates), yaw[1:], atol=1e-6)
    tilted = readings(QUIET, np.column_stack([yaw, 0.05 * np.cos(t), 0.1 * np.sin(t)]))
    np.testing.assert_allclose([one.pitch_rad for one in tilted], 0.05 * np.cos(t[1:]), atol=1e-6)
    np.testing.assert_allclose([one.roll_rad for one in tilted], 0.1 * np.sin(t[1:]), atol=1e-6)
    # the body's own z axis, not the world's: scipy's body rates are the oracle
    turns = Rotation.from_euler("ZYX", np.column_stack([yaw, 0.05 * np.cos(t), 0.1 * np.sin(t)]))
    body = (turns[:-1].inv() * turns[1:]).as_rotvec()[:, 2] / 0.01
    np.testing.assert_allclose([one.yaw_rate_rad_s for one in tilted], body, atol=1e-5)


def test_bias_noise_and_mounting_are_those_asked_for() -> None:
    assumed = ImuAssumed(
        yaw_rate_bias_rad_s=-0.02, yaw_rate_noise_rad_s=0.003, roll_error_rad=0.01,
        pitch_error_rad=-0.02, tilt_noise_rad=0.002,
    )  # fmt: skip
    seen = readings(assumed, np.zeros((20_001, 3)))
    table = np.array([(one.yaw_rate_rad_s, one.roll_rad, one.pitch_rad) for one in seen])
    np.testing.assert_allclose(table.mean(axis=0), [-0.02, 0.01, -0.02], atol=1e-4)
    np.testing.assert_allclose(table.std(axis=0), [0.003, 0.002, 0.002], rtol=0.03)
    assert readings(assumed, np.zeros((50, 3))) == seen[:49], "the same seed gives the same"
    assert readings(assumed, np.zeros((50, 3)), seed=1) != seen[:49]


def test_the_bias_walks_by_the_square_root_of_time() -> None:
    assumed = replace(QUIET, yaw_rate_walk=0.01)
    ends = []
    for seed in range(300):
        imu = VirtualImu(assumed, seed)
        for k in range(101):
            imu.sample(k * PERIOD_NS, np.array([0.0, 0.0, 0.0, 1.0]))
        ends.append(imu.yaw_rate_bias_rad_s)
    assert np.std(ends) == pytest.approx(0.01, rel=0.15), "after a second"


def test_what_is_late_arrives_later_with_its_own_stamp() -> None:
    late = VirtualImu(replace(QUIET, delay_s=0.025, tilt=False), 0)
    for k in range(5):
        late.sample(k * PERIOD_NS, np.array([0.0, 0.0, 0.0, 1.0]))
    assert late.arrived(34_999_999) == ()
    (first,) = late.arrived(35_000_000)
    assert first.t_ns == PERIOD_NS
    assert isnan(first.roll_rad), "a gyro alone has no angles"
    assert [one.t_ns for one in late.arrived(65_000_000)] == [
        2 * PERIOD_NS,
        3 * PERIOD_NS,
        4 * PERIOD_NS,
    ]


def test_it_watches_the_plant_at_its_own_rate_and_changes_nothing() -> None:
    config = load_robot()
    truths, counts = [], []
    for imu in (None, ImuAssumed(rate_hz=50.0)):
        rig, robot = open_twin(config, None, VirtualSettings(seed=2, imu=imu), cameras=False)
        assert isinstance(robot.world, World)
        begin_ns = rig.clock.now_ns()
        if robot.imu is not None:
            robot.imu.imu.arrived(begin_ns)
        robot.world.advance_to(begin_ns + 1_000_000_000)
        truths.append(robot.world.truth(begin_ns + 1_000_000_000))
        seen = robot.imu.imu.arrived(begin_ns + 1_000_000_000) if robot.imu is not None else ()
        counts.append(len(seen))
        step_ns = round(robot.world.plant.dt_s * 1e9)
        assert all(one.t_ns % 20_000_000 < step_ns for one in seen)
        rig.close()
    assert counts[0] == 0
    assert 49 <= counts[1] <= 51
    assert truths[0] is not None
    assert truths[1] is not None
    np.testing.assert_array_equal(truths[0].pose, truths[1].pose)
