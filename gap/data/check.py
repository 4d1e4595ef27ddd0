"""Faults of the data themselves, before any physics is blamed: what any trial shows without a model.

Rules look for what no machine does (a step of a whole turn, a reading that repeats bit for bit while
all around it moves, a signed quantity that never is negative), so that effects of the catalogue pass as
healthy.
"""

from collections.abc import Iterator

import numpy as np

from gap.data.columns import (
    FEWEST,
    LONGEST_SPIKE,
    Sign,
    exchanged,
    faults_of,
    likeness,
    paired,
    runs,
    slope,
    spread_of,
    standing_out,
    unit_of,
)
from gap.data.time_lag import lag_faults
from gap.interfaces import DataFault
from gap.rounding import count_words
from model.values.arrays import BoolArray, FloatArray
from record.trial.table_check import SAMPLED_S
from record.trial.trial import Place, Trial, trial_places

FROZEN_S = 0.5
FROZEN_SAMPLES = 20
GAP_S = 0.1
SEVERE_SHARE = 0.1
SPIKE_SHARE = 0.6  # of a column's range, that lone samples must stand out
SPIKE_SIGMAS = 20.0
SEVERE_SPIKES = 0.01  # share of the samples
SATURATED_SAMPLES = 20
SATURATED_SHARE = 0.005
NEAR_ZERO_SAMPLES = 40
MOVING_RAD = 0.05
STEADY_RAD = 5.0  # most of a turn: in it a leg is loaded and free
PILED_UP = 4  # times as many samples as at the values next to it
OPPOSITE, ALIKE, UNLIKE = -0.9, 0.9, 0.6
DEGREES, TICKS = 180 / np.pi, 4096 / (2 * np.pi)
UNITS = ((DEGREES, "degrees"), (TICKS, "encoder ticks"), (1 / (2 * np.pi), "turns"))
COMMAND_UNITS = tuple((1 / factor, unit) for factor, unit in UNITS)
# Quantities with a sign, and those that a machine reads again with noise in every sample.
SIGNED = ("current_a", "torque_nm", "pwm", "force_n")
ANGLES = ("command_rad", "shaft_rad", "body_angles_rad")
NOISY = ("shaft_rad", "foot_m", "force_n", "body_position_m", "body_angles_rad", "current_a")


def check_trial(trial: Trial) -> tuple[DataFault, ...]:
    """Look for faults in any machine's trial."""
    time = time_faults(trial)
    if any(fault.kind == "unit" for fault in time):
        return time  # nothing that has to do with time can be checked
    period = float(np.median(np.diff(trial.time_s))) if len(trial.time_s) > 1 else 1.0
    columns = (
        fault
        for place in trial_places(trial.header.names)
        for fault in faults_of(place.column, _column(trial, place, period))
    )
    return (*time, *columns, *_shafts(trial), *lag_faults(trial))


def time_faults(trial: Trial) -> tuple[DataFault, ...]:
    """Look for faults of a trial's times alone."""
    return tuple(faults_of("time_s", _time(trial)))


def _time(trial: Trial) -> Iterator[Sign]:
    steps = np.diff(trial.time_s)
    if len(steps) == 0:
        return
    usual, rate = float(np.median(steps)), trial.header.sample_rate_hz
    if np.isfinite(rate) and rate > 0 and not 0.01 <= usual * rate <= 100:
        words = f"samples lie {usual:g} apart, {1 / rate:g} s by the header: time is not in seconds"
        yield "unit", words, True
        return
    if not SAMPLED_S[0] <= usual <= SAMPLED_S[1]:
        words = (
            f"samples lie {usual:g} s apart: time is not in seconds; name its unit in the map (ms)"
        )
        yield "unit", words, True
        return
    long = steps > max(GAP_S, 5 * usual)
    if long.any():
        lost = float(steps[long].sum() / (trial.time_s[-1] - trial.time_s[0]))
        words = f"{count_words(int(long.sum()), 'pause')} without a sample, of up to {steps.max():.2f} s, "
        yield "gap", f"{words}{100 * lost:.1f} % of the trial", lost > SEVERE_SHARE


def _column(trial: Trial, place: Place, period: float) -> Iterator[Sign]:
    values = getattr(trial, place.field)[place.where]
    known = values[np.isfinite(values)]
    if len(known) < 2:
        return
    yield from _holes(np.isfinite(values), period)
    if place.field in ANGLES and place.column != "body_yaw_rad":
        yield from _wraps(known)
    if place.field in NOISY:
        moving = None
        if place.field in {"shaft_rad", "current_a"}:
            moving = trial.command_rad[:, place.index[0]]
        # a motor that turns evenly under an even load may draw the same counts for a while
        turned = STEADY_RAD if place.field == "current_a" else MOVING_RAD
        sideways = place.field == "foot_m" and place.index[-1] == 1
        if not (sideways and np.ptp(known) == 0.0):  # legs need not move sideways
            yield from _frozen(values, moving, period, turned)
        if place.field != "current_a":  # motors do draw lone peaks
            yield from _spikes(known)
    if place.field in SIGNED:
        if place.field != "pwm":  # what a controller asks for ends at its limit: no sensor's fault
            yield from _saturated(known)
        if not (place.field == "force_n" and place.index[-1] == 2):
            yield from _magnitude(known)


def _holes(known: BoolArray, period: float) -> Iterator[Sign]:
    lengths = np.diff(runs(~known)).ravel() * period
    long = lengths > GAP_S
    if long.any():
        share = float(1 - known.mean())
        words = f"{count_words(int(long.sum()), 'hole')} of up to {lengths.max():.2f} s, "
        words += f"{100 * share:.1f} % is missing"
        yield "gap", words, share > SEVERE_SHARE


