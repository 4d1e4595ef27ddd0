"""The geared motor of a servo: voltage to torque, friction budget, heat. Compiled, one motor at a time."""

import math

import numpy as np

from model.compiled import compiled, in_place
from model.values.arrays import FloatArray
from sim_hw.plant.parameters import MotorParameters

# Places in the row of numbers that the compiled code takes.
MOTOR_NUMBERS = 15
(
    TORQUE_CONSTANT, RESISTANCE, ARMATURE, DUTY_LIMIT, STRIBECK, LOAD, LOAD_STRIBECK, STRIBECK_SPEED,
    STRIBECK_POWER, VISCOUS, THERMAL_RESISTANCE, THERMAL_TIME, BATTERY_V, BATTERY_RESISTANCE, AMBIENT_C,
) = range(MOTOR_NUMBERS)  # fmt: skip


def motor_row(motor: MotorParameters) -> FloatArray:
    """Return a motor's parameters as the compiled code takes them, (15,), in the order of the dataclass."""
    return np.array([getattr(motor, name) for name in MotorParameters.__slots__], dtype=np.float64)


@in_place
@compiled
def friction_budget(
    motor: FloatArray, rate: float, motor_torque: float, load_torque: float
) -> float:
    """Largest torque that dry friction can take up [N m].

    Args:
        motor: Row of ``motor_row``.
        rate: Output speed [rad/s].
        motor_torque: Torque of the motor at the output [N m].
        load_torque: Torque of the load on the output [N m].

    Reference: Rhoban/bam, model m4 (Stribeck and load-dependent).
    """
    carried = abs(motor_torque - load_torque)
    decay = math.exp(-(abs(rate / motor[STRIBECK_SPEED]) ** motor[STRIBECK_POWER]))
    at_rest = motor[STRIBECK] + motor[LOAD_STRIBECK] * carried
    budget: float = motor[LOAD] * carried + decay * at_rest
    return budget


@in_place
@compiled
def slowed(momentum: float, friction: float) -> float:
    """Return what dry friction leaves of a momentum, each [N m s]; it stops, and never turns it round."""
    left: float = math.copysign(max(0.0, abs(momentum) - friction), momentum)
    return left


@in_place
@compiled
def turned(
    motor: FloatArray,
    rate: float,
    stall_torque: float,
    damping: float,
    load_torque: float,
    jam_torque: float,
    dt_s: float,
) -> float:
    """Return the shaft's speed a step later.

    Dry friction takes the torque that would stop the shaft in this step, up to its budget; the back-EMF
    and viscous friction are implicit.

    Args:
        motor: Row of ``motor_row``.
        rate: Speed now [rad/s].
        stall_torque: Torque of the applied voltage at standstill, kt V/R [N m].
        damping: Back-EMF, kt^2/R where the output stage is on [N m s].
        load_torque: Torque of the load on the shaft [N m].
        jam_torque: Dry friction on the shaft besides the motor's own [N m].
        dt_s: Step.
    """
    budget = friction_budget(motor, rate, stall_torque - damping * rate, load_torque)
    momentum = motor[ARMATURE] * rate + dt_s * (stall_torque + load_torque)
    left = slowed(momentum, dt_s * (budget + jam_torque))
    speed: float = left / (motor[ARMATURE] + dt_s * (motor[VISCOUS] + damping))
    return speed


@in_place
@compiled
def current_of(motor: FloatArray, applied_v: float, rate: float) -> float:
    """Return the current through the winding [A]."""
    current: float = (applied_v - motor[TORQUE_CONSTANT] * rate) / motor[RESISTANCE]
    return current


@in_place
@compiled
def warmed(motor: FloatArray, temperature_c: float, current_a: float, dt_s: float) -> float:
    """Return the temperature a step later [degC]."""
    final = motor[AMBIENT_C] + motor[THERMAL_RESISTANCE] * motor[RESISTANCE] * current_a**2
    warmer: float = temperature_c + (final - temperature_c) * (dt_s / motor[THERMAL_TIME])
    return warmer
