"""``bigant drive``: walk a gait and keep a log.

Virtual hardware is the default. Real ports are only listened to unless --armed is given. Ctrl-C stops on
all feet, a second Ctrl-C cuts torque; torque is always switched off on exit.
"""

import argparse
from pathlib import Path

from gaits.names import GAIT_NAMES
from robot.console.arguments import (
    add_robot,
    add_scenario,
    parsed,
    positive,
    seed,
    steer,
)
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    add_robot(parser)
    parser.add_argument("--gait", choices=GAIT_NAMES, default="tripod")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--cycles", type=positive, metavar="N", help="gait cycles (default: 3)")
    length.add_argument(
        "--duration", type=positive, metavar="S", dest="duration_s", help="seconds of walking"
    )
    parser.add_argument(
        "--frequency-hz", type=positive, metavar="F", help="cycles a second (default: robot file)"
    )
    parser.add_argument(
        "--steer", type=steer, default=0.0, metavar="X", help="-1 (right) to 1 (left)"
    )
    parser.add_argument(
        "--hardware",
        default="virtual",
        metavar="virtual|PORT",
        help="virtual (default), or the serial port of the servo bus, for example /dev/ttyUSB0",
    )
    parser.add_argument(
        "--force-unit",
        metavar="HOST[:UDP:CONSOLE]|none",
        help="wireless force-torque unit (default: robot file); none walks without it",
    )
    parser.add_argument(
        "--calibration",
        type=Path,
        metavar="FILE",
        help="calibration of the force sensors (default: the one that the robot file names, if any)",
    )
    parser.add_argument("--log", metavar="FILE", help="log file, or none (default: runs/...)")
    parser.add_argument(
        "--record-bytes",
        action="store_true",
        help="log the raw bytes of both devices as well, so that the drivers can be replayed",
    )
    parser.add_argument(
        "--pose-udp",
        type=_port,
        metavar="PORT",
        help="hear absolute poses on this UDP port of this machine (default: robot file, else none)",
    )
    parser.add_argument("--readonly", action="store_true", help="sense and log, never move")
    parser.add_argument("--armed", action="store_true", help="allow torque on real hardware")
    parser.add_argument("--teleop", action="store_true", help="drive with the keyboard")
    parser.add_argument(
        "--deadman",
        type=positive,
        default=5.0,
        metavar="S",
        dest="deadman_s",
        help="with --teleop: stand after so many seconds without a key (default: 5)",
    )
    parser.add_argument("--rate-hz", type=_rate, metavar="R", help="loop rate, up to 200")
    parser.add_argument(
        "--virtual-time",
        action="store_true",
        help="virtual hardware in memory under a virtual clock: as fast as the computer goes, and "
        "the same log, byte for byte, every time",
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of virtual noise")
    add_scenario(parser)


def _port(text: str) -> int:
    value = int(text)
    if not 1 <= value <= 65535:
        raise argparse.ArgumentTypeError(f"must be a port from 1 to 65535, not {text}")
    return value


def _rate(text: str) -> int:
    value = int(text)
    if not 10 <= value <= 200:
        raise argparse.ArgumentTypeError(f"must be from 10 to 200 Hz, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Drive.

    Raises:
        BigantError: Something is wrong before the robot moves.
    """
    from robot.drive.drive import drive
    from robot.drive.request import DriveRequest

    return drive(parsed(options, DriveRequest))
