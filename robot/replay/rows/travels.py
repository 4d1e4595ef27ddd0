"""How far goals and shafts turn over many ticks: as ``body_watch`` adds up, tick by tick, to the bit."""

import numpy as np

from model.compiled import NUMBER, compile_for, compiled, given, in_place, out
from model.values.arrays import FloatArray
from robot.config.safety import BodyLimits
from robot.control.body_watch import FOLLOWING_SHARE, Travel


def travelled(
    travels: tuple[Travel, ...], goal_rad: FloatArray, joints: tuple[FloatArray, FloatArray],
    fade: FloatArray, limits: BodyLimits,
) -> tuple[int, tuple[Travel, ...]]:  # fmt: skip
    """Add up travels, up to the first tick in which a shaft does not follow its goal.

    Args:
        travels: Before the first tick, N of them.
        goal_rad: Goals, (T, N).
        joints: Shafts' angles [rad] and currents [A], (T, N) each, all known.
        fade: What is left of a sum after each tick, (T,).
        limits: When a shaft does not follow.

    Returns:
        How many ticks there are up to that one, and the travels after the last of them.
    """
    table = np.array(travels, dtype=np.float64)
    compile_for(_add_up, *given(2, 2, 2, 1), NUMBER, NUMBER, NUMBER, *out(2, 2))
    count = _add_up(
        np.ascontiguousarray(goal_rad), np.ascontiguousarray(joints[0]),
        np.ascontiguousarray(joints[1]), fade,
        float(limits.stall_current), float(limits.stall_travel), FOLLOWING_SHARE, table,
        np.empty_like(table),
    )  # fmt: skip
    return int(count), tuple(Travel(*row) for row in table.tolist())


@in_place
@compiled
def _add_up(
    goal_rad: FloatArray, angle_rad: FloatArray, current_a: FloatArray, fade: FloatArray,
    stall_current: float, stall_travel: float, share: float, travels: FloatArray, room: FloatArray,
) -> int:  # fmt: skip
    """Write the travels after so many ticks as it returns; a row of both is a ``Travel``."""
    for k in range(len(fade)):
        for leg in range(travels.shape[0]):
            goal, angle = goal_rad[k, leg], angle_rad[k, leg]
            step, turned = goal - travels[leg, 0], angle - travels[leg, 1]
            step = step if np.isfinite(step) else 0.0
            turned = turned if np.isfinite(turned) else 0.0
            along = turned if step > 0 else -turned if step < 0 else 0.0
            load = travels[leg, 4] * fade[k] + abs(current_a[k, leg]) * (1.0 - fade[k])
            goal_travel = travels[leg, 2] * fade[k] + abs(step)
            shaft_travel = travels[leg, 3] * fade[k] + along
            room[leg, 0], room[leg, 1] = goal, angle
            room[leg, 2], room[leg, 3], room[leg, 4] = goal_travel, shaft_travel, load
            works = load > stall_current and goal_travel > stall_travel
            if works and shaft_travel < share * goal_travel:
                return k
        for leg in range(travels.shape[0]):
            for i in range(travels.shape[1]):
                travels[leg, i] = room[leg, i]
    return len(fade)
