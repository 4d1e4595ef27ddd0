"""Lone samples that healthy runs of the same machine show as well: its nature, and no fault to fix first.

A foot that meets hard ground rattles for a sample or two at each touch-down, in all runs alike. Whether
that is a little more or less than the share from which lone samples are severe is chance.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gap.interfaces import DataFault

SPIKES = "spikes"
MORE = 2.0  # times as many as in references are more than usual
TrialsFaults = Sequence[tuple[DataFault, ...]]


def without_usual_spikes(
    trials: TrialsFaults, references: TrialsFaults
) -> tuple[tuple[DataFault, ...], ...]:
    """Return the faults of trials; lone samples are not severe where references have nearly as many.

    Args:
        trials: Faults of each trial.
        references: Of each run of the same machine that is assumed healthy.
    """
    return tuple(tuple(_judged(fault, references) for fault in faults) for faults in trials)


def _judged(fault: DataFault, references: TrialsFaults) -> DataFault:
    if not (fault.severe and fault.kind == SPIKES and references):
        return fault
    usual = float(np.median([_share(faults, fault.channel) for faults in references]))
    if fault.share is None or fault.share > MORE * usual:
        return fault
    evidence = f"{fault.evidence}; references have nearly as many"
    return replace(fault, evidence=evidence, severe=False)


def _share(faults: Sequence[DataFault], channel: str) -> float:
    """Of a channel's samples that stand out; 0 where none does."""
    own = [one.share for one in faults if (one.kind, one.channel) == (SPIKES, channel)]
    return max((share for share in own if share is not None), default=0.0)
