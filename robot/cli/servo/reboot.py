"""``bigant servo reboot``: reboot servos, and keep what they are about to forget.

Reads the hardware error and the turns first, reboots, waits until the servo is back, and sees that
torque is off. Says what was lost. A servo that holds torque drops what it carries, so that takes a yes.
"""

import argparse
import json
import sys
from dataclasses import asdict
from typing import TYPE_CHECKING

from model.errors import BusError
from robot.bringup.servo.access import (
    baud_rate,
    confirmed,
    open_port,
    robot_of,
    scan_port,
    servo_at,
    servo_id,
)
from robot.console.arguments import add_robot
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from drivers.dynamixel.reboot import Reboot


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--port", metavar="PORT", required=True, help="serial port")
    parser.add_argument("--baud", type=baud_rate, metavar="B", help="baud rate (robot file)")
    parser.add_argument("--id", type=_id_or_all, metavar="N|all", required=True, help="which servo")
    add_robot(parser)
    parser.add_argument("--yes", action="store_true", help="also if it holds torque")
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def _id_or_all(text: str) -> int | None:
    return None if text == "all" else servo_id(text)


def run(options: argparse.Namespace) -> ExitCode:
    """Reboot.

    Returns:
        OK, or VERDICT_FAILED when a servo still reports an error, or nothing was done.

    Raises:
        BusError: A servo does not answer, or does not come back.
    """
    from drivers.dynamixel.reboot import reboot_servo

    config = robot_of(options)
    baud = options.baud if options.baud is not None else config.servo_bus.baud_rate
    numbers = [options.id] if options.id is not None else _everybody(options.port, baud)
    with open_port(options.port, baud) as (port, packets):
        servos = [servo_at(port, packets, number, config) for number in numbers]
        holding = [f"{s.leg} (id {s.servo_id})" for s in servos if s.read("torque_enable")]
        if holding:
            question = f"{', '.join(holding)} will drop what they carry; reboot?"
            if not options.yes:
                print(f"torque is on: {', '.join(holding)}", file=sys.stderr)
            if not confirmed(question, yes=options.yes):
                return ExitCode.VERDICT_FAILED
        reboots = [reboot_servo(servo, port.clock) for servo in servos]
    if options.json:
        print(json.dumps([_as_json(reboot) for reboot in reboots], indent=2))
    else:
        for reboot in reboots:
            print(line_of(reboot))
    well = all(reboot.error_after == 0 for reboot in reboots)
    return ExitCode.OK if well else ExitCode.VERDICT_FAILED


def _everybody(port: str, baud: int) -> list[int]:
    numbers = [servo.servo_id for servo in scan_port(port, (baud,))]
    if not numbers:
        raise BusError(
            f"no servo answers on {port} at {baud} baud: check power and cable", port=port
        )
    return numbers


def line_of(reboot: "Reboot") -> str:
    """Return one reboot as a line."""
    from drivers.dynamixel.mx106 import hardware_error_names

    cause = ", ".join(reboot.cause_names) or "no hardware error"
    turns = reboot.turns_lost
    lost = f"{turns:+d} turns lost" if turns else "no turns lost"
    text = (
        f"{reboot.leg} (id {reboot.servo_id}): was {cause}; {lost} "
        f"({reboot.ticks_before} to {reboot.ticks_after} ticks); torque off; "
        f"back after {reboot.duration_s:.2f} s"
    )
    if reboot.error_after:
        names = ", ".join(hardware_error_names(reboot.error_after))
        text += f"; STILL REPORTS {names}: remove the cause"
    return text


def _as_json(reboot: "Reboot") -> dict[str, object]:
    return {
        **asdict(reboot),
        "cause_names": list(reboot.cause_names),
        "turns_lost": reboot.turns_lost,
    }
