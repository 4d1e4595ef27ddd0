"""``bigant sim render``: a picture or video of a log or a trial, off-screen.

Body, legs, feet's paths and the ground's forces (red: more than a newton), drawn in three dimensions by
matplotlib from what was measured; nothing is simulated and no graphics card is needed. .png is one
moment (--at), .gif and .mp4 are videos; .mp4 needs ffmpeg.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.arguments import positive
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from record.trial.trial import Trial

FRAMES_A_SECOND = 10


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
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
    """Draw.

    Raises:
        ConfigError: --out is of no kind that can be drawn here.
        RecordError: The run cannot be read, or holds no poses.
    """
    import shutil

    from model.errors import ConfigError, RecordError
    from record.whole_file import whole_file
    from robot.console.progress import ProgressBar
    from robot.virtual.drawing import RunDrawing

    out: Path = options.out
    if out.suffix not in {".png", ".gif", ".mp4"}:
        raise ConfigError("--out", f"must end in .png, .gif or .mp4, not {out}")
    if out.suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise ConfigError(
            "--out", "an .mp4 needs ffmpeg, which is not here; install it, or choose .gif"
        )
    if not out.parent.is_dir():
        raise ConfigError("--out", f"there is no folder {out.parent}; make it first")
    drawing = RunDrawing(_trial(options.path))
    if not drawing.times:
        raise RecordError(f"{options.path} holds no poses of body and feet to draw")
    if out.suffix == ".png":
        at = options.at if options.at is not None else drawing.middle_s
        first_s, last_s = drawing.span_s
        if not first_s <= at <= last_s:
            raise ConfigError("--at", f"must be from {first_s:.2f} to {last_s:.2f} s, not {at:g}")
        shown = drawing.picture(at, out)
        print(f"{out}: the robot at {shown:.2f} s")
        return ExitCode.OK
    with whole_file(out) as part, ProgressBar("drawing") as bar:
        frames = drawing.video(part, options.speed, FRAMES_A_SECOND, bar.show)
    print(f"{out}: {frames} pictures, {options.speed:g} times real time")
    return ExitCode.OK


def _trial(path: Path) -> "Trial":
    import tempfile

    from record.log.export import export_trial
    from record.log.reader import LogContents
    from record.trial.trial import read_trial

    if path.suffix != ".mcap":
        return read_trial(path)
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "run.parquet"
        export_trial(path, table, LogContents())
        return read_trial(table)
