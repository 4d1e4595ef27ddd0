"""``bigant servo setup``: what the robot file wants of each servo's own memory, and who gets which id."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from drivers.dynamixel.image import Change, ServoImage
from drivers.dynamixel.mx106 import (
    BAUD_CODES,
    CURRENT_UNIT_A,
    MODEL_NUMBER,
    VELOCITY_UNIT_RAD_S,
    VOLTAGE_UNIT_V,
    OperatingMode,
)
from drivers.dynamixel.scan import ScannedServo
from drivers.dynamixel.setup import SHUTDOWN
from model.errors import BusError, ConfigError
from robot.bringup.servo.access import leg_of, require_answers, scan_port
from robot.bringup.servo.changes import Task, Writing, refuse_shared
from robot.config.robot_file import RobotConfig, load_robot
from robot.console.exit_codes import ExitCode
from robot.requests.servo import ServoSetupRequest

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
        present = image.values[item.name]
        stays = item.lowest <= present <= item.highest
        changes.append(Change(item.name, present, present if stays else item.value, item.why))
    return tuple(change for change in changes if change.present != change.wanted)


def set_up(request: ServoSetupRequest) -> ExitCode:
    """Show, ask, write, verify.

    Returns:
        OK when all is as wanted, VERDICT_FAILED when something differs and was not written.

    Raises:
        BusError: A servo cannot be set up.
        ConfigError: The options make no sense.
    """
    config = load_robot(request.robot)
    baud = request.new_baud if request.new_baud is not None else config.servo_bus.baud_rate
    servos = require_answers(scan_port(request.port, request.baud), request.port)
    wanted = wanted_of(config, baud)
    done = f"written and read back, answering at {baud} baud"
    return Writing(request.port, config, "as wanted", "to change", done, request.yes).carry_out([
        Task(
            servo,
            f"{leg_of(new_id, config)}  id {servo.servo_id} at {servo.baud_rate} baud",
            partial(differences, wanted=wanted, new_id=new_id),
        )
        for servo, new_id in plan(servos, config, request.id, request.new_id, request.port)
    ])  # fmt: skip


def plan(
    servos: Sequence[ScannedServo],
    config: RobotConfig,
    only: int | None,
    new_id: int | None,
    port: str,
) -> list[tuple[ScannedServo, int]]:
    """Decide which servo is to have which id. Pure.

    Args:
        servos: Who answered, at any baud rate; at least one.
        config: Robot file.
        only: The one servo to set up, or None for all.
        new_id: Its new id, or None.
        port: Port name, for messages.

    Raises:
        BusError: Ids are shared, a servo is of another model, or it is not clear who should have which id.
        ConfigError: The options make no sense.
    """
    shared = [number for number, count in Counter(s.servo_id for s in servos).items() if count > 1]
    if shared:
        refuse_shared(shared[0], port)
    known = {int(i) for i in config.servo_bus.ids}
    present = {servo.servo_id for servo in servos}
    if only is not None and only not in present:
        raise BusError(f"no servo with id {only} answers on {port}", port=port, ids=(only,))
    chosen = [servo for servo in servos if only is None or servo.servo_id == only]
    for servo in chosen:
        if servo.model != MODEL_NUMBER:
            raise BusError(
                f"id {servo.servo_id} is model {servo.model}, no MX-106(2.0); set it up with Dynamixel "
                "Wizard",
                port=port,
                ids=(servo.servo_id,),
                register="model_number",
            )
    if new_id is not None:
        if len(chosen) != 1:
            raise ConfigError("--new-id", "is for one servo; say which with --id")
        if new_id in present - {chosen[0].servo_id}:
            raise BusError(f"id {new_id} is taken on {port}; choose another", port=port)
        return [(chosen[0], new_id)]
    strangers = [servo for servo in chosen if servo.servo_id not in known]
    missing = sorted(known - present)
    if len(strangers) > 1 or (strangers and len(missing) != 1):
        ids = ", ".join(str(servo.servo_id) for servo in strangers)
        raise BusError(
            f"the robot file knows no servo with id {ids}: connect one at a time and say what it is "
            "to be with --id N --new-id M",
            port=port,
            ids=tuple(servo.servo_id for servo in strangers),
        )
    return [(s, s.servo_id if s.servo_id in known else missing[0]) for s in chosen]
