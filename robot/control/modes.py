"""The mode machine: which mode comes next, and which plan of shaft angles goes with it.

Pure functions of the situation. The modes are those of ``model.values.tick.Mode``::

    IDLE > ARMED > START > HOLD > START > WALK > SLOW > SETTLE > HOLD        any > LIMP

A stop is one of three kinds (``robot.control.stops``). A *cut* goes to LIMP at once. A *halt* slows down
and stands where it is, because moving single legs needs all of them. A *settle* brings the legs down one at
a time until all feet stand. A *pause* is a halt without a reason to end: a servo is being brought back, and
the robot goes on from ARMED.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gaits.gait import Gait
from gaits.limits import frequency_limit
from gaits.moves import LegMoves, MovePace
from gaits.plan import Hold, Plan, Walking
from model.values.arrays import BoolArray, FloatArray
from model.values.faults import StopReason
from model.values.parameters import ServoParameters
from model.values.quick import quick
from model.values.tick import Intent, Mode, Request
from robot.control.stops import STOPS, StopKind, gravest

# Legs this close to their place need no move.
IN_PLACE_RAD = 0.03


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Phase:
    """Where the machine stands.

    Attributes:
        mode: The mode.
        plan: The plan the shafts follow; None while torque is off.
        gait: Gait of the plan, None when none has been asked for.
        stop_reason: Why the run is ending, NONE while it goes on.
    """

    mode: Mode
    plan: Plan | None
    gait: Gait | None
    stop_reason: StopReason


@quick
@dataclass(frozen=True, slots=True, eq=False)
class Situation:
    """What the machine decides from.

    Attributes:
        t_ns: Time of the tick.
        request: The operator's wish.
        stop: Reason to stop found in this tick, NONE if none.
        angle_rad: Measured shaft angles, (N,), NaN where unknown.
        armed: Whether torque may be switched on.
        pause: Whether the robot has to hold where it is for a while.
        resume: Legs to be taken up where they were measured, (N,) bool, when it may go on after a pause.
    """

    t_ns: int
    request: Request
    stop: StopReason
    angle_rad: FloatArray
    armed: bool
    pause: bool = False
    resume: BoolArray | None = None


@dataclass(frozen=True, slots=True, eq=False)
class GaitBook:
    """The gaits a robot knows.

    Attributes:
        gaits: By name.
        frequency_limits: Highest frequency that the servos can follow, by name [Hz].
        pace: How fast legs move where they move one at a time.
    """

    gaits: Mapping[str, Gait]
    frequency_limits: Mapping[str, float]
    pace: MovePace

    @staticmethod
    def of(gaits: Sequence[Gait], servo: ServoParameters) -> "GaitBook":
        """Return the book of some gaits on a robot with these servos."""
        limits = {gait.name: frequency_limit(gait, servo) for gait in gaits}
        by_name = {gait.name: gait for gait in gaits}
        return GaitBook(by_name, limits, MovePace.of(servo))

    def refuses(self, request: Request) -> bool:
        """Whether a request to walk cannot be followed."""
        if request.intent is not Intent.WALK:
            return False
        limit = self.frequency_limits.get(request.gait)
        return (
            limit is None or not 0 < request.frequency_hz <= limit or not -1 <= request.steer <= 1
        )


def advance(phase: Phase, now: Situation, book: GaitBook) -> Phase:
    """Return the phase for this tick."""
    reason = _reason(phase, now, book)
    kind = STOPS[reason].kind
    if phase.mode is Mode.LIMP or kind is StopKind.CUT:
        return Phase(Mode.LIMP, None, None, reason)
    phase = Phase(phase.mode, phase.plan, phase.gait, reason)
    if phase.mode is Mode.IDLE:
        return _from_idle(phase, now)
    if kind is StopKind.HALT or now.pause:
        return _halt(phase, now)
    if now.resume is not None:
        angle = np.where(now.resume, now.angle_rad, _planned(phase, now.t_ns))
        return Phase(Mode.ARMED, Hold(angle), None, reason)
    if reason is not StopReason.NONE or now.request.intent is not Intent.WALK:
        return _come_to_rest(phase, now, book)
    return _towards_walking(phase, now, book)


def _reason(phase: Phase, now: Situation, book: GaitBook) -> StopReason:
    """Return the gravest reason so far; of equals the one that came first stays."""
    candidates = [phase.stop_reason, now.stop]
    if now.request.intent is Intent.CUT:
        candidates.append(StopReason.EMERGENCY)
    if now.request.intent is Intent.STOP:
        candidates.append(now.request.reason)
    if phase.mode is not Mode.IDLE and book.refuses(now.request):
        candidates.append(StopReason.GAIT_REFUSED)
    return gravest(*candidates)


def _from_idle(phase: Phase, now: Situation) -> Phase:
    wants_torque = now.request.intent in {Intent.STAND, Intent.WALK}
    known = bool(np.isfinite(now.angle_rad).all())
    if wants_torque and now.armed and known and phase.stop_reason is StopReason.NONE:
        return Phase(Mode.ARMED, Hold(now.angle_rad), None, StopReason.NONE)
    return phase


def _planned(phase: Phase, t_ns: int) -> FloatArray:
    assert phase.plan is not None  # every mode but IDLE and LIMP has one
    angle, _ = phase.plan.at(t_ns)
    return angle


def _halt(phase: Phase, now: Situation) -> Phase:
    if isinstance(phase.plan, Walking) and phase.mode is Mode.WALK:
        return Phase(Mode.SLOW, phase.plan.slowing(now.t_ns), phase.gait, phase.stop_reason)
    if isinstance(phase.plan, Walking) and not phase.plan.stopped(now.t_ns):
        return phase
    return Phase(Mode.HOLD, Hold(_planned(phase, now.t_ns)), phase.gait, phase.stop_reason)


def _come_to_rest(phase: Phase, now: Situation, book: GaitBook) -> Phase:
    t_ns, reason = now.t_ns, phase.stop_reason
    if phase.mode is Mode.HOLD:
        return phase
    if isinstance(phase.plan, Walking):
        if phase.mode is Mode.WALK:
            return Phase(Mode.SLOW, phase.plan.slowing(t_ns), phase.gait, reason)
        if not phase.plan.stopped(t_ns):
            return phase
    if isinstance(phase.plan, LegMoves) and phase.mode is Mode.SETTLE:
        if t_ns < phase.plan.end_ns:
            return phase
        return Phase(Mode.HOLD, Hold(_planned(phase, t_ns)), phase.gait, reason)
    angle = _planned(phase, t_ns)
    moves = LegMoves.stand(t_ns, angle, book.pace)
    return Phase(Mode.SETTLE, moves, phase.gait, reason)


def _towards_walking(phase: Phase, now: Situation, book: GaitBook) -> Phase:
    t_ns, request = now.t_ns, now.request
    gait = book.gaits[request.gait]
    if phase.mode is Mode.WALK and isinstance(phase.plan, Walking):
        if phase.plan.gait.name != request.gait:
            return Phase(Mode.SLOW, phase.plan.slowing(t_ns), gait, StopReason.NONE)
        plan = phase.plan.retuned(t_ns, request.frequency_hz).steered(t_ns, request.steer)
        return Phase(Mode.WALK, plan, gait, StopReason.NONE)
    if isinstance(phase.plan, Walking) and not phase.plan.stopped(t_ns):
        return phase
    if isinstance(phase.plan, LegMoves) and t_ns < phase.plan.end_ns:
        return phase
    angle = _planned(phase, t_ns)
    if phase.mode is Mode.ARMED and not _standing(angle):
        stand = LegMoves.stand(t_ns, angle, book.pace)
        return Phase(Mode.START, stand, None, StopReason.NONE)
    if not _at_start(gait, angle):
        start = LegMoves.start(t_ns, gait, angle, book.pace)
        return Phase(Mode.START, start, gait, StopReason.NONE)
    walking = Walking.begin(t_ns, gait, angle, request.frequency_hz)
    return Phase(Mode.WALK, walking, gait, StopReason.NONE)


def _standing(angle_rad: FloatArray) -> bool:
    return bool((np.abs(_wrap(angle_rad)) < IN_PLACE_RAD).all())


def _at_start(gait: Gait, angle_rad: FloatArray) -> bool:
    start = gait.motion(gait.start_phase, 0.0).angle_rad
    return bool((np.abs(_wrap(angle_rad - start)) < 1e-6).all())


def _wrap(angle_rad: FloatArray) -> FloatArray:
    wrapped: FloatArray = np.remainder(angle_rad + np.pi, 2 * np.pi) - np.pi
    return wrapped
