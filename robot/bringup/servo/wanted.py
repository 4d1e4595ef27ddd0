"""What the robot file wants of a servo's own memory. Pure."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from drivers.dynamixel.image import BAUD_OF_CODE, Change, ServoImage
from drivers.dynamixel.mx106 import (
    BAUD_CODES,
    CURRENT_UNIT_A,
    VELOCITY_UNIT_RAD_S,
    VOLTAGE_UNIT_V,
    OperatingMode,
    hardware_error_names,
)
from robot.config.robot_file import RobotConfig

SHUTDOWN = 0x34  # overload, electrical shock, overheating: the factory's choice
HEADROOM = 1.1  # a supply ten per cent above nominal must not be an error


@dataclass(frozen=True, slots=True)
class Wanted:
    """A register and what it may hold.

    Attributes:
        name: Register name.
        value: What is written if it holds something else.
        lowest: Smallest value that may stay.
        highest: Largest value that may stay.
        why: In words.
    """

    name: str
    value: int
    lowest: int
    highest: int
    why: str


def wanted_of(config: RobotConfig, baud_rate: int) -> tuple[Wanted, ...]:
    """Return what each servo of a robot is to hold, its id apart.

    The servos' own limits must lie beyond those of the robot file, so that ours act first, and within
    the factory's.
    """
    limits, servo = config.limits, config.parameters.servo
    hot = min(80, math.ceil(limits.max_temperature_c))
    low = max(95, math.floor(limits.min_voltage_v / VOLTAGE_UNIT_V))
    high = min(160, math.ceil(HEADROOM * servo.supply_voltage / VOLTAGE_UNIT_V))
    current = min(2047, math.ceil(limits.max_current_a / CURRENT_UNIT_A))
    speed = min(1023, math.ceil(limits.max_speed_rad_s / VELOCITY_UNIT_RAD_S))
    code = BAUD_CODES[baud_rate]

    def exactly(name: str, value: int, why: str) -> Wanted:
        return Wanted(name, value, value, value, why)

    return (
        exactly("baud_rate", code, "servo_bus.baud_rate"),
        Wanted("return_delay_time", 0, 0, 1, "each servo's wait costs every tick"),
        exactly("drive_mode", 0, "servo_sign turns the sense, not the servo"),
        exactly("operating_mode", OperatingMode.EXTENDED_POSITION, "shafts turn round and round"),
        exactly("secondary_id", 255, "a shadow id would obey another's commands"),
        exactly("homing_offset", 0, "servo_zero holds the offset"),
        Wanted("temperature_limit", 80, hot, 80, "beyond servo.max_temperature"),
        Wanted("max_voltage_limit", 160, high, 160, "above servo.supply_voltage"),
        Wanted("min_voltage_limit", 95, 95, low, "below servo.min_voltage"),
        exactly("pwm_limit", 885, "full duty"),
        Wanted("current_limit", 2047, current, 2047, "beyond servo.max_current"),
        Wanted("velocity_limit", max(210, speed), speed, 1023, "beyond servo.max_speed"),
        exactly("shutdown", SHUTDOWN, "overload, electrical shock, overheating"),
    )


def differences(image: ServoImage, wanted: Sequence[Wanted], new_id: int) -> tuple[Change, ...]:
    """Return what has to change in one servo, its id first."""
    changes = [Change("id", image.servo_id, new_id, "legs.dynamixel_id")]
    for item in wanted:
        present = image.value(item.name)
        stays = item.lowest <= present <= item.highest
        changes.append(Change(item.name, present, present if stays else item.value, item.why))
    return tuple(change for change in changes if change.present != change.wanted)


def in_words(name: str, value: int) -> str:
    """Return a register's value with what it means."""
    if name == "baud_rate":
        return f"{value} ({BAUD_OF_CODE.get(value, '?')} baud)"
    if name == "return_delay_time":
        return f"{value} ({2 * value} us)"
    if name == "operating_mode":
        known = {int(mode): mode.name.lower().replace("_", " ") for mode in OperatingMode}
        return f"{value} ({known.get(value, '?')})"
    if name == "shutdown":
        return f"0x{value:02x} ({', '.join(hardware_error_names(value)) or 'never'})"
    if name.endswith("voltage_limit"):
        return f"{value} ({value * VOLTAGE_UNIT_V:.1f} V)"
    if name == "temperature_limit":
        return f"{value} (degC)"
    if name == "current_limit":
        return f"{value} ({value * CURRENT_UNIT_A:.2f} A)"
    if name == "velocity_limit":
        return f"{value} ({value * VELOCITY_UNIT_RAD_S:.2f} rad/s)"
    return str(value)


def change_lines(changes: Sequence[Change]) -> list[str]:
    """Return changes as a table: register, what is there, what is wanted, why."""
    rows = [("register", "there", "wanted", "why")]
    rows += [
        (c.name, in_words(c.name, c.present), in_words(c.name, c.wanted), c.why) for c in changes
    ]
    widths = [max(len(row[column]) for row in rows) for column in range(3)]
    return [
        "  " + "  ".join(f"{cell:<{w}}" for cell, w in zip(row, [*widths, 0], strict=True)).rstrip()
        for row in rows
    ]
