"""Pictures of a log: trajectory, body velocity, foot forces; predicted against measured.

Each pair of curves is drawn with the difference below it, because overlaid curves hide each other.
Colours are those of Okabe and Ito, distinct for the colour-blind; line styles differ as well.
"""

from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model.signals import FloatArray, Mode
from record.recording import Recording
from robot.run_totals import truth_yaw
from robot.summary import planar_pose

TRUE, PREDICTED, DIFFERENCE, ESTIMATED = "#0072B2", "#D55E00", "#555555", "#009E73"
STYLE: Any = {  # matplotlib types its settings by name
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "svg.fonttype": "none",
    "svg.hashsalt": "bigant",
    "legend.framealpha": 0.85,
    "legend.edgecolor": "none",
    "legend.borderpad": 0.2,
}
# A picture is 650 points wide, a panel of the forces a third of it.
MOST_POINTS, MOST_IN_PANEL = 1500, 600


def draw_log(log: Recording) -> dict[str, Figure]:
    """Draw all pictures of a log, by title."""
    with mpl.rc_context(STYLE):
        return {
            "Trajectory": _trajectory(log),
            "Body velocity": _velocity(log),
            "Foot forces": _forces(log),
            "Shafts": _shafts(log),
        }


def save_png(figures: dict[str, Figure], path: Path) -> tuple[Path, ...]:
    """Save each picture as a PNG beside ``path``; return the files."""
    saved = []
    for title, figure in figures.items():
        target = path.with_name(f"{path.stem}-{title.lower().replace(' ', '-')}.png")
        figure.savefig(target, dpi=130)
        saved.append(target)
    return tuple(saved)


