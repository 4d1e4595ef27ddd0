"""One walk, as it was and as both friction laws predict it.

As in the paper the feet's velocities are those of a Savitzky-Golay filter over their positions in the
body (order 2, 25 samples), and the ansatz' forces get one scale a frame that brings them nearest to
the measured ones; here the positions come from the shaft angles through the linkage.
"""

import time
from dataclasses import dataclass

import numpy as np
from scipy.signal import savgol_filter
from scipy.spatial.transform import Rotation

from model.errors import ModelError
from model.kinematics.legs import leg_kinematics
from model.motion.attitude import roll_pitch_yaw
from model.motion.se2 import integrate
from model.quasistatic.frames import FrameSolutions, FrictionLaw, solve_frames
from model.traction.force_scale import force_scale
from model.values.arrays import BoolArray, FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from model.values.tick import Mode
from record.log.recording import Recording
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.report.ground_truth import true_forward_slip, true_velocity, unwrap_known

FILTER_WINDOW, FILTER_ORDER = 25, 2
TIMED = 5
SWAY_WINDOW = 9  # samples; slopes are smooth already


@dataclass(frozen=True, slots=True, eq=False)
class LawPrediction:
    """What one friction law predicts for a walk of F frames and N feet.

    Attributes:
        velocity_B: vx, vy [m/s], yaw rate [rad/s], (F, 3); NaN where there is no answer.
        force_xy_B: Horizontal ground force on each foot, (F, N, 2) [N].
        pose: Integrated x, y [m], yaw [rad] from the true beginning, (F, 3).
        unique: Whether the answer is the only one, (F,): under Coulomb's law the forces of several
            sticking feet are a choice among many.
        frame_us: Time of solving one frame in the batch, support and traction [us].
    """

    velocity_B: FloatArray  # noqa: N815 - frame suffix
    force_xy_B: FloatArray  # noqa: N815
    pose: FloatArray
    unique: BoolArray
    frame_us: float


@dataclass(frozen=True, slots=True, eq=False)
class WalkComparison:
    """A walk of F frames and N feet; what is not known is NaN.

    Attributes:
        gait: Its name.
        names: Leg names.
        mu: Friction coefficients in the robot file, (N,).
        t_s: Time since the walk began, (F,).
        phase: Gait phase, (F,) [cycles].
        angle_rad: Shaft angles, (F, N).
        position_W: True place, (F, 3) [m].
        tilt_rad: True roll, pitch, yaw, (F, 3).
        velocity_B: True vx, vy [m/s], yaw rate [rad/s], (F, 3).
        force_n: True (without truth: measured) ground force on each foot, body axes, (F, N, 3).
        slip_m_s: True horizontal speed of loaded feet over the ground, (F, N); NaN in the air.
        slip_ahead_m_s: The same along the body's heading, signed, (F, N).
        support_tilt_rad: Roll and pitch of the spring support model, (F, 2).
        sway_B: Horizontal velocity of the body origin as it tilts over the ground below it, from the
            support model's tilt and height, (F, 2) [m/s]. The planar balance leaves it out.
        load_share: The model's vertical force over the weight, (F, N).
        viscous: Prediction of the viscous-Coulomb ansatz.
        coulomb: Prediction of Coulomb's law.
        body_size_m: Length and width of the rectangle of the shafts, (2,).
    """

    gait: str
    names: tuple[str, ...]
    mu: FloatArray
    t_s: FloatArray
    phase: FloatArray
    angle_rad: FloatArray
    position_W: FloatArray  # noqa: N815
    tilt_rad: FloatArray
    velocity_B: FloatArray  # noqa: N815
    force_n: FloatArray
    slip_m_s: FloatArray
    slip_ahead_m_s: FloatArray
    support_tilt_rad: FloatArray
    sway_B: FloatArray  # noqa: N815
    load_share: FloatArray
    viscous: LawPrediction
    coulomb: LawPrediction
    body_size_m: FloatArray

    @property
    def true_share(self) -> FloatArray:
        """Share of each foot in the true vertical force, (F, N)."""
        total = self.force_n[:, :, 2].sum(axis=1, keepdims=True)
        share: FloatArray = self.force_n[:, :, 2] / np.where(total > 0, total, np.nan)
        return share


