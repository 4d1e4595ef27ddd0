"""``bigant doctor``: is this computer set up, and if not, what to do?

Looks at versions, optional parts, disk, serial ports and who may open them, latency timers, real-time
settings, the compiler's cache and OpenGL. Asks no device anything; the robot itself is looked at by bigant
check.
"""

import argparse

from robot.console.arguments import add_json
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_json(parser)


def run(options: argparse.Namespace) -> ExitCode:
    """Examine the computer."""
    from robot.bringup.preflight.doctor import examine

    return examine(as_json=options.json)
