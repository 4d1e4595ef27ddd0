"""Measurements of one run that were taken at different times, put on the times of one of them."""

import numpy as np

from model.errors import RecordError
from model.values.arrays import FloatArray, readonly
from record.trial.trial import COLUMNS, Trial, trial_places

LONGEST_HOLE = 2.5  # periods between samples that are bridged


def joined(base: Trial, other: Trial, later_s: float = 0.0) -> Trial:
    """Return a trial with what another one of the same run measured, between its samples on a line.

    Args:
        base: Its times and header are kept.
        other: Of the same joints; what it measured may not be in ``base``.
        later_s: What is added to the other's times to have them on the clock of ``base``.

    Raises:
        RecordError: Both have a column.
    """
    arrays: dict[str, FloatArray] = {name: getattr(base, name).copy() for name in COLUMNS}
    time_s = other.time_s + later_s
    for place in trial_places(base.header.names):
        values = other.values(place)
        if not np.isfinite(values).any():
            continue
        if np.isfinite(base.values(place)).any():
            raise RecordError(f"{place.column} is measured twice; map it in one of the tables")
        arrays[place.field][place.where] = at_times(time_s, values, base.time_s)
    kept = {name: readonly(array) for name, array in arrays.items()}
    return Trial(base.header, time_s=base.time_s, **kept)


def at_times(time_s: FloatArray, values: FloatArray, at_s: FloatArray) -> FloatArray:
    """Return values between samples, (F,); NaN outside of them and in holes.

    Args:
        time_s: Times of the samples, (T,), increasing.
        values: (T,); NaN where missing.
        at_s: When they are wanted, (F,).
    """
    known = np.isfinite(values)
    time_s, values = time_s[known], values[known]
    if len(time_s) < 2:
        return np.full(len(at_s), np.nan)
    steps = np.diff(time_s)
    out = np.interp(at_s, time_s, values, left=np.nan, right=np.nan)
    step = steps[np.clip(np.searchsorted(time_s, at_s) - 1, 0, len(steps) - 1)]
    on_sample = np.isin(at_s, time_s)
    out[(step > LONGEST_HOLE * np.median(steps)) & ~on_sample] = np.nan
    return out
