"""Each run counts once: a recording that is given twice says nothing of how much runs differ."""

import hashlib
from collections.abc import Sequence

import numpy as np

from model.errors import GapError
from record.trial.trial import Trial
from robot.gap_report.trial_bytes import arrays_of, bytes_of

NO_READINGS = ("time_s", "command_rad")


def check_each_once(trials: Sequence[Trial], names: Sequence[object]) -> None:
    """Make sure that no recording is given twice, as trial, as reference, or as both.

    Only readings are compared, not when they were taken: a copy may begin at another time.

    Args:
        trials: Trials and references.
        names: What they are called in the error.

    Raises:
        GapError: Two of them have the same readings.
    """
    seen: dict[bytes, object] = {}
    for trial, name in zip(trials, names, strict=True):
        own = _digest(trial)
        if own is None:
            continue
        if own in seen:
            words = (
                "is given twice" if seen[own] == name else f"has the same readings as {seen[own]}"
            )
            raise GapError(
                f"{name} {words}: one recording is one run, and may not be both a trial and a reference; "
                "leave one of the two out (see docs/gap.md#what-to-record)"
            )
        seen[own] = name


def _digest(trial: Trial) -> bytes | None:
    """Tell readings from others; None where nothing was measured."""
    readings = {name: one for name, one in arrays_of(trial).items() if name not in NO_READINGS}
    if not any(np.isfinite(one).any() for one in readings.values()):
        return None
    hashed = hashlib.sha256()
    for part in bytes_of(readings):
        hashed.update(part)
    return hashed.digest()
