"""Why a run stops: one table of all reasons, each with its kind, its words, its causes and the exit code.

A new reason is a member of ``StopReason`` and an entry here, nothing else. Where a stop is found out
(``Controller._stop``), the gravest of all reasons of a tick counts.
"""

import enum
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from model.values.faults import Fault, FaultKind, StopReason
from robot.console.exit_codes import ExitCode

_NO_FAULTS: frozenset[FaultKind] = frozenset()


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
        causes: Faults that it comes from, after a while or at once; none where somebody wished it.
        at_once: Those of them that stop the run in the very tick in which they come.
        exit_code: What a shell sees.
    """

    kind: StopKind
    words: str
    causes: frozenset[FaultKind] = _NO_FAULTS
    at_once: frozenset[FaultKind] = _NO_FAULTS
    exit_code: ExitCode = ExitCode.HARDWARE

    @property
    def wished(self) -> bool:
        """Whether somebody wished this end, so that nothing has to be explained."""
        return self.exit_code is ExitCode.OK


def _at_once(kind: StopKind, fault: FaultKind, words: str) -> Stop:
    return Stop(kind, words, frozenset({fault}), frozenset({fault}))


STOPS: Mapping[StopReason, Stop] = MappingProxyType({
    StopReason.NONE: Stop(
        StopKind.NONE, "the log ends while the run goes on", exit_code=ExitCode.OK
    ),
    StopReason.COMPLETED: Stop(
        StopKind.SETTLE, "what was asked for was done", exit_code=ExitCode.OK
    ),
    StopReason.OPERATOR: Stop(StopKind.SETTLE, "the operator ended it", exit_code=ExitCode.OK),
    StopReason.EMERGENCY: Stop(StopKind.CUT, "the operator cut the torque"),
    StopReason.COMMAND_REFUSED: Stop(
        StopKind.HALT, "the safety gate refused commands in a row", frozenset({FaultKind.REFUSED})
    ),
    StopReason.SERVO_LOST: Stop(
        StopKind.HALT, "a servo no longer answered", frozenset({FaultKind.SERVO_SILENT})
    ),
    StopReason.SERVO_FAULT: Stop(
        StopKind.HALT,
        "a servo was beyond a limit or reported an error",
        frozenset({
            FaultKind.SERVO_CORRUPT, FaultKind.SERVO_ALERT, FaultKind.SERVO_HOT,
            FaultKind.SERVO_CURRENT, FaultKind.SERVO_VOLTAGE, FaultKind.SERVO_LAG,
            FaultKind.SERVO_DOWN, FaultKind.RECOVERY_FAILED,
        }),
        at_once=frozenset({FaultKind.SERVO_CORRUPT}),
    ),
    StopReason.FORCE_LOST: _at_once(
        StopKind.SETTLE, FaultKind.FORCE_SILENT, "the force unit sent nothing more"
    ),
    StopReason.TIMING: Stop(
        StopKind.HALT,
        "the loop was too late too often",
        frozenset({FaultKind.LATE, FaultKind.REFUSED}),  # the gate says how old its last command is
    ),
    StopReason.LOG_FAILED: Stop(
        StopKind.SETTLE,
        "the log could no longer be written",
        frozenset({FaultKind.LOG_WRITE}),
        frozenset({FaultKind.LOG_WRITE}),
        ExitCode.LOG,
    ),
    StopReason.LINK_LOST: _at_once(
        StopKind.CUT, FaultKind.LINK_LOST, "the servo port vanished"
    ),
    StopReason.GAIT_REFUSED: Stop(
        StopKind.SETTLE, "the gait asked for cannot be followed", exit_code=ExitCode.USAGE
    ),
    StopReason.TILTED: _at_once(StopKind.HALT, FaultKind.TILTED, "the body leant too far"),
    StopReason.SERVO_STALLED: _at_once(
        StopKind.HALT, FaultKind.SERVO_STALLED, "a shaft did not follow its goal"
    ),
    StopReason.SLIPPED: _at_once(
        StopKind.HALT,
        FaultKind.SLIPPED,
        "the body moved when it should stand, or was too far from where it began",
    ),
    StopReason.UNLOADED: _at_once(
        StopKind.HALT, FaultKind.UNLOADED, "the feet carried too little"
    ),
})  # fmt: skip
_BY_FAULT = {fault: reason for reason, stop in STOPS.items() for fault in stop.at_once}


def gravest(*reasons: StopReason) -> StopReason:
    """Return the gravest of some reasons: a cut before a halt before a settle before none.

    Of several alike the first one counts: what came first stays the reason.
    """
    return max(reasons, key=lambda reason: STOPS[reason].kind)


def stop_at_once(faults: Iterable[Fault]) -> StopReason:
    """Return the gravest reason to stop that faults are by themselves, NONE if they are none."""
    kinds = {fault.kind for fault in faults}
    return gravest(
        StopReason.NONE, *(reason for kind, reason in _BY_FAULT.items() if kind in kinds)
    )


def cause_words(reason: StopReason, faults: Iterable[Fault]) -> str:
    """Return what caused a stop, from the faults of the tick in which it began; empty if none did."""
    causes = STOPS[reason].causes
    return "; ".join(dict.fromkeys(f"{f.source}: {f.detail}" for f in faults if f.kind in causes))
