"""Run time against legs, and parallel overhead, from a file of benchmark figures."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model.errors import RecordError
from model.values.arrays import FloatArray
from robot.report.figure_style import COULOMB, NEUTRAL, TRUTH

HOW_TO = "Make the file of benchmark figures first: python -m benchmarks"
PAPER_OURS, PAPER_MUJOCO, PAPER_OVERHEAD = 3.0, 13.0, 1.5


# Median over some abscissa, (M,), and the percentiles that were kept, by name: q25, q75, q025, q975.
Ribbon = Mapping[str, FloatArray]


class Benchmark(NamedTuple):
    """The benchmark file; what it does not hold is None.

    Attributes:
        legs: Numbers of legs, (M,).
        ours: Time a frame of our model over ``legs`` [us].
        mujoco: The same of MuJoCo.
        processes: Numbers of processes, (P,).
        overhead: Time times processes over the time of one.
    """

    legs: FloatArray
    ours: Ribbon | None
    mujoco: Ribbon | None
    processes: FloatArray
    overhead: Ribbon | None


def read_benchmark(path: Path) -> Benchmark | None:
    """Read the file of benchmark figures, or return None if there is none.

    Raises:
        RecordError: It is there and cannot be read.
    """
    if not path.exists():
        return None
    try:
        table = json.loads(path.read_text(encoding="utf-8"))
        return Benchmark(
            legs=np.array(table.get("legs", ()), dtype=np.float64),
            ours=_ribbon(table.get("ours_us")),
            mujoco=_ribbon(table.get("mujoco_us")),
            processes=np.array(table.get("processes", ()), dtype=np.float64),
            overhead=_ribbon(table.get("overhead")),
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecordError(
            f"the benchmark file {path} cannot be read ({error}); {HOW_TO.lower()}"
        ) from error


def _ribbon(table: Any) -> Ribbon | None:  # JSON: anything until it is read
    if table is None:
        return None
    _ = table["median"]
    return {name: np.array(values, dtype=np.float64) for name, values in table.items()}


def draw_runtime(benchmark: Benchmark | None) -> tuple[Figure | None, str]:
    """Draw fig:run_time: time a frame over the number of legs, in units of its first median."""
    if benchmark is None or benchmark.ours is None:
        return None, f"Run time against the number of legs. {HOW_TO}."
    figure = Figure(figsize=(7, 4.4), layout="constrained")
    ax = figure.subplots()
    legs = benchmark.legs
    words = []
    series = (("our model", benchmark.ours, COULOMB, PAPER_OURS),
              ("MuJoCo", benchmark.mujoco, TRUTH, PAPER_MUJOCO))  # fmt: skip
    for name, ribbon, colour, paper in series:
        if ribbon is None:
            continue
        median = ribbon["median"]
        relative = {key: values / median[0] for key, values in ribbon.items()}
        _draw_ribbon(ax, legs, relative, colour, name)
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


def draw_parallel(benchmark: Benchmark | None) -> tuple[Figure | None, str]:
    """Draw fig:parallel: time times processes over the time of one process."""
    if benchmark is None or benchmark.overhead is None:
        return None, f"Parallel overhead. {HOW_TO}."
    figure = Figure(figsize=(5.5, 4), layout="constrained")
    ax = figure.subplots()
    processes, overhead = benchmark.processes, benchmark.overhead
    _draw_ribbon(ax, processes, overhead, COULOMB, "ours")
    ax.plot(processes, processes, color=NEUTRAL, ls="--", lw=1, label="no gain")
    ax.axhline(1, color="black", lw=0.6)
    ax.set(xlabel="processes", ylabel="time x processes / time of one", xticks=processes)
    ax.set_ylim(bottom=0)
    ax.legend(loc="lower right")
    return figure, (
        f"Parallel overhead: {overhead['median'][-1]:.2f} on {processes[-1]:.0f} processes (1 is "
        f"perfect). The paper: below {PAPER_OVERHEAD:g} on 4 processors."
    )


def _draw_ribbon(ax: Axes, x: FloatArray, ribbon: Ribbon, colour: str, name: str) -> None:
    for low, high, alpha in (("q025", "q975", 0.15), ("q25", "q75", 0.3)):
        if low in ribbon and high in ribbon:
            ax.fill_between(x, ribbon[low], ribbon[high], color=colour, alpha=alpha, lw=0)
    ax.plot(x, ribbon["median"], color=colour, lw=1.6, marker=".", ls=":", label=name)