def compare_walk(log: Recording) -> WalkComparison:
    """Run both laws over the walking part of a recording, virtual or real.

    Raises:
        ModelError: There is no walking in it, or too little to filter.
    """
    config = parse_robot(log.config_text) if log.config_text else load_robot()
    walking = np.flatnonzero(log.mode == Mode.WALK.value)
    if len(walking) < FILTER_WINDOW:
        raise ModelError(
            f"the recording holds {len(walking)} walking ticks; at least {FILTER_WINDOW} are needed"
        )
    feet = FootMotion(*(values[walking] for values in _feet(log, config)))
    tilt = _tilt(log)[walking]
    t_s = log.t_s[walking]
    start = np.array([*log.truth_position_W[walking[0], :2], tilt[0, 2]])
    start = np.where(np.isfinite(start), start, 0.0)
    weight_n = config.parameters.body.mass * STANDARD_GRAVITY
    contact = config.parameters.contact
    force = log.truth_force_n[walking] if log.has_truth else log.force_n[walking]
    viscous, viscous_us = _solve(feet, contact, weight_n, FrictionLaw.VISCOUS)
    frames, coulomb_us = _solve(feet, contact, weight_n, FrictionLaw.COULOMB)
    bare = viscous.force_xy_B
    # the paper's loss, of magnitudes; a frame at rest has no scale, and no forces either
    sigma = force_scale(bare, force[..., :2], norms=True).scale
    scaled = np.where(np.isfinite(sigma), sigma, 0.0)[:, None, None] * bare
    loaded = log.truth_contact[walking]
    shafts = config.parameters.legs.shaft_position[:, :2]
    return WalkComparison(
        gait=log.metadata.get("gait", "walk"),
        names=log.names,
        mu=contact.mu,
        t_s=t_s - t_s[0],
        phase=log.gait_phase[walking],
        angle_rad=log.angle_rad[walking],
        position_W=log.truth_position_W[walking],
        tilt_rad=tilt,
        velocity_B=true_velocity(log)[walking],
        force_n=force,
        slip_m_s=np.where(
            loaded, np.linalg.norm(log.truth_foot_velocity_W[walking, :, :2], axis=-1), np.nan
        ),
        slip_ahead_m_s=true_forward_slip(log)[walking],
        support_tilt_rad=np.arctan(frames.pose[:, [1, 0]]),
        sway_B=_sway(frames, t_s),
        load_share=frames.load_n / weight_n,
        viscous=_prediction(viscous, scaled, t_s, start, viscous_us),
        coulomb=_prediction(frames, frames.force_xy_B, t_s, start, coulomb_us),
        body_size_m=np.ptp(shafts, axis=0),
    )


def _solve(
    feet: FootMotion, contact: ContactParameters, weight_n: float, law: FrictionLaw
) -> tuple[FrameSolutions, float]:
    """Solve, and time it a few times more: the first may have to compile. Median time a frame in [us]."""
    solved = solve_frames(feet, contact, weight_n, law=law)
    times_s = []
    for _ in range(TIMED):
        begin = time.perf_counter()
        solve_frames(feet, contact, weight_n, law=law)
        times_s.append(time.perf_counter() - begin)
    return solved, 1e6 * float(np.median(times_s)) / len(feet.position_m)


def _feet(log: Recording, config: RobotConfig) -> tuple[FloatArray, FloatArray]:
    """Positions of the feet in the body from the shaft angles, velocities as in the paper's setup."""
    parameters = config.parameters
    kinematics = leg_kinematics(parameters)
    position = kinematics.feet(log.angle_rad, np.zeros_like(log.angle_rad)).position_m
    period_s = float(np.median(np.diff(log.t_s)))
    velocity = savgol_filter(position, FILTER_WINDOW, FILTER_ORDER, deriv=1, delta=period_s, axis=0)
    return position, velocity


def _tilt(log: Recording) -> FloatArray:
    """Roll, pitch, yaw (unwrapped) of the truth, (T, 3) [rad]; NaN where there is none."""
    tilt = np.full((len(log.t_s), 3), np.nan)
    known = np.isfinite(log.truth_quaternion_xyzw).all(axis=1)
    if known.any():
        turned = Rotation.from_quat(log.truth_quaternion_xyzw[known])
        tilt[known] = roll_pitch_yaw(turned)
    tilt[:, 2] = unwrap_known(tilt[:, 2])
    return tilt


def _sway(frames: FrameSolutions, t_s: FloatArray) -> FloatArray:
    """Tilt rate cross height: (height pitch rate, -height roll rate), (F, 2) [m/s]."""
    slopes, height = frames.pose[:, :2], frames.pose[:, 2:]
    period_s = float(np.median(np.diff(t_s)))
    rate = savgol_filter(
        slopes, SWAY_WINDOW, FILTER_ORDER, deriv=1, delta=period_s, axis=0, mode="nearest"
    )
    sway: FloatArray = height * rate * [1.0, -1.0]
    return sway


def _prediction(
    frames: FrameSolutions, force: FloatArray, t_s: FloatArray, start: FloatArray, frame_us: float
) -> LawPrediction:
    velocity = frames.velocity_B
    between = (velocity[:-1] + velocity[1:]) / 2
    held = np.where(np.isfinite(between), between, 0.0)  # without an answer the pose stands still
    pose = integrate(held, np.diff(t_s), start)
    return LawPrediction(velocity, force, pose, frames.unique, frame_us)
