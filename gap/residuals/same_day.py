"""Runs that were recorded on one day: what differs from day to day is alike in them, so they count once.

Where files do not say the day (``parts.DAY``), each run has one of its own.
"""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import lru_cache

from gap.residuals.parts import TrialPart

# Runs of a day, and all others.
EachDayOut = Sequence[tuple[tuple[int, ...], tuple[int, ...]]]

SILENT_TRIALS = "that of trials which do not say theirs"


def days_of(parts: Sequence[TrialPart]) -> tuple[str, ...]:
    """Return the day of each run; none where each has one of its own."""
    days = tuple(part.day for part in parts)
    return days if any(days) else ()


def same_day(one: TrialPart, other: TrialPart) -> bool:
    """Whether two runs are known to be of one day."""
    return bool(one.day) and one.day == other.day


def with_days(
    trials: Sequence[Sequence[TrialPart]], references: Sequence[TrialPart]
) -> tuple[tuple[TrialPart, ...], ...]:
    """Return groups of trials, and references behind them, with a day for each where any file says one.

    Trials that do not say theirs are taken to be of one day, references each of a day of its own.
    """
    if not any(part.day for parts in (*trials, references) for part in parts):
        return (*map(tuple, trials), tuple(references))
    return (
        *(tuple(p if p.day else replace(p, day=SILENT_TRIALS) for p in parts) for parts in trials),
        tuple(p if p.day else replace(p, day=f"run {p.trial}") for p in references),
    )


@lru_cache(maxsize=4096)
def together_on_days(days: tuple[str, ...], runs: tuple[int, ...]) -> tuple[tuple[int, ...], ...]:
    """Return some runs by their day, in order."""
    grouped: dict[str, list[int]] = {}
    for run in runs:
        grouped.setdefault(days[run], []).append(run)
    return tuple(tuple(own) for own in grouped.values())


def several(gaits: Iterable[str]) -> str:
    """Return the name of the gaits of one day together."""
    return "+".join(sorted(set(gaits)))


def leave_each_day_out(days: tuple[str, ...], runs: int) -> EachDayOut:
    """Return the runs of each day with all others; without days each run is one."""
    every = tuple(range(runs))
    groups = together_on_days(days, every) if days else tuple((run,) for run in every)
    return [(own, tuple(k for k in every if k not in own)) for own in groups]
