"""Which effects of the catalogue a healthy robot of a reality has, because it is built so.

A diagnosis without references names what the simulator lacks on a robot, healthy or not. Whether it was
right to in a healthy one is judged by this, and by what healthy runs show beyond it: another law of the
servos looks like a delay, and how it looks is not written in how it is built.
"""

import numpy as np

from sim_hw.plant.structure import LoopKind
from sim_hw.realities.reality import Reality

# MuJoCo's feet slide by Coulomb's law, legs give along the ground, a loop follows with a lag, gears rub
EVERY_ROBOT = frozenset({"coulomb_friction", "joint_friction", "leg_flex", "servo_lag"})


def own_effects(reality: Reality) -> frozenset[str]:
    """Return the names of the effects of its healthy robots, whatever their size."""
    unequal, gears, surface = reality.unequal, reality.gears, reality.surface
    there = {
        "gear_backlash": gears.backlash_rad > 0.0,
        # without an integral a loop holds a load only by an error: 0.018 rad/N m and more
        "servo_compliance": gears.compliance_rad_per_nm > 0.0
        or reality.loop.kind is LoopKind.POSITION,
        "stiction": surface.static_ratio > 1.0,
        "ground_stiffness": bool(np.isfinite(surface.give_n_per_m)),
        "foot_rolling": surface.rolling_m > 0.0,
        "chassis_twist": reality.twist_rad_per_nm > 0.0,
        "leg_stiffness": unequal.stiffness > 0.0,
        "foot_friction": unequal.mu > 0.0,
        "leg_length": unequal.length_m > 0.0,
        "link_length": unequal.link_m > 0.0,
        "hip_mount_offset": unequal.mount_m > 0.0,
        "force_lowpass": reality.sensing.filter_s > 0.0,
        "marker_on_shank": reality.sensing.marker_share < 1.0,
        "pose_delay": reality.sensing.pose_delay_s > 0.0,
    }
    return EVERY_ROBOT | {name for name, one in there.items() if one}
