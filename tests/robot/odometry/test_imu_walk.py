"""A walk of the virtual robot with its IMU: bias known, yaw and stiffness better, a wrong sign noticed."""

from dataclasses import replace
from math import nan

import numpy as np
import pytest

from drivers.ati.foot_forces import no_forces
from model.estimator.settings import EstimatorSettings
from model.motion.se2 import yaw_of
from model.values.arrays import FloatArray
from model.values.estimate import Estimate, Health
from model.values.readings import ImuRecord
from model.values.tick import Intent, Mode, Tick
from record.log.reader import StampedTick
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.control.controller import Controller
from robot.control.tick_estimator import TickEstimator
from robot.odometry.track import Tracker
from robot.odometry.tune import TuningWalk, tuned_names, whiteness
from robot.run.operator import Script
from robot.run.rig import Reading
from robot.virtual.direct_robot import DirectRobot
from robot.virtual.open import VirtualSettings, open_twin
from robot.virtual.rehearsal import rehearse
from robot.virtual.walk import TickList
from sim_hw.assumed import ImuAssumed

CONFIG = load_robot()
RATE_HZ = 50
BIAS_RAD_S = 0.02
TRUE_STIFFNESS = np.array([2000.0, 3000.0, 2300.0, 2900.0, 2200.0, 2700.0])
ASKEW = ImuAssumed(
    yaw_rate_bias_rad_s=BIAS_RAD_S, yaw_rate_walk=0.00002, roll_error_rad=0.02, pitch_error_rad=-0.015
)  # fmt: skip


class WithTruth(DirectRobot):
    """Ground truth beside what the robot reads."""

    def read(self) -> Reading:
        return replace(super().read(), truth=self.world.truth(self.clock.now_ns()))


def plant() -> RobotConfig:
    """The robot that is there: other legs than the robot file says, and more grip on its left."""
    text = CONFIG.text
    for key, before, values in (
        ("stiffness", "2500.0", TRUE_STIFFNESS),
        ("mu", "0.6", np.repeat([0.75, 0.45], 3)),
    ):
        row = f"{key} = [{', '.join([before] * 6)}]"
        assert text.count(row) == 1
        text = text.replace(row, f"{key} = {values.tolist()}")
    return parse_robot(text)


@pytest.fixture(scope="module")
def walked() -> list[Tick]:
    """It stands up, walks a cycle, and stands still."""
    there = plant()
    settings = VirtualSettings(seed=5, imu=ASKEW)
    rig, robot = open_twin(there, None, settings, cameras=False)
    controller = Controller(there, rig.calibrations, armed=True, rate_hz=RATE_HZ, estimate=False)
    kept = TickList()
    script = Script("metachronal", 0.2, cycles=1.0, end=Intent.STOP)
    rehearse(WithTruth(there, rig, robot), controller, script, lambda _: None, kept)
    rig.close()
    return kept.ticks


def estimates_of(ticks: list[Tick], forces: bool, tilt: bool, sign: float | None) -> list[Estimate]:
    """What the estimator of the robot file makes of them; a ``sign`` of None leaves the IMU out."""
    estimator, estimates = TickEstimator(CONFIG), []
    for tick in ticks:
        imu: tuple[ImuRecord, ...] = ()
        if sign is not None:
            imu = tuple(
                ImuRecord(
                    one.t_ns,
                    sign * one.yaw_rate_rad_s,
                    one.roll_rad if tilt else nan,
                    one.pitch_rad if tilt else nan,
                )
                for one in tick.inputs.imu
            )
        seen = replace(tick, inputs=replace(tick.inputs, imu=imu))
        estimates.append(
            estimator.step(seen.sensed if forces else replace(seen.sensed, forces=no_forces(6)))
        )
    return estimates


class Estimated:
    """What the estimator makes of the walk; several tests ask for the same."""

    def __init__(self, ticks: list[Tick]) -> None:
        self._ticks = ticks
        self._kept: dict[tuple[bool, bool, float | None], list[Estimate]] = {}

    def __call__(
        self, *, forces: bool, tilt: bool = True, sign: float | None = 1.0
    ) -> list[Estimate]:
        key = forces, tilt, sign
        if key not in self._kept:
            self._kept[key] = estimates_of(self._ticks, *key)
        return self._kept[key]


@pytest.fixture(scope="module")
def estimated(walked: list[Tick]) -> Estimated:
    return Estimated(walked)


def yaw_rate_rmse(walked: list[Tick], estimates: list[Estimate]) -> float:
    """Root mean square error of the yaw rate [rad/s] while it walks."""
    errors = [
        estimate.velocity_B[2] - tick.inputs.truth.planar_velocity_B[2]
        for tick, estimate in zip(walked, estimates, strict=True)
        if tick.mode is Mode.WALK and tick.inputs.truth is not None
    ]
    return float(np.sqrt(np.mean(np.square(errors))))


