"""Why a run stops: one table of all reasons, each with its kind, its words, its causes and the exit code.

A new reason is a member of ``StopReason`` and an entry here, nothing else. Where a stop is found out
(``Controller._decide``), the gravest of all reasons of a tick counts.
"""

import enum
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from model.values.faults import Fault, FaultKind, StopReason
from robot.console.exit_codes import ExitCode


class StopKind(enum.IntEnum):
    """How a run stops, the gravest last."""

    NONE = 0  # it goes on
    SETTLE = 1  # the legs come down one at a time until all feet stand
    HALT = 2  # it slows down and stands where it is: moving single legs needs all of them
    CUT = 3  # torque goes off at once


@dataclass(frozen=True, slots=True)
class Stop:
    """One reason to stop.

    Attributes:
        kind: How the run stops.
        words: Why it ended, for a person.
        at_once: Faults that stop the run in the very tick in which they come.
        lasting: Faults that stop it after a while.
        exit_code: What a shell sees.
    """

    kind: StopKind
    words: str
    at_once: tuple[FaultKind, ...] = ()
    lasting: tuple[FaultKind, ...] = ()
    exit_code: ExitCode = ExitCode.HARDWARE

    @property
    def causes(self) -> tuple[FaultKind, ...]:
        """Faults that it comes from; none where the operator caused it."""
        return self.at_once + self.lasting

    @property
    def wished(self) -> bool:
        """Whether somebody wished this end, so that nothing has to be explained."""
        return self.exit_code is ExitCode.OK


_GOOD, _SETTLE, _HALT, _CUT = ExitCode.OK, StopKind.SETTLE, StopKind.HALT, StopKind.CUT
STOPS: Mapping[StopReason, Stop] = MappingProxyType({
    StopReason.NONE: Stop(
        StopKind.NONE, "the log ends while the run goes on", exit_code=_GOOD
    ),
    StopReason.COMPLETED: Stop(_SETTLE, "the requested motion is complete", exit_code=_GOOD),
    StopReason.OPERATOR: Stop(_SETTLE, "the operator ended it", exit_code=_GOOD),
    StopReason.EMERGENCY: Stop(_CUT, "the operator cut the torque"),
    StopReason.COMMAND_REFUSED: Stop(
        _HALT, "the safety gate refused commands in a row", lasting=(FaultKind.REFUSED,)
    ),
    StopReason.SERVO_LOST: Stop(
        _HALT, "a servo stopped answering", lasting=(FaultKind.SERVO_SILENT,)
    ),
    StopReason.SERVO_FAULT: Stop(
        _HALT, "a servo was beyond a limit or reported an error", (FaultKind.SERVO_CORRUPT,), (
            FaultKind.SERVO_ALERT, FaultKind.SERVO_HOT, FaultKind.SERVO_CURRENT,
            FaultKind.SERVO_VOLTAGE, FaultKind.SERVO_LAG, FaultKind.SERVO_DOWN,
            FaultKind.RECOVERY_FAILED,
        ),
    ),
    StopReason.FORCE_LOST: Stop(
        _SETTLE, "the force unit stopped sending", (FaultKind.FORCE_SILENT,)
    ),
    StopReason.TIMING: Stop(  # a refusal says how old the last command is
        _HALT, "the loop was too late too often", lasting=(FaultKind.LATE, FaultKind.REFUSED)
    ),
    StopReason.LOG_FAILED: Stop(
        _SETTLE, "the log could no longer be written", (FaultKind.LOG_WRITE,),
        exit_code=ExitCode.LOG,
    ),
    StopReason.LINK_LOST: Stop(_CUT, "the servo port vanished", (FaultKind.LINK_LOST,)),
    StopReason.GAIT_REFUSED: Stop(
        _SETTLE, "the gait asked for cannot be followed", exit_code=ExitCode.USAGE
    ),
    StopReason.TILTED: Stop(_HALT, "the body leant too far", (FaultKind.TILTED,)),
    StopReason.SERVO_STALLED: Stop(
        _HALT, "a shaft did not follow its goal", (FaultKind.SERVO_STALLED,)
    ),
    StopReason.SLIPPED: Stop(
        _HALT, "the body moved when it should stand, or was too far from where it began",
        (FaultKind.SLIPPED,),
    ),
    StopReason.UNLOADED: Stop(_HALT, "the feet carried too little", (FaultKind.UNLOADED,)),
    StopReason.TURNS_USED: Stop(
        _SETTLE, "a servo's turn counter is nearly used up; a new start sets it back",
        (FaultKind.TURNS_USED,),
    ),
})  # fmt: skip
_BY_FAULT = {fault: reason for reason, stop in STOPS.items() for fault in stop.at_once}


def gravest(*reasons: StopReason) -> StopReason:
    """Return the gravest of some reasons, a cut before a halt before a settle; of equals the first."""
    if reasons.count(StopReason.NONE) == len(reasons):
        return StopReason.NONE
    return max(reasons, key=lambda reason: STOPS[reason].kind)


def stop_at_once(faults: Iterable[Fault]) -> StopReason:
    """Return the gravest reason to stop that faults are by themselves, NONE if they are none."""
    kinds = {fault.kind for fault in faults}
    if not kinds:
        return StopReason.NONE
    return gravest(
        StopReason.NONE, *(reason for kind, reason in _BY_FAULT.items() if kind in kinds)
    )


def cause_words(reason: StopReason, faults: Iterable[Fault]) -> str:
    """Return what caused a stop, from the faults of the tick in which it began; empty if none did."""
    causes = STOPS[reason].causes
    return "; ".join(dict.fromkeys(f"{f.source}: {f.detail}" for f in faults if f.kind in causes))
