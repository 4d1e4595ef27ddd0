"""``bigant sim render``: a picture or video of a log or a trial, off-screen.

Body, legs, feet's paths and the ground's forces (red: more than a newton), drawn in three dimensions by
matplotlib from what was measured; nothing is simulated and no graphics card is needed. .png is one
moment (--at), .gif and .mp4 are videos; .mp4 needs ffmpeg.
"""

import argparse
from pathlib import Path

from robot.console.arguments import parsed, positive
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments."""
    parser.add_argument("path", type=Path, metavar="LOG|TRIAL")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE", help=".png, .gif or .mp4"
    )
    parser.add_argument(
        "--at", type=float, metavar="S", help="moment of a .png (default: the middle)"
    )
    parser.add_argument(
        "--speed",
        type=positive,
        default=4.0,
        metavar="X",
        help="times real time of a video (default: 4)",
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Draw."""
    from robot.virtual.drawing import RenderRequest, render

    return render(parsed(options, RenderRequest))
