"""Bounded recovery, the controller's half: when to wait, when to ask, when to go on, when to give up.

Pure. A servo that lost its torque (or, for a while, stays silent) makes the robot slow down and hold where
it is. Once it holds, the step asks for one servo at a time to be brought back (``Allowed.recover``); the
loop does that through the bus (``drivers.dynamixel.recovery``), and the result is among the next tick's
inputs as a ``ServoEvent``. Without ``[safety.recovery]`` in the robot file all of this stops the robot.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.values.arrays import BoolArray, IntArray
from model.values.faults import Fault, FaultKind, ServoEvent, StopReason
from model.values.quick import quick
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


@quick
@dataclass(frozen=True, slots=True, eq=False)
class RecoveryPlan:
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
    pause: bool = False
    ask: tuple[int, ...] = ()
    resume: BoolArray | None = None
    stop: StopReason = StopReason.NONE
    faults: tuple[Fault, ...] = ()


def legs_down(memory: RecoveryMemory, events: Sequence[ServoEvent]) -> BoolArray:
    """Return the servos without torque, (N,) bool, after this tick's events."""
    if not events:
        return memory.down
    down = memory.down.copy()
    for event in events:
        if event.kind is not FaultKind.RECOVERY_FAILED:
            down[event.leg] = event.kind is FaultKind.SERVO_DOWN
    return down


@quick
@dataclass(frozen=True, slots=True, eq=False)
class RecoveryInputs:
    """What the decision is made from.

    Attributes:
        t_ns: Time of the tick.
        events: What became of servos since the last tick.
        verdict: Of the watch over the servos.
        valid: Servos that answered, (N,) bool.
        age_ns: Time since each servo's last answer, (N,); -1 if there never was one.
        holding: Whether the robot stands where it was stopped.
        torque: Whether torque has been asked for.
    """

    t_ns: int
    events: Sequence[ServoEvent]
    verdict: ServoVerdict
    valid: BoolArray
    age_ns: IntArray
    holding: bool
    torque: bool


def plan_recovery(
    memory: RecoveryMemory,
    inputs: RecoveryInputs,
    settings: RecoverySettings,
    names: Sequence[str],
) -> RecoveryPlan:
    """Decide what to do about servos that are silent, broken or without torque.

    Args:
        memory: What was remembered.
        inputs: What is known.
        settings: What is allowed.
        names: Leg names.
    """
    if _nothing_to_do(memory, inputs):
        return RecoveryPlan(memory)
    down = legs_down(memory, inputs.events)
    back = memory.back | (memory.down & ~down)
    lost = inputs.verdict.lost_legs
    stop = _stop(inputs, settings, down, lost)
    if stop is not StopReason.NONE or settings.most == 0 or not inputs.torque:
        return RecoveryPlan(RecoveryMemory(down, back, False, memory.attempts), stop=stop)
    troubled = bool((down | lost).any())
    if not troubled and not (memory.paused and not (inputs.holding and inputs.valid.all())):
        none = np.zeros_like(down)
        resume = back if memory.paused else None
        return RecoveryPlan(RecoveryMemory(down, none, False, memory.attempts), resume=resume)
    paused = RecoveryMemory(down, back, True, memory.attempts)
    ready = memory.paused and inputs.holding and not lost.any()
    candidates = np.flatnonzero(down & inputs.valid).tolist() if ready else []
    if not candidates:
        return RecoveryPlan(paused, pause=True)
    return _ask(paused, candidates[0], inputs.t_ns, settings, names)


def _nothing_to_do(memory: RecoveryMemory, inputs: RecoveryInputs) -> bool:
    """Whether every servo is well and was before, as in nearly every tick."""
    legs = (memory.down, memory.back, inputs.verdict.lost_legs, inputs.verdict.broken_legs)
    return not (memory.paused or inputs.events or any(True in each.tolist() for each in legs))


def _stop(
    inputs: RecoveryInputs, settings: RecoverySettings, down: BoolArray, lost: BoolArray
) -> StopReason:
    """Return why nothing can be waited for, NONE if it can."""
    allowed = settings.most > 0 and inputs.torque
    waited = (inputs.age_ns < 0) | (inputs.age_ns > settings.wait * 1e9)
    if (lost & waited).any() or (lost.any() and not allowed):
        return StopReason.SERVO_LOST
    failed = any(event.kind is FaultKind.RECOVERY_FAILED for event in inputs.events)
    if failed or (inputs.verdict.broken_legs & ~down).any() or (down.any() and not allowed):
        return StopReason.SERVO_FAULT
    return StopReason.NONE


def _ask(
    memory: RecoveryMemory, leg: int, t_ns: int, settings: RecoverySettings, names: Sequence[str]
) -> RecoveryPlan:
    recent = tuple(t for t in memory.attempts if t_ns - t < settings.window * 1e9)
    bound = f"of {settings.most} within {settings.window:g} s"
    if len(recent) >= settings.most:
        detail = f"{len(recent)} recoveries {bound} are used up"
        failed = Fault(FaultKind.RECOVERY_FAILED, names[leg], detail)
        return RecoveryPlan(memory, pause=True, stop=StopReason.SERVO_FAULT, faults=(failed,))
    asked = RecoveryMemory(memory.down, memory.back, True, (*recent, t_ns))
    detail = f"is to be brought back where it stands, {len(recent) + 1} {bound}"
    fault = Fault(FaultKind.RECOVERING, names[leg], detail)
    return RecoveryPlan(asked, pause=True, ask=(leg,), faults=(fault,))
