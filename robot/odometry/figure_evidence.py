"""What an estimate rests on, over time: errors within their bands, innovations, health, rejections, forces.

Each figure is as wide as a phone, so that its letters are of a size to be read there.
"""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator

from model.values.arrays import FloatArray
from model.values.estimate import Health
from robot.odometry.compare import OdometryComparison
from robot.odometry.figure import (
    LAST_S,
    METHOD_COLOURS,
    MOST_OF_A_BAND,
    TRUTH,
    error_panel,
    leg_panel,
    path_panel,
    scale_path,
    thin,
)
from robot.odometry.health import PoorHealth, periods
from robot.odometry.sources import BLOCK_S, Rejected, SourceFit

WIDTH_IN = 4.8
HEALTH_COLOURS = {Health.OK: "#009E73", Health.DEGRADED: "#E69F00", Health.LOST: "#D6204E"}
ESTIMATOR, NAIVE, MEASURED, BAND = *METHOD_COLOURS[:3], "#808080"
NAIVE_AT = 1  # place of the open loop among the methods
MOST_IN_PANEL = 3000
LEAST_NIS, FEW_DECADES = 1e-4, 30.0
LEAST_N = 2.0
REASON = "#555555"
LEAST_SPAN_S = 1 / 250  # of the time shown: a period as narrow as a hair is not seen


def path_figure(comparison: OdometryComparison) -> Figure:
    """Path in the plane with error ellipses."""
    figure, ax = _one(3.6)
    path_panel(comparison, ax)
    _legend(figure, ax, 1 if len(ax.lines) < 4 else 2)
    scale_path(figure, ax)
    return figure


def error_figure(comparison: OdometryComparison) -> Figure:
    """Distance from the truth along the path."""
    figure, ax = _one(3.6)
    error_panel(comparison, ax)
    _legend(figure, ax, 2)
    return figure


