"""What all servos of a sync read measure, as the bytes of their answers, in one compiled call.

The frames are those that ``drivers.dynamixel.frames.build_status`` builds of the same registers, byte for
byte (``tests/sim_hw/test_measured_kernel.py``). Where a number does not fit its register, nothing is
answered here: who packs servo by servo says what is wrong.
"""

from typing import Any

import numpy as np

from drivers.dynamixel.frames import STATUS
from drivers.dynamixel.units import (
    DUTY_FULL,
    LOAD_UNIT,
    TICK_RAD,
    VELOCITY_UNIT_RAD_S,
    VOLTAGE_UNIT_V,
)
from model.compiled import COUNT, compile_for, compiled, given, in_place, out
from model.values.arrays import FloatArray, IntArray
from sim_hw.dynamixel.firmware import CURRENT, PWM, SERVO, VELOCITY

# What a servo's registers say of its measurements, a row a servo. ``CURRENT_UNIT``: 0 where it measures
# none; ``ALERT``: the bit in the error byte of its answers.
SENSE, OFFSET, MOVING_RAD_S, CURRENT_UNIT, ALERT = range(5)
# Moving Status: bits, and the type of the profile in them.
IN_POSITION, PROFILE_ONGOING = 0x01, 0x02
NO_PROFILE, RECTANGULAR, TRAPEZOIDAL = 0x00, 0x10, 0x30
PROFILE_ONGOING_TICKS = 0.5  # the trajectory is farther than this from its goal
# Bytes of a status frame before its data and behind them.
HEAD_BYTES, CRC_BYTES = 9, 2


def _crc_table() -> IntArray:
    """Return the CRC of every byte: polynomial 0x8005, most significant bit first."""
    value = np.arange(1 << 8, dtype=np.int64) << 8
    for _ in range(8):
        value = np.where(value & 0x8000, value << 1 ^ 0x8005, value << 1) & 0xFFFF
    return value


_CRC = _crc_table()


@in_place
@compiled
def _moving_status(servo: Any) -> int:
    """What register Moving Status says of a control loop, a record of ``firmware.SERVO``."""
    mode = servo.operating_mode
    if not servo.torque or mode in (CURRENT, VELOCITY, PWM):
        return IN_POSITION
    if not abs(servo.goal_position - servo.trajectory) > PROFILE_ONGOING_TICKS:
        return IN_POSITION
    if servo.profile_velocity == 0.0:
        return PROFILE_ONGOING | NO_PROFILE
    return PROFILE_ONGOING | (TRAPEZOIDAL if servo.profile_acceleration != 0.0 else RECTANGULAR)


@in_place
@compiled
def measure(
    servos: Any,
    i: int,
    settings: FloatArray,
    ticks: FloatArray,
    rate_rad_s: FloatArray,
    current_a: FloatArray,
    supply_v: FloatArray,
    temperature_c: FloatArray,
    time_ms: int,
    values: FloatArray,
) -> None:
    """Round what one servo measures to its registers.

    Args:
        servos: Records of the firmware, (N,).
        i: Index of the servo.
        settings: Its row of settings, (5,).
        ticks: ``MotorReadings``, as all up to ``temperature_c``, (N,).
        rate_rad_s: Speeds.
        current_a: Currents.
        supply_v: Voltages.
        temperature_c: Temperatures.
        time_ms: Register Realtime Tick.
        values: From Realtime Tick to Present Temperature, by address, (11,); written.
    """
    servo = servos[i]
    sense, offset, unit_a = settings[SENSE], settings[OFFSET], settings[CURRENT_UNIT]
    status = _moving_status(servo)
    moving = abs(rate_rad_s[i]) > settings[MOVING_RAD_S] or (status & PROFILE_ONGOING) != 0
    if servo.operating_mode == VELOCITY:
        planned = servo.ramp_velocity
    else:
        planned = servo.trajectory_rate * TICK_RAD / VELOCITY_UNIT_RAD_S
    values[0] = time_ms
    values[1] = 1.0 if moving else 0.0
    values[2] = status
    values[3] = np.rint(sense * servo.pwm)
    if unit_a > 0.0:
        values[4] = np.rint(sense * (current_a[i] / unit_a))
    else:  # a servo without a current: its own output
        values[4] = np.rint(sense * servo.pwm / DUTY_FULL / LOAD_UNIT)
    values[5] = np.rint(sense * rate_rad_s[i] / VELOCITY_UNIT_RAD_S)
    values[6] = np.rint(sense * ticks[i]) + offset
    values[7] = np.rint(sense * planned)
    values[8] = np.rint(sense * servo.trajectory) + offset
    values[9] = np.rint(supply_v[i] / VOLTAGE_UNIT_V)
    values[10] = np.rint(temperature_c[i])
    if values[10] < 0.0:
        values[10] = 0.0


