"""One walk drawn: trajectory, tilt, body velocity and one foot (fig:FTbigAnt)."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter1d

from model.motion.se2 import placed
from model.values.arrays import FloatArray
from robot.report.figure_style import (
    COULOMB,
    MODEL_WIDTH,
    SUPPORT,
    TRUTH,
    TRUTH_WIDTH,
    VISCOUS,
    model_legend,
)
from robot.study.walk_comparison import WalkComparison
from robot.study.walk_errors import UNKNOWN, Component, component_errors, components

FOOT = "FR"  # the foot the paper shows
CORNERS = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]]) / 2  # of the body, in its size
SMOOTH_S = 0.1  # forces are drawn as means over so long; all errors are of the raw samples
FORCES, FORCE_LABELS = ("Fx", "Fy", "Fz share"), ("Fx [N]", "Fy [N]", "share of Fz")
STUCK = (
    "Where all feet down move alike, noise of some ten micrometres a second decides Coulomb's forces: they "
    "chatter, the ill-posed case of the paper's static friction, and the ansatz does not."
)
Curve = tuple[FloatArray, str, float]  # values, colour, line width


def draw_walk(walk: WalkComparison) -> tuple[Figure, str]:
    """Draw trajectory, tilt, body velocity and the forces of one foot."""
    figure = Figure(figsize=(11, 10), layout="constrained")
    grid = figure.add_gridspec(4, 3, height_ratios=[1.25, 1, 1, 1])
    _trajectory(figure.add_subplot(grid[0, :2]), walk)
    _stretched(figure.add_subplot(grid[0, 2]), walk)
    parts = components(walk)
    for column, name in enumerate(("roll", "pitch", "yaw")):
        ax = figure.add_subplot(grid[1, column])
        if name == "yaw":
            ax.plot(walk.t_s, 1e3 * walk.tilt_rad[:, 2], color=TRUTH, lw=TRUTH_WIDTH)
            for law, colour in ((walk.viscous, VISCOUS), (walk.coulomb, COULOMB)):
                ax.plot(walk.t_s, 1e3 * law.pose[:, 2], color=colour, lw=1.6)
        else:
            _plot(ax, walk.t_s, _curves(parts[name]))
        ax.set(ylabel=f"{name} [mrad]")
    for column, name in enumerate(("vx", "vy", "yaw rate")):
        ax = figure.add_subplot(grid[2, column])
        _plot(ax, walk.t_s, _curves(parts[name]))
        ax.set(ylabel=f"{name} [{parts[name].unit}]")
        _limit_to_most(ax, [curve for curve, _, _ in _curves(parts[name])])
    foot = walk.names.index(FOOT) if FOOT in walk.names else 0
    for column in range(3):
        ax = figure.add_subplot(grid[3, column])
        plot_foot_force(ax, walk, foot, column)
        ax.set(ylabel=f"{walk.names[foot]} {FORCE_LABELS[column]}", xlabel="time [s]")
    model_legend(figure)
    return figure, _caption(walk)


def _paths(walk: WalkComparison) -> list[Curve]:
    """The true and both predicted poses; unknown ones left out."""
    true = np.column_stack([walk.position_W[:, :2], walk.tilt_rad[:, 2]])
    paths = (
        (true, TRUTH, TRUTH_WIDTH),
        (walk.viscous.pose, VISCOUS, 1.6),
        (walk.coulomb.pose, COULOMB, 1.6),
    )
    return [path for path in paths if np.isfinite(path[0]).any()]


def _trajectory(ax: Axes, walk: WalkComparison) -> None:
    for pose, colour, width in _paths(walk):
        ax.plot(pose[:, 0], pose[:, 1], color=colour, lw=width)
        for frame in (0, len(pose) // 2, len(pose) - 1):
            ax.plot(*pose[frame, :2], "+", color=colour, ms=11, mew=2)
            body = placed(pose[frame], CORNERS * walk.body_size_m)
            ax.plot(*body.T, color=colour, lw=0.9)
    ax.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    ax.set_title("trajectory, the body at its beginning, half way and end", loc="left", fontsize=9)


def _stretched(ax: Axes, walk: WalkComparison) -> None:
    for pose, colour, width in _paths(walk):
        ax.plot(pose[:, 0], 1e3 * pose[:, 1], color=colour, lw=width)
        ax.plot(pose[-1, 0], 1e3 * pose[-1, 1], "+", color=colour, ms=11, mew=2)
    ax.set(xlabel="x [m]", ylabel="y [mm]")
    ax.set_title("the same, sideways stretched", loc="left", fontsize=9)


def _curves(one: Component) -> list[Curve]:
    """What is true and what the models predict, those that do."""
    models = ((one.viscous, VISCOUS), (one.coulomb, COULOMB), (one.support, SUPPORT))
    predicted = [(curve, col, MODEL_WIDTH) for curve, col in models if curve is not UNKNOWN]
    return [(one.true, TRUTH, TRUTH_WIDTH), *predicted]


def _plot(ax: Axes, t_s: FloatArray, curves: Sequence[Curve]) -> None:
    for curve, colour, width in curves:
        ax.plot(t_s, curve, color=colour, lw=width)


def plot_foot_force(ax: Axes, walk: WalkComparison, foot: int, column: int) -> None:
    """Plot one force component of one foot, Fx, Fy or the share of Fz, as running means."""
    true, *predicted = _curves(components(walk)[FORCES[column]])
    to_share = 1e-2 if column == 2 else 1.0
    smooth = [
        (to_share * running_mean(curve, walk.t_s), colour, width)
        for curve, colour, width in (true, *reversed(predicted))  # the ansatz on top
    ]
    _plot(ax, walk.t_s, [(curve[:, foot], colour, width) for curve, colour, width in smooth])
    if column == 2:
        ax.set_ylim(-0.05, 1.0)
    else:
        _limit_to_most(ax, [curve for curve, _, _ in smooth])


def running_mean(curve: FloatArray, t_s: FloatArray) -> FloatArray:
    """Mean over ``SMOOTH_S`` about each sample along the first axis: for the eye, not for errors."""
    size = max(1, round(SMOOTH_S / float(np.median(np.diff(t_s)))))
    mean: FloatArray = uniform_filter1d(curve, size, axis=0, mode="nearest")
    return mean


def _limit_to_most(ax: Axes, curves: Sequence[FloatArray]) -> None:
    """Scale to all but the wildest thousandth of each curve; a spike must not flatten the rest."""
    ends = [np.nanpercentile(curve, [0.1, 99.9]) for curve in curves if np.isfinite(curve).any()]
    if not ends:
        return
    low, high = min(end[0] for end in ends), max(end[1] for end in ends)
    margin = 0.08 * max(high - low, 1e-9)
    ax.set_ylim(low - margin, high + margin)


def _caption(walk: WalkComparison) -> str:
    errors = component_errors(walk)
    vx, vy, yaw, fx = (errors[name] for name in ("vx", "vy", "yaw rate", "Fx"))
    paths = (walk.position_W, walk.viscous.pose, walk.coulomb.pose)
    true_m, viscous_m, coulomb_m = (np.hypot(*(path[-1, :2] - path[0, :2])) for path in paths)
    closer = ["so" if e.apart < min(e.viscous, e.coulomb) else "not so" for e in (vx, yaw)]
    note = f"{STUCK} " if fx.coulomb > fx.spread else ""
    return (
        f"The {walk.gait} walk, {np.ptp(walk.phase):.1f} cycles. Distance: true {true_m:.3f} m, "
        f"viscous-Coulomb {viscous_m:.3f} m, Coulomb {coulomb_m:.3f} m. RMSE of vx: "
        f"viscous {vx.viscous:.1f}, Coulomb {vx.coulomb:.1f} mm/s, the laws {vx.apart:.1f} mm/s apart; "
        f"of vy {vy.coulomb:.2f} mm/s (Coulomb), {errors['vy + sway'].coulomb:.2f} with the sway that "
        "the planar balance leaves out (height x roll rate of the spring support); "
        f"of the yaw rate {yaw.viscous:.1f} and {yaw.coulomb:.1f} mrad/s; of Fx {fx.viscous:.1f} and "
        f"{fx.coulomb:.1f} N; of the share of Fz {errors['Fz share'].support:.1f} %. Forces are drawn "
        f"as means over {SMOOTH_S:g} s, errors are of the raw samples. {note}The paper prints no "
        "RMSE; it finds the two laws closer to each other than either to the robot: here that is "
        f"{closer[0]} for vx and {closer[1]} for the yaw rate."
    )
