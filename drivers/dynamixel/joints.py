"""Counts of the servos to angles, speeds and currents in the leg's sense, and angles to counts. Pure."""

from collections.abc import Sequence
from functools import cache
from math import isfinite

import numpy as np

from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import DUTY_FULL, TICK_RAD, VELOCITY_UNIT_RAD_S, VOLTAGE_UNIT_V
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.legs import JointState
from model.values.readings import ServoReadings


def ticks_to_angle(ticks: FloatArray | IntArray, sign: IntArray, zero: IntArray) -> FloatArray:
    """Return shaft angles in the leg's sense, (N,) [rad].

    Args:
        ticks: Present or goal positions, (N,) [ticks].
        sign: +1 or -1, (N,); the leg's sense.
        zero: Position at shaft angle 0, (N,) [ticks].
    """
    return _signed(ticks - zero, sign) * TICK_RAD


def angle_to_ticks(angle_rad: FloatArray, sign: IntArray, zero: IntArray) -> IntArray:
    """Return the nearest positions, (N,) int64 [ticks]; the inverse of ``ticks_to_angle``.

    Raises:
        ValueError: An angle is not a number; it has no position.
    """
    angles = angle_rad.tolist()
    if not all(map(isfinite, angles)):
        raise ValueError("an angle is not a number and has no position")
    return np.array(nearest_ticks(angles, sign.tolist(), zero.tolist()), dtype=np.int64)


def nearest_ticks(
    angle_rad: Sequence[float], sign: Sequence[int], zero: Sequence[int]
) -> list[int]:
    """Return the same as plain numbers, N of them: half a dozen are rounded sooner one by one."""
    mounted = zip(angle_rad, sign, zero, strict=True)
    return [round(at + turned * angle / TICK_RAD) for angle, turned, at in mounted]


def _signed(values: FloatArray | IntArray, sign: IntArray) -> FloatArray:
    turned: FloatArray = sign.astype(np.float64) * values.astype(np.float64)
    return turned


DUTY = 3  # row of what ``joint_state`` makes


@cache
def _units(settings: ServoBusSettings) -> FloatArray:
    """Units of its rows; the first four turn with the leg's sense, (6, N)."""
    one = np.ones_like(settings.signs)
    units = [TICK_RAD * one, VELOCITY_UNIT_RAD_S * one, settings.current_unit_a, one]
    return np.vstack([*(unit * settings.signs for unit in units), VOLTAGE_UNIT_V * one, one])


def joint_state(readings: ServoReadings, settings: ServoBusSettings) -> JointState:
    """Calibrate one sync read into the leg's sense and SI units.

    NaN where a servo was silent, and in the current of one that does not measure it.
    """
    valid = readings.valid
    # all at once: one by one these are thirty calls of numpy on six numbers each
    counts = np.concatenate((
        readings.position_ticks - settings.zeros, readings.velocity_counts, readings.current_counts,
        readings.duty_counts, readings.voltage_counts, readings.temperature_c,
    ))  # fmt: skip
    units = _units(settings)
    rows = counts.reshape(units.shape) * units
    rows[DUTY] /= DUTY_FULL
    if False in valid.tolist():
        rows[:, ~valid] = np.nan
    angle, rate, current, duty, voltage, temperature = readonly(rows)
    return JointState(readings.t_ns, angle, rate, current, duty, voltage, temperature, valid)


def joint_states(readings: Sequence[ServoReadings], settings: ServoBusSettings) -> list[JointState]:
    """``joint_state`` of many reads at once; the same numbers.

    Args:
        readings: B of them.
        settings: How servos are mounted.
    """
    units = _units(settings)
    rows, legs = units.shape

    def together(name: str) -> IntArray:
        return np.concatenate([getattr(one, name) for one in readings]).reshape(-1, legs)

    counts = np.empty((len(readings), rows, legs), dtype=np.int64)
    counts[:, 0] = together("position_ticks") - settings.zeros
    for row, name in enumerate(
        ("velocity_counts", "current_counts", "duty_counts", "voltage_counts", "temperature_c"),
        start=1,
    ):
        counts[:, row] = together(name)
    values = counts * units
    values[:, DUTY] /= DUTY_FULL
    for place in np.flatnonzero([False in one.valid.tolist() for one in readings]).tolist():
        values[place][:, ~readings[place].valid] = np.nan
    readonly(values)
    joints = []
    for one, own in zip(readings, values, strict=True):
        angle, rate, current, duty, voltage, temperature = own
        joints.append(
            JointState(one.t_ns, angle, rate, current, duty, voltage, temperature, one.valid)
        )
    return joints
