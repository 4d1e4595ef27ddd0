"""Which runs are fitted to and which judge, as ``--hold-out`` chooses them, said before all else."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from gap.data.check import time_faults
from gap.interfaces import Simulator
from gap.residuals.hold_out import HoldOut
from gap.residuals.parts import split
from model.errors import GapError
from record.trial.header import Condition, TrialHeader
from robot.gap_report.trials import Runs
from robot.gap_report.words import few

LAST_THIRD, TRIAL = "last-third", "trial"
SHOWN = 6


def with_hold_out(runs: Runs, paths: Sequence[Path], chosen: Sequence[str]) -> Runs:
    """Return runs with what ``--hold-out`` chooses of them.

    Args:
        runs: The runs.
        paths: Files of its trials.
        chosen: ``KEY=VALUE``, ``trial=NAME`` or ``last-third``; runs of any of them are held out.

    Raises:
        GapError: No run is of one of them, or all are.
    """
    if not chosen:
        return runs
    if LAST_THIRD in chosen:
        if len(chosen) > 1:
            raise GapError(f"--hold-out {LAST_THIRD} is of every run; leave the others out")
        return replace(runs, hold_out=HoldOut(last_third=True))
    held: set[int] = set()
    for text in chosen:
        held |= _of(text, runs, paths)
    if len(held) == len(runs.trials):
        raise GapError("--hold-out holds out every run; leave some to fit to")
    return replace(runs, hold_out=HoldOut(tuple(sorted(held))))


def _of(text: str, runs: Runs, paths: Sequence[Path]) -> set[int]:
    """Indices of the trials that a choice names."""
    key, equal, value = text.partition("=")
    if not equal:
        raise GapError(f"--hold-out {text}: write KEY=VALUE, {TRIAL}=NAME or {LAST_THIRD}")
    if key == TRIAL:
        known: list[Condition | None] = [path.stem for path in paths]
        value = Path(value).stem if Path(value).suffix else value
    else:
        known = [trial.header.condition(key) for trial in runs.trials]
    held = {at for at, own in enumerate(known) if own is not None and _same(own, value)}
    if held:
        return held
    values = sorted({_words(own) for own in known if own is not None})
    if values:
        raise GapError(f"--hold-out {text}: no run is; {key} is {few(values, SHOWN)}")
    keys = _conditions([trial.header for trial in runs.trials])
    raise GapError(
        f"--hold-out {text}: no run says {key}; they say {keys or 'nothing'}: write it into [conditions] "
        "of the files beside the tables, or of the map"
    )


def _same(own: Condition, value: str) -> bool:
    if isinstance(own, str):
        return own == value
    try:
        return own == float(value)
    except ValueError:
        return False


def _words(value: Condition) -> str:
    return value if isinstance(value, str) else f"{value:g}"


def _conditions(headers: Sequence[TrialHeader]) -> str:
    keys = dict.fromkeys(key for header in headers for key, _ in header.conditions)
    known = [key for key in ("gait", "frequency_hz") if any(h.condition(key) for h in headers)]
    return ", ".join((*known, *keys))


def split_lines(
    runs: Runs, simulator: Simulator, paths: Sequence[Path], chosen: Sequence[str]
) -> Iterator[str]:
    """Yield what is fitted to, what judges, and at which rate runs are compared.

    Raises:
        GapError: A run cannot be compared with the simulator: nothing else has been done yet.
    """
    for path, trial in zip(paths, runs.trials, strict=True):
        for fault in time_faults(trial):
            if fault.kind == "unit":
                raise GapError(f"{path.name}: {fault.evidence}")
    fitted, held = split(simulator, runs.trials, runs.hold_out)
    own = {part.trial for part in fitted}
    if own & {part.trial for part in held}:
        yield f"fitted to the first two thirds of {_files(own, paths)}; tested on the last third of each"
    else:
        why = f" ({', '.join(chosen)})" if chosen else ""
        judges = {part.trial for part in held}
        yield f"fitted to {_files(own, paths)}; held out for testing{why}: {_files(judges, paths)}"
    compared = sorted({_rate(part.observation.time_s) for part in (*fitted, *held)})
    logged = sorted({_rate(trial.time_s) for trial in runs.trials})
    yield f"compared at {_span(compared)} Hz; logged at {_span(logged)} Hz"


def _files(numbers: set[int], paths: Sequence[Path]) -> str:
    names = few([paths[at].name for at in sorted(numbers)], SHOWN)
    return names if len(numbers) <= SHOWN else f"{len(numbers)} runs ({names})"


def _rate(time_s: np.ndarray) -> float:
    return round(1.0 / float(np.median(np.diff(time_s))), 1)


def _span(rates: Sequence[float]) -> str:
    low, high = f"{rates[0]:.4g}", f"{rates[-1]:.4g}"
    return low if low == high else f"{low} to {high}"
