"""``bigant ft watch``: what the force-torque unit sends, live.

Per transducer forces and moments, state and age; for the stream its rate, losses and the unit's clock
against the host's. The robot file's bias or a calibration is subtracted. Ctrl-C ends it; the unit is always
told to stop on exit.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_json, add_robot, parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_robot(parser)
    parser.add_argument("--force-unit", metavar="HOST[:UDP:CONSOLE]", help="(default: robot file)")
    parser.add_argument("--seconds", type=float, metavar="S", help="end by itself after so long")
    parser.add_argument("--calibration", type=Path, metavar="FILE", help="calibration file to use")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write every sample")
    add_json(parser, "only what was read last,")


def run(options: argparse.Namespace) -> ExitCode:
    """Watch."""
    from robot.bringup.force.watch import WatchRequest, watch_forces

    return watch_forces(parsed(options, WatchRequest))
