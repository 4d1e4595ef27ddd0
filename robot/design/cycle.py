"""One cycle of a gait through kinematics and the quasi-static model, phase by phase."""

from dataclasses import dataclass

import numpy as np

from gaits.gait import Gait, ShaftMotion
from model.kinematics.legs import leg_kinematics
from model.quasistatic.frames import FrameSolutions, FrictionLaw, solve_frames
from model.support.static_margin import StaticMargin, static_margin
from model.traction.forced_slip import ForcedSlip, forced_slip
from model.values.arrays import BoolArray, FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootMotion
from model.values.parameters import RobotParameters

PHASES = 180  # of a cycle


@dataclass(frozen=True, slots=True, eq=False)
class GaitCycle:
    """F even phases of one cycle, N legs.

    Attributes:
        frequency_hz: Cycles a second.
        steer: -1 (right) to 1 (left).
        phase: In the middle of F equal parts of the cycle, (F,).
        shafts: Angles, slopes and curvatures, (F, N).
        feet: Unloaded feet in the body frame, (F, N, 3).
        jacobian_m: d foot / d joint angle, (F, N, 3, J) [m/rad].
        stance: Which feet the gait has on the ground, (F, N).
        answer: Support and Coulomb's law on level ground.
        height_m: Of each unloaded foot over the ground as the body then stands, (F, N) [m]; negative where
            a leg spring is pressed, NaN where the robot tips over.
        margin: Static margin of the feet in stance.
        forced: Slip that the feet in stance force on each other.
    """

    frequency_hz: float
    steer: float
    phase: FloatArray
    shafts: ShaftMotion
    feet: FootMotion
    jacobian_m: FloatArray
    stance: BoolArray
    answer: FrameSolutions
    height_m: FloatArray
    margin: StaticMargin
    forced: ForcedSlip

    @property
    def force_n(self) -> FloatArray:
        """Ground's force on each foot under Coulomb's law, (F, N, 3) [N]."""
        return np.concatenate([self.answer.force_xy_B, self.answer.load_n[..., None]], axis=-1)

    @property
    def torque_nm(self) -> FloatArray:
        """Torque that each joint needs, (F, J) [N m]."""
        return joint_torque(self.jacobian_m, self.force_n)


def walk_cycle(
    robot: RobotParameters, gait: Gait, steer: float = 0.0, frequency_hz: float | None = None
) -> GaitCycle:
    """Walk one cycle.

    Args:
        robot: The robot.
        gait: One of its gaits.
        steer: -1 (right) to 1 (left).
        frequency_hz: Cycles a second; the gait's own if None.
    """
    frequency = gait.frequency_hz if frequency_hz is None else frequency_hz
    phase = (np.arange(PHASES) + 0.5) / PHASES
    shafts, stance = gait.motion(phase, steer), gait.stance(phase)
    legs = leg_kinematics(robot)
    feet = legs.feet(shafts.angle_rad, shafts.slope * frequency)
    answer = solve_frames(
        feet, robot.contact, robot.body.mass * STANDARD_GRAVITY, law=FrictionLaw.COULOMB
    )
    place = feet.position_m
    slope_x, slope_y, height = (answer.pose[:, i, None] for i in range(3))
    return GaitCycle(
        frequency_hz=frequency,
        steer=steer,
        phase=phase,
        shafts=shafts,
        feet=feet,
        jacobian_m=legs.jacobian(shafts.angle_rad),
        stance=stance,
        answer=answer,
        height_m=-slope_x * place[..., 0] + slope_y * place[..., 1] + place[..., 2] + height,
        margin=static_margin(place[..., :2], stance),
        forced=forced_slip(place[..., :2], feet.velocity_m_s[..., :2], stance),
    )


def joint_torque(jacobian_m: FloatArray, force_n: FloatArray) -> FloatArray:
    """Return the torques that hold a force on each foot: by virtual work, ``torque = -jacobian^T force``.

    Legs are taken as massless.

    Args:
        jacobian_m: d foot / d joint angle, (..., N, 3, J) [m/rad].
        force_n: Ground's force on each foot, (..., N, 3) [N].

    Returns:
        (..., J) [N m].
    """
    torque: FloatArray = -np.einsum("...nij,...ni->...j", jacobian_m, force_n)
    return torque


def most_torque(cycle: GaitCycle, mu: FloatArray) -> FloatArray:
    """Return the largest torque that any friction force in the cone can ask of each joint, (F, J) [N m].

    Args:
        cycle: The cycle.
        mu: Friction of each foot, (N,).
    """
    lever = np.abs(cycle.jacobian_m)
    sideways = np.hypot(lever[..., 0, :], lever[..., 1, :])
    at_most = cycle.answer.load_n[..., None] * (lever[..., 2, :] + mu[:, None] * sideways)
    most: FloatArray = at_most.sum(axis=-2)
    return most


def swing_share(stance: BoolArray) -> FloatArray:
    """Return how far each swinging foot is through its swing, 0 to 1, (F, N); NaN in stance.

    Args:
        stance: Stance at even phases of one cycle, (F, N).
    """
    frames, count = stance.shape
    share = np.full(stance.shape, np.nan)
    for leg in range(count):
        down = stance[:, leg]
        if down.all() or not down.any():
            continue  # no swing, or nothing else
        first = int(np.flatnonzero(down & ~np.roll(down, -1))[0]) + 1  # a swing begins here
        turned = np.roll(down, -first)
        starts = np.flatnonzero(~turned & np.roll(turned, 1))
        for start in starts:
            length = int(np.argmax(turned[start:])) if turned[start:].any() else frames - start
            inside = (np.arange(length) + 0.5) / length
            share[(first + start + np.arange(length)) % frames, leg] = inside
    return share
