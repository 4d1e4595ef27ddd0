"""A walk by the estimator and by simpler methods: path, error, velocity; friction and stiffness of legs.

Each panel is drawn into axes that it is given: the page has one a picture, ``--out FILE.png`` four in one.
"""

from typing import NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from model.values.arrays import FloatArray
from robot.odometry.compare import OdometryComparison
from robot.odometry.metrics import chi_squared_quantile, path_length
from robot.report.plots import STYLE

LAST_S = 20.0  # of velocity and forces that are drawn
METHOD_COLOURS = ("#009E73", "#D55E00", "#0072B2", "#CC79A7", "#E69F00")
TRUTH = "#000000"
# Legs are no methods: other colours, and the second half of them (the other side of the body) is dashed.
LEG_COLOURS = ("#7570B3", "#A6761D", "#66A61E", "#17A2B8")
LEAST_STRETCH = 1.5
LONG_M = 3.0
LEAST_PATH_M = 0.01  # a robot that stands is a point, not rounding errors that fill the picture
ELLIPSES = 10
SHARE = 0.95  # of the places that are to be inside an ellipse
MOST_POINTS, MOST_OF_A_BAND = 6000, 300  # in a line, and in a shade; a still picture thins further
LEAVES = " (leaves the picture)"
FAR = 4.0  # times the error that the estimator expects of itself
FARTHEST = 1.0  # spans of the path beside it that are still drawn, for methods that are far off


def drawing(comparison: OdometryComparison) -> Figure:
    """Return the panels as one picture."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 7), layout="constrained")
        (path, error), (speed, friction) = figure.subplots(2, 2)
        path_panel(comparison, path)
        error_panel(comparison, error)
        speed_panel(comparison, speed)
        leg_panel(comparison, friction, "mu")
        for ax, title in (
            (path, "path"),
            (error, "distance from the truth"),
            (speed, f"velocity ahead, the last {LAST_S:g} s at most"),
            (friction, "friction coefficient of each leg, estimated"),
        ):
            ax.set_title(title, loc="left")
            if ax.lines and ax is not speed:
                ax.legend(fontsize=7, ncols=2 if ax is friction else 1)
        scale_path(figure, path)
    return figure


def thin(ticks: int, most: int = MOST_POINTS) -> slice:
    """As many of some ticks as a picture can show."""
    return slice(None, None, max(1, ticks // most))


def path_panel(comparison: OdometryComparison, ax: Axes) -> None:
    """The path in the plane with the estimator's error ellipses, and the truth."""
    run, some = comparison.track, thin(len(comparison.track.t_s))
    at = np.unique(np.linspace(0, len(run.t_s) - 1, ELLIPSES + 1).astype(int))[1:]
    unit = _unit(comparison)
    ellipses = [
        _ellipse(unit.factor * run.pose[row, :2],
                 unit.factor**2 * run.displacement_covariance[row, :2, :2])
        for row in at
    ]  # fmt: skip
    corners = np.array([corner for one in ellipses for corner in one.get_corners()])
    low, high = _limits(comparison, corners, unit.factor)
    for motion, colour in zip(comparison.motions, METHOD_COLOURS, strict=False):
        place = unit.factor * motion.pose[:, :2]
        seen = bool(((place >= low) & (place <= high)).all())
        label = motion.name + LEAVES * (not seen)
        ax.plot(*place[some].T, label=label, lw=1, color=colour)
    if comparison.truth is not None:
        true = unit.factor * comparison.truth.pose[some, :2]
        ax.plot(*true.T, label="truth", lw=1, color=TRUTH, ls="--")
    for one in ellipses:
        ax.add_patch(one)
    ax.plot(*unit.factor * run.pose[at, :2].T, ls="", marker=".", ms=3, color=METHOD_COLOURS[0])
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    ax.set(xlabel=f"x [{unit.name}]", ylabel=f"y [{unit.name}]")


class Unit(NamedTuple):
    """A unit of length, and how many are a metre."""

    name: str
    factor: float


def _unit(comparison: OdometryComparison) -> Unit:
    """Millimetres, or metres for a long walk."""
    span_m = np.ptp(comparison.track.pose[:, :2], axis=0).max()
    return Unit("m", 1.0) if span_m > LONG_M else Unit("mm", 1e3)


def _ellipse(place: FloatArray, covariance: FloatArray) -> Ellipse:
    """Where the true place is in 95 of 100 cases, if the covariance is right."""
    variance, axes = np.linalg.eigh(covariance)
    width, height = 2.0 * np.sqrt(chi_squared_quantile(SHARE, 2) * np.maximum(variance, 0.0))
    angle = float(np.degrees(np.arctan2(axes[1, 0], axes[0, 0])))
    colour = METHOD_COLOURS[0]
    return Ellipse((float(place[0]), float(place[1])), width, height, angle=angle,
                   facecolor=(*mpl.colors.to_rgb(colour), 0.07), edgecolor=colour, lw=0.6)  # fmt: skip


