"""The watch over body and shafts: leaning, stalled shafts, slipping away, feet that carry nothing.

Pure: what it remembers goes in and comes out. Each limit is a key of the robot file (``[safety]``), each
must be exceeded for a while, and nothing is judged from what is absent.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import atan, atan2, dist, hypot, inf

import numpy as np

from model.values.arrays import BoolArray, FloatArray, readonly
from model.values.contact import ContactSolution
from model.values.faults import Fault, FaultKind, StopReason
from model.values.legs import FootForces, JointCommand, JointState
from model.values.tick import DeadReckoning, Mode
from robot.config.safety import BodyLimits
from robot.control.body_watch_kernel import ROWS, way_kernel

# A shaft that goes less than this share of its goal's way does not follow.
FOLLOWING_SHARE = 0.25
NOWHERE = readonly(np.full(2, np.nan))
STANDING = frozenset({Mode.ARMED, Mode.HOLD})
REASONS = (
    (FaultKind.TILTED, StopReason.TILTED),
    (FaultKind.SERVO_STALLED, StopReason.SERVO_STALLED),
    (FaultKind.SLIPPED, StopReason.SLIPPED),
    (FaultKind.UNLOADED, StopReason.UNLOADED),
)


@dataclass(frozen=True, slots=True, eq=False)
class BodyMemory:
    """What the watch remembers.

    Attributes:
        t_ns: Time of the tick before, -1 if there was none.
        goal_rad: Goals of the tick before, (N,).
        angle_rad: Latest known shaft angles, (N,).
        goal_way_rad: Way of the goals, fading with the stall time, (N,).
        shaft_way_rad: Way of the shafts in the goals' direction, fading in the same way, (N,).
        load_a: Current against which the shaft works, fading in the same way, (N,).
        tilted_s: How long the body has leaned too far.
        unloaded_s: How long the feet have carried too little.
        standing_at_m: Where dead reckoning was when the robot came to stand, (2,); NaN while it moves.
    """

    t_ns: int
    goal_rad: FloatArray
    angle_rad: FloatArray
    goal_way_rad: FloatArray
    shaft_way_rad: FloatArray
    load_a: FloatArray
    tilted_s: float
    unloaded_s: float
    standing_at_m: FloatArray

    @staticmethod
    def empty(count: int) -> "BodyMemory":
        """Return the memory before the first tick."""
        nan, zero = np.full(count, np.nan), np.zeros(count)
        return BodyMemory(-1, nan, nan, zero, zero, zero, 0.0, 0.0, np.full(2, np.nan))


@dataclass(frozen=True, slots=True, eq=False)
class BodySeen:
    """What the watch looks at in one tick.

    Attributes:
        t_ns: Time of the tick.
        mode: Mode of the tick before.
        joints: Calibrated shaft state.
        sent: The command that the servos were following.
        forces: Latest measured foot forces.
        contact: The model's answer for this tick.
        dead_reckoning: That of the tick before; the run began at (0, 0).
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
    memory: BodyMemory, seen: BodySeen, limits: BodyLimits, names: Sequence[str]
) -> tuple[BodyMemory, tuple[Fault, ...]]:
    """Compare one tick with the limits.

    Args:
        memory: What was remembered.
        seen: What there is to see.
        limits: Limits.
        names: Leg names.

    Returns:
        What is to be remembered, and the faults.
    """
    dt_s = 0.0 if memory.t_ns < 0 else max(0.0, (seen.t_ns - memory.t_ns) * 1e-9)
    if not seen.sent.torque:  # nobody answers for a robot without torque
        return replace(BodyMemory.empty(len(names)), t_ns=seen.t_ns), ()
    memory, stalled = _stalled(memory, seen, limits, names, dt_s)
    summed = _summed(seen)
    tilt, of = _tilt(seen, summed)
    tilted_s = memory.tilted_s + dt_s if tilt > limits.max_tilt else 0.0
    load_n = hypot(*summed) if summed is not None else inf
    unloaded_s = memory.unloaded_s + dt_s if load_n < limits.min_load * seen.weight_n else 0.0
    standing_at_m = _standing_at(memory, seen)
    faults = [*stalled]
    if tilted_s >= limits.tilt_time:
        detail = f"leans {tilt:.2f} rad by {of}, limit {limits.max_tilt:g} rad"
        faults.append(Fault(FaultKind.TILTED, "body", detail))
    faults += _slipped(seen, standing_at_m, limits)
    if unloaded_s >= limits.unloaded_time:
        share = f"{load_n:.1f} N of {seen.weight_n:.1f} N"
        detail = f"all feet together carry {share}: lifted, hanging or fallen"
        faults.append(Fault(FaultKind.UNLOADED, "body", detail))
    after = BodyMemory(
        seen.t_ns, memory.goal_rad, memory.angle_rad, memory.goal_way_rad, memory.shaft_way_rad,
        memory.load_a, tilted_s, unloaded_s, standing_at_m,
    )  # fmt: skip
    return after, tuple(faults)


