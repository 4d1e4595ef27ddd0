"""Lone samples that healthy runs of the same machine show as well: its nature, and no fault to fix first.

A foot that meets hard ground rattles for a sample or two at each touch-down, in all runs alike. Whether
that is a little more or less than the share from which lone samples are severe is chance. How often it
touches down depends on the gait, so not all healthy runs need have them, but two.
"""

from collections.abc import Sequence
from dataclasses import replace

from gap.interfaces import DataFault

SPIKES = "spikes"
MORE = 3.0  # times as many as in references are more than usual; twice as many are chance
ENOUGH = 2  # healthy runs that have so many; one could have the same loose cable
RunFaults = tuple[DataFault, ...]


def without_usual_spikes(
    trials: Sequence[RunFaults], references: Sequence[RunFaults]
) -> tuple[RunFaults, ...]:
    """Return the faults of all runs; lone samples are not severe where two references have a third as many.

    Args:
        trials: Faults of each trial.
        references: Of each run of the same machine that is assumed healthy; they are judged by each other.

    Returns:
        Those of the trials, then those of the references.
    """
    of_trials = [_judged(faults, references, ENOUGH) for faults in trials]
    of_references = [
        _judged(faults, [*references[:at], *references[at + 1 :]], ENOUGH - 1)
        for at, faults in enumerate(references)
    ]
    return (*of_trials, *of_references)


def _judged(faults: RunFaults, others: Sequence[RunFaults], enough: int) -> RunFaults:
    return tuple(_milder(fault, others, enough) for fault in faults)


def _milder(fault: DataFault, others: Sequence[RunFaults], enough: int) -> DataFault:
    if fault.share is None or not (fault.severe and fault.kind == SPIKES and others):
        return fault
    most = sorted((_share(faults, fault.channel) for faults in others), reverse=True)
    if fault.share > MORE * most[min(enough, len(most)) - 1]:
        return fault
    evidence = f"{fault.evidence}; references have a third as many or more"
    return replace(fault, evidence=evidence, severe=False)


def _share(faults: RunFaults, channel: str) -> float:
    """Of a channel's samples that stand out; 0 where none does."""
    own = [one.share for one in faults if (one.kind, one.channel) == (SPIKES, channel)]
    return max((share for share in own if share is not None), default=0.0)
