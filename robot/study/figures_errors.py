"""Distributions of the prediction errors, as violins (fig:err, fig:slipping_err)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model.values.arrays import FloatArray, known_mean
from robot.report.figure_style import COULOMB, SUPPORT, TRUTH, VISCOUS, line
from robot.study.walk_comparison import WalkComparison
from robot.study.walk_errors import UNKNOWN, Component, component_errors, components

GROUP, WIDTH = 1.0, 0.26  # distance of groups and width of a violin on the axis
MOST_SAMPLES = 3000  # a violin needs no more
SHOWN = (0.5, 99.5)  # percentiles kept in a violin; beyond are touchdown spikes
BODY, FORCES = ("vx", "vy", "yaw rate", "roll", "pitch"), ("Fx", "Fy", "Fz share")

Part = tuple[FloatArray, str]  # samples and their colour


def draw_error_distributions(walk: WalkComparison) -> tuple[Figure, str]:
    """Draw residuals from the mean and prediction errors of velocity, tilt and forces."""
    figure = Figure(figsize=(11, 9), layout="constrained")
    grid = figure.add_gridspec(4, 5)
    parts = components(walk)
    for column, name in enumerate(BODY):
        ax = figure.add_subplot(grid[0, column])
        _violins(ax, [_parts(parts[name])], [""])
        ax.set_title(f"{name} [{parts[name].unit}]", fontsize=9)
    for row, name in enumerate(FORCES):
        _force_panel(figure.add_subplot(grid[row + 1, :]), walk, parts[name])
    _legend(figure, support=True)
    return figure, _caption(walk, (*BODY, *FORCES))


def draw_planar_force_errors(walk: WalkComparison) -> tuple[Figure, str]:
    """Draw residuals and errors of the horizontal forces alone."""
    figure = Figure(figsize=(11, 5.4), layout="constrained")
    parts = components(walk)
    for name, ax in zip(FORCES[:2], figure.subplots(2, 1), strict=True):
        _force_panel(ax, walk, parts[name])
    _legend(figure, support=False)
    return figure, _caption(walk, FORCES[:2])


def _parts(one: Component, samples: Any = ...) -> list[Part]:
    """True values about their mean, and the errors of each model that predicts them."""
    true = one.true[samples]
    models = ((one.viscous, VISCOUS), (one.coulomb, COULOMB), (one.support, SUPPORT))
    return [
        (true - known_mean(true), TRUTH),
        *((model[samples] - true, colour) for model, colour in models if model is not UNKNOWN),
    ]


def _force_panel(ax: Axes, walk: WalkComparison, force: Component) -> None:
    """Draw a group of violins for each foot, over the frames in which the foot is down."""
    down = walk.force_n[..., 2] > 0
    groups = [_parts(force, (down[:, foot], foot)) for foot in range(len(walk.names))]
    _violins(ax, groups, list(walk.names))
    ax.set_ylabel("share of Fz [%]" if force.unit == "%" else f"{force.name} [{force.unit}]")


def _violins(ax: Axes, groups: list[list[Part]], names: list[str]) -> None:
    ax.axhline(0, color="black", lw=0.6)
    for number, parts in enumerate(groups):
        for place, (samples, colour) in enumerate(parts):
            at = number * GROUP + (place - (len(parts) - 1) / 2) * WIDTH * 1.1
            kept = _kept(samples)
            if len(kept) < 2 or np.ptp(kept) == 0:
                continue
            drawn = ax.violinplot([kept], positions=[at], widths=WIDTH, showextrema=False)
            bodies: Any = drawn["bodies"]  # matplotlib types them as one collection
            for body in bodies:
                body.set(facecolor=colour, alpha=0.65, edgecolor=colour)
            low, middle, high = np.percentile(kept, [25, 50, 75])
            ax.plot([at, at], [low, high], color="black", lw=2)
            ax.plot(at, middle, "o", color="white", mec="black", ms=3.5)
    ax.set_xticks([number * GROUP for number in range(len(groups))], names)
    ax.grid(visible=False, axis="x")


def _kept(samples: FloatArray) -> FloatArray:
    known = samples[np.isfinite(samples)]
    if len(known) < 2:
        return known
    low, high = np.percentile(known, SHOWN)
    inner = known[(known >= low) & (known <= high)]
    thinned: FloatArray = inner[:: max(1, len(inner) // MOST_SAMPLES)]
    return thinned


def _legend(figure: Figure, *, support: bool) -> None:
    handles = [
        line(TRUTH, "true, mean subtracted", 6),
        line(VISCOUS, "error, viscous-Coulomb", 6),
        line(COULOMB, "error, Coulomb", 6),
    ]
    if support:
        handles.append(line(SUPPORT, "error, spring support", 6))
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))


def _caption(walk: WalkComparison, names: tuple[str, ...]) -> str:
    errors = component_errors(walk)
    words = []
    for name in names:
        row = errors[name]
        models = (("viscous", row.viscous), ("Coulomb", row.coulomb), ("support", row.support))
        rmse = ", ".join(f"{label} {value:.2f}" for label, value in models if np.isfinite(value))
        words.append(f"{name} {rmse} (spread {row.spread:.2f}) {row.unit}")
    return (
        f"Error distributions, {walk.gait} gait: violins with quartiles and median, the inner "
        f"{SHOWN[1] - SHOWN[0]:.0f} %; forces of each foot while it is down. RMSE over all frames: "
        + "; ".join(words)
        + ". The paper shows the distributions without figures."
    )