def _wraps(values: FloatArray) -> Iterator[Sign]:
    steps = np.abs(np.diff(values))
    turns = np.abs(steps - 2 * np.pi) < 0.5
    # one step of a turn between steps that are small: no motion does that
    if turns.any() and np.median(steps) < 0.5:
        yield (
            "wrap",
            f"{count_words(int(turns.sum()), 'jump')} of a whole turn; unwrap the angle",
            True,
        )


def _frozen(
    values: FloatArray, command: FloatArray | None, period: float, turned_rad: float
) -> Iterator[Sign]:
    same = np.concatenate([[False], values[1:] == values[:-1]])
    shortest = max(FROZEN_SAMPLES, round(FROZEN_S / period))
    held = [
        (first, last)
        for first, last in runs(same).tolist()
        # a sensor without noise that reads 0 in the air, or an encoder of a shaft at rest, may repeat
        if last - first >= shortest and values[first] != 0.0
    ]
    if command is not None:
        held = [run for run in held if _range(command[slice(*run)]) > turned_rad]
    elif 0.3 < np.mean(same) < 0.999 and len(held) > 20:
        return  # a coarse sensor that repeats all the time
    if held:
        total = sum(last - first for first, last in held) * period
        where = "1 stretch" if len(held) == 1 else f"{len(held)} stretches"
        words = f"repeats bit for bit for {total:.1f} s in {where}, first at sample "
        yield "frozen", f"{words}{held[0][0]}", total > SEVERE_SHARE * len(values) * period


def _range(values: FloatArray) -> float:
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) if len(known) else 0.0


def _spikes(values: FloatArray) -> Iterator[Sign]:
    if len(values) < FEWEST:
        return
    smooth, off = standing_out(values)
    low, high = np.percentile(smooth, [0.5, 99.5])
    limit = max(SPIKE_SHARE * (high - low), SPIKE_SIGMAS * spread_of(off), 1e-9)
    lone = [first for first, last in runs(off > limit).tolist() if last - first <= LONGEST_SPIKE]
    if lone:
        stand = "stands out by" if len(lone) == 1 else "stand out by up to"
        words = f"{count_words(len(lone), 'lone sample')} {stand} {off[lone].max():.3g} "
        words += f"(range of the rest {high - low:.3g})"
        share = len(lone) / len(values)
        yield "spikes", words, share > SEVERE_SPIKES, share


def _saturated(values: FloatArray) -> Iterator[Sign]:
    # noise must reach into the extremes for an exact repeat of them to mean something
    for extreme, word in ((values.max(), "highest"), (values.min(), "lowest")):
        if extreme == 0.0 or np.ptp(values) == 0.0:
            continue
        at = values == extreme
        count, held = int(at.sum()), int((at[1:] & at[:-1]).sum())
        beside = np.unique(values[~at], return_counts=True)[1]
        near = beside[-3:] if word == "highest" else beside[:3]
        if len(near) and count < PILED_UP * near.max():
            continue  # a coarse reading at a turning point, not a limit
        if count >= max(SATURATED_SAMPLES, SATURATED_SHARE * len(values)) and held >= count / 3:
            words = f"{count} samples read exactly {extreme:g}, its {word} value"
            yield "saturated", words, count > SEVERE_SHARE * len(values)


def _magnitude(values: FloatArray) -> Iterator[Sign]:
    size = float(np.percentile(np.abs(values), 95))
    noise = spread_of(np.diff(values)) / np.sqrt(2)
    # what only comes near 0, as the current of a motor that always pushes one way, is hardly this near
    near = int(np.sum((np.abs(values) < max(noise, 0.02 * size)) & (values != 0.0)))
    if near >= NEAR_ZERO_SAMPLES and (values >= 0).all() and size > 0:
        yield (
            "magnitude_only",
            f"never negative, with {near} samples near 0: its sign is lost",
            True,
        )


def _shafts(trial: Trial) -> Iterator[DataFault]:
    """Commands against shafts: sign, unit, and joints that were exchanged."""
    command, shaft = (_speeds(trial.time_s, a) for a in (trial.command_rad, trial.shaft_rad))
    alike = likeness(shaft, command, clipped=True)
    names = trial.joints
    for j, joint in enumerate(names):
        own = alike[j, j]
        yield from faults_of(f"shaft_{joint}_rad", _shaft(own, command[:, j], shaft[:, j]))
    for j, k in exchanged(alike, ALIKE, UNLIKE):
        words = f"follows the command of {names[k]} and not its own, and the other way round"
        yield DataFault("swapped", f"shaft_{names[j]}_rad", words, True)


def _shaft(own: float, command: FloatArray, shaft: FloatArray) -> Iterator[Sign]:
    if own < OPPOSITE:
        yield "sign", f"moves against its command (correlation {own:.2f})", True
    if own > ALIKE:
        ratio = slope(*paired(command, shaft, clipped=True))
        for units, words in ((UNITS, "is"), (COMMAND_UNITS, "command is")):
            if unit := unit_of(ratio, units, 0.1):
                yield "unit", f"moves {ratio:.3g} times its command: it {words} in {unit}", True


def _speeds(time_s: FloatArray, angles: FloatArray) -> FloatArray:
    """Speeds over a tenth of a second, (T - w, N)."""
    period = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 1.0
    width = max(1, round(0.1 / period))
    steps = angles[width:] - angles[:-width]
    return steps / (time_s[width:] - time_s[:-width])[:, None]
