"""``bigant ft bias``: what the sensors read with no contact, measured on the host.

Hang the robot up so that no foot touches anything. The mean over some seconds goes into a calibration
file, with its standard error; the unit itself is not changed unless --device is given. Refused when the
readings spread or wander as they do when something touches the robot.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_json, add_robot, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_robot(parser)
    parser.add_argument("--force-unit", metavar="HOST[:UDP:CONSOLE]", help="(default: robot file)")
    parser.add_argument("--seconds", type=float, default=5.0, metavar="S", help="(default: 5)")
    parser.add_argument(
        "--out",
        type=Path,
        default=Path("force-bias.toml"),
        metavar="FILE",
        help="calibration file to write (default: force-bias.toml)",
    )
    device = parser.add_mutually_exclusive_group()
    device.add_argument(
        "--device-off",
        action="store_true",
        help="first switch the unit's own BIAS off, which somebody may have left on",
    )
    device.add_argument(
        "--device",
        action="store_true",
        help="also switch the unit's own BIAS on for every transducer (it then counts from zero, so "
        "the file holds zeros measured after that)",
    )
    add_json(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """Measure the bias."""
    from robot.bringup.force.bias import BiasRequest, measure

    return measure(parsed(options, BiasRequest))
