"""The MX-106 with protocol 2.0 firmware: control table as data, and counts to SI and back.

Source: ROBOTIS e-manual, MX-106(2.0), control table; addresses and sizes agree with ROBOTIS' own
model files. Everything here is pure.
"""

import enum
import math
from dataclasses import dataclass
from functools import cache, partial
from types import MappingProxyType

import numpy as np

from drivers.dynamixel.settings import ServoBusSettings
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.legs import JointState
from model.values.readings import ServoReadings

MODEL_NUMBER = 321
MODEL_NUMBER_PROTOCOL_1 = 320
TICKS_PER_TURN = 4096
TICK_RAD = 2 * math.pi / TICKS_PER_TURN
# 1 count a 64 ms is 0.228882 rpm; the manual rounds to 0.229 and its acceleration unit needs this.
VELOCITY_UNIT_RAD_S = TICK_RAD / 0.064
CURRENT_UNIT_A = 0.00336
DUTY_FULL = 885
VOLTAGE_UNIT_V = 0.1
WATCHDOG_UNIT_S = 0.02
RETURN_DELAY_UNIT_S = 2e-6
EXTENDED_POSITION_LIMIT = 1_048_575
# Rates in the order of their codes, from 0.
_BAUD_RATES = (9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
BAUD_CODES = MappingProxyType({rate: code for code, rate in enumerate(_BAUD_RATES)})


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
    """Return the names of the bits set, in words; a bit without a name by its mask."""
    masks = [1 << bit for bit in range(8) if value & 1 << bit]
    names = {int(bit): str(bit.name).lower().replace("_", " ") for bit in HardwareError}
    return tuple(names.get(mask, f"bit 0x{mask:02x}") for mask in masks)


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
        """Return the bytes of a value.

        Raises:
            OverflowError: The value does not fit into the register's bytes.
        """
        return value.to_bytes(self.size, "little", signed=self.signed)


def _writable(
    name: str, address: int, size: int, initial: int, minimum: int, maximum: int, *, eeprom: bool
) -> Register:
    return Register(name, address, size, True, eeprom, initial, minimum, maximum, minimum < 0)


_kept, _volatile = partial(_writable, eeprom=True), partial(_writable, eeprom=False)


def _read_only(
    name: str, address: int, size: int, *, signed: bool = False, eeprom: bool = False
) -> Register:
    low = -(1 << 8 * size - 1) if signed else 0
    high = (1 << 8 * size - (1 if signed else 0)) - 1
    return Register(name, address, size, False, eeprom, None, low, high, signed)


REGISTERS: tuple[Register, ...] = (
    _read_only("model_number", 0, 2, eeprom=True),
    _read_only("model_information", 2, 4, eeprom=True),
    _read_only("firmware_version", 6, 1, eeprom=True),
    _kept("id", 7, 1, 1, 0, 252),
    _kept("baud_rate", 8, 1, 1, 0, 7),
    _kept("return_delay_time", 9, 1, 250, 0, 254),
    _kept("drive_mode", 10, 1, 0, 0, 7),
    _kept("operating_mode", 11, 1, 3, 0, 16),
    _kept("secondary_id", 12, 1, 255, 0, 255),
    _kept("protocol_type", 13, 1, 2, 1, 2),
    _kept("homing_offset", 20, 4, 0, -1_044_479, 1_044_479),
    _kept("moving_threshold", 24, 4, 10, 0, 1023),
    _kept("temperature_limit", 31, 1, 80, 0, 100),
    _kept("max_voltage_limit", 32, 2, 160, 95, 160),
    _kept("min_voltage_limit", 34, 2, 95, 95, 160),
    _kept("pwm_limit", 36, 2, 885, 0, 885),
    _kept("current_limit", 38, 2, 2047, 0, 2047),
    _kept("acceleration_limit", 40, 4, 32767, 0, 32767),
    _kept("velocity_limit", 44, 4, 210, 0, 1023),
    _kept("max_position_limit", 48, 4, 4095, 0, 4095),
    _kept("min_position_limit", 52, 4, 0, 0, 4095),
    _kept("shutdown", 63, 1, 0x34, 0, 0x3D),
    _volatile("torque_enable", 64, 1, 0, 0, 1),
    _volatile("led", 65, 1, 0, 0, 1),
    _volatile("status_return_level", 68, 1, 2, 0, 2),
    _read_only("registered_instruction", 69, 1),
    _read_only("hardware_error_status", 70, 1),
    _volatile("velocity_i_gain", 76, 2, 1920, 0, 16383),
    _volatile("velocity_p_gain", 78, 2, 100, 0, 16383),
    _volatile("position_d_gain", 80, 2, 0, 0, 16383),
    _volatile("position_i_gain", 82, 2, 0, 0, 16383),
    _volatile("position_p_gain", 84, 2, 850, 0, 16383),
    _volatile("feedforward_2nd_gain", 88, 2, 0, 0, 16383),
    _volatile("feedforward_1st_gain", 90, 2, 0, 0, 16383),
    _volatile("bus_watchdog", 98, 1, 0, -1, 127),
    _volatile("goal_pwm", 100, 2, 885, -885, 885),
    _volatile("goal_current", 102, 2, 2047, -2047, 2047),
    _volatile("goal_velocity", 104, 4, 0, -1023, 1023),
    _volatile("profile_acceleration", 108, 4, 0, 0, 32767),
    _volatile("profile_velocity", 112, 4, 0, 0, 32767),
    _volatile("goal_position", 116, 4, 0, -EXTENDED_POSITION_LIMIT, EXTENDED_POSITION_LIMIT),
    _read_only("realtime_tick", 120, 2),
    _read_only("moving", 122, 1),
    _read_only("moving_status", 123, 1),
    _read_only("present_pwm", 124, 2, signed=True),
    _read_only("present_current", 126, 2, signed=True),
    _read_only("present_velocity", 128, 4, signed=True),
    _read_only("present_position", 132, 4, signed=True),
    _read_only("velocity_trajectory", 136, 4, signed=True),
    _read_only("position_trajectory", 140, 4, signed=True),
    _read_only("present_input_voltage", 144, 2),
    _read_only("present_temperature", 146, 1),
    *(_volatile(f"indirect_address_{i + 1}", 168 + 2 * i, 2, 224 + i, 64, 661) for i in range(28)),
    *(_volatile(f"indirect_data_{i + 1}", 224 + i, 1, 0, 0, 255) for i in range(28)),
    *(_volatile(f"indirect_address_{i + 29}", 578 + 2 * i, 2, 634 + i, 64, 661) for i in range(28)),
    *(_volatile(f"indirect_data_{i + 29}", 634 + i, 1, 0, 0, 255) for i in range(28)),
)
REGISTER = MappingProxyType({register.name: register for register in REGISTERS})


def registers_between(first: str, last: str) -> list[Register]:
    """Return the registers from one to another, both included, by address."""
    low, high = REGISTER[first].address, REGISTER[last].address
    return [register for register in REGISTERS if low <= register.address <= high]


# One sync read of everything measured: PWM to temperature.
READ_ADDRESS = REGISTER["present_pwm"].address
READ_LENGTH = REGISTER["present_temperature"].address + 1 - READ_ADDRESS


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
    if not np.isfinite(angle_rad).all():
        raise ValueError("an angle is not a number and has no position")
    ticks: IntArray = np.rint(zero + _signed(angle_rad, sign) / TICK_RAD).astype(np.int64)
    return ticks


def _signed(values: FloatArray | IntArray, sign: IntArray) -> FloatArray:
    turned: FloatArray = sign.astype(np.float64) * values.astype(np.float64)
    return turned


DUTY = 3  # row of what ``joint_state`` makes


@cache
def _units(settings: ServoBusSettings) -> FloatArray:
    """Units of its rows; the first four turn with the leg's sense, (6, N)."""
    one = np.ones_like(settings.signs)
    turning = np.outer([TICK_RAD, VELOCITY_UNIT_RAD_S, CURRENT_UNIT_A, 1.0], settings.signs)
    return np.vstack([turning, VOLTAGE_UNIT_V * one, one])


def joint_state(readings: ServoReadings, settings: ServoBusSettings) -> JointState:
    """Calibrate one sync read into the leg's sense and SI units; NaN where a servo was silent."""
    valid = readings.valid
    # all at once: one by one these are thirty calls of numpy on six numbers each
    counts = np.array([
        readings.position_ticks - settings.zeros, readings.velocity_counts, readings.current_counts,
        readings.duty_counts, readings.voltage_counts, readings.temperature_c,
    ])  # fmt: skip
    rows = counts * _units(settings)
    rows[DUTY] /= DUTY_FULL
    if False in valid.tolist():
        rows[:, ~valid] = np.nan
    angle, rate, current, duty, voltage, temperature = readonly(rows)
    return JointState(readings.t_ns, angle, rate, current, duty, voltage, temperature, valid)
