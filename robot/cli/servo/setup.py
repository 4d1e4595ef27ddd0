"""``bigant servo setup``: bring servos into the settings of the robot file.

Shows what differs in each servo's memory before anything is written (id, baud rate, return delay,
operating mode, homing offset, limits, shutdown), asks, writes, reads back, and talks at the new baud
rate. Refuses servos with torque on, and two servos with one id. A servo with an id that the robot
file does not know gets the one that is missing, if it is the only one; otherwise connect one at a time.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from model.errors import BusError, ConfigError
from robot.bringup.servo.access import (
    add_port,
    baud_rate,
    bauds_of,
    confirmed,
    leg_of,
    open_port,
    progress,
    robot_of,
    scan_port,
    servo_at,
    servo_id,
)
from robot.console.arguments import add_robot
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from drivers.dynamixel.image import Change
    from drivers.dynamixel.scan import FoundServo
    from robot.config.robot_file import RobotConfig


@dataclass(frozen=True, slots=True)
class Task:
    """One servo and what it is to become.

    Attributes:
        found: The servo.
        new_id: Its id afterwards.
    """

    found: "FoundServo"
    new_id: int


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser)
    add_robot(parser)
    parser.add_argument("--id", type=servo_id, metavar="N", help="this servo only")
    parser.add_argument("--new-id", type=servo_id, metavar="M", help="the id it is to have")
    parser.add_argument(
        "--new-baud", type=baud_rate, metavar="B", help="the baud rate to have (robot file)"
    )
    parser.add_argument("--yes", action="store_true", help="write without being asked")


def run(options: argparse.Namespace) -> ExitCode:
    """Show, ask, write, verify.

    Returns:
        OK when all is as wanted, VERDICT_FAILED when something differs and was not written.

    Raises:
        BusError: A servo cannot be set up.
        ConfigError: The options make no sense.
    """
    config = robot_of(options)
    new_baud = options.new_baud if options.new_baud is not None else config.servo_bus.baud_rate
    found = scan_port(options.port, bauds_of(options))
    tasks = plan(found, config, options.id, options.new_id, options.port)
    changes = [_inspect(options.port, task, config, new_baud) for task in tasks]
    from robot.bringup.servo.wanted import change_lines

    for task, some in zip(tasks, changes, strict=True):
        servo = task.found
        title = f"{leg_of(task.new_id, config)}  id {servo.servo_id} at {servo.baud_rate} baud"
        print(f"{title}: " + (f"{len(some)} to change" if some else "as wanted"))
        for line in change_lines(some) if some else []:
            print(line)
    todo = [(task, some) for task, some in zip(tasks, changes, strict=True) if some]
    if not todo:
        return ExitCode.OK
    if not confirmed(f"write this to {len(todo)} servo(s)?", yes=options.yes):
        return ExitCode.VERDICT_FAILED
    for place, (task, some) in enumerate(todo, start=1):
        progress(f"writing servo {place} of {len(todo)} ...")
        _write(options.port, task, some, config, new_baud)
    progress("")
    print(f"{len(todo)} servo(s) written and read back, answering at {new_baud} baud")
    return ExitCode.OK


def plan(
    found: "Sequence[FoundServo]",
    config: "RobotConfig",
    only: int | None,
    new_id: int | None,
    port: str,
) -> list[Task]:
    """Decide which servo is to have which id. Pure.

    Args:
        found: Who answered, at any baud rate.
        config: Robot file.
        only: The one servo to set up, or None for all.
        new_id: Its new id, or None.
        port: Port name, for messages.

    Raises:
        BusError: Nobody answers, ids are shared, or it is not clear who should have which id.
        ConfigError: The options make no sense.
    """
    if not found:
        raise BusError(f"no servo answers on {port}: check power and cable", port=port)
    shared = [number for number, count in Counter(s.servo_id for s in found).items() if count > 1]
    if shared:
        _refuse_shared(shared[0], port)
    known = {int(i) for i in config.servo_bus.ids}
    present = {servo.servo_id for servo in found}
    if only is not None and only not in present:
        raise BusError(f"no servo with id {only} answers on {port}", port=port, ids=(only,))
    chosen = [servo for servo in found if only is None or servo.servo_id == only]
    if new_id is not None:
        if len(chosen) != 1:
            raise ConfigError("--new-id", "is for one servo; say which with --id")
        if new_id in present - {chosen[0].servo_id}:
            raise BusError(f"id {new_id} is taken on {port}; choose another", port=port)
        return [Task(chosen[0], new_id)]
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
    return [Task(s, s.servo_id if s.servo_id in known else missing[0]) for s in chosen]


def _refuse_shared(number: int, port: str) -> None:
    raise BusError(
        f"two servos on {port} share id {number}: connect one at a time and give each its own with "
        "--new-id",
        port=port,
        ids=(number,),
    )


def _inspect(
    port_name: str, task: Task, config: "RobotConfig", new_baud: int
) -> "tuple[Change, ...]":
    """Return what differs in one servo; refuse what must not be written to."""
    from drivers.dynamixel.collision import id_is_shared
    from drivers.dynamixel.image import read_image, require_torque_off
    from drivers.dynamixel.mx106 import MODEL_NUMBER
    from robot.bringup.servo.wanted import differences, wanted_of

    found = task.found
    if found.model != MODEL_NUMBER:
        raise BusError(
            f"id {found.servo_id} is model {found.model}, no MX-106(2.0); set it up with Dynamixel "
            "Wizard",
            port=port_name,
            ids=(found.servo_id,),
            register="model_number",
        )
    with open_port(port_name, found.baud_rate) as (port, packets):
        if id_is_shared(port, packets, found.servo_id):
            _refuse_shared(found.servo_id, port_name)
        servo = servo_at(port, packets, found.servo_id, config)
        require_torque_off(servo)
        return differences(read_image(servo), wanted_of(config, new_baud), task.new_id)


def _write(
    port_name: str,
    task: Task,
    changes: "Sequence[Change]",
    config: "RobotConfig",
    new_baud: int,
) -> None:
    from drivers.dynamixel.image import read_image, write_changes
    from robot.bringup.servo.wanted import differences, wanted_of

    with open_port(port_name, task.found.baud_rate) as (port, packets):
        servo = write_changes(servo_at(port, packets, task.found.servo_id, config), changes)
        left = differences(read_image(servo), wanted_of(config, new_baud), task.new_id)
        if left:
            raise BusError(
                f"{servo.leg} (id {servo.servo_id}) does not keep {left[0].name}: switch its power "
                "off and on and try again",
                port=port_name,
                ids=(servo.servo_id,),
                register=left[0].name,
            )
