"""What a replay compares: stage by stage, field by field, each with its tolerance and the reason for it.

The same inputs through the same code give the same bits. What may differ is rounding: another version
of numpy, another processor, the model compiled or not. A tolerance says how much of that a stage can
have gathered; anything larger is a change of behaviour. Flags, modes and faults have none.

Not compared: the loop's own timing, stamps of measurements, texts for a person, and the count of
contact changes that the support search took (two ways to the same equilibrium are both right).
"""

import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from model.values.arrays import IntArray
from model.values.faults import Fault, StopReason
from model.values.readings import ForceRecord, ServoReadings
from model.values.tick import Mode, Tick
from record.log.estimate_message import HEALTHS
from record.log.recording import LEGS, follow


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a tick.

    Attributes:
        stage: Stage of the pipeline.
        name: Name of the field.
        unit: Unit, empty for flags and codes.
        tolerance: Largest difference allowed: absolute up to 1 unit, relative beyond; 0 = none.
        why: Where a difference of this size can come from.
        path: Where the value is in a tick.
        shape: Its shape; empty for a number, ``LEGS`` for the number of legs.
        parts: Names along the last axis, if it has any.
        codes: What the numbers are called, for a field that is a code.
        change: What to make of the value first; None where there is nothing.
    """

    stage: str
    name: str
    unit: str
    tolerance: float
    why: str
    path: str
    shape: tuple[int, ...] = ()
    parts: tuple[str, ...] = ()
    codes: type[enum.Enum] | None = None
    change: Callable[[Any], ArrayLike | None] | None = None

    def take(self, tick: Tick) -> ArrayLike:
        """Return the value in a tick: a number, (N,) or (N, k); NaN where there is none."""
        value: ArrayLike | None = follow(tick, self.path)
        if value is not None and self.change is not None:
            value = self.change(value)
        if value is not None:
            return value
        legs = len(tick.feet.position_m)
        return np.full([legs if size == LEGS else size for size in self.shape], np.nan)


PRODUCT = "one product of a count and a constant"
QUOTIENT = "counts over a calibration, turned by a yaw angle"
PHASE = "phase from time stamps, then sines of the gait"
GEOMETRY = "sines and roots of the four-bar"
SLOPE = "slope of a line through a dozen shaft angles"
BALANCE = "a small linear system; its condition times rounding"
SUM = "a sum over all ticks so far"
EXACT = "a decision: it is the same or it is not"
RAW = "as it came from the wire"
FILTERED = "a filter over all ticks so far: its gain makes a difference of one tick fade"
LEAST = "forces of several feet at rest: the least ones, found to a finite precision"
N, N2, N3 = (LEGS,), (LEGS, 2), (LEGS, 3)
XY, XYZ, PLANAR = ("x", "y"), ("x", "y", "z"), ("vx", "vy", "yaw rate")
COUNTS = ("position", "velocity", "current", "duty", "voltage", "temperature", "hardware error")


def _faults(faults: Sequence[Fault]) -> ArrayLike:
    return np.array(" ".join(f"{f.kind.name}:{f.source}" for f in faults), dtype=object)


def _servo_counts(s: ServoReadings) -> ArrayLike:
    return np.column_stack([
        s.position_ticks, s.velocity_counts, s.current_counts, s.duty_counts, s.voltage_counts,
        s.temperature_c, s.hardware_error,
    ])  # fmt: skip


def _last_counts(records: Sequence[ForceRecord]) -> IntArray | None:
    return records[-1].counts if records else None


# What the drivers make of recorded bytes; in a replay of inputs they are the inputs themselves.
WIRE_FIELDS = (
    Field("servos", "counts", "", 0.0, RAW, "inputs.servos", (LEGS, 7), COUNTS, change=_servo_counts),
    Field("force unit", "counts", "", 0.0, RAW, "inputs.forces", (6, 6),
          ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz"), change=_last_counts),
    Field("force unit", "records", "", 0.0, RAW, "inputs.forces", change=len),
)  # fmt: skip

FIELDS = (
    Field("joints", "angle", "rad", 1e-12, PRODUCT, "joints.angle_rad", N),
    Field("joints", "rate", "rad/s", 1e-12, PRODUCT, "joints.rate_rad_s", N),
    Field("joints", "current", "A", 1e-12, PRODUCT, "joints.current_a", N),
    Field("joints", "duty", "", 1e-12, PRODUCT, "joints.duty", N),
    Field("joints", "voltage", "V", 1e-12, PRODUCT, "joints.voltage_v", N),
    Field("joints", "temperature", "C", 1e-12, PRODUCT, "joints.temperature_c", N),
    Field("joints", "valid", "", 0.0, EXACT, "joints.valid", N),
    Field("forces", "force", "N", 1e-11, QUOTIENT, "forces.force_n", N3, XYZ),
    Field("forces", "valid", "", 0.0, EXACT, "forces.valid", N),
    Field("mode", "mode", "", 0.0, EXACT, "mode.value", codes=Mode),
    Field("mode", "stop reason", "", 0.0, EXACT, "stop_reason.value", codes=StopReason),
    Field("gait", "phase", "cycles", 1e-12, PHASE, "gait_phase"),
    Field("gait", "angle", "rad", 1e-10, PHASE, "wished.angle_rad", N),
    Field("gait", "rate", "rad/s", 1e-9, PHASE, "wished.rate_rad_s", N),
    Field("gait", "torque", "", 0.0, EXACT, "wished.torque"),
    Field("safety gate", "angle", "rad", 1e-10, PHASE, "sent.angle_rad", N),
    Field("safety gate", "rate", "rad/s", 1e-9, PHASE, "sent.rate_rad_s", N),
    Field("safety gate", "torque", "", 0.0, EXACT, "sent.torque"),
    Field("feet", "position", "m", 1e-12, GEOMETRY, "feet.position_m", N3, XYZ),
    Field("feet", "velocity", "m/s", 1e-10, SLOPE, "feet.velocity_m_s", N3, XYZ),
    Field("support", "height", "m", 1e-11, BALANCE, "contact.support.height_m"),
    Field("support", "slope x", "rad", 1e-10, BALANCE, "contact.support.slope_x"),
    Field("support", "slope y", "rad", 1e-10, BALANCE, "contact.support.slope_y"),
    Field("support", "load", "N", 1e-8, BALANCE, "contact.support.load_n", N),
    Field("support", "contact", "", 0.0, EXACT, "contact.support.contact", N),
    Field("support", "converged", "", 0.0, EXACT, "contact.support.converged"),
    Field("traction", "velocity", "m/s, rad/s", 1e-9, BALANCE, "contact.traction.velocity_B", (3,),
          PLANAR),
    Field("traction", "slip", "m/s", 1e-9, BALANCE, "contact.traction.slip_B", N2, XY),
    Field("traction", "force", "N", 1e-8, BALANCE, "contact.traction.force_B", N3, XYZ),
    Field("traction", "valid", "", 0.0, EXACT, "contact.traction.valid"),
    Field("dead reckoning", "position", "m", 1e-9, SUM, "dead_reckoning.position_m", (2,), XY),
    Field("dead reckoning", "yaw", "rad", 1e-9, SUM, "dead_reckoning.yaw_rad"),
    Field("dead reckoning", "velocity", "m/s, rad/s", 1e-9, BALANCE, "dead_reckoning.velocity_B",
          (3,), PLANAR),
    Field("dead reckoning", "valid", "", 0.0, EXACT, "dead_reckoning.valid"),
    Field("estimate", "position", "m", 1e-8, FILTERED, "estimate.position_m", (2,), XY),
    Field("estimate", "yaw", "rad", 1e-8, FILTERED, "estimate.yaw_rad"),
    Field("estimate", "velocity", "m/s, rad/s", 1e-8, FILTERED, "estimate.velocity_B", (3,), PLANAR),
    Field("estimate", "pose covariance", "m2, rad2", 1e-8, FILTERED, "estimate.pose_covariance",
          (3, 3)),
    Field("estimate", "twist covariance", "", 1e-8, FILTERED, "estimate.twist_covariance", (3, 3)),
    Field("estimate", "mu", "", 1e-7, FILTERED, "estimate.mu", N),
    Field("estimate", "stiffness", "N/m", 1e-7, FILTERED, "estimate.stiffness", N),
    Field("estimate", "force", "N", 1e-4, LEAST, "estimate.force_B", N3, XYZ),
    Field("estimate", "contact", "", 0.0, EXACT, "estimate.contact", N),
    Field("estimate", "rejects", "", 0.0, EXACT, "estimate.rejects"),
    Field("estimate", "health", "", 0.0, EXACT, "estimate.health", change=HEALTHS.index),
    Field("faults", "kind and source", "", 0.0, EXACT, "faults", change=_faults),
)  # fmt: skip
