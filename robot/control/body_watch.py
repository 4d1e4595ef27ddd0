"""The watch over body and shafts: leaning, stalled shafts, slipping away, feet that carry nothing.

Pure: what it remembers goes in and comes out. Each limit is a key of the robot file (``[safety]``), each
must be exceeded for a while, and nothing is judged from what is absent.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import atan, atan2, dist, exp, hypot, inf, isfinite, nan
from typing import NamedTuple

import numpy as np

from model.values.arrays import BoolArray, FloatArray, readonly
from model.values.contact import ContactSolution
from model.values.faults import Fault, FaultKind
from model.values.legs import FootForces, JointCommand, JointState
from model.values.quick import quick
from model.values.tick import DeadReckoning, Mode
from robot.config.safety import BodyLimits

# A shaft that turns less than this share of its goal's travel does not follow.
FOLLOWING_SHARE = 0.25
NOWHERE = readonly(np.full(2, np.nan))
STANDING = frozenset({Mode.ARMED, Mode.HOLD})


class Travel(NamedTuple):
    """How far the goal of one shaft and the shaft itself have turned; all sums fade with the stall time.

    Attributes:
        goal_rad: Goal of the tick before.
        angle_rad: Latest known shaft angle.
        goal_travel_rad: Travel of the goal, either way.
        shaft_travel_rad: Travel of the shaft in the goal's direction.
        load_a: Current against which the shaft works.
    """

    goal_rad: float = nan
    angle_rad: float = nan
    goal_travel_rad: float = 0.0
    shaft_travel_rad: float = 0.0
    load_a: float = 0.0


@quick
@dataclass(frozen=True, slots=True, eq=False)
class BodyMemory:
    """What the watch remembers.

    Attributes:
        t_ns: Time of the tick before, -1 if there was none.
        travels: Of each leg, N of them.
        tilted_s: How long the body has leaned too far.
        unloaded_s: How long the feet have carried too little.
        standing_at_m: Where dead reckoning was when the robot came to stand, (2,); NaN while it moves.
    """

    t_ns: int
    travels: tuple[Travel, ...]
    tilted_s: float
    unloaded_s: float
    standing_at_m: FloatArray

    @staticmethod
    def empty(count: int) -> "BodyMemory":
        """Return the memory before the first tick."""
        return BodyMemory(-1, (Travel(),) * count, 0.0, 0.0, NOWHERE)


@quick
@dataclass(frozen=True, slots=True, eq=False)
class BodyInputs:
    """What the watch looks at in one tick.

    Attributes:
        t_ns: Time of the tick.
        mode: Mode of the tick before.
        joints: Calibrated shaft state.
        sent: The command that the servos were following.
        forces: Latest measured foot forces.
        contact: The model's answer for this tick.
        dead_reckoning: Dead reckoning of the tick before; the run began at (0, 0).
        weight_n: The robot's weight [N].
        sensors: Legs with a force sensor, (N,) bool.
        down: Legs whose servos have lost their torque, (N,) bool.
    """

    t_ns: int
    mode: Mode
    joints: JointState
    sent: JointCommand
    forces: FootForces
    contact: ContactSolution
    dead_reckoning: DeadReckoning
    weight_n: float
    sensors: Sequence[bool]
    down: BoolArray


def watch_body(
    memory: BodyMemory, inputs: BodyInputs, limits: BodyLimits, names: Sequence[str]
) -> tuple[BodyMemory, tuple[Fault, ...]]:
    """Compare one tick with the limits.

    Args:
        memory: What was remembered.
        inputs: What is known.
        limits: Limits.
        names: Leg names.

    Returns:
        What is to be remembered, and the faults.
    """
    dt_s = 0.0 if memory.t_ns < 0 else max(0.0, (inputs.t_ns - memory.t_ns) * 1e-9)
    if not inputs.sent.torque:  # a robot without torque may lie as it likes
        return replace(BodyMemory.empty(len(names)), t_ns=inputs.t_ns), ()
    travels = _travels(memory, inputs, exp(-dt_s / limits.stall_time))
    total_n = _total_force(inputs)
    tilt, source = _tilt(inputs, total_n)
    tilted_s = memory.tilted_s + dt_s if tilt > limits.max_tilt else 0.0
    load_n = hypot(*total_n) if total_n is not None else inf
    unloaded_s = memory.unloaded_s + dt_s if load_n < limits.min_load * inputs.weight_n else 0.0
    standing_at_m = _standing_at(memory, inputs)
    faults = _stalled(travels, inputs.joints, limits, names)
    if tilted_s >= limits.tilt_time:
        detail = f"leans {tilt:.2f} rad by {source}, limit {limits.max_tilt:g} rad"
        faults.append(Fault(FaultKind.TILTED, "body", detail))
    faults += _slipped(inputs, standing_at_m, limits)
    if unloaded_s >= limits.unloaded_time:
        share = f"{load_n:.1f} N of {inputs.weight_n:.1f} N"
        detail = f"all feet together carry {share}: lifted, hanging or fallen"
        faults.append(Fault(FaultKind.UNLOADED, "body", detail))
    after = BodyMemory(inputs.t_ns, travels, tilted_s, unloaded_s, standing_at_m)
    return after, tuple(faults)


def _travels(memory: BodyMemory, inputs: BodyInputs, fade: float) -> tuple[Travel, ...]:
    """Add a tick to the travels; half a dozen legs are sooner done one by one than as arrays.

    Args:
        memory: What was remembered.
        inputs: What is known. A servo that did not answer waits where it was; one without torque follows
            nothing and starts from zero afterwards.
        fade: What is left of a sum after the tick.
    """
    joints = inputs.joints
    legs = zip(
        memory.travels, inputs.sent.angle_rad.tolist(), joints.angle_rad.tolist(),
        joints.current_a.tolist(), joints.valid.tolist(), inputs.down.tolist(), strict=True,
    )  # fmt: skip
    travels = []
    for before, sent_rad, measured_rad, current_a, known, down in legs:
        goal_rad = sent_rad if known else before.goal_rad
        angle_rad = measured_rad if known else before.angle_rad
        if down:
            travels.append(Travel(angle_rad=angle_rad))
            continue
        load_a = abs(current_a) if known else before.load_a
        step, turned = goal_rad - before.goal_rad, angle_rad - before.angle_rad
        # where a goal or an angle is not known there is no travel
        step = step if isfinite(step) else 0.0
        turned = turned if isfinite(turned) else 0.0
        along = turned if step > 0 else -turned if step < 0 else 0.0
        travels.append(Travel(
            goal_rad,
            angle_rad,
            before.goal_travel_rad * fade + abs(step),
            before.shaft_travel_rad * fade + along,
            before.load_a * fade + load_a * (1.0 - fade),
        ))  # fmt: skip
    return tuple(travels)


def _stalled(
    travels: Sequence[Travel], joints: JointState, limits: BodyLimits, names: Sequence[str]
) -> list[Fault]:
    """Find shafts that did not follow their goals although they worked for it."""
    return [
        Fault(
            FaultKind.SERVO_STALLED,
            name,
            f"its goal moved {leg.goal_travel_rad:.2f} rad and its shaft {leg.shaft_travel_rad:.2f} "
            f"rad at {leg.load_a:.1f} A, limit {limits.stall_current:g} A",
        )
        for name, known, leg in zip(names, joints.valid.tolist(), travels, strict=True)
        if leg.load_a > limits.stall_current
        and known
        and leg.goal_travel_rad > limits.stall_travel
        and leg.shaft_travel_rad < FOLLOWING_SHARE * leg.goal_travel_rad
    ]


def _total_force(inputs: BodyInputs) -> list[float] | None:
    """Return the sum of the forces on all feet, x, y, z [N]; None where that cannot be known."""
    if not all(inputs.sensors) or False in inputs.forces.valid.tolist():
        return None
    x, y, z = 0.0, 0.0, 0.0
    for fx, fy, fz in inputs.forces.force_n.tolist():
        x, y, z = x + fx, y + fy, z + fz
    return [x, y, z]


def _tilt(inputs: BodyInputs, total_n: list[float] | None) -> tuple[float, str]:
    """Return the larger of two leans [rad] and what it comes from; -1 if neither is known.

    Args:
        inputs: What is known.
        total_n: Forces on all feet together [N], if known.
    """
    leans = [(-1.0, "nothing")]
    support = inputs.contact.support
    if support.converged:
        lean = atan(hypot(support.slope_x, support.slope_y))
        leans.append((lean, "the model's support"))
    if total_n is not None:
        # inner forces between the feet cancel: what is left points where gravity does not pull
        x, y, z = total_n
        if hypot(x, y, z) > 0.5 * inputs.weight_n:
            leans.append((atan2(hypot(x, y), z), "the sum of measured forces"))
    return max(leans)


def _standing_at(memory: BodyMemory, inputs: BodyInputs) -> FloatArray:
    if inputs.mode not in STANDING:
        return NOWHERE
    known = bool(np.isfinite(memory.standing_at_m).all())
    return memory.standing_at_m if known else inputs.dead_reckoning.position_m


def _slipped(inputs: BodyInputs, standing_at_m: FloatArray, limits: BodyLimits) -> list[Fault]:
    faults = []
    moved_m = dist(inputs.dead_reckoning.position_m.tolist(), standing_at_m.tolist())
    if moved_m > limits.max_slip:  # False where it does not stand: NaN
        detail = f"moved {moved_m:.3f} m while it should stand, limit {limits.max_slip:g} m"
        faults.append(Fault(FaultKind.SLIPPED, "body", detail))
    distance_m = hypot(*inputs.dead_reckoning.position_m.tolist())
    if distance_m > limits.max_distance:
        detail = f"is {distance_m:.2f} m from where it began, limit {limits.max_distance:g} m"
        faults.append(Fault(FaultKind.SLIPPED, "body", detail))
    return faults
