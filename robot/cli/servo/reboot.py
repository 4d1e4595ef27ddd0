"""``bigant servo reboot``: reboot servos, and keep what they are about to forget.

Reads the hardware error and the turns first, reboots, waits until the servo is back, and checks that
torque is off. Says what was lost. A servo that holds torque drops what it carries, so that takes a yes.
"""

import argparse

from robot.console.arguments import add_json, add_port, add_robot, parsed, servo_id
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_port(parser, baud="baud rate (robot file)")
    parser.add_argument("--id", type=_id_or_all, metavar="N|all", required=True, help="which servo")
    add_robot(parser)
    parser.add_argument("--yes", action="store_true", help="also if it holds torque")
    add_json(parser)


def _id_or_all(text: str) -> int | None:
    return None if text == "all" else servo_id(text)


def run(options: argparse.Namespace) -> ExitCode:
    """Reboot."""
    from robot.bringup.servo.reboot import RebootRequest, reboot

    return reboot(parsed(options, RebootRequest))
