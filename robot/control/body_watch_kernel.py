"""How far goals and shafts have gone, compiled: the watch's arithmetic on every leg in every tick."""

import numpy as np

from model.compiled import FLAG, NUMBER, compile_for, compiled, given, out
from model.values.arrays import BoolArray, FloatArray

# Rows of what is remembered.
GOAL, ANGLE, GOAL_WAY, SHAFT_WAY, LOAD, ROWS = range(6)


@compiled
def way_kernel(
    sent_rad: FloatArray,
    angle_rad: FloatArray,
    current_a: FloatArray,
    known: BoolArray,
    down: BoolArray,
    goal_before: FloatArray,
    angle_before: FloatArray,
    goal_way: FloatArray,
    shaft_way: FloatArray,
    load_a: FloatArray,
    fade: float,
    rows: FloatArray,
) -> None:
    """Add a tick to the ways of goals and shafts and to the current, all of which fade.

    Args:
        sent_rad: Angles sent, (N,).
        angle_rad: Shaft angles, (N,).
        current_a: Motor currents, (N,) [A].
        known: Legs whose servos answered; goal and shaft of the others wait where they were, (N,).
        down: Legs without torque: they follow nothing, and begin anew afterwards, (N,).
        goal_before: What was remembered, (N,), with the next four.
        angle_before: (N,).
        goal_way: (N,) [rad].
        shaft_way: (N,) [rad].
        load_a: (N,) [A].
        fade: What is left of a way after the tick.
        rows: Out: GOAL to LOAD, (ROWS, N).
    """
    for k in range(known.size):
        goal = sent_rad[k] if known[k] else goal_before[k]
        angle = angle_rad[k] if known[k] else angle_before[k]
        load = abs(current_a[k]) if known[k] else load_a[k]
        left = fade
        if down[k]:
            goal, load, left = np.nan, 0.0, 0.0
        step, turned = goal - goal_before[k], angle - angle_before[k]
        # where a goal or an angle is not known there is no way
        step = step if np.isfinite(step) else 0.0
        turned = turned if np.isfinite(turned) else 0.0
        rows[GOAL, k], rows[ANGLE, k] = goal, angle
        rows[GOAL_WAY, k] = goal_way[k] * left + abs(step)
        rows[SHAFT_WAY, k] = shaft_way[k] * left + turned * np.sign(step)
        rows[LOAD, k] = load_a[k] * left + load * (1.0 - left)


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    flags = given(1, 1, kind=FLAG)
    compile_for(way_kernel, *given(1, 1, 1), *flags, *given(1, 1, 1, 1, 1), NUMBER, *out(2))
