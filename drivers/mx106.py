"""The MX-106 with protocol 2.0 firmware: control table as data, and counts to SI and back.

Source: ROBOTIS e-manual, MX-106(2.0), control table; addresses and sizes agree with ROBOTIS' own
model files. Everything here is pure.
"""

import enum
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.settings import ServoBusSettings
from model.signals import (
    BoolArray,
    FloatArray,
    IntArray,
    JointCommand,
    JointState,
    ServoReadings,
    readonly,
)

MODEL_NUMBER = 321
MODEL_NUMBER_PROTOCOL_1 = 320
TICKS_PER_TURN = 4096
TICK_RAD = 2 * np.pi / TICKS_PER_TURN
# 1 count a 64 ms is 0.228882 rpm; the manual rounds to 0.229 and its acceleration unit needs this.
VELOCITY_UNIT_RAD_S = (1 / 4096 / 0.064) * 2 * np.pi
CURRENT_UNIT_A = 0.00336
DUTY_FULL = 885
VOLTAGE_UNIT_V = 0.1
WATCHDOG_UNIT_S = 0.02
RETURN_DELAY_UNIT_S = 2e-6
EXTENDED_POSITION_LIMIT = 1_048_575
BAUD_CODES = MappingProxyType(
    {
        9_600: 0,
        57_600: 1,
        115_200: 2,
        1_000_000: 3,
        2_000_000: 4,
        3_000_000: 5,
        4_000_000: 6,
        4_500_000: 7,
    }
)


class OperatingMode(enum.IntEnum):
    """Values of register 11."""

    CURRENT = 0
    VELOCITY = 1
    POSITION = 3
    EXTENDED_POSITION = 4
    CURRENT_BASED_POSITION = 5
    PWM = 16


class HardwareError(enum.IntFlag):
    """Bits of register 70, and of the shutdown mask in register 63."""

    INPUT_VOLTAGE = 0x01
    OVERHEATING = 0x04
    MOTOR_ENCODER = 0x08
    ELECTRICAL_SHOCK = 0x10
    OVERLOAD = 0x20


def hardware_error_names(value: int) -> tuple[str, ...]:
    """Return the names of the bits set, in words."""
    return tuple((bit.name or "").lower().replace("_", " ") for bit in HardwareError if value & bit)


@dataclass(frozen=True, slots=True)
class Register:
    """One item of the control table.

    Attributes:
        name: Name in snake case.
        address: First byte.
        size: Bytes.
        writable: Whether it may be written at all.
        eeprom: Whether it is kept without power, and locked while torque is on.
        initial: Factory value, None where it is measured.
        minimum: Smallest value allowed.
        maximum: Largest value allowed.
        signed: Two's complement.
    """

    name: str
    address: int
    size: int
    writable: bool
    eeprom: bool
    initial: int | None
    minimum: int
    maximum: int
    signed: bool

    def decode(self, data: bytes) -> int:
        """Return the value of this register's bytes."""
        return int.from_bytes(data, "little", signed=self.signed)

    def encode(self, value: int) -> bytes:
        """Return the bytes of a value."""
        if not self.signed and value < 0:
            value &= (1 << 8 * self.size) - 1
        return value.to_bytes(self.size, "little", signed=self.signed)


def _e(
    name: str, address: int, size: int, initial: int | None, minimum: int, maximum: int
) -> Register:
    return Register(name, address, size, True, True, initial, minimum, maximum, minimum < 0)


def _w(
    name: str, address: int, size: int, initial: int | None, minimum: int, maximum: int
) -> Register:
    return Register(name, address, size, True, False, initial, minimum, maximum, minimum < 0)


def _r(
    name: str, address: int, size: int, *, signed: bool = False, eeprom: bool = False
) -> Register:
    low = -(1 << 8 * size - 1) if signed else 0
    high = (1 << 8 * size - (1 if signed else 0)) - 1
    return Register(name, address, size, False, eeprom, None, low, high, signed)


