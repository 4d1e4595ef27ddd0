"""What the servos' part of the pre-flight list measured, number by number, for its page."""

from dataclasses import dataclass, field

from drivers.dynamixel.condition import ServoCondition


@dataclass(slots=True)
class ServoFigures:
    """Filled while the servos are looked at; what was not reached stays empty.

    Attributes:
        conditions: Of the servos that answered.
        read_ms: How long each sync read of all servos took [ms].
        complete: Whether all servos answered to it.
        period_ms: Period of the loop [ms].
        wire_ms: What the bytes of one read take on the wire [ms].
    """

    conditions: list[ServoCondition] = field(default_factory=list)
    read_ms: list[float] = field(default_factory=list)
    complete: list[bool] = field(default_factory=list)
    period_ms: float = float("nan")
    wire_ms: float = float("nan")
