"""``bigant ft calibrate``: force sensors to foot wrenches, from logs of a robot at rest.

Stage one fits what each sensor reads with its foot in the air (offset and leg gravity over the shaft
angle), stage two a 6 x 6 correction from poses in which the feet carry the weight. Poses are found in the
logs where no shaft moves. Judged on held-out poses; nothing is written if those got worse. --hardware
virtual drives the virtual robot through such poses first, in virtual time.
"""

import argparse
from pathlib import Path

from robot.console.arguments import add_json, parsed, seed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("logs", nargs="*", type=Path, metavar="LOG", help="robot standing at rest")
    parser.add_argument("--hung", nargs="+", type=Path, default=[], metavar="LOG",
                        help="logs of the robot hung up, no foot on the ground")  # fmt: skip
    parser.add_argument("--hardware", choices=("virtual",), help="record poses first")
    parser.add_argument("--rounds", type=int, default=4, metavar="N",
                        help="with --hardware: how often each leg is lifted (4)")  # fmt: skip
    parser.add_argument("--seed", type=seed, default=0, metavar="N", help="with --hardware")
    parser.add_argument("--log", type=Path, default=Path("ft-poses.mcap"), metavar="FILE",
                        help="with --hardware: the log to write (ft-poses.mcap)")  # fmt: skip
    parser.add_argument("--robot", type=Path, metavar="FILE",
                        help="robot file (default: with --hardware config/bigant.toml, else the "
                        "one in the logs)")  # fmt: skip
    parser.add_argument("--harmonics", type=int, default=3, metavar="H",
                        help="most harmonics of leg gravity (3)")  # fmt: skip
    parser.add_argument("--no-cross-talk", action="store_true", help="stage one only")
    parser.add_argument("--no-point-feet", action="store_true",
                        help="do not assume that feet touch at a point")  # fmt: skip
    parser.add_argument("--out", type=Path, default=Path("force-calibration.toml"), metavar="FILE",
                        help="calibration file (force-calibration.toml)")  # fmt: skip
    parser.add_argument("--report", type=Path, metavar="FILE", help="picture, .png")
    add_json(parser, "residuals and warnings")


def run(options: argparse.Namespace) -> ExitCode:
    """Calibrate."""
    from robot.bringup.force.calibrate import CalibrateRequest, calibrate

    return calibrate(parsed(options, CalibrateRequest))
