"""The estimator beside simpler ways of dead reckoning over one recording, and the truth."""

from dataclasses import dataclass, replace

import numpy as np

from model.errors import RecordError
from model.estimator.settings import EstimatorSettings
from model.motion.se2 import integrate
from model.parameters.robot import ContactParameters
from model.quasistatic.frame import solve_frame
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.tick import Mode
from record.log.recording import Recording
from robot.config.robot_file import RobotConfig
from robot.odometry.effect_frames import effect_frames
from robot.odometry.metrics import TrackErrors, nees, track_errors
from robot.odometry.track import OdometryTrack, Progress, feet_of, inputs_of, track, weight_of
from robot.report.run_totals import true_pose


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """A way of dead reckoning: pose (T, 3), body velocity (T, 3), foot forces (T, N, 3)."""

    name: str
    pose: FloatArray
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    force_B: FloatArray  # noqa: N815


@dataclass(frozen=True, slots=True, eq=False)
class Comparison:
    """All ways over the walking part of a recording of T ticks.

    Attributes:
        track: The estimator's.
        log_ticks: Ticks of all of the recording.
        ways: All, the estimator first; the truth is no way.
        truth: Its pose, velocity and forces; None without truth.
        errors: One a way; empty without truth.
        twist_nees: (T,); NaN without truth.
        pose_nees: (T,).
    """

    track: OdometryTrack
    log_ticks: int
    ways: tuple[Way, ...]
    truth: tuple[FloatArray, FloatArray, FloatArray] | None
    errors: tuple[TrackErrors, ...]
    twist_nees: FloatArray
    pose_nees: FloatArray


def walking_part(log: Recording) -> tuple[int, int]:
    """First tick of walking and the one after the last.

    Raises:
        RecordError: There is no walking.
    """
    walking = np.flatnonzero(log.mode == Mode.WALK.value)
    if len(walking) < 2:
        raise RecordError("the log holds no walking; record a walk")
    return int(walking[0]), int(walking[-1]) + 1


def compare_ways(
    log: Recording,
    config: RobotConfig,
    settings: EstimatorSettings,
    *,
    fitted: ContactParameters | None = None,
    stride_m: float = np.nan,
    keep_states: bool = False,
    progress: Progress | None = None,
) -> Comparison:
    """Run all ways.

    Args:
        log: A recording with walking in it.
        config: The robot as the estimator believes it to be.
        settings: Of the estimator.
        fitted: Parameters fitted offline to another walk, for the open loop.
        stride_m: Distance a cycle, for the way that knows nothing else; NaN leaves it out.
        keep_states: Keep what a smoother needs.
        progress: Told the share done.

    Raises:
        RecordError: There is no walking.
    """
    first, last = walking_part(log)
    span = slice(first, last)
    weight_n, feet = weight_of(config), feet_of(log, config)
    effects = effect_frames(log, config, settings, (first, last), progress)
    if effects is not None:
        weight_n, feet = effects.weight_n, effects.feet
        log = replace(log, force_n=effects.force_n)
    truth = true_motion(log, span)
    start = np.zeros(3) if truth is None else truth[0][0]
    inputs = inputs_of(log, feet, first, last)
    if effects is not None:
        inputs = [replace(one, added=a) for one, a in zip(inputs, effects.added, strict=True)]
    run = track(
        inputs, config.parameters.contact, weight_n, settings,
        pose=start, keep_states=keep_states, progress=progress,
    )  # fmt: skip
    walked = FootMotion(feet.position_m[span], feet.velocity_m_s[span])
    t_s = log.t_s[span]
    ways = [Way("estimator", run.pose, run.velocity_B, run.force_B)]
    naive = config.parameters.contact
    if effects is None:
        ways.append(_open_loop("open loop, naive", walked, naive, weight_n, t_s, start))
    else:
        pose = dead_reckon(effects.velocity_B, t_s, start)
        ways.append(Way("open loop, naive", pose, effects.velocity_B, effects.force_B))
    if fitted is not None:
        ways.append(_open_loop("open loop, fitted", walked, fitted, weight_n, t_s, start))
    if np.isfinite(stride_m):
        ways.append(_strides(log.gait_phase[span], stride_m, t_s, start, ways[0].force_B.shape))
    ways.append(_rigid_stance(walked, ways[1].force_B, t_s, start))
    if truth is None:
        nothing = np.full(len(t_s), np.nan)
        return Comparison(run, len(log.t_s), tuple(ways), None, (), nothing, nothing)
    errors = tuple(track_errors(w.name, w.pose, w.velocity_B, w.force_B, truth) for w in ways)
    return Comparison(
        run, len(log.t_s), tuple(ways), truth, errors,
        nees(run.velocity_B - truth[1], run.twist_covariance),
        nees(run.pose - truth[0], run.pose_covariance),
    )  # fmt: skip


