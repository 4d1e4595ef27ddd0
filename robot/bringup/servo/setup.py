"""``bigant servo setup``: what the robot file wants of each servo's own memory, and who gets which id."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from drivers.dynamixel.catalog import MODEL_BY_NUMBER
from drivers.dynamixel.image import Change, ServoImage
from drivers.dynamixel.model_words import mismatch_words, unknown_words
from drivers.dynamixel.registers import OperatingMode, hardware_error_names
from drivers.dynamixel.scan import ScannedServo
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.units import BAUD_CODES, VELOCITY_UNIT_RAD_S, VOLTAGE_UNIT_V
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


def wanted_of(config: RobotConfig, baud_rate: int, model: ServoModel) -> tuple[Wanted, ...]:
    """Return what a servo of a robot is to hold, its id apart.

    The servos' own limits must lie beyond those of the robot file, so that ours act first, and within
    the factory's.

    Args:
        config: Robot file.
        baud_rate: [baud].
        model: Model of the servo.
    """
    limits, servo, table = config.limits, config.parameters.servo, model.table

    def exactly(name: str, value: int, why: str) -> Wanted:
        return Wanted(name, value, value, value, why)

    def factory(name: str) -> int:
        return table[name].initial or 0

    hottest = factory("temperature_limit")
    hot = min(hottest, math.ceil(limits.max_temperature_c))
    lowest, highest = table["min_voltage_limit"].minimum, table["max_voltage_limit"].maximum
    low = max(lowest, math.floor(limits.min_voltage_v / VOLTAGE_UNIT_V))
    high = min(highest, math.ceil(HEADROOM * servo.supply_voltage / VOLTAGE_UNIT_V))
    fastest = table["velocity_limit"].maximum
    speed = min(fastest, math.ceil(limits.max_speed_rad_s / VELOCITY_UNIT_RAD_S))
    wanted = [
        exactly("baud_rate", BAUD_CODES[baud_rate], "servo_bus.baud_rate"),
        Wanted("return_delay_time", 0, 0, 1, "each servo's wait costs every tick"),
        exactly("drive_mode", 0, "servo_sign turns the sense, not the servo"),
        exactly("operating_mode", OperatingMode.EXTENDED_POSITION, "shafts turn round and round"),
        exactly("secondary_id", 255, "a shadow id would obey another's commands"),
        exactly("homing_offset", 0, "servo_zero holds the offset"),
        Wanted("temperature_limit", hottest, hot, hottest, "beyond servo.max_temperature"),
        Wanted("max_voltage_limit", highest, high, highest, "above servo.supply_voltage"),
        Wanted("min_voltage_limit", lowest, lowest, low, "below servo.min_voltage"),
        exactly("pwm_limit", factory("pwm_limit"), "full duty"),
    ]
    if model.measures_current:
        most = table["current_limit"].maximum
        current = math.ceil(min(limits.max_current_a / model.current_unit_a, most))
        wanted.append(Wanted("current_limit", most, current, most, "beyond servo.max_current"))
    usual = max(factory("velocity_limit"), speed)
    shutdown = factory("shutdown")
    return (
        *wanted,
        Wanted("velocity_limit", usual, speed, fastest, "beyond servo.max_speed"),
        exactly("shutdown", shutdown, ", ".join(hardware_error_names(shutdown))),
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
    done = f"written and read back, answering at {baud} baud"
    return Writing(request.port, config, "as wanted", "to change", done, request.yes).carry_out([
        Task(
            servo,
            f"{leg_of(new_id, config)}  id {servo.servo_id} at {servo.baud_rate} baud",
            partial(
                differences,
                wanted=wanted_of(config, baud, MODEL_BY_NUMBER[servo.model]),
                new_id=new_id,
            ),
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
    if new_id is not None:
        if len(chosen) != 1:
            raise ConfigError("--new-id", "is for one servo; say which with --id")
        if new_id in present - {chosen[0].servo_id}:
            raise BusError(f"id {new_id} is taken on {port}; choose another", port=port)
        return _of_their_models([(chosen[0], new_id)], config, port)
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
    pairs = [(s, s.servo_id if s.servo_id in known else missing[0]) for s in chosen]
    return _of_their_models(pairs, config, port)


def _of_their_models(
    pairs: list[tuple[ScannedServo, int]], config: RobotConfig, port: str
) -> list[tuple[ScannedServo, int]]:
    """Return servos and their new ids if each is of the model that the robot file says.

    Raises:
        BusError: One is of another, or of a model that is not known.
    """
    models = config.servo_bus.model_of_id
    for servo, new_id in pairs:
        words = ""
        if new_id in models:
            words = mismatch_words(models[new_id], servo.model)
        elif servo.model not in MODEL_BY_NUMBER:
            words = unknown_words(servo.model)
        if words:
            raise BusError(
                f"{leg_of(new_id, config)} (id {servo.servo_id}) {words}",
                port=port,
                ids=(servo.servo_id,),
                register="model_number",
            )
    return pairs
