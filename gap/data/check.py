"""Faults of the data themselves, before any physics is blamed: what any trial shows without a model.

Rules look for what no machine does (a step of a whole turn, a reading that repeats bit for bit while
all around it moves, a signed quantity that never is negative), so that effects of the catalogue pass as
healthy.
"""

from collections.abc import Iterator

import numpy as np
from scipy.ndimage import median_filter

from gap.data.time_lag import lag_faults
from gap.interfaces import DataFault
from model.values.arrays import FloatArray
from record.trial.trial import Trial, trial_places

FROZEN_S = 0.5
FROZEN_SAMPLES = 20
GAP_S = 0.1
SEVERE_SHARE = 0.1
SPIKE_SHARE = 0.6  # of a column's range, that lone samples must stand out
SPIKE_SIGMAS = 20.0
LONGEST_SPIKE = 3
SATURATED_SAMPLES = 20
SATURATED_SHARE = 0.005
NEAR_ZERO_SAMPLES = 40
MOVING_RAD = 0.05
STEADY_RAD = 5.0  # most of a turn: in it a leg is loaded and free
PILED_UP = 4  # times as many samples as at the values next to it
OPPOSITE, ALIKE, UNLIKE = -0.9, 0.9, 0.6
DEGREES, TICKS = 180 / np.pi, 4096 / (2 * np.pi)
UNITS = ((DEGREES, "degrees"), (TICKS, "encoder ticks"), (1 / (2 * np.pi), "turns"))
# Quantities with a sign, and those that a machine reads anew with noise in every sample.
SIGNED = ("current_a", "torque_nm", "pwm", "force_n")
ANGLES = ("command_rad", "shaft_rad", "body_angles_rad")
NOISY = ("shaft_rad", "foot_m", "force_n", "body_position_m", "body_angles_rad", "current_a")


def check_trial(trial: Trial) -> tuple[DataFault, ...]:
    """Look for faults in any machine's trial."""
    time = tuple(_time_faults(trial))
    if any(fault.kind == "unit" for fault in time):
        return time  # nothing that has to do with time can be told
    return (*time, *_column_faults(trial), *_shaft_faults(trial), *lag_faults(trial))


def _time_faults(trial: Trial) -> Iterator[DataFault]:
    steps = np.diff(trial.time_s)
    if len(steps) == 0:
        return
    usual = float(np.median(steps))
    rate = trial.header.sample_rate_hz
    if np.isfinite(rate) and rate > 0:
        ratio = usual * rate
        if ratio > 100 or ratio < 0.01:
            yield DataFault(
                "unit",
                "time_s",
                f"samples lie {usual:g} apart, {1 / rate:g} s by the header: time is not in seconds",
                True,
            )
            return
    long = steps > max(GAP_S, 5 * usual)
    if long.any():
        lost = float(steps[long].sum() / (trial.time_s[-1] - trial.time_s[0]))
        yield DataFault(
            "gap",
            "time_s",
            f"{int(long.sum())} times no sample for up to {steps.max():.2f} s, "
            f"{100 * lost:.1f} % of the trial",
            lost > SEVERE_SHARE,
        )


def _column_faults(trial: Trial) -> Iterator[DataFault]:
    period = float(np.median(np.diff(trial.time_s))) if len(trial.time_s) > 1 else 1.0
    for place in trial_places(trial.joints):
        values = getattr(trial, place.field)[(slice(None), *place.index)]
        known = np.isfinite(values)
        if known.sum() < 2:
            continue
        yield from _holes(place.column, known, period)
        if place.field in ANGLES:
            yield from _wraps(place.column, values[known])
        if place.field in NOISY:
            moving = None
            if place.field in {"shaft_rad", "current_a"}:
                moving = trial.command_rad[:, place.index[0]]
            # a motor that turns evenly under an even load may draw the same counts for a while
            turned = STEADY_RAD if place.field == "current_a" else MOVING_RAD
            sideways = place.field == "foot_m" and place.index[-1] == 1
            if not (sideways and np.ptp(values[known]) == 0.0):  # legs need not move sideways
                yield from _frozen(place.column, values, moving, period, turned)
            if place.field != "current_a":  # motors do draw lone peaks
                yield from _spikes(place.column, values[known])
        if place.field in {"force_n", "current_a", "torque_nm", "pwm"}:
            yield from _saturated(place.column, values[known])
        vertical = place.field == "force_n" and place.index[-1] == 2
        if place.field in SIGNED and not vertical:
            yield from _magnitude(place.column, values[known])


