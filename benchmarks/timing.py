"""Timing: medians and quartiles of repetitions, in microseconds."""

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

RESULTS = Path(__file__).resolve().parents[1] / "docs" / "figures" / "model_benchmark.json"


@dataclass(frozen=True, slots=True)
class Spread:
    """Percentiles of repeated measurements [us]."""

    q025: float
    q25: float
    median: float
    q75: float
    q975: float

    def __str__(self) -> str:
        return f"{self.median:10.2f} us  (quartiles {self.q25:.2f}, {self.q75:.2f})"


def spread(samples_us: list[float]) -> Spread:
    """Percentiles of samples [us]."""
    return Spread(*np.percentile(samples_us, [2.5, 25, 50, 75, 97.5]).tolist())


def repeat(action: Callable[[], object], times: int, per_call: int = 1) -> Spread:
    """Call ``action`` so many times; each sample is divided by ``per_call``. One call warms up."""
    action()
    samples = []
    for _ in range(times):
        began = time.perf_counter_ns()
        action()
        samples.append((time.perf_counter_ns() - began) / 1e3 / per_call)
    return spread(samples)


def each(actions: list[Callable[[], object]], rounds: int = 3) -> Spread:
    """Time many calls one by one, the best of some rounds each; the spread is over the calls."""
    best = np.full(len(actions), np.inf)
    for _ in range(rounds):
        for i, action in enumerate(actions):
            began = time.perf_counter_ns()
            action()
            best[i] = min(best[i], (time.perf_counter_ns() - began) / 1e3)
    return spread(best.tolist())


def keep_model(**figures: Spread) -> None:
    """Add run times of the model to that file, by name."""
    known = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    rounded = {
        name: {key: round(value, 4) for key, value in asdict(one).items()}
        for name, one in figures.items()
    }
    keep(model={**known.get("model", {}), **rounded})


def keep(**figures: object) -> None:
    """Add figures to the file that the documentation's plots are drawn from."""
    known = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    known.update(figures)
    RESULTS.write_text(json.dumps(known, indent=1) + "\n", encoding="utf-8")
