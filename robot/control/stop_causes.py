"""Why a run stopped: the reason in words, and the faults that it comes from."""

from collections.abc import Iterable

from model.values.faults import Fault, FaultKind, StopReason

# The faults that a reason to stop comes from.
CAUSES = {
    StopReason.LINK_LOST: {FaultKind.LINK_LOST},
    StopReason.SERVO_LOST: {FaultKind.SERVO_SILENT},
    StopReason.SERVO_FAULT: {
        FaultKind.SERVO_CORRUPT,
        FaultKind.SERVO_ALERT,
        FaultKind.SERVO_HOT,
        FaultKind.SERVO_CURRENT,
        FaultKind.SERVO_VOLTAGE,
        FaultKind.SERVO_LAG,
        FaultKind.SERVO_DOWN,
        FaultKind.RECOVERY_FAILED,
    },
    StopReason.COMMAND_REFUSED: {FaultKind.REFUSED},
    StopReason.FORCE_LOST: {FaultKind.FORCE_SILENT},
    StopReason.TIMING: {FaultKind.LATE, FaultKind.REFUSED},  # the gate says how old its last is
    StopReason.LOG_FAILED: {FaultKind.LOG_WRITE},
    StopReason.TILTED: {FaultKind.TILTED},
    StopReason.SERVO_STALLED: {FaultKind.SERVO_STALLED},
    StopReason.SLIPPED: {FaultKind.SLIPPED},
    StopReason.UNLOADED: {FaultKind.UNLOADED},
}
WORDS = {
    StopReason.NONE: "the log ends while the run goes on",
    StopReason.COMPLETED: "what was asked for was done",
    StopReason.OPERATOR: "the operator ended it",
    StopReason.EMERGENCY: "the operator cut the torque",
    StopReason.COMMAND_REFUSED: "the safety gate refused commands in a row",
    StopReason.SERVO_LOST: "a servo no longer answered",
    StopReason.SERVO_FAULT: "a servo was beyond a limit or reported an error",
    StopReason.FORCE_LOST: "the force unit sent nothing more",
    StopReason.TIMING: "the loop was too late too often",
    StopReason.LOG_FAILED: "the log could no longer be written",
    StopReason.LINK_LOST: "the servo port vanished",
    StopReason.GAIT_REFUSED: "the gait asked for cannot be followed",
    StopReason.TILTED: "the body leant too far",
    StopReason.SERVO_STALLED: "a shaft did not follow its goal",
    StopReason.SLIPPED: "the body moved when it should stand, or was too far from where it began",
    StopReason.UNLOADED: "the feet carried too little",
}
# Ends that somebody wished: nothing has to be told about them.
WISHED = frozenset({StopReason.NONE, StopReason.COMPLETED, StopReason.OPERATOR})


def cause_words(reason: StopReason, faults: Iterable[Fault]) -> str:
    """Return what caused a stop, from the faults of the tick in which it began; empty if none did."""
    causes = CAUSES.get(reason, set())
    words = [f"{f.source}: {f.detail}" for f in faults if f.kind in causes]
    return "; ".join(dict.fromkeys(words))
