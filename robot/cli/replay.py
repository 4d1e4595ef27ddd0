"""``bigant replay``: a recorded run again, as a test.

Plain, the recorded inputs go through today's controller and every stage's output is compared with the
recorded one. With --bus the recorded bytes of both devices go through today's drivers, which have to
send what they sent then. With --drive the robot does the same run again, and the new measurements are
compared with the old. Exit code 0: equal (--drive: driven); 1: not.
"""

import argparse
import math
from pathlib import Path

from robot.console.arguments import parsed, seed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("path", type=Path, metavar="LOG")
    parser.add_argument(
        "--tolerance", type=_scale, default=1.0, metavar="X",
        help="factor on all tolerances (1); 0 asks for the same bits",
    )  # fmt: skip
    parser.add_argument(
        "--robot", type=Path, metavar="FILE", help="try this robot file instead of the log's"
    )
    parser.add_argument("--json", action="store_true", help="the result as JSON")
    kind = parser.add_mutually_exclusive_group()
    kind.add_argument(
        "--bus", action="store_true",
        help="replay the recorded bytes through the drivers (log: bigant drive --record-bytes)",
    )  # fmt: skip
    kind.add_argument("--drive", action="store_true", help="do the run again on a robot")
    again = parser.add_argument_group("with --drive")
    again.add_argument("--hardware", default="virtual", metavar="virtual|PORT",
                       help="virtual (default), or the serial port of the servo bus")  # fmt: skip
    again.add_argument("--armed", action="store_true", help="allow torque on real hardware")
    again.add_argument("--force-unit", metavar="HOST[:UDP:CONSOLE]|none",
                       help="force-torque unit (default: robot file)")  # fmt: skip
    again.add_argument("--virtual-time", action="store_true", help="as fast as the computer goes")
    again.add_argument("--seed", type=seed, default=0, metavar="N", help="seed of virtual noise")
    again.add_argument("--log", type=Path, metavar="FILE", help="the new log (default: runs/...)")
    again.add_argument("--out", type=Path, metavar="FILE",
                       help="page with the pictures (default: beside the new log)")  # fmt: skip


def _scale(text: str) -> float:
    value = float(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"must be 0 or a positive number, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Replay, or drive again."""
    if options.drive:
        from robot.replay.drive import RepeatRequest, drive_again

        return drive_again(parsed(options, RepeatRequest))
    from robot.replay.command import ReplayRequest, replay

    return replay(parsed(options, ReplayRequest))
