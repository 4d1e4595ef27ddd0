"""The estimator next to simpler methods and the ground truth, over the walking part of a log."""

from dataclasses import dataclass, replace

import numpy as np

from model.errors import RecordError
from model.kinematics.legs import leg_kinematics
from model.motion.dead_reckoning import advance
from model.motion.se2 import aligning, compose, integrate
from model.motion.shaft_speed import agreed_over
from model.quasistatic.frame import solve_walk
from model.values.arrays import BoolArray, FloatArray, root_mean_square
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from model.values.tick import DeadReckoning, Mode
from record.log.recording import Recording
from robot.config.robot_file import RobotConfig
from robot.control.effect_uses import true_forces_of
from robot.control.effects import model_of
from robot.odometry.metrics import Motion, TrackErrors, nees, track_errors, turned_to_fit
from robot.odometry.track import Track, TrackedLog
from robot.report.ground_truth import true_pose, true_velocity

OWN_TRUTH = "this log's own ground truth, so its end error is not independent"


@dataclass(frozen=True, slots=True, eq=False)
class OdometryComparison:
    """The walking part of a recording by every method, T ticks; all begin at the estimator's pose.

    Attributes:
        names: Legs.
        track: The estimator's.
        log_ticks: Ticks of all of the recording.
        motions: One a method, the estimator first; the truth is none of them.
        truth: Begun there too; None without truth.
        errors: One a method; empty without truth.
        twist_nees: (T,); NaN without truth.
        pose_nees: Of the displacement since the first of these ticks, (T,).
        config: The robot that the estimator used.
        measured_force_n: What the sensors measured, without the errors that the robot file knows of,
            (T, N, 3) [N]; NaN without a sensor.
        stride_m: Distance a cycle of the method that knows nothing else [m]; NaN without that method.
        stride_from: What that distance was calibrated on.
    """

    names: tuple[str, ...]
    track: Track
    log_ticks: int
    motions: tuple[Motion, ...]
    truth: Motion | None
    errors: tuple[TrackErrors, ...]
    twist_nees: FloatArray
    pose_nees: FloatArray
    config: RobotConfig
    measured_force_n: FloatArray
    stride_m: float = np.nan
    stride_from: str = ""

    def of_estimator(self) -> "OdometryComparison":
        """Return the same without the simpler methods."""
        return replace(
            self, motions=self.motions[:1], errors=self.errors[:1], stride_m=np.nan, stride_from=""
        )

    @property
    def judged_by_sensors(self) -> bool:
        """Whether predicted forces are judged by the measured ones, for want of the true ones."""
        return self.truth is None or not np.isfinite(self.truth.force_B).any()

    @property
    def reference_force_n(self) -> FloatArray:
        """Foot forces that predicted ones are judged by, (T, N, 3) [N]; NaN where there are none."""
        if self.truth is None or self.judged_by_sensors:
            return self.measured_force_n
        return self.truth.force_B

    def leg_force_rmse(self, method: int) -> FloatArray:
        """RMSE of a method's forces, (N, 3) [N], over ticks in which every method knows them."""
        forces = [motion.force_B for motion in self.motions if motion.force_B.ndim]
        known = np.isfinite(np.sum(forces, axis=0))
        off = self.motions[method].force_B - self.reference_force_n
        return root_mean_square(np.where(known, off, np.nan))


def walking_part(log: Recording) -> slice:
    """Ticks from the first one of walking to the last.

    Raises:
        RecordError: There is no walking.
    """
    walking = np.flatnonzero(log.mode == Mode.WALK.value)
    if len(walking) < 2:
        raise RecordError("the log holds no walking; record a walk")
    return slice(int(walking[0]), int(walking[-1]) + 1)


