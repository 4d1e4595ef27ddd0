"""The robot in three dimensions, drawn from measured poses: one moment, or a video."""

import math
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from scipy.spatial.transform import Rotation

from model.errors import ConfigError, RecordError
from model.values.arrays import FloatArray
from record.log.export import export_trial
from record.log.reader import LogContents
from record.trial.trial import Trial, read_trial
from record.whole_file import whole_file
from robot.config.robot_file import parse_robot
from robot.console.exit_codes import ExitCode
from robot.console.progress import ProgressBar
from robot.requests.sim import SimRenderRequest

# One metre of arrow stands for so much force.
NEWTONS_A_METRE = 250.0
SHOWN_N = 1.0
PATH_S = 3.0
MARGIN_M = 0.08
FRAMES_A_SECOND = 10
# Beyond these it is no run of a robot, and a picture would show nothing of it.
FARTHEST_M, LARGEST_RAD, LARGEST_N = 1e4, 1e6, 1e6
MOST_PICTURES = 36_000  # of a video: an hour of watching


def render(request: SimRenderRequest) -> ExitCode:
    """Draw the robot of a log or a trial.

    Raises:
        ConfigError: --out is of no kind that can be drawn here.
        RecordError: The run cannot be read, holds no poses, or some that are no robot's.
    """
    out = request.out
    if out.suffix not in {".png", ".gif", ".mp4"}:
        raise ConfigError("--out", f"must end in .png, .gif or .mp4, not {out}")
    if out.suffix == ".mp4" and shutil.which("ffmpeg") is None:
        raise ConfigError(
            "--out", "an .mp4 needs ffmpeg, which is not here; install it, or choose .gif"
        )
    if not out.parent.is_dir():
        raise ConfigError("--out", f"there is no folder {out.parent}; make it first")
    trial = _trial(request.path)
    if absurd := _absurd(trial):
        raise RecordError(f"{request.path} cannot be drawn: {absurd}; leave that part of it out")
    drawing = RunDrawing(trial)
    if not drawing.times:
        raise RecordError(f"{request.path} holds no poses of body and feet to draw")
    if out.suffix == ".png":
        at = request.at if request.at is not None else drawing.middle_s
        first_s, last_s = drawing.span_s
        if not first_s <= at <= last_s:
            raise ConfigError("--at", f"must be from {first_s:.2f} to {last_s:.2f} s, not {at:g}")
        shown = drawing.picture(at, out)
        print(f"{out}: the robot at {shown:.2f} s")
        return ExitCode.OK
    pictures = drawing.pictures(request.speed, FRAMES_A_SECOND)
    if pictures > MOST_PICTURES:
        words = f"gives {pictures:g} pictures; at most {MOST_PICTURES} can be drawn, so choose a higher one"
        raise ConfigError(
            "--speed", f"{request.speed:g} {words}, or cut the run with bigant log trim"
        )
    with whole_file(out) as part, ProgressBar("drawing") as bar:
        frames = drawing.video(part, request.speed, FRAMES_A_SECOND, bar.show)
    print(f"{out}: {frames} pictures, {request.speed:g} times real time")
    return ExitCode.OK


def _trial(path: Path) -> Trial:
    if path.suffix != ".mcap":
        return read_trial(path)
    with tempfile.TemporaryDirectory() as folder:
        table = Path(folder) / "run.parquet"
        export_trial(path, table, LogContents())
        return read_trial(table)


def _absurd(trial: Trial) -> str:
    """Return the first thing that is no robot's, in words; empty if there is none. NaN is none."""
    for what, values, most, unit in (
        ("the body is", trial.body_position_m, FARTHEST_M, "m away"),
        ("the body is turned by", trial.body_angles_rad, LARGEST_RAD, "rad"),
        ("a foot is", trial.foot_m, FARTHEST_M, "m from the body"),
        ("a foot carries", trial.force_n, LARGEST_N, "N"),
    ):
        rows = np.abs(values.reshape(len(values), math.prod(values.shape[1:])))
        largest = np.where(np.isnan(rows), 0.0, rows).max(axis=1, initial=0.0)
        if (largest > most).any():
            at = int(np.argmax(largest > most))
            return f"at {trial.time_s[at]:.2f} s {what} {largest[at]:.3g} {unit}"
    return ""


