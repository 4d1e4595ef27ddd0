"""Pictures of a diagnosis: measured, before and after, one small picture a channel."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gap.diagnosis.findings import Diagnosis, Verdict
from gap.diagnosis.how_far import Trace
from robot.report.plots import PREDICTED, STYLE

AFTER = "#009E73"
NOT_COMPARED = "#808080"
SIZE_IN = (4.8, 2.1)  # as wide as a phone, so that its letters are of a size to be read there
LEAST_SEEN = 0.005
FACTORS = {"m": (1e3, "mm"), "m/s": (1e3, "mm/s"), "rad": (1e3, "mrad"), "rad/s": (1e3, "mrad/s")}


def draw_traces(d: Diagnosis) -> dict[str, Figure]:
    """Draw the channels that the causes change most, in a run kept back, by name."""
    if d.verdict is Verdict.NO_GAP:
        return {}
    with mpl.rc_context({**STYLE, "font.size": 8}):
        changed = [one for one in d.far.traces if _changed(one)] or d.far.traces
        return {f"{t.channel} {t.joint}".strip(): _trace(t) for t in changed}


def _changed(trace: Trace) -> bool:
    """Whether the causes make a difference that an eye can see."""
    change = float(np.nanmax(np.abs(trace.after - trace.before), initial=0.0))
    span = float(
        np.nanmax(trace.measured, initial=-np.inf) - np.nanmin(trace.measured, initial=np.inf)
    )
    return change > LEAST_SEEN * span


def _trace(trace: Trace) -> Figure:
    figure = Figure(figsize=SIZE_IN, layout="constrained")
    figure.patch.set_alpha(0.0)
    ax: Axes = figure.subplots()
    ax.patch.set_alpha(0.0)
    factor, unit = FACTORS.get(trace.unit, (1.0, trace.unit))
    lines = (
        (trace.measured, "black", "-", 1.6, "measured"),
        (trace.before, PREDICTED, ":", 1.2, "simulator before"),
        (trace.after, AFTER, "--", 1.2, "with the causes"),
    )
    for values, colour, style, width, label in lines:
        ax.plot(trace.time_s, factor * values, color=colour, ls=style, lw=width, label=label)
    if not trace.compared.all():
        ax.fill_between(
            trace.time_s, 0.0, 1.0, where=~trace.compared, transform=ax.get_xaxis_transform(),
            color=NOT_COMPARED, alpha=0.25, lw=0, label="not compared",
        )  # fmt: skip
    ax.set_ylabel(f"{trace.channel} {trace.joint} [{unit}]".replace("  ", " "))
    ax.set_xlabel("time [s]")
    figure.legend(
        loc="outside upper center",
        ncols=3 if trace.compared.all() else 2,
        frameon=False,
        fontsize=8,
    )
    return figure
