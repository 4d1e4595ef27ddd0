"""The estimator inside the step: settings, poses from outside, what a replay makes of it."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from model.errors import ConfigError
from model.kinematics.legs import leg_kinematics
from model.motion.se2 import aligning, compose
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import FloatArray, readonly
from model.values.estimate import Estimate, Health
from model.values.faults import StopReason
from model.values.readings import PoseRecord
from model.values.tick import Intent, Tick
from robot.config.robot_file import load_robot, parse_robot
from robot.control.controller import Controller
from robot.control.estimator_stage import estimator_stage, planar
from robot.run.loop import run
from robot.virtual.open import VirtualSettings, open_in_memory
from tests.robot.runs import Kept, Told, wish

TEXT = load_robot().text


def pose(t_ns: int, at: FloatArray, sd_m: float = 0.002) -> PoseRecord:
    half = at[2] / 2
    quaternion = np.array([0.0, 0.0, np.sin(half), np.cos(half)])
    return PoseRecord(t_ns, np.array([at[0], at[1], 0.1]), quaternion, sd_m, 0.005)


@pytest.fixture(scope="module")
def walked(usual_pace: None) -> list[Tick]:
    """Two seconds of the virtual robot getting up, with forces."""
    config = load_robot()
    rig = open_in_memory(config, VirtualSettings(seed=1))
    controller = Controller(config, rig.calibrations, armed=True)
    kept = Kept()
    operator = Told(
        lambda t, _: (
            wish(Intent.WALK, "tripod", 0.25)
            if t < 2.5
            else wish(Intent.CUT, reason=StopReason.EMERGENCY)
        )
    )
    run(rig, controller, operator, kept, None)
    return kept.ticks


def again(ticks: list[Tick], poses: Mapping[int, tuple[PoseRecord, ...]]) -> list[Tick]:
    """The same inputs once more, with poses heard in some ticks."""
    controller = Controller(load_robot(), (None,) * 6, armed=True)
    state, found = controller.initial(), []
    for tick in ticks:
        inputs = replace(tick.inputs, poses=poses.get(tick.index, ()))
        state, new = controller.step(state, inputs, tick.t_ns)
        found.append(new)
    return found


def test_it_runs_by_default_and_says_everything(walked: list[Tick]) -> None:
    said = walked[-1].estimate
    assert said is not None
    assert said.t_ns == walked[-1].t_ns
    assert said.force_covariance.shape == (6, 3, 3)
    assert (np.diagonal(said.pose_covariance) > 0).all()
    assert said.health in set(Health)


def test_it_can_be_switched_off_and_set(walked: list[Tick]) -> None:
    config = parse_robot(TEXT + '\n[estimator]\nenabled = false\nlaw = "viscous"\nlag_s = 0.01\n')
    assert config.estimator.settings.law is FrictionLaw.VISCOUS
    assert config.estimator.settings.lag_s == 0.01
    controller = Controller(config, (None,) * 6, armed=False)
    _, tick = controller.step(controller.initial(), walked[0].inputs, walked[0].t_ns)
    assert tick.estimate is None


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("leg_s = 1.0", "did you mean 'lag_s'"),
        ('law = "wet"', "viscous, coulomb"),
        ("force_sd = 0.0", "must be above 0"),
        ("memory = 2.0", "memory"),
        ("load_off = 0.5", "must not be above load_on"),
    ],
)
def test_a_wrong_setting_is_refused(lines: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        parse_robot(f"{TEXT}\n[estimator]\n{lines}\n")


def test_frames_undo_each_other() -> None:
    ours, seen = np.array([0.3, -0.2, 0.7]), np.array([5.0, 2.0, -2.0])
    frame = aligning(ours, seen)
    np.testing.assert_allclose(compose(frame, seen), ours, atol=1e-14)
    np.testing.assert_allclose(planar(pose(0, seen)), seen, atol=1e-14)


def test_the_first_pose_sets_the_frame_and_later_ones_count(walked: list[Tick]) -> None:
    there = np.array([5.0, 2.0, 1.2])
    last = len(walked) - 1
    aside = compose(there, np.array([0.02, 0.0, 0.0]))  # ahead of the first
    heard = {10: (pose(walked[10].t_ns, there),)}
    first = again(walked, heard)
    plain = again(walked, {})
    at = first[10].estimate, plain[10].estimate
    assert at[0] is not None
    assert at[1] is not None
    np.testing.assert_allclose(at[0].position_m, at[1].position_m, atol=1e-9)  # no jump
    for i in range(last - 30, last + 1):
        heard[i] = (pose(walked[i].t_ns, aside),)
    both = again(walked, heard)[-1].estimate
    assert both is not None
    before = plain[10].estimate
    assert before is not None
    moved = both.position_m - before.position_m
    np.testing.assert_allclose(moved, [0.02, 0.0], atol=2e-3)
    assert both.pose_covariance[0, 0] < 0.002**2


def test_a_late_pose_counts_as_if_it_had_come_in_time(walked: list[Tick]) -> None:
    start = {10: (pose(walked[10].t_ns, np.zeros(3)),)}
    seen = pose(walked[200].t_ns, np.array([0.004, 0.001, 0.01]))
    intime = again(walked, {**start, 200: (seen,)})
    late = again(walked, {**start, 208: (seen,)})
    lost = again(walked, {**start, 230: (seen,)})  # 0.3 s is more than is remembered
    plain = again(walked, start)

    def said(ticks: list[Tick], i: int) -> FloatArray:
        estimate = ticks[i].estimate
        assert estimate is not None
        return np.array([*estimate.position_m, estimate.yaw_rad, *estimate.pose_covariance.flat])

    assert not np.array_equal(said(intime, 200), said(plain, 200))
    np.testing.assert_array_equal(said(late, 207), said(plain, 207))
    np.testing.assert_array_equal(said(late, 208), said(intime, 208))
    np.testing.assert_array_equal(said(late, -1), said(intime, -1))
    np.testing.assert_array_equal(said(lost, -1), said(plain, -1))


def test_a_place_without_a_heading_waits_for_one(walked: list[Tick]) -> None:
    blind = replace(pose(walked[5].t_ns, np.zeros(3)), quaternion_xyzw=np.full(4, np.nan))
    alone, plain = again(walked, {5: (blind,)})[-1].estimate, again(walked, {})[-1].estimate
    assert alone is not None
    assert plain is not None
    np.testing.assert_array_equal(alone.position_m, plain.position_m)


def test_effects_of_the_robot_file_are_in_it(walked: list[Tick]) -> None:
    """A bias that the file tells of is taken out: what is left is the estimate of sound sensors."""
    bias = np.zeros((6, 3))
    bias[1] = [3.0, -2.0, 4.0]
    told = TEXT + "\n[effects.force_bias.ML]\nx_n = 3.0\ny_n = -2.0\nz_n = 4.0\n"

    def estimates(text: str, added: FloatArray) -> list[Estimate]:
        config = parse_robot(text)
        robot = config.parameters
        stage = estimator_stage(config, leg_kinematics(robot))
        memory, found = stage.initial(), []
        for tick in walked:
            forces = replace(tick.forces, force_n=readonly(tick.forces.force_n + added))
            memory, new = stage.step(memory, tick.t_ns, tick.joints, forces, ())
            found.append(new)
        return found

    sound, corrected = estimates(TEXT, 0 * bias), estimates(told, bias)
    uncorrected = estimates(TEXT, bias)
    learned = [[[*e.mu, *e.stiffness] for e in run] for run in (sound, corrected, uncorrected)]
    ratio = np.log(np.array(learned))
    assert np.abs(ratio[2] - ratio[0]).max() > 0.02, "the bias matters"
    assert np.abs(ratio[1] - ratio[0]).max() < 1e-3
    speed = np.array([[e.velocity_B for e in run] for run in (sound, corrected)])
    assert np.abs(speed[1] - speed[0]).max() < 1e-3  # two solvers of one law, at rest
