"""``bigant ft identify``: press each foot, and see which transducer feels it and how it is turned.

For a robot that hangs in a frame, torque off. Each foot is pressed up, forward and to the robot's left,
with about 1 kg; a press is noticed by itself, and so is its end. Gives each leg's transducer, whether it is
mounted the right way up, and its yaw, and says which line of the robot file is to be changed to what.
--hardware virtual has a virtual person press the feet of a virtual robot, which --virtual-robot may make
differ from the robot file.
"""

import argparse

from robot.console.arguments import add_json, add_robot, add_virtual_robot, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("--hardware", choices=("virtual",), help="a virtual robot and its unit")
    parser.add_argument(
        "--force-unit", metavar="HOST[:UDP:CONSOLE]", help="wireless unit (robot file)"
    )
    add_robot(parser)
    add_virtual_robot(parser)
    parser.add_argument("--leg", default="all", metavar="LEG|all", help="foot to press (all)")
    add_json(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """Identify."""
    from robot.bringup.mapping.identify import IdentifyRequest, identify

    return identify(parsed(options, IdentifyRequest))
