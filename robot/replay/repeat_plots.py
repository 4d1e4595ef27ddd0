"""Pictures of a run and its repetition: body velocity, vertical forces, shafts, with their differences."""

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from robot.replay.repeat import Overlay
from robot.report.plots import DIFFERENCE, PREDICTED, STYLE, TRUE

OLD, NEW = TRUE, PREDICTED


def draw_repeat(both: Overlay) -> dict[str, Figure]:
    """Draw all pictures of two runs that lie one over the other, by title."""
    with mpl.rc_context(STYLE):
        return {"Body velocity": _velocity(both), "Feet and shafts": _legs(both)}


def _velocity(both: Overlay) -> Figure:
    figure = Figure(figsize=(9, 6.4), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True)
    kind, name = "true", "truth_velocity_B"
    if not all(np.isfinite(run[name]).any() for run in (both.old, both.new)):
        kind, name = "predicted", "predicted_velocity_B"
    old, new = both.old[name], both.new[name]
    labels = ("vx [mm/s]", "vy [mm/s]", "yaw rate [mrad/s]")
    colours = (PREDICTED, "#009E73", "#CC79A7")
    for part, (ax, label, colour) in enumerate(zip(axes, labels, colours, strict=False)):
        ax.plot(both.t_s, old[:, part] * 1e3, color=OLD, lw=1.8, label=f"old, {kind}")
        ax.plot(both.t_s, new[:, part] * 1e3, color=NEW, lw=0.9, label=f"new, {kind}")
        ax.set_ylabel(label)
        difference = (new - old)[:, part] * 1e3
        axes[3].plot(both.t_s, difference, color=colour, lw=0.8, label=label)
    axes[0].legend(loc="upper right", ncols=2)
    axes[3].legend(loc="upper right", ncols=3)
    axes[3].set_ylabel("new - old")
    axes[3].set_xlabel("time since the feet began to move [s]")
    return figure


def _legs(both: Overlay) -> Figure:
    legs = len(both.names)
    figure = Figure(figsize=(9, 1.5 * legs + 0.6), layout="constrained")
    axes = figure.subplots(legs, 3, sharex=True, squeeze=False, sharey="col")
    t_s = both.t_s
    angle, amperes = both.difference("angle_rad"), both.difference("current_a")
    for leg, name in enumerate(both.names):
        force, shaft, current = axes[leg]
        force.plot(t_s, both.old["force_n"][:, leg, 2], color=OLD, lw=1.4)
        force.plot(t_s, both.new["force_n"][:, leg, 2], color=NEW, lw=0.8)
        shaft.plot(t_s, angle[:, leg] * 1e3, color=DIFFERENCE, lw=0.8)
        current.plot(t_s, amperes[:, leg], color=DIFFERENCE, lw=0.8)
        force.set_ylabel(name)
    titles = ("Fz [N], old and new", "shaft, new - old [mrad]", "current, new - old [A]")
    for ax, title in zip(axes[0], titles, strict=True):
        ax.set_title(title)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
    figure.legend(
        handles=[
            mpl.lines.Line2D([], [], color=colour, label=label)
            for colour, label in ((OLD, "old"), (NEW, "new"))
        ],
        loc="outside upper center",
        ncols=2,
    )
    return figure
