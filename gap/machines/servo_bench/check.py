"""Faults of servo data that no physics should be blamed for."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter

from gap.data.time_lag import LATEST_S, SURE, lag
from gap.interfaces import DataFault
from model.values.arrays import BoolArray, FloatArray
from record.trial.trial import Trial

FULL_TURN = 2 * np.pi
SPIKE_SPREADS = 30.0
# A shaft may rest bit for bit while its command moves within play and stiction, which are effects of the
# catalogue (to 0.4 rad); beyond that and for so long, its encoder is frozen.
MOST_PLAY_RAD = 0.4
FROZEN_S = 0.5
SPIKE_COUNTS = 20.0
FLICKER_COUNTS = 2.5  # a lone sample so few steps of its encoder off is no spike


def check_bench(trial: Trial) -> tuple[DataFault, ...]:
    """Look through a servo trial."""
    found: list[DataFault] = []
    dt = float(np.median(np.diff(trial.time_s)))
    longest = float(np.diff(trial.time_s).max())
    if longest > 5 * dt:
        found.append(
            DataFault("gap", "time_s", f"a hole of {longest:.3g} s between samples", False)
        )
    for at, joint in enumerate(trial.joints):
        shaft, command = trial.shaft_rad[:, at], trial.command_rad[:, at]
        found += _shaft(joint, shaft, command)
        found += _held(joint, trial.time_s, shaft, command)
        speed = np.gradient(shaft, trial.time_s) if np.isfinite(shaft).sum() > 2 else shaft
        found += _speed(joint, trial.shaft_rad_s[:, at], speed)
        for name, values in (
            (f"torque_{joint}_nm", trial.torque_nm[:, at]),
            (f"current_{joint}_a", trial.current_a[:, at]),
        ):
            found += _magnitude(name, values, speed)
            found += _spikes(name, values)
        duty = trial.pwm[:, at]
        if np.isfinite(duty).any() and np.mean(np.abs(duty) > 0.99) > 0.2:
            share = np.mean(np.abs(duty) > 0.99)
            found.append(
                DataFault(
                    "saturated", f"pwm_{joint}", f"{share:.0%} of samples at the limit", False
                )
            )
    return tuple(found)


def believable(fault: DataFault, trial: Trial, compared: frozenset[str]) -> DataFault | None:
    """Return a fault as it counts for servos: None where a servo does that by itself.

    Args:
        fault: What any machine's check found.
        trial: Where.
        compared: Columns that the simulator compares or is driven by; a fault of another is not severe.
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
    thirds = (slice(None), slice(0, len(trial.time_s) // 3), slice(-(len(trial.time_s) // 3), None))
    for part in thirds:
        one = trial.rows(_rows(trial, part))
        late, sure = lag(one.time_s, one.command_rad, one.shaft_rad)
        speed = np.gradient(one.command_rad, one.time_s, axis=0)
        if not sure > SURE or abs(late) * np.sqrt(np.nanmean(speed**2)) < 0.5 * MOST_PLAY_RAD:
            continue
        if not _alike_soon(one):
            return False
    return True


def _rows(trial: Trial, part: slice) -> BoolArray:
    keep = np.zeros(len(trial.time_s), dtype=np.bool_)
    keep[part] = True
    return keep


def _alike_soon(trial: Trial) -> bool:
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
    if len(known) < 3:
        return 0.0
    return float(np.max(np.abs(known - median_filter(known, 7, mode="nearest"))))


def _held(
    joint: str, time_s: FloatArray, shaft: FloatArray, command: FloatArray
) -> list[DataFault]:
    """Look for stretches in which the shaft never changes while its command leaves any play."""
    edges = np.flatnonzero(np.concatenate([[True], shaft[1:] != shaft[:-1], [True]]))
    total, count = 0.0, 0
    for first, behind in pairwise(edges.tolist()):
        span = time_s[behind - 1] - time_s[first]
        asked = command[first:behind][np.isfinite(command[first:behind])]
        if span >= FROZEN_S and len(asked) and np.ptp(asked) > MOST_PLAY_RAD:
            total, count = total + float(span), count + 1
    if not count:
        return []
    words = f"repeats bit for bit for {total:.1f} s in {count} stretches while its command moves on"
    severe = total > 0.1 * float(time_s[-1] - time_s[0])
    return [DataFault("frozen", f"shaft_{joint}_rad", words, severe)]


def _shaft(joint: str, shaft: FloatArray, command: FloatArray) -> list[DataFault]:
    name, found = f"shaft_{joint}_rad", []
    known = np.isfinite(shaft) & np.isfinite(command)
    if known.sum() < 3:
        return []
    steps = np.diff(shaft[known])
    wraps = int(np.sum(np.abs(np.abs(steps) - FULL_TURN) < 0.3))
    if wraps:
        found.append(DataFault("wrap", name, f"{wraps} jumps of a full turn", True))
    moved = np.ptp(command[known])
    if np.ptp(shaft[known]) < 1e-6:
        return found
    if moved > 0.1:
        c, s = command[known] - command[known].mean(), shaft[known] - shaft[known].mean()
        slope = float(c @ s / (c @ c))
        tight = abs(float(np.corrcoef(c, s)[0, 1])) > 0.9
        if tight and slope < -0.5:
            found.append(
                DataFault("sign", name, f"turns against its command (slope {slope:.2f})", True)
            )
        elif tight and not 0.2 < slope < 5:
            found.append(
                DataFault("unit", name, f"moves {slope:.3g} times as far as its command", True)
            )
    return found


def _speed(joint: str, reported: FloatArray, derived: FloatArray) -> list[DataFault]:
    known = np.isfinite(reported) & np.isfinite(derived)
    moving = known & (np.abs(derived) > 0.05)
    if moving.sum() < 20:
        return []
    zero = float(np.mean(reported[moving] == 0.0))
    if zero > 0.3:
        words = f"reads 0 in {zero:.0%} of the samples in which the angle moves; not used"
        return [DataFault("frozen", f"shaft_{joint}_rad_s", words, False)]
    ratio = float(reported[moving] @ derived[moving] / (derived[moving] @ derived[moving]))
    if not 0.5 < ratio < 2.0:
        words = f"is {ratio:.2f} times the derivative of the angle; not used"
        return [DataFault("sign" if ratio < -0.5 else "unit", f"shaft_{joint}_rad_s", words, False)]
    return []


def _magnitude(name: str, values: FloatArray, speed: FloatArray) -> list[DataFault]:
    known = np.isfinite(values) & np.isfinite(speed)
    if known.sum() < 50 or not np.any(values[known] > 0):
        return []
    both = min(np.mean(speed[known] > 0.02), np.mean(speed[known] < -0.02))
    if both > 0.05 and np.min(values[known]) >= 0:
        return [
            DataFault(
                "magnitude_only", name, "never negative although the shaft turns both ways", False
            )
        ]
    return []


def _spikes(name: str, values: FloatArray) -> list[DataFault]:
    known = values[np.isfinite(values)]
    if len(known) < 50:
        return []
    spread = float(np.median(np.abs(known - np.median(known)))) * 1.48
    lone = np.abs(known[1:-1] - np.median([known[:-2], known[1:-1], known[2:]], axis=0))
    limit = SPIKE_SPREADS * max(
        spread, 0.01 * float(np.ptp(np.quantile(known, [0.02, 0.98]))), 1e-12
    )
    limit = max(
        limit, SPIKE_COUNTS * _count_of(known)
    )  # a reading that is 0 most of the time flickers
    count = int(np.sum(lone > limit))
    if count:
        return [
            DataFault(
                "spikes",
                name,
                f"{count} lone samples up to {lone.max():.3g} off their neighbours",
                False,
            )
        ]
    return []