def true_motion(log: Recording, span: slice) -> tuple[FloatArray, FloatArray, FloatArray] | None:
    """True pose, velocity and foot forces of some ticks; None where any is missing."""
    found = (true_pose(log)[span], log.truth_velocity_B[span], log.truth_force_n[span])
    return found if all(np.isfinite(part).all() for part in found) else None


def stride_of(log: Recording) -> float:
    """True distance a cycle of a walk [m]; NaN without truth."""
    first, last = walking_part(log)
    cycles = float(log.gait_phase[last - 1] - log.gait_phase[first])
    way = log.truth_position_W[last - 1, :2] - log.truth_position_W[first, :2]
    return float(np.hypot(*way)) / cycles if cycles > 0 else np.nan


def dead_reckon(velocity: FloatArray, t_s: FloatArray, start: FloatArray) -> FloatArray:
    """Poses of a body velocity held between ticks, (T, 3); unknown velocities stand still."""
    between = 0.5 * (velocity[:-1] + velocity[1:])
    held = np.where(np.isfinite(between), between, 0.0)
    return integrate(held, np.diff(t_s), start)


def _open_loop(
    name: str,
    feet: FootMotion,
    contact: ContactParameters,
    weight_n: float,
    t_s: FloatArray,
    start: FloatArray,
) -> Way:
    """The viscous-Coulomb model with fixed parameters, as the loop runs it."""
    velocity = np.empty((len(t_s), 3))
    force = np.empty(feet.position_m.shape)
    for i in range(len(t_s)):
        motion = FootMotion(feet.position_m[i], feet.velocity_m_s[i])
        traction = solve_frame(motion, contact, weight_n).traction
        velocity[i], force[i] = traction.velocity_B, traction.force_B
    return Way(name, dead_reckon(velocity, t_s, start), velocity, force)


def _strides(
    phase: FloatArray, stride_m: float, t_s: FloatArray, start: FloatArray, shape: tuple[int, ...]
) -> Way:
    velocity = np.zeros((len(t_s), 3))
    velocity[:, 0] = stride_m * np.gradient(phase, t_s)
    pose = dead_reckon(velocity, t_s, start)
    return Way("distance a stride", pose, velocity, np.full(shape, np.nan))


def _rigid_stance(feet: FootMotion, force: FloatArray, t_s: FloatArray, start: FloatArray) -> Way:
    """Legs that do not slip: the twist that moves loaded feet least over the ground."""
    velocity = np.full((len(t_s), 3), np.nan)
    loaded = force[:, :, 2] > 0
    for i in range(len(t_s)):
        place = feet.position_m[i][loaded[i]]
        speed = feet.velocity_m_s[i][loaded[i]]
        if len(place) < 2:
            continue
        rows = np.zeros((2 * len(place), 3))
        rows[: len(place), 0] = rows[len(place) :, 1] = 1.0
        rows[:, 2] = [*-place[:, 1], *place[:, 0]]
        velocity[i] = np.linalg.lstsq(rows, -speed[:, :2].T.ravel(), rcond=None)[0]
    pose = dead_reckon(velocity, t_s, start)
    return Way("rigid stance", pose, velocity, np.full(force.shape, np.nan))
