"""A trial's samples on an even grid, for simulators that step through time."""

from dataclasses import dataclass

import numpy as np

from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial

FASTEST_HZ = 100.0
SHORTEST = 20


@dataclass(frozen=True, slots=True, eq=False)
class EvenTrial:
    """Servo signals of a trial on F even frames.

    Attributes:
        time_s: Since the start, (F,).
        period_s: Between frames.
        command_rad: (F, N).
        shaft_rad: (F, N); NaN where nothing was measured.
        pwm: (F, N).
        current_a: (F, N).
        torque_nm: (F, N).
    """

    time_s: FloatArray
    period_s: float
    command_rad: FloatArray
    shaft_rad: FloatArray
    pwm: FloatArray
    current_a: FloatArray
    torque_nm: FloatArray


def even_times(trial: Trial) -> FloatArray:
    """Return even times from the first to the last sample, (F,).

    Raises:
        GapError: The trial is too short.
    """
    if len(trial.time_s) < SHORTEST:
        raise GapError(f"a trial has {len(trial.time_s)} samples; it needs at least {SHORTEST}")
    span = float(trial.time_s[-1] - trial.time_s[0])
    period = max(float(np.median(np.diff(trial.time_s))), 1.0 / FASTEST_HZ)
    frames = round(span / period) + 1
    return np.asarray(trial.time_s[0] + np.linspace(0.0, span, frames))


def on_times(time_s: FloatArray, values: FloatArray, at_s: FloatArray) -> FloatArray:
    """Interpolate columns, (T, ...) to (F, ...); NaN near a sample that is missing."""
    flat = values.reshape(len(values), -1)
    if len(time_s) == len(at_s) and np.allclose(time_s, at_s, rtol=0.0, atol=1e-9):
        return values.copy()
    out = np.column_stack([np.interp(at_s, time_s, column) for column in flat.T])
    return np.asarray(out.reshape(len(at_s), *values.shape[1:]))


def even_trial(trial: Trial) -> EvenTrial:
    """Put a trial on an even grid; a missing command is the one before.

    Raises:
        GapError: It is too short, or a joint has no commands.
    """
    at_s = even_times(trial)
    names = ("command_rad", "shaft_rad", "pwm", "current_a", "torque_nm")
    put = {name: on_times(trial.time_s, getattr(trial, name), at_s) for name in names}
    for column, joint in zip(put["command_rad"].T, trial.joints, strict=True):
        known = np.flatnonzero(np.isfinite(column))
        if len(known) == 0:
            raise GapError(
                f"command_{joint}_rad is empty: map the column of its goals (bigant import --map); an MJCF "
                "machine does with torque or current alone"
            )
        before = np.searchsorted(known, np.arange(len(column)), side="right") - 1
        column[:] = column[known[np.fmax(before, 0)]]
    time_s = at_s - at_s[0]
    return EvenTrial(time_s, float(time_s[1]), **put)