def _thin(log: Recording, most: int = MOST_POINTS) -> slice:
    return slice(None, None, max(1, len(log.t_s) // most))


def _trajectory(log: Recording) -> Figure:
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    ax: Axes = figure.subplots()
    thin = _thin(log)
    estimate = _in_truth_frame(log, log.estimate_pose)[thin]
    if log.has_truth:
        true = planar_pose(log)[thin]
        ax.plot(true[:, 0], true[:, 1], color=TRUE, lw=2.5, label="true")
        _headings(ax, true, TRUE)
    ax.plot(
        estimate[:, 0], estimate[:, 1], color=PREDICTED, lw=1.5, ls="--", label="dead reckoning"
    )
    _headings(ax, estimate, PREDICTED)
    if np.isfinite(log.odometry_pose).any():
        said = _in_truth_frame(log, log.odometry_pose)[thin]
        ax.plot(said[:, 0], said[:, 1], color=ESTIMATED, lw=1.5, ls="-.", label="estimator")
    ax.set_aspect("equal", adjustable="datalim")
    ax.set_xlabel("x [m]")
    ax.set_ylabel("y [m]")
    ax.legend(loc="best")
    return figure


def _headings(ax: Axes, pose: FloatArray, colour: str) -> None:
    known = pose[np.isfinite(pose).all(axis=1)]
    for row in known[np.linspace(0, len(known) - 1, 6).astype(int)] if len(known) else ():
        ax.annotate(
            "",
            xy=(row[0] + 0.012 * np.cos(row[2]), row[1] + 0.012 * np.sin(row[2])),
            xytext=(row[0], row[1]),
            arrowprops={"arrowstyle": "->", "color": colour, "lw": 1.2},
        )


def _in_truth_frame(log: Recording, own: FloatArray) -> FloatArray:
    """Poses begun where the truth begins, so that both can be compared; (T, 3)."""
    pose = own.copy()
    known = np.flatnonzero(np.isfinite(log.truth_position_W[:, 0]))
    if len(known) == 0:
        return pose
    first = known[0]
    turn = truth_yaw(log)[first] - pose[first, 2]
    c, s = np.cos(turn), np.sin(turn)
    moved = pose[:, :2] - pose[first, :2]
    pose[:, :2] = log.truth_position_W[first, :2] + moved @ np.array([[c, s], [-s, c]])
    pose[:, 2] += turn
    return pose


def _velocity(log: Recording) -> Figure:
    figure = Figure(figsize=(9, 6.4), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True, height_ratios=[2, 2, 2, 1.4])
    thin = _thin(log)
    labels = ("vx [mm/s]", "vy [mm/s]", "yaw rate [mrad/s]")
    for component, ax in enumerate(axes[:3]):
        if log.has_truth:
            true = log.truth_velocity_B[thin, component] * 1e3
            ax.plot(log.t_s[thin], true, color=TRUE, lw=1.8, label="true")
        predicted = log.predicted_velocity_B[thin, component] * 1e3
        ax.plot(log.t_s[thin], predicted, color=PREDICTED, lw=0.9, label="predicted")
        ax.set_ylabel(labels[component])
        _shade_walking(ax, log)
        _clip(ax, log.truth_velocity_B[:, component] * 1e3, log.mode == Mode.WALK.value)
    axes[0].legend(loc="upper right", ncols=2)
    error = (log.predicted_velocity_B - log.truth_velocity_B)[thin] * 1e3
    for component, colour in enumerate((PREDICTED, "#009E73", "#CC79A7")):
        axes[3].plot(log.t_s[thin], error[:, component], lw=0.8, color=colour,
                     label=labels[component].split()[0])  # fmt: skip
    axes[3].set_ylabel("difference")
    axes[3].set_xlabel("time [s]")
    axes[3].legend(loc="upper right", ncols=3)
    walking = log.mode == Mode.WALK.value
    _clip(axes[3], (log.predicted_velocity_B - log.truth_velocity_B)[walking].ravel() * 1e3)
    return figure


def _forces(log: Recording) -> Figure:
    legs = len(log.names)
    figure = Figure(figsize=(9, 1.5 * legs + 0.6), layout="constrained")
    axes = figure.subplots(legs, 3, sharex=True, squeeze=False, sharey="col")
    thin = _thin(log, MOST_IN_PANEL)
    for leg, name in enumerate(log.names):
        for axis, letter in enumerate("xyz"):
            ax = axes[leg, axis]
            ax.plot(log.t_s[thin], log.force_n[thin, leg, axis], color=TRUE, lw=1.2)
            ax.plot(log.t_s[thin], log.predicted_force_n[thin, leg, axis], color=PREDICTED, lw=0.8)
            if leg == 0:
                ax.set_title(f"F{letter} [N]")
            if axis == 0:
                ax.set_ylabel(name)
            if leg == legs - 1:
                ax.set_xlabel("time [s]")
    for axis in range(3):
        _clip(axes[0, axis], np.concatenate([log.force_n[:, :, axis].ravel()]))
    figure.legend(
        handles=[
            mpl.lines.Line2D([], [], color=TRUE, label="measured"),
            mpl.lines.Line2D([], [], color=PREDICTED, label="predicted"),
        ],
        loc="outside upper center",
        ncols=2,
    )
    return figure


def _shafts(log: Recording) -> Figure:
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    thin = _thin(log)
    for leg, name in enumerate(log.names):
        top.plot(log.t_s[thin], log.angle_rad[thin, leg], lw=1.2, label=name)
        lag = (log.angle_rad - log.sent_angle_rad)[thin, leg]
        bottom.plot(log.t_s[thin], lag * 1e3, lw=0.8)
    top.set_ylabel("shaft angle [rad]")
    top.legend(ncols=len(log.names), loc="upper left")
    bottom.set_ylabel("measured - sent [mrad]")
    bottom.set_xlabel("time [s]")
    _shade_walking(top, log)
    return figure


def _shade_walking(ax: Axes, log: Recording) -> None:
    walking = log.mode == Mode.WALK.value
    edges = np.flatnonzero(np.diff(np.concatenate([[False], walking, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2):
        ax.axvspan(log.t_s[begin], log.t_s[end - 1], color="#000000", alpha=0.05, lw=0)


def _clip(ax: Axes, values: FloatArray, where: np.ndarray | None = None) -> None:
    """Scale to what matters: a few wild samples must not flatten the rest."""
    chosen = values if where is None else values[where]
    known = chosen[np.isfinite(chosen)]
    if len(known) == 0:
        return
    low, high = np.percentile(known, [0.5, 99.5])
    low, high = min(low, 0.0), max(high, 0.0)
    margin = 0.35 * max(high - low, 1e-9)
    ax.set_ylim(low - margin, high + margin)