def yaw_errors(ticks: list[Tick], estimates: list[Estimate]) -> FloatArray:
    """Estimated less true change of yaw while walking [rad]."""
    rows = [k for k, tick in enumerate(ticks) if tick.mode is Mode.WALK]
    truths = [truth for k in rows if (truth := ticks[k].inputs.truth) is not None]
    true = np.unwrap([yaw_of(truth.quaternion_xyzw) for truth in truths])
    yaw = np.array([estimates[k].yaw_rad for k in rows])
    errors: FloatArray = (yaw - yaw[0]) - (true - true[0])
    return errors


def stiffness_errors(estimate: Estimate) -> FloatArray:
    """Of log K without what is common to all legs, which tilts nothing, (6,)."""
    errors: FloatArray = np.log(estimate.stiffness / TRUE_STIFFNESS)
    errors -= errors.mean()
    return errors


def test_the_bias_of_the_gyro_is_recovered(walked: list[Tick], estimated: Estimated) -> None:
    estimates = estimated(forces=True)
    last = estimates[-1]
    assert abs(last.gyro_bias_rad_s - BIAS_RAD_S) < 3 * last.gyro_bias_sd < 0.003
    # known before the first step: the robot stood still until then
    first = next(k for k, tick in enumerate(walked) if tick.mode is Mode.WALK)
    assert abs(estimates[first].gyro_bias_rad_s - BIAS_RAD_S) < 3 * estimates[first].gyro_bias_sd
    assert np.abs(yaw_errors(walked, estimates)).max() < 0.01


@pytest.mark.parametrize("forces", [True, False])
def test_a_gyro_makes_the_yaw_rate_better(
    walked: list[Tick], estimated: Estimated, forces: bool
) -> None:
    alone = yaw_rate_rmse(walked, estimated(forces=forces, sign=None))
    helped = yaw_rate_rmse(walked, estimated(forces=forces, tilt=False))
    assert helped < 0.9 * alone


def test_without_forces_roll_and_pitch_tell_the_stiffness_of_the_legs(estimated: Estimated) -> None:
    """The IMU is mounted one degree askew, and no sensor feels the ground."""
    before = np.abs(stiffness_errors(estimated(forces=False, sign=None)[-1])).max()
    after = np.abs(stiffness_errors(estimated(forces=False)[-1])).max()
    assert before > 0.15
    assert after < 0.5 * before


def test_with_forces_an_imu_mounted_askew_does_no_harm(estimated: Estimated) -> None:
    plain, helped = estimated(forces=True, sign=None), estimated(forces=True)
    both = [np.abs(stiffness_errors(each[-1])).max() for each in (plain, helped)]
    assert both[1] < both[0] + 0.03  # roll and pitch of a model in which bodies do not swing
    assert all(estimate.health is Health.OK for estimate in helped[RATE_HZ:])


def test_a_gyro_of_the_wrong_sign_is_noticed(estimated: Estimated) -> None:
    sound, wrong = (estimated(forces=True, tilt=False, sign=sign) for sign in (1.0, -1.0))
    assert wrong[-1].rejects > sound[-1].rejects + 20
    assert any("gyro contradicts the feet" in estimate.reason for estimate in wrong)
    assert not any("gyro contradicts the feet" in estimate.reason for estimate in sound)


def test_an_imu_can_be_left_out_and_its_noise_is_tuned(
    walked: list[Tick], estimated: Estimated
) -> None:
    tracker, plain = Tracker(CONFIG, no_imu=True), estimated(forces=True, sign=None)
    assert [tracker.step(tick.sensed).pose.tolist() for tick in walked] == [
        e.pose.tolist() for e in plain
    ]
    walking = [tick for tick in walked if tick.mode is Mode.WALK][:100]
    items = tuple(StampedTick(tick.t_ns, tick) for tick in walking)
    blind = tuple(
        StampedTick(tick.t_ns, replace(tick, inputs=replace(tick.inputs, imu=())))
        for tick in walking
    )
    with_imu, without = TuningWalk(items, CONFIG), TuningWalk(blind, CONFIG)
    assert tuned_names([with_imu])[-2:] == ("gyro_sd", "tilt_sd")
    assert tuned_names([without]) == tuned_names([with_imu])[:-2]
    found = [whiteness([walk], EstimatorSettings()) for walk in (with_imu, without)]
    # an IMU between the forces does not hide that their innovations follow each other
    np.testing.assert_allclose(found[0].lag_one, found[1].lag_one, atol=0.2)
    assert np.isfinite(found[0].lag_one).all()