def _limits(
    comparison: OdometryComparison, corners: FloatArray, factor: float
) -> tuple[FloatArray, FloatArray]:
    """Show what matters, (2,) each: a method that ends far away must not make a point of all others."""
    shown = [factor * comparison.track.pose[:, :2], corners]
    if comparison.truth is not None:
        shown.append(factor * comparison.truth.pose[:, :2])
    places = np.concatenate(shown)
    low, high = np.nanmin(places, axis=0), np.nanmax(places, axis=0)
    missing = np.maximum(0.0, LEAST_PATH_M * factor - (high - low)) / 2
    low, high = low - missing, high + missing
    for motion in comparison.motions[1:]:
        place = factor * motion.pose[:, :2]
        near = np.abs(place - (low + high) / 2) <= (0.5 + FARTHEST) * (high - low)
        if near.all():
            low, high = np.minimum(low, place.min(axis=0)), np.maximum(high, place.max(axis=0))
    margin = 0.04 * (high - low)
    return low - margin, high + margin


def scale_path(figure: Figure, ax: Axes) -> None:
    """Give both axes one scale, or say how much more a metre of y is: a straight walk would be a line."""
    figure.draw_without_rendering()
    box = ax.get_window_extent()
    (left, right), (low, high) = ax.get_xlim(), ax.get_ylim()
    stretch = (box.height / (high - low)) / (box.width / (right - left))
    if stretch > LEAST_STRETCH:
        ax.set_ylabel(f"{ax.get_ylabel()} (stretched {stretch:.0f} times)")
    elif stretch > 1.0:
        ax.set_ylim(*_widened(low, high, stretch))
    else:
        ax.set_xlim(*_widened(left, right, 1.0 / stretch))


def _widened(low: float, high: float, times: float) -> tuple[float, float]:
    """Limits about the same middle, so many times as far apart."""
    half, middle = 0.5 * times * (high - low), 0.5 * (high + low)
    return middle - half, middle + half


def error_panel(comparison: OdometryComparison, ax: Axes) -> None:
    """Distance of each method from the truth, and the deviation that the estimator expects."""
    ax.set(xlabel="true path [m]", ylabel="distance [mm]")
    truth = comparison.truth
    if truth is None:
        return
    along, some = path_length(truth.pose), thin(len(truth.pose))
    variance = comparison.track.displacement_covariance[:, [0, 1], [0, 1]].sum(axis=1)
    expected_mm = 2e3 * np.sqrt(variance)
    off_mm = [1e3 * np.hypot(*(one.pose - truth.pose)[:, :2].T) for one in comparison.motions]
    least = 1.1 * max(np.nanmax(expected_mm), np.nanmax(off_mm[0]))
    tops = [1.1 * top for one in off_mm if (top := np.nanmax(one)) <= FAR * least]
    for motion, off, colour in zip(comparison.motions, off_mm, METHOD_COLOURS, strict=False):
        label = motion.name + LEAVES * bool(np.nanmax(off) > FAR * least)
        ax.plot(along[some], off[some], lw=1, label=label, color=colour)
    label = "2 sd, as the estimator says"
    ax.plot(along[some], expected_mm[some], color=TRUTH, ls=":", lw=1, label=label)
    top = max(least, *tops) if len(tops) == len(off_mm) else FAR * least
    ax.set_ylim(-0.03 * top, top)


def speed_panel(comparison: OdometryComparison, ax: Axes) -> None:
    """Velocity ahead by each method, and the true one."""
    t_s = comparison.track.t_s
    late = np.flatnonzero(t_s > t_s[-1] - LAST_S)[thin(int((t_s > t_s[-1] - LAST_S).sum()))]
    for motion, colour in zip(comparison.motions, METHOD_COLOURS, strict=False):
        speed = 1e3 * motion.velocity_B[late, 0]
        ax.plot(t_s[late], speed, lw=0.8, color=colour, label=motion.name)
    if comparison.truth is not None:
        speed = 1e3 * comparison.truth.velocity_B[late, 0]
        ax.plot(t_s[late], speed, lw=0.8, color=TRUTH, ls="--", label="truth")
    ax.set(xlabel="time [s]", ylabel="vx [mm/s]")


def leg_panel(comparison: OdometryComparison, ax: Axes, what: str) -> None:
    """``mu`` or ``stiffness`` of each leg over time, one standard deviation around each."""
    run, names = comparison.track, comparison.names
    some = thin(len(run.t_s), MOST_OF_A_BAND)
    half = (len(names) + 1) // 2
    value = run.column(what)[some]
    sd = value * run.column(f"{what}_sd")[some]
    for k, name in enumerate(names):
        colour, style = leg_line(k, half)
        ax.plot(run.t_s[some], value[:, k], lw=1, color=colour, ls=style, label=name)
        low, high = value[:, k] - sd[:, k], value[:, k] + sd[:, k]
        ax.fill_between(run.t_s[some], low, high, color=colour, alpha=0.08, lw=0)
    ax.set(xlabel="time [s]", ylabel={"mu": "mu", "stiffness": "K [N/m]"}[what])


def leg_line(leg: int, half: int) -> tuple[str, str]:
    """Colour and style of a leg's lines, of a robot with so many legs on a side."""
    return LEG_COLOURS[leg % half % len(LEG_COLOURS)], "-" if leg < half else "--"