class RunDrawing:
    """Draws the robot of a trial.

    Args:
        trial: With body poses and foot markers.
    """

    def __init__(self, trial: Trial) -> None:
        known = np.isfinite(trial.body_position_m).all(axis=1)
        known &= np.isfinite(trial.body_angles_rad).all(axis=1)
        known &= np.isfinite(trial.foot_m).any(axis=(1, 2))
        self._time_s = trial.time_s[known]
        self._position = trial.body_position_m[known]
        self._force = np.nan_to_num(trial.force_n[known])
        roll, pitch, yaw = trial.body_angles_rad[known].T
        angles = np.stack([yaw, pitch, roll], axis=1)
        self._turn = Rotation.from_euler("ZYX", angles if len(angles) else np.zeros((1, 3)))
        self._foot = trial.foot_m[known]
        self._hips = _hips(trial, self._foot)
        if len(angles):
            matrices = self._turn.as_matrix()
            self._feet_w = self._position[:, None] + np.einsum("tij,tnj->tni", matrices, self._foot)

    @property
    def times(self) -> int:
        """Number of moments that can be drawn."""
        return len(self._time_s)

    def pictures(self, speed: float, rate_hz: int) -> float:
        """Return how many pictures a video has."""
        first_s, last_s = self.span_s
        return (last_s - first_s) / speed * rate_hz

    @property
    def middle_s(self) -> float:
        """The moment in the middle."""
        return float(self._time_s[self.times // 2])

    @property
    def span_s(self) -> tuple[float, float]:
        """The first and the last moment that can be drawn."""
        return float(self._time_s[0]), float(self._time_s[-1])

    def picture(self, at_s: float, out: Path) -> float:
        """Draw the moment nearest to a time; return which it is.

        Raises:
            RecordError: The file cannot be written.
        """
        index = int(np.argmin(np.abs(self._time_s - at_s)))
        figure = Figure(figsize=(8, 6))
        self._draw(figure, index)
        with whole_file(out) as part:
            figure.savefig(part, dpi=110)
        return float(self._time_s[index])

    def video(
        self, out: Path, speed: float, rate_hz: int, progress: Callable[[float], None]
    ) -> int:
        """Draw a video; return its number of pictures."""
        with mpl.rc_context({"savefig.bbox": None}):
            figure = Figure(figsize=(6.4, 4.8))
            writer: Any = (PillowWriter if out.suffix == ".gif" else FFMpegWriter)(fps=rate_hz)
            times = np.arange(self._time_s[0], self._time_s[-1], speed / rate_hz)
            with writer.saving(figure, str(out), dpi=90):
                for at, time_s in enumerate(times):
                    figure.clear()
                    self._draw(figure, int(np.searchsorted(self._time_s, time_s)))
                    writer.grab_frame()
                    progress((at + 1) / len(times))
        return len(times)

    def _draw(self, figure: Figure, index: int) -> None:
        axes: Any = figure.add_subplot(projection="3d", computed_zorder=False)
        position, turn = self._position[index], self._turn[index]
        hips = position + turn.apply(self._hips)
        feet = self._feet_w[index]
        order = np.argsort(np.arctan2(self._hips[:, 1], self._hips[:, 0]))
        axes.add_collection3d(Poly3DCollection([hips[order]], alpha=0.35, facecolor="tab:blue"))
        begin = int(np.searchsorted(self._time_s, self._time_s[index] - PATH_S))
        for leg in range(len(feet)):
            axes.plot(*self._feet_w[begin : index + 1, leg].T, lw=0.8, color="0.6")
            loaded = self._force[index, leg, 2] > SHOWN_N
            axes.plot(*np.stack([hips[leg], feet[leg]]).T, lw=3, color="k" if loaded else "0.5")
            if loaded:
                arrow = turn.apply(self._force[index, leg].copy()) / NEWTONS_A_METRE
                axes.quiver(*feet[leg], *arrow, color="tab:red", lw=1.5, arrow_length_ratio=0.2)
        axes.plot(*self._position[: index + 1].T, lw=1.2, color="tab:green")
        self._frame(axes)
        axes.set_title(f"{self._time_s[index]:.2f} s")

    def _frame(self, axes: Any) -> None:
        """The same view of the whole run in every picture, equal scales."""
        low = np.nanmin(self._feet_w, axis=(0, 1)) - MARGIN_M
        high = np.nanmax(self._feet_w, axis=(0, 1)) + MARGIN_M
        high[2] = max(high[2], float(self._position[:, 2].max()) + MARGIN_M)
        axes.set_xlim(low[0], high[0])
        axes.set_ylim(low[1], high[1])
        axes.set_zlim(low[2], high[2])
        axes.set_box_aspect(high - low)
        axes.set_xlabel("x [m]")
        axes.set_ylabel("y [m]")
        axes.view_init(elev=25, azim=-60)


def _hips(trial: Trial, feet: FloatArray) -> FloatArray:
    """Return the shafts in the body frame, or where there is no robot file, the feet's middles raised."""
    if trial.header.robot_text:
        legs = parse_robot(trial.header.robot_text).parameters.legs
        hips: FloatArray = legs.shaft_position.copy()
        return hips
    middle: FloatArray = np.nanmean(feet, axis=0)
    middle[:, 2] = 0.0
    return middle