def leg_figure(comparison: OdometryComparison, what: str) -> Figure:
    """``mu`` or ``stiffness`` of each leg with its standard deviation."""
    figure, ax = _one(2.8)
    leg_panel(comparison, ax, what)
    _legend(figure, ax, max(3, (len(comparison.names) + 1) // 2))
    return figure


def velocity_figure(comparison: OdometryComparison) -> Figure:
    """Error of each component of the velocity within two standard deviations."""
    assert comparison.truth is not None  # drawn only with one
    run = comparison.track
    figure = Figure(figsize=(WIDTH_IN, 4.8), layout="constrained")
    axes = figure.subplots(3, 1, sharex=True)
    error = 1e3 * (run.velocity_B - comparison.truth.velocity_B)
    covariance = run.column("twist_covariance")
    sd = 1e3 * np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    some, few = thin(len(error)), thin(len(error), MOST_OF_A_BAND)
    labels = ("vx [mm/s]", "vy [mm/s]", "yaw rate [mrad/s]")
    for k, (ax, label) in enumerate(zip(axes, labels, strict=True)):
        ax.fill_between(run.t_s[few], -2 * sd[few, k], 2 * sd[few, k], color=BAND, alpha=0.25,
                        lw=0, label="2 sd, as the estimator says")  # fmt: skip
        ax.plot(
            run.t_s[some], error[some, k], color=ESTIMATOR, lw=0.7, label="estimate minus truth"
        )
        ax.set_ylabel(label)
        known = np.isfinite(error[:, k])
        if known.any():
            inside = np.mean(np.abs(error[known, k]) <= 2 * sd[known, k])
            ax.set_title(f"{100 * inside:.0f} % inside", loc="right", fontsize=8)
            top = 1.15 * max(np.nanpercentile(np.abs(error[:, k]), 99.5), np.median(2 * sd[:, k]))
            ax.set_ylim(-top, top)
    axes[-1].set_xlabel("time [s]")
    _legend(figure, axes[0], 2)
    return figure


def innovation_figure(fits: Sequence[SourceFit], t_s: FloatArray) -> Figure:
    """NIS per degree of freedom of each kind of measurement, with its 95 % band; logarithmic."""
    figure = Figure(figsize=(WIDTH_IN, 0.7 + 1.25 * len(fits)), layout="constrained")
    axes = figure.subplots(len(fits), 1, sharex=True, squeeze=False)[:, 0]
    for ax, one in zip(axes, fits, strict=True):
        middle_s, ratio, (least, most) = one.blocks(t_s)
        edge_s = np.repeat(middle_s, 2) + np.tile([-BLOCK_S / 2, BLOCK_S / 2], len(middle_s))
        ax.fill_between(edge_s, np.repeat(least, 2), np.repeat(most, 2), color=BAND, alpha=0.35, lw=0,
                        label="95 % band")  # fmt: skip
        ax.axhline(1.0, color=TRUTH, lw=0.7, ls=":", label="1 is ideal")
        ax.plot(middle_s, ratio, color=ESTIMATOR, lw=1, marker=".", ms=3, label="mean of a second")
        ax.set_yscale("log")
        low, high = max(LEAST_NIS, min(0.3, 0.7 * ratio.min())), max(3.0, 1.4 * ratio.max())
        ax.yaxis.set_major_locator(
            LogLocator(subs=(1.0, 3.0) if high < FEW_DECADES * low else (1.0,))
        )
        ax.yaxis.set_major_formatter("{x:g}")
        ax.yaxis.set_minor_formatter("")
        ax.set_ylim(low, high)
        ax.set_xlim(t_s[0], t_s[-1])
        ax.set_title(one.name, loc="left", fontsize=8)
        words = f"mean {one.mean:.2f}, {100 * one.in_band(t_s):.0f} % of seconds in the band"
        ax.set_title(words, loc="right", fontsize=8)
        ax.set_ylabel("NIS / numbers")
    axes[-1].set_xlabel("time [s]")
    _legend(figure, axes[0], 3)
    return figure


def health_figure(
    healths: Sequence[Health], reasons: Sequence[PoorHealth], t_s: FloatArray
) -> Figure:
    """Health as a coloured band over time, and below it when each numbered reason held."""
    figure, ax = _one(0.95 + 0.24 * len(reasons))
    least_s = LEAST_SPAN_S * (t_s[-1] - t_s[0])
    for health, colour in HEALTH_COLOURS.items():
        rows = [row for row, one in enumerate(healths) if one is health]
        _bars(ax, periods(t_s, rows), 0, colour, 0.0 if health is Health.OK else least_s)
    for number, one in enumerate(reasons, 1):
        _bars(ax, one.periods, number, REASON, least_s)
    ax.set_yticks(range(len(reasons) + 1), ["health", *map(str, range(1, len(reasons) + 1))])
    ax.set_ylim(len(reasons) + 0.5, -0.5)
    ax.set_xlim(t_s[0], t_s[-1])
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("time [s]")
    samples = [Patch(color=colour, label=one.value) for one, colour in HEALTH_COLOURS.items()]
    figure.legend(handles=samples, loc="outside upper center", ncols=3, frameon=False)
    return figure


def rejection_figure(rejected: Sequence[Rejected], t_s: FloatArray) -> Figure:
    """When measurements were rejected, a kind and leg a row."""
    figure, ax = _one(0.65 + 0.18 * len(rejected))
    least_s = LEAST_SPAN_S * (t_s[-1] - t_s[0])
    for number, one in enumerate(rejected):
        _bars(ax, one.periods, number, HEALTH_COLOURS[Health.LOST], least_s)
    ax.set_yticks(range(len(rejected)), [one.place for one in rejected])
    ax.set_ylim(len(rejected) - 0.5, -0.5)
    ax.set_xlim(t_s[0], t_s[-1])
    ax.grid(visible=False, axis="y")
    ax.set_xlabel("time [s]")
    return figure


def _bars(ax: Axes, times_s: FloatArray, row: int, colour: str, least_s: float) -> None:
    """Periods as bars of a row, none of them too short to be seen; those that then touch are one bar."""
    bars: list[list[float]] = []
    for begin, end in times_s:
        if bars and begin <= bars[-1][1]:
            bars[-1][1] = max(bars[-1][1], end, begin + least_s)
        else:
            bars.append([begin, max(end, begin + least_s)])
    spans = [(begin, end - begin) for begin, end in bars]
    ax.broken_barh(spans, (row - 0.38, 0.76), facecolors=colour, lw=0)


def force_figures(comparison: OdometryComparison) -> dict[str, Figure]:
    """Forces on each foot in the last seconds, measured and predicted, by leg."""
    run, naive = comparison.track, comparison.motions[NAIVE_AT:][:1]
    late = np.flatnonzero(run.t_s > run.t_s[-1] - LAST_S)
    late = late[thin(len(late), MOST_IN_PANEL)]
    curves = [(comparison.reference_force_n, MEASURED, 1.4, "-")]
    curves += [(one.force_B, NAIVE, 0.8, "--") for one in naive]
    curves.append((run.force_B, ESTIMATOR, 0.9, "-"))
    spans = [_span_n(comparison.reference_force_n[late, :, k]) for k in range(3)]
    figures = {}
    for leg, name in enumerate(comparison.names):
        figure = Figure(figsize=(WIDTH_IN, 3.4), layout="constrained")
        axes = figure.subplots(3, 1, sharex=True)
        for k, (ax, span) in enumerate(zip(axes, spans, strict=True)):
            for force, colour, width, style in curves:
                ax.plot(run.t_s[late], force[late, leg, k], color=colour, lw=width, ls=style)
            ax.set_ylim(-0.1 * span if k == 2 else -1.2 * span, 1.2 * span)
            ax.set_ylabel(f"F{'xyz'[k]} [N]")
        axes[0].set_title(name, loc="left")
        axes[-1].set_xlabel("time [s]")
        labels = ["measured" if comparison.judged_by_sensors else "true"]
        labels += [*("open loop" for _ in naive), "estimator"]
        samples = [
            Line2D([], [], color=colour, lw=width, ls=style, label=label)
            for (_, colour, width, style), label in zip(curves, labels, strict=True)
        ]
        figure.legend(handles=samples, loc="outside upper center", ncols=3, frameon=False)
        figures[name] = figure
    return figures


def _span_n(force_n: FloatArray) -> float:
    """How far an axis of forces goes: as nearly all of them, and never so little that noise fills it."""
    known = np.abs(force_n[np.isfinite(force_n)])
    return max(LEAST_N, float(np.percentile(known, 99.8))) if len(known) else LEAST_N


def _one(height_in: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(WIDTH_IN, height_in), layout="constrained")
    return figure, figure.subplots()


def _legend(figure: Figure, ax: Axes, columns: int) -> None:
    """Put the legend above the axes, where no curve is."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=columns, frameon=False)
