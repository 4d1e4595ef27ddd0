"""Counts of the servos to angles, speeds and currents in the leg's sense, and angles to counts. Pure."""

from collections.abc import Sequence
from functools import cache
from math import isfinite

import numpy as np

from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import DUTY_FULL, TICK_RAD, VELOCITY_UNIT_RAD_S, VOLTAGE_UNIT_V
from model.compiled import COUNT, FLAG, compile_for, compiled, given, in_place, out
from model.values.arrays import BoolArray, FloatArray, IntArray, readonly
from model.values.input_rows import ServoRows
from model.values.legs import JointState
from model.values.readings import ServoReadings
from model.values.tick_rows import JointRows


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


@in_place
@compiled
def _calibrate(
    position: IntArray, velocity: IntArray, current: IntArray, duty: IntArray, voltage: IntArray,
    temperature: IntArray, valid: BoolArray, zeros: IntArray, units: FloatArray, rows: FloatArray,
) -> None:  # fmt: skip
    """Write what ``joint_state`` makes of one read, (6, N).

    Args:
        position: Of ``ServoReadings``, as all up to ``valid``, (N,).
        velocity: Speeds.
        current: Currents.
        duty: Duties.
        voltage: Voltages.
        temperature: Temperatures.
        valid: Who has answered.
        zeros: Positions at shaft angle 0, (N,) [ticks].
        units: Of ``_units``, (6, N).
        rows: Written.
    """
    for k in range(valid.size):
        rows[0, k] = (position[k] - zeros[k]) * units[0, k]
        rows[1, k] = velocity[k] * units[1, k]
        rows[2, k] = current[k] * units[2, k]
        rows[3, k] = duty[k] * units[3, k] / DUTY_FULL
        rows[4, k] = voltage[k] * units[4, k]
        rows[5, k] = temperature[k] * units[5, k]
        for i in range(rows.shape[0] if not valid[k] else 0):
            rows[i, k] = np.nan


class ReadCalibration:
    """Calibrates reads, one a tick, by machine code that is loaded or made here.

    Args:
        settings: How the servos are mounted.
    """

    def __init__(self, settings: ServoBusSettings) -> None:
        self._zeros = np.ascontiguousarray(settings.zeros, dtype=np.int64)
        self._units = np.ascontiguousarray(_units(settings))
        compile_for(
            _calibrate, *given(1, 1, 1, 1, 1, 1, kind=COUNT), *given(1, kind=FLAG),
            *given(1, kind=COUNT), *given(2), *out(2),
        )  # fmt: skip

    def state(self, readings: ServoReadings) -> JointState:
        """Return ``joint_state`` of a read, to the bit."""
        rows, valid, flat = np.empty(self._units.shape), readings.valid, np.ascontiguousarray
        _calibrate(
            flat(readings.position_ticks), flat(readings.velocity_counts),
            flat(readings.current_counts), flat(readings.duty_counts),
            flat(readings.voltage_counts), flat(readings.temperature_c), flat(valid), self._zeros,
            self._units, rows,
        )  # fmt: skip
        angle, rate, current, duty, voltage, temperature = readonly(rows)
        return JointState(readings.t_ns, angle, rate, current, duty, voltage, temperature, valid)


def joint_rows(readings: ServoRows, settings: ServoBusSettings) -> JointRows:
    """``joint_state`` of T reads; the same numbers."""
    units = _units(settings)
    counts = np.empty((len(units), *readings.valid.shape), dtype=np.int64)
    counts[0] = readings.position_ticks - settings.zeros
    of_servos = (
        readings.velocity_counts, readings.current_counts, readings.duty_counts,
        readings.voltage_counts, readings.temperature_c,
    )  # fmt: skip
    for row, own in enumerate(of_servos, start=1):
        counts[row] = own
    values = counts * units[:, None]
    values[DUTY] /= DUTY_FULL
    values[:, ~readings.valid] = np.nan
    angle, rate, current, duty, voltage, temperature = readonly(values)
    return JointRows(
        readings.t_ns, angle, rate, current, duty, voltage, temperature, readings.valid
    )
