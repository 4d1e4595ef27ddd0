"""Methods of dead reckoning beside each other: path, error along it, velocity; friction of each leg."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robot.odometry.compare import OdometryComparison
from robot.odometry.metrics import Motion, path_length
from robot.report.plots import STYLE

LAST_S = 20.0  # of velocity that are drawn
METHOD_COLOURS = ("#009E73", "#D55E00", "#0072B2", "#CC79A7", "#E69F00")
TRUTH = "#000000"
# Legs are no methods: other colours, and the second half of them (the other side of the body) is dashed.
LEG_COLOURS = ("#7570B3", "#A6761D", "#66A61E", "#17A2B8")
LEAST_STRETCH = 1.5


def drawing(comparison: OdometryComparison) -> Figure:
    """Return the picture."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 7), layout="constrained")
        (path, error), (speed, friction) = figure.subplots(2, 2)
        curves = [(*pair, "-") for pair in zip(comparison.motions, METHOD_COLOURS, strict=False)]
        if comparison.truth is not None:
            curves.append((comparison.truth, TRUTH, "--"))
            _errors(comparison, comparison.truth, error)
        t_s = comparison.track.t_s
        late = t_s > t_s[-1] - LAST_S
        for motion, colour, style in curves:
            path.plot(*motion.pose[:, :2].T, label=motion.name, lw=1, color=colour, ls=style)
            speed.plot(t_s[late], 1e3 * motion.velocity_B[late, 0], lw=0.8, color=colour, ls=style)
        _friction(comparison, friction)
        for ax, title, across, up in (
            (path, "path", "x, m", "y, m"),
            (error, "distance from the truth", "true path, m", "mm"),
            (speed, f"velocity ahead, the last {LAST_S:g} s at most", "time, s", "mm/s"),
            (friction, "friction coefficient of each leg, estimated", "time, s", "mu"),
        ):
            ax.set_title(title, loc="left")
            ax.set(xlabel=across, ylabel=up)
        for ax in (path, error, friction):
            if ax.lines:
                ax.legend(fontsize=7, ncols=2 if ax is friction else 1)
        _say_stretch(figure, path)
    return figure


def _errors(comparison: OdometryComparison, truth: Motion, ax: Axes) -> None:
    """Distance of each method from the truth, and the deviation that the estimator expects."""
    along = path_length(truth.pose)
    for motion, colour in zip(comparison.motions, METHOD_COLOURS, strict=False):
        off = np.hypot(*(motion.pose - truth.pose)[:, :2].T)
        ax.plot(along, 1e3 * off, lw=1, label=motion.name, color=colour)
    variance = comparison.track.displacement_covariance[:, [0, 1], [0, 1]].sum(axis=1)
    label = "two sd, as the estimator says"
    ax.plot(along, 2e3 * np.sqrt(variance), color=TRUTH, ls=":", lw=1, label=label)


def _friction(comparison: OdometryComparison, ax: Axes) -> None:
    names = comparison.names
    half, mu = (len(names) + 1) // 2, comparison.track.column(lambda e: e.mu)
    for k, name in enumerate(names):
        colour = LEG_COLOURS[k % half % len(LEG_COLOURS)]
        style = "-" if k < half else "--"
        ax.plot(comparison.track.t_s, mu[:, k], lw=1, color=colour, ls=style, label=name)


def _say_stretch(figure: Figure, ax: Axes) -> None:
    """Say how much more a metre of y is than one of x: a straight walk would else be a line."""
    figure.draw_without_rendering()
    box = ax.get_window_extent()
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    stretch = (box.height / (high - low)) / (box.width / (right - left))
    if stretch > LEAST_STRETCH:
        ax.set_ylabel(f"y, m (stretched {stretch:.0f} times)")
