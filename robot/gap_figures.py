"""Pictures of a diagnosis: the map of where, before and after, the causes."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gap.findings import Diagnosis, Verdict
from gap.where import PHASE_BINS, ChannelGap, Where
from robot.plots import PREDICTED, STYLE, TRUE

AFTER = "#009E73"
MOST_ROWS = 40


def draw_diagnosis(d: Diagnosis) -> dict[str, Figure]:
    """Draw all pictures, by title."""
    with mpl.rc_context(STYLE):
        found = {"Where it lies": _stages(d), "Which channel, and when in the gait": _map(d)}
        if d.far.traces and d.verdict is not Verdict.NO_GAP:
            found["Before and after, in a run kept back"] = _traces(d)
        return found


def _stages(d: Diagnosis) -> Figure:
    figure = Figure(figsize=(9, 2.6), layout="constrained")
    ax: Axes = figure.subplots()
    seen = [one for one in d.where.stages if np.isfinite(one.own)]
    at = np.arange(len(seen))
    own = [max(one.own, 0.1) for one in seen]
    whole = [max(one.end_to_end, 0.1) for one in seen]
    left = [max(one.own, 0.1) for one in d.remaining.stages if np.isfinite(one.own)]
    ax.bar(at - 0.27, own, 0.26, color=PREDICTED, label="stage by itself, fed what was measured")
    ax.bar(at, whole, 0.26, color=TRUE, label="end to end, fed commands")
    ax.bar(at + 0.27, left, 0.26, color=AFTER, label="stage by itself, with the causes added")
    ax.axhline(1, color="k", lw=0.8)
    ax.set_yscale("log")
    ax.set_xticks(at, [one.stage for one in seen])
    ax.set_ylabel("energy / expected")
    ax.legend(fontsize=7)
    return figure


def _rows(where: Where) -> list[ChannelGap]:
    known = [one for one in where.channels if np.isfinite(one.excess)]
    return sorted(known, key=lambda one: -one.excess)[:MOST_ROWS]


def _map(d: Diagnosis) -> Figure:
    rows = _rows(d.where)
    if not rows:
        return Figure(figsize=(9, 1))
    cyclic = any(np.isfinite(one.bands[0]) for one in rows)
    values = np.array([one.phases if cyclic else one.thirds for one in rows])
    figure = Figure(figsize=(9, 0.8 + 0.17 * len(rows)), layout="constrained")
    ax: Axes = figure.subplots()
    ax.grid(visible=False)
    shown = np.log10(np.fmax(values, 0.3))
    picture = ax.imshow(
        shown, aspect="auto", cmap="magma_r", vmin=-0.3, vmax=max(1.0, np.nanmax(shown))
    )
    ax.set_yticks(
        range(len(rows)), [f"{one.channel} {one.joint}".strip() for one in rows], fontsize=7
    )
    if cyclic:
        ax.set_xticks(
            np.arange(PHASE_BINS + 1) - 0.5, [f"{i / PHASE_BINS:g}" for i in range(PHASE_BINS + 1)]
        )
        ax.set_xlabel("phase of the gait")
    else:
        ax.set_xticks(range(3), ["first third", "second", "last"])
    figure.colorbar(picture, ax=ax, label="log10 energy / expected")
    return figure


def _traces(d: Diagnosis) -> Figure:
    figure = Figure(figsize=(9, 2.1 * len(d.far.traces)), layout="constrained")
    axes = figure.subplots(len(d.far.traces), 1, squeeze=False)[:, 0]
    for ax, trace in zip(axes, d.far.traces, strict=True):
        ax.plot(trace.time_s, trace.measured, color="k", lw=1.8, label="measured")
        ax.plot(
            trace.time_s, trace.before, color=PREDICTED, lw=1.1, ls=":", label="simulator before"
        )
        ax.plot(
            trace.time_s, trace.after, color=AFTER, lw=1.1, ls="--", label="with the causes added"
        )
        ax.set_ylabel(
            f"{trace.channel} {trace.joint}\n[{trace.unit}]".replace(" \n", "\n"), fontsize=8
        )
    axes[0].legend(ncols=3, fontsize=7)
    axes[-1].set_xlabel("time [s]")
    return figure