@in_place
@compiled
def _frame(
    servo_id: int, alert: int, values: FloatArray, sizes: IntArray, begin: int, length: int,
    data: Any, first: int,
) -> int:  # fmt: skip
    """Write a status frame with a part of the measured registers; return where it ends."""
    data[first], data[first + 1], data[first + 2], data[first + 3] = 0xFF, 0xFF, 0xFD, 0
    data[first + 4], data[first + 7], data[first + 8] = servo_id, STATUS, alert
    at, place = first + HEAD_BYTES, 0
    for r in range(len(values)):
        number = int(values[r])
        for byte in range(sizes[r]):
            if begin <= place < begin + length:
                data[at] = number >> 8 * byte & 0xFF
                at += 1
                mark = at - first >= HEAD_BYTES + 3 and data[at - 1] == 0xFD
                if mark and data[at - 2] == 0xFF and data[at - 3] == 0xFF:  # stuffing
                    data[at] = 0xFD
                    at += 1
            place += 1
    size = at - first - 7 + CRC_BYTES
    data[first + 5], data[first + 6] = size & 0xFF, size >> 8
    crc = 0
    for k in range(first, at):
        crc = (crc << 8 ^ _CRC[crc >> 8 ^ data[k]]) & 0xFFFF
    data[at], data[at + 1] = crc & 0xFF, crc >> 8
    return at + CRC_BYTES


@compiled
def measured_answers(
    servos: Any,
    who: IntArray,
    ids: IntArray,
    settings: FloatArray,
    ticks: FloatArray,
    rate_rad_s: FloatArray,
    current_a: FloatArray,
    supply_v: FloatArray,
    temperature_c: FloatArray,
    time_ms: int,
    bounds: FloatArray,
    sizes: IntArray,
    begin: int,
    length: int,
    data: Any,
    ends: IntArray,
) -> bool:
    """Write the answers to a read of measured registers, one behind the other.

    Args:
        servos: Records of the firmware, (N,).
        who: Index of each servo that answers, (M,).
        ids: Their ids, (M,).
        settings: By index, (N, 5).
        ticks: ``MotorReadings``, as all up to ``temperature_c``, (N,).
        rate_rad_s: Speeds.
        current_a: Currents.
        supply_v: Voltages.
        temperature_c: Temperatures.
        time_ms: Register Realtime Tick.
        bounds: Least and largest value of each measured register, by address, (11, 2).
        sizes: Their bytes, (11,).
        begin: First byte that is read, counted from the first measured one.
        length: Bytes that are read; all of them are measured.
        data: The bytes, long enough; written.
        ends: Where each answer ends in them, (M,); written.

    Returns:
        Whether all values fit their registers; if not, nothing written is to be used.
    """
    values = np.empty(len(sizes))
    at = 0
    for m in range(len(who)):
        i = who[m]
        measure(
            servos, i, settings[i], ticks, rate_rad_s, current_a, supply_v, temperature_c, time_ms,
            values,
        )  # fmt: skip
        for r in range(len(values)):
            if not bounds[r, 0] <= values[r] <= bounds[r, 1]:
                return False
        alert = int(settings[i, ALERT])
        at = _frame(ids[m], alert, values, sizes, begin, length, data, at)
        ends[m] = at
    return True


def prepare() -> None:
    """Load or make the machine code, so that no answer waits for it."""
    servos = np.zeros(1, dtype=SERVO)
    compile_for(measure, servos, COUNT, *given(1, 1, 1, 1, 1, 1), COUNT, *out(1))
    compile_for(
        measured_answers, servos, *given(1, 1, kind=COUNT), *given(2, 1, 1, 1, 1, 1), COUNT,
        *given(2), *given(1, kind=COUNT), COUNT, COUNT, *out(1, kind="uint8"), *out(1, kind=COUNT),
    )  # fmt: skip
