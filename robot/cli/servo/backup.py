"""``bigant servo backup``: everything the servos keep, into a file.

Reads all EEPROM registers and the gains of every servo that answers, with id, model, firmware and
date, into a TOML file that ``bigant servo restore`` puts back. Writes nothing to any servo.
"""

import argparse
import time
from pathlib import Path

from model.errors import BusError
from robot.bringup.servo.access import (
    add_port,
    bauds_of,
    open_port,
    progress,
    scan_port,
    servo_at,
    write_new,
)
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser)
    parser.add_argument("--out", type=Path, metavar="FILE", required=True, help="a new .toml file")


def run(options: argparse.Namespace) -> ExitCode:
    """Read and write the file.

    Raises:
        BusError: Nobody answers, or a servo stops answering.
        ConfigError: The file exists or cannot be written.
    """
    from drivers.dynamixel.image import read_image
    from drivers.dynamixel.mx106 import MODEL_NUMBER
    from robot.bringup.servo.backup_file import Backup, backup_text

    found = scan_port(options.port, bauds_of(options))
    images = []
    for place, servo in enumerate(found, start=1):
        if servo.model != MODEL_NUMBER:
            print(
                f"id {servo.servo_id}: model {servo.model}, left out: its registers are not known"
            )
            continue
        progress(f"reading servo {place} of {len(found)} ...")
        with open_port(options.port, servo.baud_rate) as (port, packets):
            images.append(read_image(servo_at(port, packets, servo.servo_id)))
    progress("")
    if not images:
        raise BusError(f"no MX-106 answers on {options.port}: check power and cable")
    date = time.strftime("%Y-%m-%dT%H:%M:%S%z")
    write_new(options.out, backup_text(Backup(date, options.port, tuple(images))), "--out")
    ids = ", ".join(str(image.servo_id) for image in images)
    print(
        f"{len(images)} servos (ids {ids}), {len(images[0].values)} registers each: {options.out}"
    )
    return ExitCode.OK
