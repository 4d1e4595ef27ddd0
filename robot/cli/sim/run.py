"""``bigant sim run``: a walk of the virtual robot, with what is wrong with it, as a trial or a log.

The whole stack runs in virtual time: controller, servo bus and force unit, byte by byte. --fast leaves
the bytes out and gives the same trial in a fraction of the time. FILE.parquet and FILE.csv are trials
(the walk, with FILE.toml and the robot file beside it), FILE.mcap is a log of the whole run. The seed
also sets the day: friction, stiffness and centre of mass differ by a few per cent from seed to seed.
"""

import argparse
from pathlib import Path

from gaits.names import GAIT_NAMES
from robot.console.arguments import add_robot, parsed, positive, seed, steer
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    add_robot(parser)
    parser.add_argument("--gait", choices=GAIT_NAMES, default="tripod")
    parser.add_argument(
        "--frequency-hz",
        type=positive,
        metavar="F",
        help="cycles a second (default: the robot file's)",
    )
    parser.add_argument(
        "--seconds", type=positive, default=30.0, metavar="S", help="of walking (default: 30)"
    )
    parser.add_argument(
        "--steer", type=steer, default=0.0, metavar="X", help="-1 (right) to 1 (left)"
    )
    parser.add_argument(
        "--effect",
        action="append",
        default=[],
        metavar="NAME[@LEG][:param=value,...]",
        help="what is wrong; may be given several times (bigant sim effects lists them)",
    )
    parser.add_argument("--seed", type=seed, default=0, metavar="N")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE", help=".parquet, .csv or .mcap"
    )
    parser.add_argument("--fast", action="store_true", help="without the byte layer; no .mcap")
    parser.add_argument("--json", action="store_true", help="what was done as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Walk and write.

    Raises:
        ConfigError: Options or effects that make no sense.
        ModelError: The robot stopped before it was done.
        RecordError: A file cannot be written.
    """
    from robot.virtual.twin_file import TwinFileRequest, twin_file

    return twin_file(parsed(options, TwinFileRequest))
