"""Pictures of a log: trajectory, body velocity, foot forces; predicted against measured.

Each pair of curves is drawn with the difference below it, because overlaid curves hide each other.
Colours are those of Okabe and Ito, distinct for the colour-blind; line styles differ as well.
"""

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from model.values.arrays import FloatArray
from model.values.tick import Mode
from record.log.recording import Recording
from robot.control.stops import STOPS
from robot.report.ground_truth import aligned_to_truth, true_velocity
from robot.report.summary import planar_pose

TRUE, PREDICTED, DIFFERENCE, ESTIMATED = "#0072B2", "#D55E00", "#555555", "#009E73"
FAULT, HEADING = "#D6204E", "#000000"
HEADING_M = 0.012
# The least span of an axis: a robot at rest is a line, not rounding errors that fill the picture.
LEAST_M, LEAST_MM_S, LEAST_N, LEAST_MRAD = 0.05, 2.0, 2.0, 2.0
WILD = 4.0  # as many times the span of nearly all samples: the rest is left out
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
MOST_MARKS = 600  # of faults in a picture


def draw_log(log: Recording) -> dict[str, Figure]:
    """Draw all pictures of a log, by title."""
    with mpl.rc_context(STYLE):
        return {
            "Trajectory": _trajectory(log),
            "Body velocity": _velocity(log),
            "Foot forces": _forces(log),
            "Shafts": _shafts(log),
        }


def _trajectory(log: Recording) -> Figure:
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    ax: Axes = figure.subplots()
    curves = [
        ("dead reckoning", aligned_to_truth(log, log.dead_reckoning_pose), PREDICTED, 1.5, "--"),
        ("estimator", aligned_to_truth(log, log.estimate_pose), ESTIMATED, 1.5, "-."),
    ]
    if log.has_truth:
        curves.insert(0, ("true", planar_pose(log), TRUE, 2.5, "-"))
    for name, pose, colour, width, style in curves:
        if name != "estimator" or np.isfinite(pose).any():
            ax.plot(*pose[:, :2].T, color=colour, lw=width, ls=style, label=name)
    _headings(ax, curves[0][1])
    _widen(ax, LEAST_M)
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x [m]", ylabel="y [m]")
    _legend_above(ax)
    return figure


def _headings(ax: Axes, pose: FloatArray) -> None:
    """Draw which way the body points, at some places of a path."""
    known = pose[np.isfinite(pose).all(axis=1)]
    if len(known) == 0:
        return
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(known[:, :2], axis=0).T))])
    for row in known[np.unique(np.searchsorted(along, np.linspace(0, along[-1], 6)))]:
        ahead = HEADING_M * np.array([np.cos(row[2]), np.sin(row[2])])
        ax.annotate("", xy=tuple(row[:2] + ahead), xytext=tuple(row[:2]), zorder=5,
                    arrowprops={"arrowstyle": "-|>", "color": HEADING, "lw": 0.6})  # fmt: skip
    ax.plot([], [], color=HEADING, lw=0.6, marker=">", ms=4, label="heading of the body")


def _widen(ax: Axes, least: float) -> None:
    """Give both axes a least span, as if there were points so far apart."""
    middle = [ax.dataLim.x0 + ax.dataLim.width / 2, ax.dataLim.y0 + ax.dataLim.height / 2]
    ax.update_datalim([[place + side * least / 2 for place in middle] for side in (-1, 1)])
    ax.autoscale_view()


def _legend_above(ax: Axes) -> None:
    """Put the legend above the axes, where no curve is."""
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=7, frameon=False, borderaxespad=0)


def _velocity(log: Recording) -> Figure:
    figure = Figure(figsize=(9, 6.9), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True, height_ratios=[2, 2, 2, 1.4])
    labels = ("vx [mm/s]", "vy [mm/s]", "yaw rate [mrad/s]")
    curves = [("predicted", log.predicted_velocity_B, PREDICTED, 0.9)]
    if log.has_truth:
        curves.insert(0, ("true", true_velocity(log), TRUE, 1.8))
    if np.isfinite(log.estimate_velocity_B).any():
        curves.append(("estimator", log.estimate_velocity_B, ESTIMATED, 0.9))
    for component, (ax, label) in enumerate(zip(axes[:3], labels, strict=True)):
        for name, velocity, colour, width in curves:
            values = velocity[:, component] * 1e3
            ax.plot(log.t_s, values, color=colour, lw=width, label=name)
        ax.set_ylabel(label)
        _shade_walking(ax, log)
        _mark_faults(ax, log)
        shown = np.concatenate([velocity[:, component] for _, velocity, _, _ in curves])
        _clip(ax, shown * 1e3, LEAST_MM_S)
    _legend_above(axes[0])
    _velocity_difference(axes[3], log, labels)
    return figure