def compare_methods(
    tracked: TrackedLog,
    *,
    fitted: ContactParameters | None = None,
    stride_m: float = np.nan,
    stride_from: str = OWN_TRUTH,
    simpler: bool = True,
) -> OdometryComparison:
    """Compare the estimator with the simpler methods and the truth.

    Args:
        tracked: A log with walking in it, and what the estimator reported.
        simpler: Whether the simpler methods are wanted; an hour of them takes seconds.
        fitted: Parameters fitted offline to another walk, for the open loop.
        stride_m: Distance a cycle, for the method that knows nothing else; NaN leaves it out.
        stride_from: What it was calibrated on.

    Raises:
        RecordError: There is no walking.
    """
    log, config = tracked.log, tracked.config
    span = judged_part(log)
    run, t_s = tracked.track.part(span), log.t_s[span]
    start = run.pose[0]
    motions = [Motion("estimator", run.pose, run.velocity_B, run.force_B)]
    if simpler:
        motions += _simpler(tracked, span, start, fitted, stride_m)
    unknown, without_errors = np.full(len(t_s), np.nan), true_forces_of(config)
    measured_n = log.force_n[span]
    alone = OdometryComparison(
        names=log.names,
        track=run,
        log_ticks=len(log.t_s),
        motions=tuple(motions),
        truth=None,
        errors=(),
        twist_nees=unknown,
        pose_nees=unknown,
        config=config,
        measured_force_n=measured_n if without_errors is None else without_errors(measured_n, t_s),
        stride_m=stride_m,
        stride_from=stride_from if np.isfinite(stride_m) else "",
    )
    truth = true_motion(log, span)
    if truth is None:
        return alone
    truth = truth._replace(pose=_begun_at(start, truth.pose, run.pose))
    return replace(
        alone,
        truth=truth,
        errors=tuple(track_errors(one, truth) for one in motions),
        twist_nees=nees(run.velocity_B - truth.velocity_B, run.column("twist_covariance")),
        pose_nees=nees(run.pose - truth.pose, run.displacement_covariance),
    )


def _simpler(
    tracked: TrackedLog,
    span: slice,
    start: FloatArray,
    fitted: ContactParameters | None,
    stride_m: float,
) -> list[Motion]:
    """Motions by the methods that know less, over some ticks from a pose on."""
    log, t_s = tracked.log, tracked.log.t_s[span]
    feet, velocity, force = _model(log, tracked.config, span)
    naive = _reckoned("open loop, naive", velocity, t_s, start, force)
    motions = [naive]
    if fitted is not None:
        weight_n = float(np.nanmedian(force[..., 2].sum(axis=1)))  # with what rides along
        velocity, force = _solved(feet, fitted, weight_n)
        motions.append(_reckoned("open loop, fitted", velocity, t_s, start, force))
    if np.isfinite(stride_m):
        velocity = np.zeros((len(t_s), 3))
        velocity[:, 0] = stride_m * np.nan_to_num(np.gradient(log.gait_phase[span], t_s))
        motions.append(_reckoned("distance a stride", velocity, t_s, start))
    velocity = _rigid_stance(feet, naive.force_B[..., 2] > 0)
    return [*motions, _reckoned("rigid stance", velocity, t_s, start)]


def judged_part(log: Recording) -> slice:
    """The walking part, from the first tick on in which the truth is known if it is known in any.

    Raises:
        RecordError: There is no walking.
    """
    span = walking_part(log)
    pose = true_pose(log)[span]
    for columns in (pose, pose[:, :2]):  # a place without a heading is better than nothing
        known = np.flatnonzero(np.isfinite(columns).all(axis=1))
        if len(known) > 1:
            return slice(span.start + int(known[0]), span.stop)
    return span


def true_motion(log: Recording, span: slice) -> Motion | None:
    """True motion over some ticks, NaN where it is not known; None without two known places."""
    pose = true_pose(log)[span]
    if np.isfinite(pose[:, :2]).all(axis=1).sum() < 2:
        return None
    return Motion("truth", pose, true_velocity(log)[span], log.truth_force_n[span])


def _begun_at(start: FloatArray, truth: FloatArray, path: FloatArray) -> FloatArray:
    """The truth in the frame in which it begins at a pose; without a heading, turned to fit a path."""
    if np.isfinite(truth[0]).all():
        return compose(aligning(start, truth[0]), truth)
    return turned_to_fit(truth, path)


