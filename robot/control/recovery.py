"""Bounded recovery, the controller's half: when to wait, when to ask, when to go on, when to give up.

Pure. A servo that lost its torque (or, for a while, its voice) makes the robot slow down and hold where it
is. Once it holds, the step asks for one servo at a time to be brought back; the loop does that through the
bus (``drivers.dynamixel.recovery``), and what came of it is among the next tick's inputs as a fault:
``SERVO_RECOVERED`` or ``RECOVERY_FAILED``. Without ``[safety.recovery]`` in the robot file all of this
stops the robot instead.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.values.arrays import BoolArray, IntArray
from model.values.faults import Fault, FaultKind, StopReason
from robot.config.safety import RecoverySettings
from robot.control.safety import ServoVerdict


@dataclass(frozen=True, slots=True, eq=False)
class RecoveryMemory:
    """What is remembered from one tick to the next.

    Attributes:
        down: Servos without torque, (N,) bool.
        back: Servos brought back since the robot holds, (N,) bool.
        paused: Whether the robot holds, or is about to, for a servo's sake.
        attempts: When a recovery was asked for, within the window [ns].
    """

    down: BoolArray
    back: BoolArray
    paused: bool
    attempts: tuple[int, ...]

    @staticmethod
    def empty(count: int) -> "RecoveryMemory":
        """Return the memory before the first tick."""
        none = np.zeros(count, dtype=bool)
        return RecoveryMemory(none, none, False, ())


@dataclass(frozen=True, slots=True, eq=False)
class Care:
    """What is to be done in one tick.

    Attributes:
        memory: What is to be remembered.
        pause: The robot has to hold where it is.
        ask: Legs to be brought back now.
        resume: The robot may go on: legs to be taken up where they were measured, (N,) bool. None if not.
        stop: Why the robot has to stop, NONE if it has not.
        faults: In words.
    """

    memory: RecoveryMemory
    pause: bool
    ask: tuple[int, ...]
    resume: BoolArray | None
    stop: StopReason
    faults: tuple[Fault, ...]


def legs_down(memory: RecoveryMemory, faults: Sequence[Fault], names: Sequence[str]) -> BoolArray:
    """Return the servos without torque, (N,) bool, with what this tick's faults say of them."""
    down = memory.down.copy()
    for fault in faults:
        if fault.kind in {FaultKind.SERVO_DOWN, FaultKind.SERVO_RECOVERED}:
            down[list(names).index(fault.source)] = fault.kind is FaultKind.SERVO_DOWN
    return down


@dataclass(frozen=True, slots=True, eq=False)
class CareSeen:
    """What the decision is made from.

    Attributes:
        t_ns: Time of the tick.
        faults: Faults among the inputs.
        verdict: What the watch found.
        valid: Servos that answered, (N,) bool.
        age_ns: Time since each servo's last answer, (N,); -1 if there never was one.
        holding: Whether the robot stands where it was stopped.
        torque: Whether torque has been asked for.
    """

    t_ns: int
    faults: Sequence[Fault]
    verdict: ServoVerdict
    valid: BoolArray
    age_ns: IntArray
    holding: bool
    torque: bool


def care(
    memory: RecoveryMemory, seen: CareSeen, settings: RecoverySettings, names: Sequence[str]
) -> Care:
    """Decide what to do about servos that are silent, broken or without torque.

    Args:
        memory: What was remembered.
        seen: What there is to see.
        settings: What is allowed.
        names: Leg names.
    """
    if _nothing_to_do(memory, seen):
        return Care(memory, False, (), None, StopReason.NONE, ())
    down = legs_down(memory, seen.faults, names)
    back = memory.back | (memory.down & ~down)
    lost = seen.verdict.lost_legs
    stop = _stop(seen, settings, down, lost)
    if stop is not StopReason.NONE or settings.most == 0 or not seen.torque:
        kept = RecoveryMemory(down, back, False, memory.attempts)
        return Care(kept, False, (), None, stop, ())
    troubled = bool((down | lost).any())
    pause = troubled or (memory.paused and not (seen.holding and seen.valid.all()))
    if not pause:
        none = np.zeros_like(down)
        resume = back if memory.paused else None
        kept = RecoveryMemory(down, none, False, memory.attempts)
        return Care(kept, False, (), resume, StopReason.NONE, ())
    ready = memory.paused and seen.holding and not lost.any()
    candidates = np.flatnonzero(down & seen.valid) if ready else np.zeros(0, dtype=np.int64)
    kept = RecoveryMemory(down, back, True, memory.attempts)
    if not len(candidates):
        return Care(kept, True, (), None, StopReason.NONE, ())
    return _ask(kept, int(candidates[0]), seen.t_ns, settings, names)


def _nothing_to_do(memory: RecoveryMemory, seen: CareSeen) -> bool:
    """Whether every servo is well and was before: so it is in nearly every tick."""
    found = (memory.down, memory.back, seen.verdict.lost_legs, seen.verdict.broken_legs)
    return not (memory.paused or seen.faults or any(True in legs.tolist() for legs in found))


def _stop(
    seen: CareSeen, settings: RecoverySettings, down: BoolArray, lost: BoolArray
) -> StopReason:
    """Return why nothing can be waited for, NONE if it can."""
    allowed = settings.most > 0 and seen.torque
    waited = (seen.age_ns < 0) | (seen.age_ns > settings.wait * 1e9)
    if (lost & waited).any() or (lost.any() and not allowed):
        return StopReason.SERVO_LOST
    failed = any(fault.kind is FaultKind.RECOVERY_FAILED for fault in seen.faults)
    if failed or (seen.verdict.broken_legs & ~down).any() or (down.any() and not allowed):
        return StopReason.SERVO_FAULT
    return StopReason.NONE


def _ask(
    memory: RecoveryMemory, leg: int, t_ns: int, settings: RecoverySettings, names: Sequence[str]
) -> Care:
    recent = tuple(t for t in memory.attempts if t_ns - t < settings.window * 1e9)
    bound = f"of {settings.most} within {settings.window:g} s"
    if len(recent) >= settings.most:
        detail = f"{len(recent)} recoveries {bound} are used up"
        failed = Fault(FaultKind.RECOVERY_FAILED, names[leg], detail)
        return Care(memory, True, (), None, StopReason.SERVO_FAULT, (failed,))
    asked = RecoveryMemory(memory.down, memory.back, True, (*recent, t_ns))
    detail = f"is to be brought back where it stands, {len(recent) + 1} {bound}"
    fault = Fault(FaultKind.RECOVERING, names[leg], detail)
    return Care(asked, True, (leg,), None, StopReason.NONE, (fault,))
