"""What is wrong with a robot, as numbers of the simulator."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from benchmarks.gap.apart.layout import JOINTS, LEGS, FloatArray


class Payload(NamedTuple):
    """A box on the trunk."""

    mass_kg: float
    x_m: float
    y_m: float


class Brownout(NamedTuple):
    """A servo with nearly no torque for a while in every period."""

    period_s: float
    weak_s: float


class MarkerJump(NamedTuple):
    """A plate of markers that is knocked, up to 2 s after ``earliest_s``."""

    earliest_s: float
    x_m: float
    yaw_rad: float


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong; nothing, if nothing is given.

    Attributes:
        place: Joint or leg that it is at; empty for the whole robot.
        servo_lag_s: Time constant of a low pass between a joint's command and the goal of its loop.
        command_delay_s: Between all commands and the goals.
        position_gain_ratio: Of a joint's position loop.
        dry_friction_nm: At a joint, more than a healthy one has.
        joint_zero_rad: Angle of a joint where its encoder says zero.
        encoder_ratio: Recorded angle over the encoder's angle.
        foot_friction_ratio: Of a leg's foot, or of all.
        shank_stiffness_ratio: Of a leg's rubber shank.
        leg_length_m: More length of a leg's shank.
        hip_offset_m: Of a leg's hip, (x, y) in the trunk.
        force_ratio: Recorded force of a leg over that of its sensor.
        suction_n: Pull of the floor at a foot that is less than 6 mm above it.
        pose_delay_s: Of the recorded pose.
        marker_yaw_rad: Yaw of the markers on the trunk.
    """

    place: str = ""
    servo_lag_s: float = 0.0
    command_delay_s: float = 0.0
    position_gain_ratio: float = 1.0
    dry_friction_nm: float = 0.0
    joint_zero_rad: float = 0.0
    encoder_ratio: float = 1.0
    foot_friction_ratio: float = 1.0
    shank_stiffness_ratio: float = 1.0
    leg_length_m: float = 0.0
    hip_offset_m: tuple[float, float] = (0.0, 0.0)
    force_ratio: float = 1.0
    suction_n: float = 0.0
    pose_delay_s: float = 0.0
    marker_yaw_rad: float = 0.0
    payload: Payload | None = None
    brownout: Brownout | None = None
    marker_jump: MarkerJump | None = None

    def at_joints(self, value: float, healthy: float) -> FloatArray:
        """Return ``value`` at the joint of the fault (at all, if it has no place), (12,)."""
        return self._at(JOINTS, value, healthy)

    def at_legs(self, value: float, healthy: float) -> FloatArray:
        """Return ``value`` at the leg of the fault (at all, if it has no place), (6,)."""
        return self._at(LEGS, value, healthy)

    def _at(self, names: tuple[str, ...], value: float, healthy: float) -> FloatArray:
        return np.array([value if self.place in {"", name} else healthy for name in names])


HEALTHY = Fault()
