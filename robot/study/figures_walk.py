"""One walk drawn: trajectory, tilt, body velocity and one foot (fig:FTbigAnt)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from scipy.ndimage import uniform_filter1d

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
from robot.study.walk_errors import component_errors, error_of

FOOT = "FR"  # the foot the paper shows
SMOOTH_S = 0.1  # forces are drawn as means over so long; all errors are of the raw samples
FORCE_LABELS = ("Fx [N]", "Fy [N]", "share of Fz")


STUCK = (
    "Where all feet down move alike, noise of some ten micrometres a second decides Coulomb's forces: they "
    "chatter, the ill-posed case of the paper's static friction, and the ansatz does not."
)


def draw_walk(walk: WalkComparison) -> tuple[Figure, str]:
    """Draw trajectory, tilt, body velocity and the forces of one foot."""
    figure = Figure(figsize=(11, 10), layout="constrained")
    grid = figure.add_gridspec(4, 3, height_ratios=[1.25, 1, 1, 1])
    _trajectory(figure.add_subplot(grid[0, :2]), walk)
    _stretched(figure.add_subplot(grid[0, 2]), walk)
    for column, name in enumerate(("roll", "pitch", "yaw")):
        _tilt(figure.add_subplot(grid[1, column]), walk, column, name)
    for column, name in enumerate(("vx [mm/s]", "vy [mm/s]", "yaw rate [mrad/s]")):
        ax = figure.add_subplot(grid[2, column])
        ax.plot(walk.t_s, 1e3 * walk.velocity_B[:, column], color=TRUTH, lw=TRUTH_WIDTH)
        for law, colour in ((walk.viscous, VISCOUS), (walk.coulomb, COULOMB)):
            ax.plot(walk.t_s, 1e3 * law.velocity_B[:, column], color=colour, lw=MODEL_WIDTH)
        ax.set(ylabel=name)
        limit_to_most(ax, 1e3 * walk.velocity_B[:, column], 1e3 * walk.viscous.velocity_B[:, column],
                      1e3 * walk.coulomb.velocity_B[:, column])  # fmt: skip
    foot = walk.names.index(FOOT) if FOOT in walk.names else 0
    for column in range(3):
        ax = figure.add_subplot(grid[3, column])
        plot_foot_force(ax, walk, foot, column)
        ax.set(ylabel=f"{walk.names[foot]} {FORCE_LABELS[column]}", xlabel="time [s]")
    model_legend(figure)
    return figure, _caption(walk)


def _paths(walk: WalkComparison) -> tuple[tuple[FloatArray, str, float], ...]:
    """Pose, colour and line width of the true and both predicted ways; unknown ones left out."""
    true = np.column_stack([walk.position_W[:, :2], walk.tilt_rad[:, 2]])
    paths = (
        (true, TRUTH, TRUTH_WIDTH),
        (walk.viscous.pose, VISCOUS, 1.6),
        (walk.coulomb.pose, COULOMB, 1.6),
    )
    return tuple(path for path in paths if np.isfinite(path[0]).any())


def _trajectory(ax: Axes, walk: WalkComparison) -> None:
    for pose, colour, width in _paths(walk):
        ax.plot(pose[:, 0], pose[:, 1], color=colour, lw=width)
        for frame in (0, len(pose) // 2, len(pose) - 1):
            ax.plot(*pose[frame, :2], "+", color=colour, ms=11, mew=2)
            ax.plot(*_rectangle(pose[frame], walk.body_size_m).T, color=colour, lw=0.9)
    ax.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
    ax.set_title("trajectory, the body at its beginning, half way and end", loc="left", fontsize=9)


def _stretched(ax: Axes, walk: WalkComparison) -> None:
    for pose, colour, width in _paths(walk):
        ax.plot(pose[:, 0], 1e3 * pose[:, 1], color=colour, lw=width)
        ax.plot(pose[-1, 0], 1e3 * pose[-1, 1], "+", color=colour, ms=11, mew=2)
    ax.set(xlabel="x [m]", ylabel="y [mm]")
    ax.set_title("the same, sideways stretched", loc="left", fontsize=9)


def _rectangle(pose: FloatArray, size: FloatArray) -> FloatArray:
    """Outline of the body, (5, 2) [m]."""
    corners = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1], [1, 1]]) * size / 2
    c, s = np.cos(pose[2]), np.sin(pose[2])
    outline: FloatArray = pose[:2] + corners @ np.array([[c, s], [-s, c]])
    return outline


def _tilt(ax: Axes, walk: WalkComparison, column: int, name: str) -> None:
    ax.plot(walk.t_s, 1e3 * walk.tilt_rad[:, column], color=TRUTH, lw=TRUTH_WIDTH)
    if column < 2:
        ax.plot(walk.t_s, 1e3 * walk.support_tilt_rad[:, column], color=SUPPORT, lw=MODEL_WIDTH)
    else:
        for law, colour in ((walk.viscous, VISCOUS), (walk.coulomb, COULOMB)):
            ax.plot(walk.t_s, 1e3 * law.pose[:, 2], color=colour, lw=1.6)
    ax.set(ylabel=f"{name} [mrad]")


def plot_foot_force(ax: Axes, walk: WalkComparison, foot: int, column: int) -> None:
    """Plot one force component of one foot, Fx, Fy or the share of Fz, as running means."""
    curves: tuple[tuple[FloatArray, str, float], ...]
    if column == 2:
        curves = ((walk.true_share, TRUTH, TRUTH_WIDTH), (walk.load_share, SUPPORT, MODEL_WIDTH))
        ax.set_ylim(-0.05, 1.0)
    else:
        curves = (
            (walk.force_n[..., column], TRUTH, TRUTH_WIDTH),
            (walk.coulomb.force_xy_B[..., column], COULOMB, MODEL_WIDTH),
            (walk.viscous.force_xy_B[..., column], VISCOUS, MODEL_WIDTH),
        )
    smooth = [running_mean(curve, walk.t_s) for curve, _, _ in curves]
    for curve, (_, colour, width) in zip(smooth, curves, strict=True):
        ax.plot(walk.t_s, curve[:, foot], color=colour, lw=width)
    if column < 2:
        limit_to_most(ax, *smooth)


def running_mean(curve: FloatArray, t_s: FloatArray) -> FloatArray:
    """Mean over ``SMOOTH_S`` about each sample along the first axis: for the eye, not for errors."""
    size = max(1, round(SMOOTH_S / float(np.median(np.diff(t_s)))))
    mean: FloatArray = uniform_filter1d(curve, size, axis=0, mode="nearest")
    return mean


def limit_to_most(ax: Axes, *curves: FloatArray) -> None:
    """Scale to all but the wildest thousandth of each curve; a spike must not flatten the rest."""
    ends = [np.nanpercentile(curve, [0.1, 99.9]) for curve in curves if np.isfinite(curve).any()]
    if not ends:
        return
    low, high = min(end[0] for end in ends), max(end[1] for end in ends)
    margin = 0.08 * max(high - low, 1e-9)
    ax.set_ylim(low - margin, high + margin)


def _caption(walk: WalkComparison) -> str:
    errors = component_errors(walk)
    vx, yaw = error_of(errors, "vx"), error_of(errors, "yaw rate")
    vy, swayed = error_of(errors, "vy"), error_of(errors, "vy + sway")
    fx, fz = error_of(errors, "Fx"), error_of(errors, "Fz share")
    way = walk.position_W[-1, :2] - walk.position_W[0, :2]
    ends = [law.pose[-1, :2] - law.pose[0, :2] for law in (walk.viscous, walk.coulomb)]
    note = f"{STUCK} " if fx.coulomb > fx.spread else ""
    return (
        f"The {walk.gait} walk, {np.ptp(walk.phase):.1f} cycles. Way: true {np.hypot(*way):.3f} m, "
        f"viscous-Coulomb {np.hypot(*ends[0]):.3f} m, Coulomb {np.hypot(*ends[1]):.3f} m. RMSE of vx: "
        f"viscous {vx.viscous:.1f}, Coulomb {vx.coulomb:.1f} mm/s, the laws {vx.apart:.1f} mm/s apart; "
        f"of vy {vy.coulomb:.2f} mm/s (Coulomb), {swayed.coulomb:.2f} with the sway that the planar "
        "balance leaves out (height x roll rate of the spring support); "
        f"of the yaw rate {yaw.viscous:.1f} and {yaw.coulomb:.1f} mrad/s; of Fx {fx.viscous:.1f} and "
        f"{fx.coulomb:.1f} N; of the share of Fz {fz.support:.1f} %. Forces are drawn as means over "
        f"{SMOOTH_S:g} s, errors are of the raw samples. {note}The paper prints no "
        "RMSE; it finds the two laws closer to each other than either to the robot: here that is "
        f"{'so' if vx.apart < min(vx.viscous, vx.coulomb) else 'not so'} for vx and "
        f"{'so' if yaw.apart < min(yaw.viscous, yaw.coulomb) else 'not so'} for the yaw rate."
    )