REGISTERS: tuple[Register, ...] = (
    _r("model_number", 0, 2, eeprom=True),
    _r("model_information", 2, 4, eeprom=True),
    _r("firmware_version", 6, 1, eeprom=True),
    _e("id", 7, 1, 1, 0, 252),
    _e("baud_rate", 8, 1, 1, 0, 7),
    _e("return_delay_time", 9, 1, 250, 0, 254),
    _e("drive_mode", 10, 1, 0, 0, 7),
    _e("operating_mode", 11, 1, 3, 0, 16),
    _e("secondary_id", 12, 1, 255, 0, 255),
    _e("protocol_type", 13, 1, 2, 1, 2),
    _e("homing_offset", 20, 4, 0, -1_044_479, 1_044_479),
    _e("moving_threshold", 24, 4, 10, 0, 1023),
    _e("temperature_limit", 31, 1, 80, 0, 100),
    _e("max_voltage_limit", 32, 2, 160, 95, 160),
    _e("min_voltage_limit", 34, 2, 95, 95, 160),
    _e("pwm_limit", 36, 2, 885, 0, 885),
    _e("current_limit", 38, 2, 2047, 0, 2047),
    _e("acceleration_limit", 40, 4, 32767, 0, 32767),
    _e("velocity_limit", 44, 4, 210, 0, 1023),
    _e("max_position_limit", 48, 4, 4095, 0, 4095),
    _e("min_position_limit", 52, 4, 0, 0, 4095),
    _e("shutdown", 63, 1, 0x34, 0, 0x3D),
    _w("torque_enable", 64, 1, 0, 0, 1),
    _w("led", 65, 1, 0, 0, 1),
    _w("status_return_level", 68, 1, 2, 0, 2),
    _r("registered_instruction", 69, 1),
    _r("hardware_error_status", 70, 1),
    _w("velocity_i_gain", 76, 2, 1920, 0, 16383),
    _w("velocity_p_gain", 78, 2, 100, 0, 16383),
    _w("position_d_gain", 80, 2, 0, 0, 16383),
    _w("position_i_gain", 82, 2, 0, 0, 16383),
    _w("position_p_gain", 84, 2, 850, 0, 16383),
    _w("feedforward_2nd_gain", 88, 2, 0, 0, 16383),
    _w("feedforward_1st_gain", 90, 2, 0, 0, 16383),
    Register("bus_watchdog", 98, 1, True, False, 0, -1, 127, True),
    _w("goal_pwm", 100, 2, 885, -885, 885),
    _w("goal_current", 102, 2, 2047, -2047, 2047),
    _w("goal_velocity", 104, 4, 0, -1023, 1023),
    _w("profile_acceleration", 108, 4, 0, 0, 32767),
    _w("profile_velocity", 112, 4, 0, 0, 32767),
    _w("goal_position", 116, 4, 0, -EXTENDED_POSITION_LIMIT, EXTENDED_POSITION_LIMIT),
    _r("realtime_tick", 120, 2),
    _r("moving", 122, 1),
    _r("moving_status", 123, 1),
    _r("present_pwm", 124, 2, signed=True),
    _r("present_current", 126, 2, signed=True),
    _r("present_velocity", 128, 4, signed=True),
    _r("present_position", 132, 4, signed=True),
    _r("velocity_trajectory", 136, 4, signed=True),
    _r("position_trajectory", 140, 4, signed=True),
    _r("present_input_voltage", 144, 2),
    _r("present_temperature", 146, 1),
    *(_w(f"indirect_address_{i + 1}", 168 + 2 * i, 2, 224 + i, 64, 661) for i in range(28)),
    *(_w(f"indirect_data_{i + 1}", 224 + i, 1, 0, 0, 255) for i in range(28)),
    *(_w(f"indirect_address_{i + 29}", 578 + 2 * i, 2, 634 + i, 64, 661) for i in range(28)),
    *(_w(f"indirect_data_{i + 29}", 634 + i, 1, 0, 0, 255) for i in range(28)),
)
REGISTER = MappingProxyType({register.name: register for register in REGISTERS})

# One sync read of everything measured: PWM to temperature.
READ_ADDRESS = REGISTER["present_pwm"].address
READ_LENGTH = REGISTER["present_temperature"].address + 1 - READ_ADDRESS


def ticks_to_angle(ticks: FloatArray | IntArray, sign: IntArray, zero: IntArray) -> FloatArray:
    """Return shaft angles in the leg's sense [rad] of positions [ticks]."""
    angle: FloatArray = np.asarray(sign * (ticks - zero) * TICK_RAD, dtype=np.float64)
    return angle


def angle_to_ticks(angle_rad: FloatArray, sign: IntArray, zero: IntArray) -> IntArray:
    """Return the nearest positions [ticks] of shaft angles in the leg's sense [rad]."""
    ticks: IntArray = np.rint(zero + sign * angle_rad / TICK_RAD).astype(np.int64)
    return ticks


def command_ticks(command: JointCommand, settings: ServoBusSettings) -> IntArray:
    """Return goal positions [ticks] of a command, (N,) int64."""
    return angle_to_ticks(command.angle_rad, settings.signs, settings.zeros)


def joint_state(readings: ServoReadings, settings: ServoBusSettings) -> JointState:
    """Calibrate one sync read into the leg's sense and SI units; NaN where a servo was silent."""
    valid: BoolArray = readings.valid

    def known(values: NDArray[Any]) -> FloatArray:
        array: FloatArray = readonly(np.where(valid, values, np.nan).astype(np.float64))
        return array

    signs, zeros = settings.signs, settings.zeros
    return JointState(
        t_ns=readings.t_ns,
        angle_rad=known(ticks_to_angle(readings.position_ticks, signs, zeros)),
        rate_rad_s=known(signs * readings.velocity_counts * VELOCITY_UNIT_RAD_S),
        current_a=known(signs * readings.current_counts * CURRENT_UNIT_A),
        duty=known(signs * readings.duty_counts / DUTY_FULL),
        voltage_v=known(readings.voltage_counts * VOLTAGE_UNIT_V),
        temperature_c=known(readings.temperature_c * 1.0),
        valid=valid,
    )
