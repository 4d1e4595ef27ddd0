"""Walking frames of a log: feet, forces and the true motion, and stiffness and friction fitted to them."""

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from model.effects.sensing import OF_FORCES
from model.errors import ConfigError, ModelError, RecordError
from model.fit.friction import FrictionForm, fit_friction
from model.fit.result import FitResult
from model.fit.stiffness import fit_stiffness
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frames import FrictionLaw
from model.values.arrays import BoolArray, FloatArray, part_of
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from model.values.tick import Mode
from record.log.recording import Recording
from robot.config.robot_file import parse_robot
from robot.control.effect_uses import USES, Use, true_forces_of
from robot.report.ground_truth import true_slip, true_velocity

# The paper's filter for foot velocities: second order, 25 samples at 100 Hz (sec:setup).
WINDOW, ORDER = 25, 2
# Ticks further from the even spacing than this share of a period are a gap.
UNEVEN = 0.5
# The paper's naive parameters: K = 10 where the weight is 1 (lengths in metres), mu = 1, no w.
NAIVE_STIFFNESS = 10.0
NAIVE_MU = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class WalkFrames:
    """F frames of walking, all in body axes.

    Attributes:
        feet: Unloaded feet from the measured shaft angles, (F, N, 3) [m].
        feet_velocity: Their velocity in the body, (F, N, 3) [m/s].
        force: Measured ground forces on the feet, (F, N, 3) [N].
        slip: True velocity of the feet over the ground, (F, N, 2) [m/s].
        velocity: True vx, vy [m/s], yaw rate [rad/s], (F, 3).
        slope: True slope_y (roll) and slope_x (pitch), (F, 2) [rad].
    """

    feet: FloatArray
    feet_velocity: FloatArray
    force: FloatArray
    slip: FloatArray
    velocity: FloatArray
    slope: FloatArray

    @property
    def count(self) -> int:
        """Number of frames F."""
        return len(self.feet)

    @property
    def arrays(self) -> list[FloatArray]:
        """All of them, in their order."""
        return [getattr(self, field.name) for field in fields(self)]

    def part(self, rows: slice | BoolArray) -> "WalkFrames":
        """Return some of the frames."""
        return part_of(self, rows)

    @property
    def motion(self) -> FootMotion:
        """Feet for the model."""
        return FootMotion(self.feet, self.feet_velocity)


def walk_frames(log: Recording, name: str) -> WalkFrames:
    """Take the complete walking frames of a log, called ``name`` in a complaint.

    Raises:
        RecordError: It has no truth, no forces, or no walking.
        ConfigError: The robot file in the log cannot be used, or has effects that the bare model lacks.
    """
    if not log.has_truth:
        raise RecordError(
            f"{name} has no true body motion to judge by; give a log of virtual hardware, or one with "
            "motion capture"
        )
    if not np.isfinite(log.force_n).any():
        raise RecordError(f"{name} has no foot forces; walk with the force unit")
    config = parse_robot(log.config_text)
    acting = {one.effect for one in config.effects if USES[one.effect] in {Use.MODEL, Use.READING}}
    if lacking := acting - OF_FORCES:
        raise ConfigError(
            "effects",
            f"{name} was walked with {', '.join(sorted(lacking))} in its robot file, which the fit of "
            "stiffness and friction does not know; give logs of a robot file without",
        )
    robot, true_forces = config.parameters, true_forces_of(config)
    force_n = log.force_n if true_forces is None else true_forces(log.force_n, log.t_s)
    feet = leg_kinematics(robot).feet(log.angle_rad, smooth_rate(log))
    every = WalkFrames(
        feet=feet.position_m,
        feet_velocity=feet.velocity_m_s,
        force=force_n,
        slip=true_slip(log),
        velocity=true_velocity(log),
        slope=_slopes(log.truth_quaternion_xyzw),
    )
    whole: BoolArray = log.mode == Mode.WALK.value
    for values in every.arrays:
        whole = whole & np.isfinite(values.reshape(len(values), -1)).all(axis=1)
    if not whole.any():
        raise RecordError(f"{name} has no frame of walking with feet, forces and true motion")
    return every.part(whole)


def halves(walk: WalkFrames) -> tuple[WalkFrames, WalkFrames]:
    """Cut in two in time: the earlier and the later half."""
    middle = walk.count // 2
    return walk.part(slice(middle)), walk.part(slice(middle, None))


def joined(walks: Sequence[WalkFrames]) -> WalkFrames:
    """One behind the other."""
    return WalkFrames(*map(np.concatenate, zip(*(walk.arrays for walk in walks), strict=True)))


def smooth_rate(log: Recording) -> FloatArray:
    """Shaft speeds from the angles by the paper's filter, (T, N) [rad/s]; NaN beside a gap."""
    from scipy.signal import savgol_filter  # half a second: as late as it is needed

    step = np.diff(log.t_s)
    if len(step) < WINDOW:
        return np.full_like(log.angle_rad, np.nan)
    period = float(np.median(step))
    rate: FloatArray = savgol_filter(log.angle_rad, WINDOW, ORDER, deriv=1, delta=period, axis=0)
    gaps = np.flatnonzero(np.abs(step - period) > UNEVEN * period)
    for gap in gaps:
        rate[max(0, gap - WINDOW // 2) : gap + WINDOW // 2 + 2] = np.nan
    return rate


def _slopes(quaternion: FloatArray) -> FloatArray:
    """Heights of the body's axes: slope_y (roll), slope_x (pitch), (T, 2)."""
    x, y, z, w = quaternion.T
    # last row of the rotation: height of a point is -slope_x q_x + slope_y q_y + q_z (eqn:zpj)
    return np.stack([2 * (y * z + w * x), -2 * (x * z - w * y)], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Fits:
    """Fitted parameters, the law they are for, and how well they are known."""

    law: FrictionLaw
    weight_n: float
    contact: ContactParameters
    stiffness: FitResult
    friction: FitResult


def fit_contact(
    walk: WalkFrames,
    names: tuple[str, ...],
    *,
    free_w: bool,
    rest_m_s: float,
    law: FrictionLaw = FrictionLaw.VISCOUS,
) -> Fits:
    """Fit stiffness and friction of the named legs to frames of a walk.

    With ``free_w`` there are 24 parameters instead of 18, whose w lies fore and aft. Feet no faster than
    ``rest_m_s`` rest: what holds them is statics, not the friction law, so they would lead the fit astray.
    The viscous ansatz is the paper's law.

    Raises:
        ModelError: These frames cannot be fitted to.
    """
    weight = float(np.median(walk.force[..., 2].sum(axis=1)))
    if weight <= 0:
        raise ModelError("the measured vertical forces do not carry a weight: check their bias")
    legs = len(names)
    springs = fit_stiffness(
        walk.feet,
        walk.force[..., 2],
        weight,
        np.full(legs, NAIVE_STIFFNESS * weight),
        leg_names=names,
    )
    friction = fit_friction(
        walk.force[..., :2],
        np.maximum(walk.force[..., 2], 0.0),
        walk.slip,
        FrictionForm(
            direction=None if free_w else np.tile([1.0, 0.0], (legs, 1)),
            law=law,
            mean_mu=NAIVE_MU if law is FrictionLaw.VISCOUS else None,
            rest_m_s=rest_m_s,
        ),
        leg_names=names,
    )
    contact = ContactParameters(springs.values, friction.mu, friction.anisotropy)
    return Fits(law, weight, contact, springs, friction.result)
