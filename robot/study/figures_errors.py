"""Distributions of the prediction errors, as violins (fig:err, fig:slipping_err)."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model.values.arrays import FloatArray
from robot.report.figure_style import COULOMB, SUPPORT, TRUTH, VISCOUS, line
from robot.study.walk_comparison import WalkComparison
from robot.study.walk_errors import component_errors, error_of

GROUP, WIDTH = 1.0, 0.26  # distance of groups and width of a violin on the axis
MOST_SAMPLES = 3000  # a violin needs no more
SHOWN = (0.5, 99.5)  # percentiles kept in a violin; beyond are touchdown spikes

Part = tuple[FloatArray, str]  # samples and their colour


def draw_error_distributions(walk: WalkComparison) -> tuple[Figure, str]:
    """Draw residuals from the mean and prediction errors of velocity, tilt and forces."""
    figure = Figure(figsize=(11, 9), layout="constrained")
    grid = figure.add_gridspec(4, 5)
    names = ("vx [mm/s]", "vy [mm/s]", "yaw rate [mrad/s]", "roll [mrad]", "pitch [mrad]")
    for column, name in enumerate(names):
        ax = figure.add_subplot(grid[0, column])
        parts = _velocity_parts(walk, column) if column < 3 else _tilt_parts(walk, column - 3)
        _violins(ax, [parts], [""])
        ax.set_title(name, fontsize=9)
    for row in range(3):
        ax = figure.add_subplot(grid[row + 1, :])
        _force_panel(ax, walk, row)
    _legend(figure, support=True)
    return figure, _caption(walk, ("vx", "vy", "yaw rate", "roll", "pitch", "Fx", "Fy", "Fz share"))


def draw_planar_force_errors(walk: WalkComparison) -> tuple[Figure, str]:
    """Draw residuals and errors of the horizontal forces alone."""
    figure = Figure(figsize=(11, 5.4), layout="constrained")
    for row, ax in enumerate(figure.subplots(2, 1)):
        _force_panel(ax, walk, row)
    _legend(figure, support=False)
    return figure, _caption(walk, ("Fx", "Fy"))


def _velocity_parts(walk: WalkComparison, axis: int) -> list[Part]:
    true = 1e3 * walk.velocity_B[:, axis]
    return [
        (true - _mean(true), TRUTH),
        (1e3 * walk.viscous.velocity_B[:, axis] - true, VISCOUS),
        (1e3 * walk.coulomb.velocity_B[:, axis] - true, COULOMB),
    ]


def _tilt_parts(walk: WalkComparison, axis: int) -> list[Part]:
    true = 1e3 * walk.tilt_rad[:, axis]
    return [(true - _mean(true), TRUTH), (1e3 * walk.support_tilt_rad[:, axis] - true, SUPPORT)]


def _force_panel(ax: Axes, walk: WalkComparison, axis: int) -> None:
    """Draw a group of violins for each foot, over the frames in which the foot is down."""
    groups = []
    for foot in range(len(walk.names)):
        down = walk.force_n[:, foot, 2] > 0
        if axis == 2:
            true = 1e2 * walk.true_share[down, foot]
            groups.append([
                (true - _mean(true), TRUTH),
                (1e2 * walk.load_share[down, foot] - true, SUPPORT),
            ])  # fmt: skip
        else:
            true = walk.force_n[down, foot, axis]
            groups.append([
                (true - _mean(true), TRUTH),
                (walk.viscous.force_xy_B[down, foot, axis] - true, VISCOUS),
                (walk.coulomb.force_xy_B[down, foot, axis] - true, COULOMB),
            ])  # fmt: skip
    _violins(ax, groups, list(walk.names))
    ax.set_ylabel(("Fx [N]", "Fy [N]", "share of Fz [%]")[axis])


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


def _mean(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else np.nan


def _legend(figure: Figure, *, support: bool) -> None:
    handles = [
        line(TRUTH, "true, mean subtracted", 6),
        line(VISCOUS, "error, viscous-Coulomb", 6),
        line(COULOMB, "error, Coulomb", 6),
    ]
    if support:
        handles.append(line(SUPPORT, "error, spring support", 6))
    figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))


def _caption(walk: WalkComparison, components: tuple[str, ...]) -> str:
    errors = component_errors(walk)
    words = []
    for name in components:
        row = error_of(errors, name)
        models = (("viscous", row.viscous), ("Coulomb", row.coulomb), ("support", row.support))
        said = ", ".join(f"{label} {value:.2f}" for label, value in models if np.isfinite(value))
        words.append(f"{name} {said} (spread {row.spread:.2f}) {row.unit}")
    return (
        f"Error distributions, {walk.gait} gait: violins with quartiles and median, the inner "
        f"{SHOWN[1] - SHOWN[0]:.0f} %; forces of each foot while it is down. RMSE over all frames: "
        + "; ".join(words)
        + ". The paper shows the distributions without figures."
    )
