"""``bigant view``: watch a run, live or from its log, in a viewer or in a terminal.

Draws the robot with its linkages, contact forces measured and predicted, the trajectory against ground
truth, velocities, modes, health and faults. Foxglove and Lichtblick connect to the address that is printed,
or open the .mcap that --save writes; Rerun opens an .rrd; --terminal needs none of them. --live follows a
running bigant drive by reading the log that it writes, so the run cannot be disturbed from here. See
docs/view.md.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_source, between, parsed
from robot.console.exit_codes import ExitCode

DEFAULT_PORT = 8765
DEFAULT_RATE_HZ = 25.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    add_source(parser)
    parser.add_argument("--terminal", action="store_true", help="in this terminal")
    parser.add_argument(
        "--save",
        type=Path,
        metavar="FILE",
        help="write what a viewer shows: .mcap for Foxglove and Lichtblick, .rrd for Rerun",
    )
    parser.add_argument(
        "--headless", action="store_true", help="with --live and --save: no server, only the file"
    )
    parser.add_argument(
        "--layout", type=Path, metavar="FILE.json", help="also write a layout to import in Foxglove"
    )
    parser.add_argument(
        "--host", default="127.0.0.1", metavar="ADDRESS", help="listen here (default: 127.0.0.1)"
    )
    parser.add_argument(
        "--port",
        type=between(0, 65535, whole=True),
        default=DEFAULT_PORT,
        metavar="P",
        help=f"({DEFAULT_PORT}; 0: any)",
    )
    parser.add_argument(
        "--rate-hz",
        type=between(0.1, 200, "Hz"),
        default=DEFAULT_RATE_HZ,
        metavar="R",
        help=f"pictures a second of run time (default: {DEFAULT_RATE_HZ:g})",
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Watch."""
    from robot.view.watch import ViewRequest, watch

    return watch(parsed(options, ViewRequest))
