"""Where each effect of a robot file acts: in the controller's model, in readings, or only in the device.

``gap`` adds every effect to its chain, ``sim`` every effect to the virtual robot. A controller is fed
measured shafts, so what lies between command and shaft has happened already when it looks; and what
cameras make of the truth it never sees.
"""

import sys
from collections.abc import Sequence
from enum import Enum
from types import MappingProxyType
from typing import TYPE_CHECKING

from robot.config.robot_file import RobotConfig

if TYPE_CHECKING:
    from gap.interfaces import Cause


class Use(Enum):
    """What the controller and the odometry do with an effect."""

    MODEL = "added to the model"
    READING = "taken out of the reading"
    SEEN = "seen by the encoders: nothing to add"
    LATE = "not undone: a reading cannot be had before it comes"
    CAMERAS = "of motion capture, which the controller does not use"


_GROUPS = {
    Use.MODEL: """shaft_zero_offset link_length leg_flex ground_stiffness leg_length ground_slope
        ground_step com_offset payload chassis_twist coulomb_friction stiction friction_patch foot_rolling
        tilt_coupling inertia_lag tether_force drag leg_stiffness foot_friction friction_level
        friction_anisotropy hip_mount_offset""",
    Use.READING: "force_gain force_bias force_drift force_rotation encoder_scale",
    Use.SEEN: "command_delay servo_lag servo_speed_limit servo_compliance gear_backlash",
    Use.LATE: "force_delay force_lowpass",
    Use.CAMERAS: "pose_delay pose_yaw_offset pose_origin_offset clock_skew",
}
USES = MappingProxyType({name: use for use, names in _GROUPS.items() for name in names.split()})


def unused_notes(causes: "Sequence[Cause]") -> tuple[str, ...]:
    """Say of each effect that the controller's model does not use why, in one line."""
    return tuple(
        f"effect {cause.effect} of the robot file is not in the model here: {USES[cause.effect].value}"
        for cause in causes
        if USES[cause.effect] in {Use.SEEN, Use.LATE, Use.CAMERAS}
    )


def say_unused(config: RobotConfig) -> None:
    """Print, on stderr, which effects of a robot file the controller's model does not use."""
    for note in unused_notes(config.effects):
        print(f"note: {note}", file=sys.stderr)
