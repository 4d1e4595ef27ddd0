"""Faults of servo data that no physics should be blamed for."""

import numpy as np

from gap.interfaces import DataFault
from model.signals import FloatArray
from record.trial import Trial

FULL_TURN = 2 * np.pi
SPIKE_SPREADS = 30.0


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
    if moved > 0.1 and np.ptp(shaft[known]) < 1e-6:
        found.append(
            DataFault(
                "frozen", name, f"never changes while its command moves {moved:.3g} rad", True
            )
        )
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
