"""What can go wrong in a tick, and why a run ends."""

import enum
from dataclasses import dataclass


class StopReason(enum.Enum):
    """Why a run ended, or is ending. NONE while it goes on."""

    NONE = 0
    COMPLETED = 1  # cycles or duration asked for are done
    OPERATOR = 2  # Ctrl-C or the stop key
    EMERGENCY = 3  # second Ctrl-C or the emergency key
    COMMAND_REFUSED = 4  # the safety gate refused commands in a row
    SERVO_LOST = 5  # a servo stayed silent
    SERVO_FAULT = 6  # hardware error bit, too hot, over-current, under-voltage
    FORCE_LOST = 7  # the force stream stayed silent
    TIMING = 8  # the loop missed its deadlines in a row
    LOG_FAILED = 9  # the log can no longer be written
    LINK_LOST = 10  # the port vanished
    GAIT_REFUSED = 11  # the gait asked for cannot be followed
    TILTED = 12  # the body leans too far
    SERVO_STALLED = 13  # a shaft does not follow its goal, with much current
    SLIPPED = 14  # the body moves when it should stand, or is too far from where it began
    UNLOADED = 15  # the feet carry too little: lifted, hanging or fallen
    TURNS_USED = 16  # a servo's turn counter is nearly at its end


class FaultKind(enum.Enum):
    """Faults are values in the tick, never exceptions in the loop."""

    SERVO_SILENT = 1
    SERVO_CORRUPT = 2
    SERVO_ALERT = 3  # a hardware error bit is set in the servo
    SERVO_HOT = 4
    SERVO_CURRENT = 5
    SERVO_VOLTAGE = 6
    SERVO_LAG = 7  # following error beyond the limit
    FORCE_SILENT = 8
    FORCE_GAP = 9  # samples missing between two records
    FORCE_SATURATED = 10
    LATE = 11  # the tick began later than allowed
    REFUSED = 12  # the safety gate refused the wished command
    NO_SUPPORT = 13  # the support model found no equilibrium
    LOG_WRITE = 14
    LINK_LOST = 15
    SERVO_STALLED = 16
    SERVO_DOWN = 17  # a servo has lost its torque: shut down, or restarted
    RECOVERING = 18  # the controller asks for a servo to be brought back
    SERVO_RECOVERED = 19  # it holds again where it stands
    RECOVERY_FAILED = 20
    TILTED = 21
    SLIPPED = 22
    UNLOADED = 23
    FORCE_ABSENT = 24  # a transducer that should be in the record is not
    FORCE_BATTERY = 25  # the force unit says that its battery is low
    POSE_BAD = 26  # a pose from outside that makes no sense
    IMU_BAD = 27  # a line of the IMU that makes no sense, or one that never changes
    IMU_STALE = 28  # no reading of the IMU that is fresh enough
    TURNS_USED = 29  # a servo's turn counter is nearly at its end


@dataclass(frozen=True, slots=True)
class Fault:
    """One thing that went wrong in one tick.

    Attributes:
        kind: What.
        source: Leg name, device or stage it concerns.
        detail: Words for a person, with the figures.
    """

    kind: FaultKind
    source: str
    detail: str


@dataclass(frozen=True, slots=True)
class ServoEvent:
    """What became of a servo's torque: for the controller, beside the fault that people read.

    Attributes:
        leg: Leg index.
        kind: SERVO_DOWN, SERVO_RECOVERED or RECOVERY_FAILED.
    """

    leg: int
    kind: FaultKind


SERVO_EVENTS = frozenset(
    {FaultKind.SERVO_DOWN, FaultKind.SERVO_RECOVERED, FaultKind.RECOVERY_FAILED}
)
