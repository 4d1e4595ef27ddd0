"""Faults of servo data that no physics should be blamed for."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from gap.data.columns import Sign, faults_of, paired, slope, spread_of, standing_out
from gap.data.held_shaft import MOST_PLAY_RAD, held_shaft
from gap.data.time_lag import LATEST_S, SURE, lag
from gap.interfaces import DataFault
from gap.rounding import count_words
from model.values.arrays import FloatArray
from record.trial.trial import Trial

FULL_TURN = 2 * np.pi
SPIKE_SPREADS = 30.0
FASTEST_RAD_S = 100.0  # faster than any joint: its angles are not in radians
SPIKE_COUNTS = 20.0
FLICKER_COUNTS = 2.5  # a lone sample so few steps of its encoder off is no spike


def check_bench(trial: Trial) -> Iterator[DataFault]:
    """Look through a servo trial."""
    steps = np.diff(trial.time_s)
    if not len(steps):
        return
    if steps.max() > 5 * np.median(steps):
        yield DataFault("gap", "time_s", f"a hole of {steps.max():.3g} s between samples", False)
    for at, joint in enumerate(trial.joints):
        shaft, command = trial.shaft_rad[:, at], trial.command_rad[:, at]
        speed = np.gradient(shaft, trial.time_s) if np.isfinite(shaft).sum() > 2 else shaft
        yield from faults_of(f"shaft_{joint}_rad", _shaft(shaft, command))
        yield from faults_of(f"shaft_{joint}_rad", _fast(speed))
        yield from faults_of(f"shaft_{joint}_rad", held_shaft(trial.time_s, shaft, command))
        yield from faults_of(f"shaft_{joint}_rad_s", _speed(trial.shaft_rad_s[:, at], speed))
        for name, values in (
            (f"torque_{joint}_nm", trial.torque_nm[:, at]),
            (f"current_{joint}_a", trial.current_a[:, at]),
        ):
            yield from faults_of(name, _magnitude(values, speed))
            yield from faults_of(name, _spikes(values))


def believable(fault: DataFault, trial: Trial, compared: frozenset[str]) -> DataFault | None:
    """Return a fault of any machine's check as it counts for servos; None where a servo does it by itself.

    A fault of a column that the simulator neither compares nor is driven by is not severe.
    """
    joint = next((j for j in trial.joints if fault.channel == f"shaft_{j}_rad"), "")
    if joint and fault.kind == "frozen":
        return None  # looked for by rules that leave room for play
    if joint and fault.kind == "spikes":
        shaft = trial.shaft_rad[:, trial.joints.index(joint)]
        if _largest_spike(shaft) < FLICKER_COUNTS * _count_of(shaft):
            return None
    if fault.kind == "clock_offset" and _late_by_itself(trial):
        return None
    if fault.severe and fault.channel not in compared:
        return replace(fault, severe=False)
    return fault


def _late_by_itself(trial: Trial) -> bool:
    """Whether shafts lag as servos do: within what delay, lag and play explain, or as well there.

    A periodic motion looks as much like itself a period later, and a slow one with play trails by seconds.
    """
    count = len(trial.time_s)
    for first, last in ((0, count), (0, count // 3), (count - count // 3, count)):
        one = trial.rows((np.arange(count) >= first) & (np.arange(count) < last))
        late = lag(one.time_s, one.command_rad, one.shaft_rad)
        speed = np.gradient(one.command_rad, one.time_s, axis=0)
        travel_rad = abs(late.seconds) * np.sqrt(np.nanmean(speed**2))
        if not late.correlation > SURE or travel_rad < 0.5 * MOST_PLAY_RAD:
            continue
        if not _follows_soon(one):
            return False
    return True


def _follows_soon(trial: Trial) -> bool:
    """Whether shafts follow their commands well at some lag that a servo has."""
    at_s = np.arange(trial.time_s[0], trial.time_s[-1] - LATEST_S, 0.02)
    best = 0.0
    for late_s in np.arange(0.0, LATEST_S, 0.02):
        alike = []
        for command, shaft in zip(trial.command_rad.T, trial.shaft_rad.T, strict=True):
            x = _change(np.interp(at_s, trial.time_s, command))
            y = _change(np.interp(at_s + late_s, trial.time_s, shaft))
            if x.std() > 0 and y.std() > 0:
                alike.append(float(np.corrcoef(x, y)[0, 1]))
        best = max(best, float(np.mean(alike)) if alike else 0.0)
    return best > SURE


def _change(values: FloatArray) -> FloatArray:
    """Change over a tenth of a second, on a grid of 0.02 s."""
    return values[5:] - values[:-5]


def _count_of(values: FloatArray) -> float:
    """Smallest step between values that occur; 0 if there is none."""
    steps = np.diff(np.unique(values[np.isfinite(values)]))
    steps = steps[steps > 1e-6]
    return float(steps.min()) if len(steps) else 0.0


def _largest_spike(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.max(standing_out(known)[1])) if len(known) >= 3 else 0.0


def _shaft(shaft: FloatArray, command: FloatArray) -> Iterator[Sign]:
    c, s = paired(command, shaft)
    if len(c) < 3:
        return
    wraps = int(np.sum(np.abs(np.abs(np.diff(s)) - FULL_TURN) < 0.3))
    if wraps:
        yield "wrap", f"{wraps} jumps of a full turn", True
    if np.ptp(s) < 1e-6 or np.ptp(c) <= 0.1 or not abs(float(np.corrcoef(c, s)[0, 1])) > 0.9:
        return
    ratio = slope(c, s)
    if ratio < -0.5:
        yield "sign", f"turns against its command (slope {ratio:.2f})", True
    elif not 0.2 < ratio < 5:
        yield "unit", f"moves {ratio:.3g} times as far as its command", True


def _fast(speed: FloatArray) -> Iterator[Sign]:
    known = np.abs(speed[np.isfinite(speed)])
    if len(known) and (usual := float(np.quantile(known, 0.9))) > FASTEST_RAD_S:
        yield (
            "unit",
            f"turns at {usual:.3g} rad/s: give its column a unit in the map (deg, turn)",
            True,
        )


def _speed(reported: FloatArray, derived: FloatArray) -> Iterator[Sign]:
    there, motion = paired(reported, derived)
    moving = np.abs(motion) > 0.05
    if moving.sum() < 20:
        return
    there, motion = there[moving], motion[moving]
    zero, ratio = float(np.mean(there == 0.0)), float(there @ motion / (motion @ motion))
    if zero > 0.3:
        words = f"reads 0 in {zero:.0%} of the samples in which the angle moves; not used"
        yield "frozen", words, False
    elif not 0.5 < ratio < 2.0:
        words = f"is {ratio:.2f} times the derivative of the angle; not used"
        yield "sign" if ratio < -0.5 else "unit", words, False


def _magnitude(values: FloatArray, speed: FloatArray) -> Iterator[Sign]:
    size, turning = paired(values, speed)
    if len(size) < 50 or not np.any(size > 0):
        return
    both = min(np.mean(turning > 0.02), np.mean(turning < -0.02))
    if both > 0.05 and np.min(size) >= 0:
        yield "magnitude_only", "never negative although the shaft turns both ways", False


def _spikes(values: FloatArray) -> Iterator[Sign]:
    known = values[np.isfinite(values)]
    if len(known) < 50:
        return
    lone = np.abs(known[1:-1] - np.median([known[:-2], known[1:-1], known[2:]], axis=0))
    spread = max(
        spread_of(known - np.median(known)),
        0.01 * float(np.ptp(np.quantile(known, [0.02, 0.98]))),
        1e-12,
    )
    # a reading that is 0 most of the time flickers
    count = int(np.sum(lone > max(SPIKE_SPREADS * spread, SPIKE_COUNTS * _count_of(known))))
    if count:
        yield (
            "spikes",
            f"{count_words(count, 'lone sample')}, up to {lone.max():.3g} off the neighbours",
            False,
        )