def _runs(flags: np.ndarray) -> np.ndarray:
    """Begin and end (behind the last) of each run of True, (R, 2)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return edges.reshape(-1, 2)


def _holes(column: str, known: np.ndarray, period: float) -> Iterator[DataFault]:
    runs = _runs(~known)
    lengths = (runs[:, 1] - runs[:, 0]) * period
    if len(lengths) and lengths.max() > GAP_S:
        share = float(1 - known.mean())
        yield DataFault(
            "gap",
            column,
            f"{int((lengths > GAP_S).sum())} holes of up to {lengths.max():.2f} s, "
            f"{100 * share:.1f} % is missing",
            share > SEVERE_SHARE,
        )


def _wraps(column: str, values: FloatArray) -> Iterator[DataFault]:
    steps = np.diff(values)
    turns = np.abs(np.abs(steps) - 2 * np.pi) < 0.5
    # one step of a turn between steps that are small: no motion does that
    small = np.median(np.abs(steps)) < 0.5
    if turns.any() and small and column != "body_yaw_rad":
        yield DataFault(
            "wrap", column, f"{int(turns.sum())} jumps of a whole turn; unwrap the angle", True
        )


def _frozen(
    column: str, values: FloatArray, command: FloatArray | None, period: float, turned_rad: float
) -> Iterator[DataFault]:
    same = np.concatenate([[False], values[1:] == values[:-1]])
    needed = max(FROZEN_SAMPLES, round(FROZEN_S / period))
    runs = _runs(same)
    runs = runs[runs[:, 1] - runs[:, 0] >= needed]
    # a sensor without noise that reads 0 in the air, or an encoder of a shaft at rest, may repeat
    runs = np.array([run for run in runs if values[run[0]] != 0.0]).reshape(-1, 2)
    if len(runs) == 0:
        return
    if command is not None:
        known = np.isfinite(command).any()
        runs = np.array([
            run for run in runs if known and np.nanmax(command[run[0] : run[1]], initial=-np.inf)
            - np.nanmin(command[run[0] : run[1]], initial=np.inf) > turned_rad
        ]).reshape(-1, 2)  # fmt: skip
        if len(runs) == 0:
            return
    elif np.mean(same) > 0.3 and np.mean(same) < 0.999 and len(runs) > 20:
        return  # a coarse sensor that repeats all the time
    total = float((runs[:, 1] - runs[:, 0]).sum() * period)
    whole = len(values) * period
    yield DataFault(
        "frozen",
        column,
        f"repeats bit for bit for {total:.1f} s in {len(runs)} stretches, first at sample {runs[0, 0]}",
        total > SEVERE_SHARE * whole,
    )


def _spikes(column: str, values: FloatArray) -> Iterator[DataFault]:
    if len(values) < 20:
        return
    smooth = median_filter(values, 2 * LONGEST_SPIKE + 1, mode="nearest")
    off = np.abs(values - smooth)
    noise = 1.4826 * float(np.median(off))
    low, high = np.percentile(smooth, [0.5, 99.5])
    limit = max(SPIKE_SHARE * (high - low), SPIKE_SIGMAS * noise, 1e-9)
    runs = _runs(off > limit)
    runs = runs[runs[:, 1] - runs[:, 0] <= LONGEST_SPIKE]
    if len(runs):
        share = len(runs) / len(values)
        yield DataFault(
            "spikes",
            column,
            f"{len(runs)} lone samples stand out by up to {off[runs[:, 0]].max():.3g} "
            f"(range of the rest {high - low:.3g})",
            share > 0.01,
        )


def _saturated(column: str, values: FloatArray) -> Iterator[DataFault]:
    # noise must reach into the extremes for an exact repeat of them to tell something
    for extreme, word in ((values.max(), "highest"), (values.min(), "lowest")):
        at = values == extreme
        count, held = int(at.sum()), int((at[1:] & at[:-1]).sum())
        if extreme == 0.0 or np.ptp(values) == 0.0:
            continue
        needed = max(SATURATED_SAMPLES, SATURATED_SHARE * len(values))
        rest = values[~at]
        beside = np.unique(rest, return_counts=True)[1]
        near = beside[-3:] if word == "highest" else beside[:3]
        if len(near) and count < PILED_UP * near.max():
            continue  # a coarse reading at a turning point, not a limit
        if count >= needed and held >= count / 3:
            yield DataFault(
                "saturated",
                column,
                f"{count} samples read exactly {extreme:g}, its {word} value",
                count > SEVERE_SHARE * len(values),
            )


def _magnitude(column: str, values: FloatArray) -> Iterator[DataFault]:
    size = float(np.percentile(np.abs(values), 95))
    noise = 1.4826 * float(np.median(np.abs(np.diff(values)))) / np.sqrt(2)
    near = values[np.abs(values) < max(3 * noise, 0.02 * size)]
    near = near[near != 0.0]
    if len(near) >= NEAR_ZERO_SAMPLES and (values >= 0).all() and size > 0:
        yield DataFault(
            "magnitude_only",
            column,
            f"never negative, with {len(near)} samples near 0: its sign is lost",
            True,
        )


def _shaft_faults(trial: Trial) -> Iterator[DataFault]:
    """Commands against shafts: sign, unit, and joints that were exchanged."""
    command, shaft = (_speeds(trial.time_s, a) for a in (trial.command_rad, trial.shaft_rad))
    count = len(trial.joints)
    alike = np.full((count, count), np.nan)
    for j in range(count):
        for k in range(count):
            alike[j, k] = _correlation(shaft[:, j], command[:, k])
    for j, joint in enumerate(trial.joints):
        column = f"shaft_{joint}_rad"
        if alike[j, j] < OPPOSITE:
            yield DataFault(
                "sign",
                column,
                f"moves against its command (correlation {alike[j, j]:.2f})",
                True,
            )
        if alike[j, j] > ALIKE:
            ratio = _slope(command[:, j], shaft[:, j])
            for factor, unit in UNITS:
                for scale, words in (
                    (factor, f"is in {unit}"),
                    (1 / factor, f"command is in {unit}"),
                ):
                    if abs(ratio / scale - 1) < 0.1:
                        yield DataFault(
                            "unit", column, f"moves {ratio:.3g} times its command: it {words}", True
                        )
    for j in range(count):
        for k in range(j + 1, count):
            crossed = min(alike[j, k], alike[k, j])
            own = max(alike[j, j], alike[k, k])
            if crossed > ALIKE and own < UNLIKE:
                names = trial.joints
                yield DataFault(
                    "swapped",
                    f"shaft_{names[j]}_rad",
                    f"follows the command of {names[k]} and not its own, and the other way round",
                    True,
                )


def _speeds(time_s: FloatArray, angles: FloatArray) -> FloatArray:
    """Speeds over a tenth of a second, without jumps of whole turns, (T - w, N)."""
    period = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 1.0
    width = max(1, round(0.1 / period))
    steps = angles[width:] - angles[:-width]
    return steps / (time_s[width:] - time_s[:-width])[:, None]


def _correlation(a: FloatArray, b: FloatArray) -> float:
    both = np.isfinite(a) & np.isfinite(b)
    if both.sum() < 20 or np.ptp(a[both]) == 0 or np.ptp(b[both]) == 0:
        return float("nan")
    # most jumps (wraps, spikes) are faults of their own
    x, y = (np.clip(v[both], *np.percentile(v[both], [1, 99])) for v in (a, b))
    if np.ptp(x) == 0 or np.ptp(y) == 0:
        return float("nan")
    return float(np.corrcoef(x, y)[0, 1])


def _slope(x: FloatArray, y: FloatArray) -> float:
    both = np.isfinite(x) & np.isfinite(y)
    x, y = (np.clip(v[both], *np.percentile(v[both], [1, 99])) for v in (x, y))
    x, y = x - x.mean(), y - y.mean()
    return float(x @ y / (x @ x))
