"""Run time against legs, and parallel overhead, from a file of benchmark figures."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model.errors import RecordError
from model.values.arrays import FloatArray
from record.json_text import read_json
from robot.report.figure_style import COULOMB, NEUTRAL, TRUTH

HOW_TO = "Make the file of benchmark figures first: python -m benchmarks"
PAPER_OURS, PAPER_MUJOCO, PAPER_OVERHEAD = 3.0, 13.0, 1.5
# What is measured over, x, the median over it, and the percentiles that were kept: q25, q75, q025, q975.
Ribbon = Mapping[str, FloatArray]
OVER = {"ours_us": "legs", "mujoco_us": "legs", "overhead": "processes"}


def read_benchmark(path: Path) -> dict[str, Ribbon]:
    """Read the file of benchmark figures, by the names of ``OVER``; what it does not hold is left out.

    Times are those of a frame [us], the overhead time times processes over the time of one.

    Raises:
        RecordError: It is there and cannot be read.
    """
    if not path.exists():
        return {}
    try:
        table = read_json(path)
        ribbons = {
            name: {"x": table[over], "median": table[name]["median"], **table[name]}
            for name, over in OVER.items()
            if table.get(name) is not None
        }
        return {
            name: {key: np.array(values, dtype=np.float64) for key, values in ribbon.items()}
            for name, ribbon in ribbons.items()
        }
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecordError(
            f"the benchmark file {path} cannot be read ({error}); {HOW_TO.lower()}"
        ) from error


def draw_runtime(benchmark: Mapping[str, Ribbon]) -> tuple[Figure | None, str]:
    """Draw fig:run_time: time a frame over the number of legs, in units of its first median."""
    if "ours_us" not in benchmark:
        return None, f"Run time against the number of legs. {HOW_TO}."
    figure = Figure(figsize=(7, 4.4), layout="constrained")
    ax = figure.subplots()
    words = []
    series = (
        ("our model", "ours_us", COULOMB, PAPER_OURS),
        ("MuJoCo", "mujoco_us", TRUTH, PAPER_MUJOCO),
    )
    for name, key, colour, paper in series:
        if key not in benchmark:
            continue
        legs, median = benchmark[key]["x"], benchmark[key]["median"]
        relative = {of: values / median[0] for of, values in benchmark[key].items()} | {"x": legs}
        _draw_ribbon(ax, relative, colour, name)
        ax.plot(legs[-1], paper, "x", color=colour, ms=9, mew=2)
        words.append(
            f"{name} x{relative['median'][-1]:.1f} from {legs[0]:.0f} to {legs[-1]:.0f} legs (median "
            f"{median[0]:.1f} to {median[-1]:.1f} us; the paper: "
            f"{'less than ' if paper == PAPER_OURS else ''}x{paper:.0f} from 3 to 50)"
        )
    ax.plot([], [], "x", color=NEUTRAL, ms=9, mew=2, label="the paper, 50 legs")
    ax.set(xlabel="legs", ylabel=f"time a frame / median at {legs[0]:.0f} legs")
    ax.set_ylim(bottom=0)
    ax.legend(loc="upper left")
    return figure, f"Run time against the number of legs: {'; '.join(words)}."


def draw_parallel(benchmark: Mapping[str, Ribbon]) -> tuple[Figure | None, str]:
    """Draw fig:parallel: time times processes over the time of one process."""
    if "overhead" not in benchmark:
        return None, f"Parallel overhead. {HOW_TO}."
    figure = Figure(figsize=(5.5, 4), layout="constrained")
    ax = figure.subplots()
    overhead = benchmark["overhead"]
    processes = overhead["x"]
    _draw_ribbon(ax, overhead, COULOMB, "ours")
    ax.plot(processes, processes, color=NEUTRAL, ls="--", lw=1, label="no gain")
    ax.axhline(1, color="black", lw=0.6)
    ax.set(xlabel="processes", ylabel="time x processes / time of one", xticks=processes)
    ax.set_ylim(bottom=0)
    ax.legend(loc="lower right")
    return figure, (
        f"Parallel overhead: {overhead['median'][-1]:.2f} on {processes[-1]:.0f} processes (1 is "
        f"perfect). The paper: below {PAPER_OVERHEAD:g} on 4 processors."
    )


def _draw_ribbon(ax: Axes, ribbon: Ribbon, colour: str, name: str) -> None:
    x = ribbon["x"]
    for low, high, alpha in (("q025", "q975", 0.15), ("q25", "q75", 0.3)):
        if low in ribbon and high in ribbon:
            ax.fill_between(x, ribbon[low], ribbon[high], color=colour, alpha=alpha, lw=0)
    ax.plot(x, ribbon["median"], color=colour, lw=1.6, marker=".", ls=":", label=name)
