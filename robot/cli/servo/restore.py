"""``bigant servo restore``: put a backup back.

Shows what differs between the file and each servo, asks, writes with torque off, and reads back. A
servo is found by its id; one of another model, or with torque on, is refused before anything is written.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from model.errors import BusError
from robot.bringup.servo.access import (
    add_port,
    bauds_of,
    confirmed,
    open_port,
    progress,
    scan_port,
    servo_at,
)
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from drivers.dynamixel.image import Change, ServoImage
    from drivers.dynamixel.scan import FoundServo


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("path", type=Path, metavar="FILE", help="made by bigant servo backup")
    add_port(parser)
    parser.add_argument("--yes", action="store_true", help="write without being asked")


def run(options: argparse.Namespace) -> ExitCode:
    """Show, ask, write, read back.

    Returns:
        OK when the servos are as in the file, VERDICT_FAILED when they differ and stay so.

    Raises:
        BusError: A servo is missing, of another model, or does not take a value.
        ConfigError: The file cannot be used.
    """
    from robot.bringup.servo.backup_file import load_backup
    from robot.bringup.servo.wanted import change_lines

    backup = load_backup(options.path)
    found = scan_port(options.port, bauds_of(options))
    pairs = [(image, _find(image, found, options.port)) for image in backup.servos]
    plans = []
    for image, servo in pairs:
        changes = _inspect(options.port, image, servo)
        print(
            f"id {image.servo_id}: " + (f"{len(changes)} differ" if changes else "as in the file")
        )
        if image.firmware != servo.firmware:
            print(f"  warning: saved with firmware {image.firmware}, it has {servo.firmware} now")
        for line in change_lines(changes) if changes else []:
            print(line)
        if changes:
            plans.append((image, servo, changes))
    if not plans:
        return ExitCode.OK
    if not confirmed(f"write this to {len(plans)} servo(s)?", yes=options.yes):
        return ExitCode.VERDICT_FAILED
    for place, (image, servo, changes) in enumerate(plans, start=1):
        progress(f"writing servo {place} of {len(plans)} ...")
        _write(options.port, image, servo, changes)
    progress("")
    print(f"{len(plans)} servo(s) restored as of {backup.date} and read back")
    return ExitCode.OK


def _find(image: "ServoImage", found: "Sequence[FoundServo]", port: str) -> "FoundServo":
    here = [servo for servo in found if servo.servo_id == image.servo_id]
    if len(here) != 1:
        what = "does not answer" if not here else "answers at two baud rates"
        raise BusError(
            f"id {image.servo_id} of the backup {what} on {port}; nothing has been written: give a "
            "replaced servo its id first, with bigant servo setup",
            port=port,
            ids=(image.servo_id,),
        )
    if here[0].model != image.model:
        raise BusError(
            f"id {image.servo_id} is model {here[0].model} and the backup is of model {image.model};"
            " nothing has been written: choose another backup",
            port=port,
            ids=(image.servo_id,),
            register="model_number",
        )
    return here[0]


def _inspect(port_name: str, image: "ServoImage", found: "FoundServo") -> "tuple[Change, ...]":
    from drivers.dynamixel.image import changes_to, read_image, require_torque_off

    with open_port(port_name, found.baud_rate) as (port, packets):
        servo = servo_at(port, packets, found.servo_id)
        require_torque_off(servo)
        return changes_to(read_image(servo), image.values)


def _write(
    port_name: str, image: "ServoImage", found: "FoundServo", changes: "Sequence[Change]"
) -> None:
    from drivers.dynamixel.image import changes_to, read_image, write_changes

    with open_port(port_name, found.baud_rate) as (port, packets):
        servo = write_changes(servo_at(port, packets, found.servo_id), changes)
        # a change of mode sets gains back to that mode's own, which are then to be written as well
        left = changes_to(read_image(servo), image.values)
        if left:
            servo = write_changes(servo, left)
            left = changes_to(read_image(servo), image.values)
        if left:
            raise BusError(
                f"id {servo.servo_id} does not keep {left[0].name}: switch its power off and on and "
                "try again",
                port=port_name,
                ids=(servo.servo_id,),
                register=left[0].name,
            )
