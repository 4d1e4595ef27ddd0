"""``bigant robot export``: the robot file as URDF or MJCF.

URDF is a tree: a crank joint (its value is the shaft angle) and a coupler joint a leg; the rocker that
closes the loop is left out, so set the coupler as the robot file's linkage has it. MJCF has the rocker and
closes the loop; its actuators hold shaft angles.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_robot
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_robot(parser)
    parser.add_argument("--urdf", type=Path, metavar="OUT", help="write a URDF")
    parser.add_argument("--mjcf", type=Path, metavar="OUT", help="write a MuJoCo model")


def run(options: argparse.Namespace) -> ExitCode:
    """Write the files."""
    from robot.config.xml import export

    return export(options.robot, urdf=options.urdf, mjcf=options.mjcf)