def stride_of(log: Recording) -> float:
    """True distance a cycle of a walk [m]; NaN without truth or without the phase of a gait."""
    span = walking_part(log)
    phase, place = log.gait_phase[span], log.truth_position_W[span, :2]
    known = np.flatnonzero(np.isfinite(phase) & np.isfinite(place).all(axis=1))
    if len(known) < 2:
        return np.nan
    first, last = known[0], known[-1]
    cycles = float(phase[last] - phase[first])
    return float(np.hypot(*(place[last] - place[first]))) / cycles if cycles > 0 else np.nan


def _reckoned(
    name: str,
    velocity: FloatArray,
    t_s: FloatArray,
    start: FloatArray,
    force: FloatArray | None = None,
) -> Motion:
    """The motion of a body velocity held between ticks; unknown velocities stand still."""
    between = 0.5 * (velocity[:-1] + velocity[1:])
    pose = integrate(np.where(np.isfinite(between), between, 0.0), np.diff(t_s), start)
    return Motion(name, pose, velocity, np.array(np.nan) if force is None else force)


def _model(
    log: Recording, config: RobotConfig, span: slice
) -> tuple[FootMotion, FloatArray, FloatArray]:
    """Feet, velocity and forces by the robot file's own model, as the loop runs it.

    Shaft speeds are those that the estimator uses: the servos' own, corrected without a look ahead.
    """
    robot, effects = config.parameters, model_of(config)
    angle, t_ns = log.angle_rad[span], np.round(log.t_s[span] * 1e9).astype(np.int64)
    rate = agreed_over(t_ns, angle, log.rate_rad_s[span])
    if effects is None:
        feet = leg_kinematics(robot).feet(angle, rate)
        return feet, *_solved(feet, robot.contact, robot.body.mass * STANDARD_GRAVITY)
    position, speed, force = np.full((3, *log.force_n[span].shape), np.nan)
    velocity = np.full((len(t_ns), 3), np.nan)
    where = DeadReckoning(int(t_ns[0]), np.zeros(2), 0.0, np.full(3, np.nan), valid=False)
    for i, now_ns in enumerate(t_ns.tolist()):
        pose, dt_s = np.array([*where.position_m, where.yaw_rad]), (now_ns - where.t_ns) * 1e-9
        answer = effects.solve(angle[i], rate[i], pose, where.velocity_B, dt_s)
        position[i], speed[i] = answer.feet.position_m, answer.feet.velocity_m_s
        velocity[i], force[i] = answer.contact.traction.velocity_B, answer.contact.traction.force_B
        where = advance(where, velocity[i], now_ns)
    return FootMotion(position, speed), velocity, force


def _solved(
    feet: FootMotion, contact: ContactParameters, weight_n: float
) -> tuple[FloatArray, FloatArray]:
    """Velocity and forces by the viscous-Coulomb model with fixed parameters."""
    answer = solve_walk(feet, contact, weight_n)
    return answer.velocity_B, answer.force_B


def _rigid_stance(feet: FootMotion, loaded: BoolArray) -> FloatArray:
    """Velocity if legs did not slip: the twist that moves loaded feet least over the ground, (T, 3)."""
    velocity = np.full((len(loaded), 3), np.nan)
    on_ground = loaded.sum(axis=1)
    for count in set(on_ground[on_ground >= 2].tolist()):
        ticks = np.flatnonzero(on_ground == count)
        feet_there = np.nonzero(loaded[ticks])[1].reshape(-1, count)
        place = feet.position_m[ticks[:, None], feet_there]
        speed = feet.velocity_m_s[ticks[:, None], feet_there]
        rows = np.zeros((len(ticks), 2 * count, 3))
        rows[:, :count, 0] = rows[:, count:, 1] = 1.0
        rows[:, :count, 2], rows[:, count:, 2] = -place[..., 1], place[..., 0]
        still = -np.concatenate([speed[..., 0], speed[..., 1]], axis=1)
        known = np.isfinite(rows).all(axis=(1, 2))  # of others there is no answer
        solved = np.linalg.pinv(rows[known]) @ still[known, :, None]
        velocity[ticks[known]] = solved[..., 0]
    return velocity
