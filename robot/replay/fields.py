"""What a replay compares: stage by stage, field by field, each with its tolerance and the reason for it.

The same inputs through the same code give the same bits. What may differ is rounding: another version
of numpy, another processor, the model compiled or not. A tolerance says how much of that a stage can
have gathered; anything larger is a change of behaviour. Flags, modes and faults have none.

Not compared: the loop's own timing, stamps of measurements, texts for a person, and the count of
contact changes that the support search took (two ways to the same equilibrium are both right).
"""

import enum
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from model.values.estimate import Estimate
from model.values.faults import StopReason
from model.values.tick import Mode, Tick
from record.log.estimate_message import HEALTHS

Take = Callable[[Tick], ArrayLike]


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a tick.

    Attributes:
        stage: Stage of the pipeline.
        name: Name of the field.
        unit: Unit, empty for flags and codes.
        tolerance: Largest difference allowed: absolute up to 1 unit, relative beyond; 0 = none.
        why: Where a difference of this size can come from.
        take: Takes the value from a tick: a number, (N,) or (N, k).
        legs: Whether the first axis is that of the legs.
        parts: Names along the last axis, if it has any.
        codes: What the numbers are called, for a field that is a code.
    """

    stage: str
    name: str
    unit: str
    tolerance: float
    why: str
    take: Take
    legs: bool = False
    parts: tuple[str, ...] = ()
    codes: type[enum.Enum] | None = None


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
LEGS = -1

_XYZ = ("x", "y", "z")
_PLANAR = ("vx", "vy", "yaw rate")


def _faults(tick: Tick) -> ArrayLike:
    return np.array(" ".join(f"{f.kind.name}:{f.source}" for f in tick.faults), dtype=object)


def _servo_counts(tick: Tick) -> ArrayLike:
    servos = tick.inputs.servos
    if servos is None:
        return np.zeros((len(tick.joints.angle_rad), 7), dtype=np.int64)
    return np.stack(
        [
            servos.position_ticks,
            servos.velocity_counts,
            servos.current_counts,
            servos.duty_counts,
            servos.voltage_counts,
            servos.temperature_c,
            servos.hardware_error,
        ],
        axis=1,
    )


def _force_counts(tick: Tick) -> ArrayLike:
    records = tick.inputs.forces
    return records[-1].counts if records else np.zeros((6, 6), dtype=np.int64)


def _estimate(take: Callable[[Estimate], ArrayLike], *shape: int) -> Take:
    """A field of the estimate, absent where there is none; its first axis may be that of the legs."""

    def value(tick: Tick) -> ArrayLike:
        if tick.estimate is not None:
            return take(tick.estimate)
        legs = len(tick.joints.angle_rad)
        return np.full([legs if size == LEGS else size for size in shape], np.nan)

    return value


# What the drivers make of recorded bytes; in a replay of inputs they are the inputs themselves.
WIRE_FIELDS = (
    Field("servos", "counts", "", 0.0, RAW, _servo_counts, legs=True, parts=(
        "position", "velocity", "current", "duty", "voltage", "temperature", "hardware error")),
    Field("force unit", "counts", "", 0.0, RAW, _force_counts,
          parts=("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")),
    Field("force unit", "records", "", 0.0, RAW, lambda t: len(t.inputs.forces)),
)  # fmt: skip

FIELDS = (
    Field("joints", "angle", "rad", 1e-12, PRODUCT, lambda t: t.joints.angle_rad, legs=True),
    Field("joints", "rate", "rad/s", 1e-12, PRODUCT, lambda t: t.joints.rate_rad_s, legs=True),
    Field("joints", "current", "A", 1e-12, PRODUCT, lambda t: t.joints.current_a, legs=True),
    Field("joints", "duty", "", 1e-12, PRODUCT, lambda t: t.joints.duty, legs=True),
    Field("joints", "voltage", "V", 1e-12, PRODUCT, lambda t: t.joints.voltage_v, legs=True),
    Field("joints", "temperature", "C", 1e-12, PRODUCT, lambda t: t.joints.temperature_c,
          legs=True),
    Field("joints", "valid", "", 0.0, EXACT, lambda t: t.joints.valid, legs=True),
    Field("forces", "force", "N", 1e-11, QUOTIENT, lambda t: t.forces.force_n, legs=True,
          parts=_XYZ),
    Field("forces", "valid", "", 0.0, EXACT, lambda t: t.forces.valid, legs=True),
    Field("mode", "mode", "", 0.0, EXACT, lambda t: t.mode.value, codes=Mode),
    Field("mode", "stop reason", "", 0.0, EXACT, lambda t: t.stop_reason.value, codes=StopReason),
    Field("gait", "phase", "cycles", 1e-12, PHASE, lambda t: t.gait_phase),
    Field("gait", "angle", "rad", 1e-10, PHASE, lambda t: t.wished.angle_rad, legs=True),
    Field("gait", "rate", "rad/s", 1e-9, PHASE, lambda t: t.wished.rate_rad_s, legs=True),
    Field("gait", "torque", "", 0.0, EXACT, lambda t: t.wished.torque),
    Field("safety gate", "angle", "rad", 1e-10, PHASE, lambda t: t.sent.angle_rad, legs=True),
    Field("safety gate", "rate", "rad/s", 1e-9, PHASE, lambda t: t.sent.rate_rad_s, legs=True),
    Field("safety gate", "torque", "", 0.0, EXACT, lambda t: t.sent.torque),
    Field("feet", "position", "m", 1e-12, GEOMETRY, lambda t: t.feet.position_m, legs=True,
          parts=_XYZ),
    Field("feet", "velocity", "m/s", 1e-10, SLOPE, lambda t: t.feet.velocity_m_s, legs=True,
          parts=_XYZ),
    Field("support", "height", "m", 1e-11, BALANCE, lambda t: t.contact.support.height_m),
    Field("support", "slope x", "rad", 1e-10, BALANCE, lambda t: t.contact.support.slope_x),
    Field("support", "slope y", "rad", 1e-10, BALANCE, lambda t: t.contact.support.slope_y),
    Field("support", "load", "N", 1e-8, BALANCE, lambda t: t.contact.support.load_n, legs=True),
    Field("support", "contact", "", 0.0, EXACT, lambda t: t.contact.support.contact, legs=True),
    Field("support", "converged", "", 0.0, EXACT, lambda t: t.contact.support.converged),
    Field("traction", "velocity", "m/s, rad/s", 1e-9, BALANCE, lambda t: t.contact.traction.velocity_B,
          parts=_PLANAR),
    Field("traction", "slip", "m/s", 1e-9, BALANCE, lambda t: t.contact.traction.slip_B,
          legs=True, parts=("x", "y")),
    Field("traction", "force", "N", 1e-8, BALANCE, lambda t: t.contact.traction.force_B,
          legs=True, parts=_XYZ),
    Field("traction", "valid", "", 0.0, EXACT, lambda t: t.contact.traction.valid),
    Field("dead reckoning", "position", "m", 1e-9, SUM, lambda t: t.dead_reckoning.position_m,
          parts=("x", "y")),
    Field("dead reckoning", "yaw", "rad", 1e-9, SUM, lambda t: t.dead_reckoning.yaw_rad),
    Field("dead reckoning", "velocity", "m/s, rad/s", 1e-9, BALANCE,
          lambda t: t.dead_reckoning.velocity_B, parts=_PLANAR),
    Field("dead reckoning", "valid", "", 0.0, EXACT, lambda t: t.dead_reckoning.valid),
    Field("estimate", "position", "m", 1e-8, FILTERED, _estimate(lambda o: o.position_m, 2),
          parts=("x", "y")),
    Field("estimate", "yaw", "rad", 1e-8, FILTERED, _estimate(lambda o: o.yaw_rad)),
    Field("estimate", "velocity", "m/s, rad/s", 1e-8, FILTERED, _estimate(lambda o: o.velocity_B, 3),
          parts=_PLANAR),
    Field("estimate", "pose covariance", "m2, rad2", 1e-8, FILTERED,
          _estimate(lambda o: o.pose_covariance, 3, 3)),
    Field("estimate", "twist covariance", "", 1e-8, FILTERED,
          _estimate(lambda o: o.twist_covariance, 3, 3)),
    Field("estimate", "mu", "", 1e-7, FILTERED, _estimate(lambda o: o.mu, LEGS), legs=True),
    Field("estimate", "stiffness", "N/m", 1e-7, FILTERED, _estimate(lambda o: o.stiffness, LEGS),
          legs=True),
    Field("estimate", "force", "N", 1e-5, LEAST, _estimate(lambda o: o.force_B, LEGS, 3), legs=True,
          parts=_XYZ),
    Field("estimate", "contact", "", 0.0, EXACT, _estimate(lambda o: o.contact, LEGS), legs=True),
    Field("estimate", "rejects", "", 0.0, EXACT, _estimate(lambda o: o.rejects)),
    Field("estimate", "health", "", 0.0, EXACT, _estimate(lambda o: HEALTHS.index(o.health))),
    Field("faults", "kind and source", "", 0.0, EXACT, _faults),
)  # fmt: skip
