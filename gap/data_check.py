"""Faults of the data themselves, of any trial."""

from gap.interfaces import DataFault
from record.trial import Trial


def check_trial(trial: Trial) -> tuple[DataFault, ...]:
    return ()