def stop_reason_of(faults: Sequence[Fault]) -> StopReason:
    """Return the reason to stop that is in the watch's faults, NONE if there is none."""
    kinds = {fault.kind for fault in faults}
    return next((reason for kind, reason in REASONS if kind in kinds), StopReason.NONE)


def _stalled(
    memory: BodyMemory, seen: BodySeen, limits: BodyLimits, names: Sequence[str], dt_s: float
) -> tuple[BodyMemory, list[Fault]]:
    """Compare the goals' way with the shafts' way over the stall time."""
    joints, contiguous = seen.joints, np.ascontiguousarray
    known = joints.valid
    rows = np.empty((ROWS, len(known)))
    way_kernel(
        contiguous(seen.sent.angle_rad), contiguous(joints.angle_rad), contiguous(joints.current_a),
        contiguous(known), contiguous(seen.down), memory.goal_rad, memory.angle_rad,
        memory.goal_way_rad, memory.shaft_way_rad, memory.load_a,
        float(np.exp(-dt_s / limits.stall_time)), rows,
    )  # fmt: skip
    goal, angle, goal_way, shaft_way, load_a = rows
    faults = []
    if (load_a > limits.stall_current).any():
        each = zip(
            names, known.tolist(), goal_way.tolist(), shaft_way.tolist(), load_a.tolist(),
            strict=True,
        )  # fmt: skip
        faults = [
            Fault(
                FaultKind.SERVO_STALLED,
                name,
                f"its goal moved {wanted:.2f} rad and its shaft {went:.2f} rad at "
                f"{load:.1f} A, limit {limits.stall_current:g} A",
            )
            for name, heard, wanted, went, load in each
            if heard and wanted > limits.stall_travel and went < FOLLOWING_SHARE * wanted
            and load > limits.stall_current
        ]  # fmt: skip
    after = BodyMemory(
        memory.t_ns, goal, angle, goal_way, shaft_way, load_a,
        memory.tilted_s, memory.unloaded_s, memory.standing_at_m,
    )  # fmt: skip
    return after, faults


def _summed(seen: BodySeen) -> list[float] | None:
    """Return the sum of the forces on all feet, x, y, z [N]; None where that cannot be known."""
    if not all(seen.sensors) or False in seen.forces.valid.tolist():
        return None
    summed: list[float] = seen.forces.force_n.sum(axis=0).tolist()
    return summed


def _tilt(seen: BodySeen, summed: list[float] | None) -> tuple[float, str]:
    """Return the larger of two leans [rad] and what it comes from; -1 if neither is known.

    Args:
        seen: What there is to see.
        summed: Forces on all feet together [N], if known.
    """
    leans = [(-1.0, "nothing")]
    support = seen.contact.support
    if support.converged:
        lean = atan(hypot(support.slope_x, support.slope_y))
        leans.append((lean, "the model's support"))
    if summed is not None:
        # inner forces between the feet cancel: what is left points where gravity does not pull
        x, y, z = summed
        if hypot(x, y, z) > 0.5 * seen.weight_n:
            leans.append((atan2(hypot(x, y), z), "the sum of measured forces"))
    return max(leans)


def _standing_at(memory: BodyMemory, seen: BodySeen) -> FloatArray:
    if seen.mode not in STANDING:
        return NOWHERE
    known = bool(np.isfinite(memory.standing_at_m).all())
    return memory.standing_at_m if known else seen.dead_reckoning.position_m


def _slipped(seen: BodySeen, standing_at_m: FloatArray, limits: BodyLimits) -> list[Fault]:
    faults = []
    way_m = dist(seen.dead_reckoning.position_m.tolist(), standing_at_m.tolist())
    if way_m > limits.max_slip:  # False where it does not stand: NaN
        detail = f"moved {way_m:.3f} m while it should stand, limit {limits.max_slip:g} m"
        faults.append(Fault(FaultKind.SLIPPED, "body", detail))
    distance_m = hypot(*seen.dead_reckoning.position_m.tolist())
    if distance_m > limits.max_distance:
        detail = f"is {distance_m:.2f} m from where it began, limit {limits.max_distance:g} m"
        faults.append(Fault(FaultKind.SLIPPED, "body", detail))
    return faults
