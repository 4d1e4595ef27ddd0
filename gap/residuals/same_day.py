"""Runs that were recorded on one day: what differs from day to day is alike in them, so they count once.

Where files do not say the day (``parts.DAY``), each run has one of its own.
"""

from collections.abc import Iterable, Sequence
from functools import lru_cache

from gap.residuals.parts import DAY, TrialPart
from model.errors import GapError
from record.trial.trial import Trial


def days_of(parts: Sequence[TrialPart]) -> tuple[str, ...]:
    """Return the day of each run; none where each has one of its own."""
    days = tuple(part.day for part in parts)
    return days if any(days) else ()


def same_day(one: TrialPart, other: TrialPart) -> bool:
    """Whether two runs are known to be of one day."""
    return bool(one.day) and one.day == other.day


def check_days(trials: Sequence[Trial]) -> None:
    """Refuse runs of which some say their day and some do not.

    Raises:
        GapError: Some do not.
    """
    silent = [k for k, trial in enumerate(trials, 1) if trial.header.condition(DAY) is None]
    if silent and len(silent) < len(trials):
        raise GapError(
            f"{len(silent)} of {len(trials)} runs, trials and references, do not say their day, and the "
            f"others do: give each NAME.toml {DAY} under [conditions], or none"
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


def leave_each_day_out(
    days: tuple[str, ...], runs: int
) -> Sequence[tuple[tuple[int, ...], tuple[int, ...]]]:
    """Return the runs of each day with all others; without days each run is one."""
    every = tuple(range(runs))
    groups = together_on_days(days, every) if days else tuple((run,) for run in every)
    return [(own, tuple(k for k in every if k not in own)) for own in groups]
