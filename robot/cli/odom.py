"""``bigant odom``: odometry and foot forces from a log, judged against the truth if there is one."""

import argparse
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.description = (
        "Run the estimator over a log with only what the loop knew at each tick. "
        "'odom tune LOG...' finds its noise from logs instead. --live follows the log of a running "
        "drive, or reads a robot without ever moving it."
    )
    parser.add_argument("logs", type=Path, nargs="*", metavar="[tune] LOG")
    parser.add_argument("--compare", action="store_true",
        help="beside it: open-loop model, strides, rigid stance and the truth")  # fmt: skip
    parser.add_argument("--law", choices=("coulomb", "viscous"),
        help="friction law of the process (default: the robot file's)")  # fmt: skip
    parser.add_argument("--no-sway", action="store_true",
        help="leave out how the body moves as it tilts")  # fmt: skip
    parser.add_argument("--no-forces", action="store_true", help="as if there were no force unit")
    parser.add_argument("--robot", type=Path, metavar="FILE",
        help="robot file to believe (default: the one in the log)")  # fmt: skip
    parser.add_argument("--fitted", type=Path, metavar="LOG",
        help="with --compare: fit open loop and stride to this walk of known truth")  # fmt: skip
    parser.add_argument("--smooth", action="store_true",
        help="write the trajectory smoothed with all of the walk known")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE",
        help=".tum, .mcap, .png or .html; tune: .toml, the robot file with what was found")  # fmt: skip
    live = parser.add_argument_group("while it walks")
    live.add_argument("--live", action="store_true",
        help="follow LOG (default: newest in runs/) while it is written, or --hardware")  # fmt: skip
    live.add_argument("--hardware", metavar="virtual|PORT",
        help="read servos and forces here; torque is never asked for")  # fmt: skip
    live.add_argument("--force-unit", metavar="HOST[:UDP:CONSOLE]|none",
        help="force-torque unit (default: robot file)")  # fmt: skip
    live.add_argument("--duration", type=float, metavar="S", help="end after so long")
    parser.add_argument(
        "--json", action="store_true", help="the figures as JSON; with --live a line of it a second"
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Run the command.

    Raises:
        RecordError: A log cannot be read or used, or a file cannot be written.
        ConfigError: An argument that does not fit.
    """
    from robot.odometry.request import OdomRequest

    request = parsed(options, OdomRequest)
    request.check()
    if request.live:
        from robot.odometry.live import run_live

        return run_live(request)
    if request.tunes:
        from robot.odometry.tune import tune_command

        return tune_command(request)
    from robot.odometry.command import odom

    return odom(request)