def _velocity_difference(ax: Axes, log: Recording, labels: tuple[str, ...]) -> None:
    error = (log.predicted_velocity_B - true_velocity(log)) * 1e3
    ax.set(xlabel="time [s]", ylabel="predicted\nminus true")
    if not log.has_truth:
        ax.text(0.5, 0.5, "no truth in this log", transform=ax.transAxes, ha="center", va="center")
        return
    for component, colour in enumerate((PREDICTED, ESTIMATED, "#CC79A7")):
        label = labels[component]
        ax.plot(log.t_s, error[:, component], lw=0.8, color=colour, label=label)
    _legend_above(ax)
    _clip(ax, error.ravel(), LEAST_MM_S)


def _forces(log: Recording) -> Figure:
    legs = len(log.names)
    figure = Figure(figsize=(9, 1.5 * legs + 0.6), layout="constrained")
    axes = figure.subplots(legs, 3, sharex=True, squeeze=False, sharey="col")
    curves = [("predicted", log.predicted_force_n, PREDICTED, 0.8)]
    measured = bool(np.isfinite(log.force_n).any())
    if measured:
        curves.insert(0, ("measured", log.force_n, TRUE, 1.2))
    for axis, letter in enumerate("xyz"):
        for leg, ax in enumerate(axes[:, axis]):
            for _, force, colour, width in curves:
                ax.plot(log.t_s, force[:, leg, axis], color=colour, lw=width)
        axes[0, axis].set_title(f"F{letter} [N]")
        axes[-1, axis].set_xlabel("time [s]")
        shown = np.concatenate([force[..., axis].ravel() for _, force, _, _ in curves])
        _clip(axes[0, axis], shown, LEAST_N)
    for name, ax in zip(log.names, axes[:, 0], strict=True):
        ax.set_ylabel(name)
    samples = [Line2D([], [], color=colour, label=name) for name, _, colour, _ in curves]
    title = None if measured else "no foot forces were measured"
    figure.legend(handles=samples, title=title, loc="outside upper center", ncols=2)
    return figure


def _shafts(log: Recording) -> Figure:
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    top, bottom = figure.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    lag_mrad = 1e3 * (log.angle_rad - log.sent_angle_rad)
    for joint, name in enumerate(log.joints):
        top.plot(log.t_s, log.angle_rad[:, joint], lw=1.2, label=name)
        bottom.plot(log.t_s, lag_mrad[:, joint], lw=0.8)
    top.set_ylabel("shaft angle [rad]")
    bottom.set_ylabel("measured\nless sent [mrad]")
    _clip(bottom, lag_mrad.ravel(), LEAST_MRAD)
    bottom.set_xlabel("time [s]")
    _shade_walking(top, log)
    _mark_faults(top, log)
    _legend_above(top)
    return figure


def _shade_walking(ax: Axes, log: Recording) -> None:
    walking = log.mode == Mode.WALK.value
    edges = np.flatnonzero(np.diff(np.concatenate([[False], walking, [False]]).astype(int)))
    for begin, end in edges.reshape(-1, 2):
        label = "walking" if begin == edges[0] else None
        span = (log.t_s[begin], log.t_s[end - 1])
        ax.axvspan(*span, color="#000000", alpha=0.07, lw=0, label=label)


def _mark_faults(ax: Axes, log: Recording) -> None:
    """Mark ticks with faults at the upper edge, and where a stop began that nobody wished."""
    rows = sorted({row for row, _ in log.faults})
    if rows:
        rows = rows[:: 1 + len(rows) // MOST_MARKS]
        edge = ax.get_xaxis_transform()
        ax.plot(log.t_s[rows], np.full(len(rows), 0.96), ls="", marker="|", ms=5, mew=0.8,
                color=FAULT, transform=edge, label="fault")  # fmt: skip
    unwished = ~np.isin(
        log.stop_reason, [reason.value for reason, stop in STOPS.items() if stop.wished]
    )
    if unwished.any():
        begin = log.t_s[int(np.argmax(unwished))]
        ax.axvline(begin, color=FAULT, lw=1, ls=":", label="stop begins")


def _clip(ax: Axes, values: FloatArray, least: float) -> None:
    """Scale to what matters: a few wild samples must not flatten the rest, and rest is a line."""
    known = values[np.isfinite(values)]
    if len(known) == 0:
        return
    low, high = np.percentile(known, [0.5, 99.5])
    if np.ptp(known) <= WILD * max(high - low, least):
        low, high = known.min(), known.max()
    low, high = min(low, 0.0), max(high, 0.0)
    missing = max(0.0, least - (high - low)) / 2
    margin = 0.08 * max(high - low, least) + missing
    ax.set_ylim(low - margin, high + margin)
