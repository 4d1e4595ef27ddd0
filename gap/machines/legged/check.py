"""Faults of a legged robot's data that geometry and weight show: units, signs, exchanges, clocks."""

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from gap.data.time_lag import lag, stream_faults
from gap.interfaces import DataFault
from gap.machines.legged.inputs import LeggedInputs
from model.effects.signals import SensorSignals
from model.values.arrays import BoolArray, FloatArray

FORCE_UNITS = (
    (1e3, "millinewtons"), (1e-3, "kilonewtons"), (1 / 9.80665, "kilograms"), (0.224809, "pounds"),
    (9.80665, "newtons times g"), (1e3 / 9.80665, "grams"),
)  # fmt: skip
LENGTH_UNITS = ((1e3, "millimetres"), (100.0, "centimetres"), (39.3701, "inches"))
DEGREES = 180 / np.pi
CLOSE = 0.12
LOADED_N = 5.0
AXES = "xyz"


def check_legged(
    inputs: LeggedInputs, walk: SensorSignals, weight_n: float
) -> tuple[DataFault, ...]:
    """Compare measured streams with what the simulator reads from measured shafts.

    Args:
        inputs: Measured data.
        walk: What the simulator as it stands would read.
        weight_n: The robot's weight.
    """
    axes = tuple(_force_faults(inputs, walk, weight_n))
    return (
        *axes,
        *_leg_faults(inputs, walk, swapped_axes=any(f.kind == "swapped" for f in axes)),
        *_foot_faults(inputs, walk),
        *_body_faults(inputs, walk),
        *_clock_faults(inputs, walk),
    )


def _unit(ratio: float, units: tuple[tuple[float, str], ...]) -> str | None:
    return next((name for factor, name in units if abs(ratio / factor - 1) < CLOSE), None)


def _force_faults(
    inputs: LeggedInputs, walk: SensorSignals, weight_n: float
) -> Iterator[DataFault]:
    """The feet together carry the weight, along z."""
    if not np.isfinite(inputs.force_n).all(axis=(1, 2)).any():
        return
    total = np.nanmedian(inputs.force_n.sum(axis=1), axis=0) / weight_n
    largest = int(np.argmax(np.abs(total)))
    if largest != 2 and abs(abs(total[largest]) - 1) < 0.3 and abs(total[2]) < 0.3:
        yield DataFault(
            "swapped",
            "force",
            f"the feet's {AXES[largest]} forces sum up to {total[largest]:.2f} of the weight, z to "
            f"{total[2]:.2f}: axes are exchanged",
            True,
        )
        return
    unit = _unit(abs(float(total[2])), FORCE_UNITS)
    if unit:
        yield DataFault(
            "unit",
            "force",
            f"the feet carry {total[2]:.3g} of the weight together: forces are in {unit}",
            True,
        )
    if total[2] < -0.3 * (1.0 if unit is None else abs(total[2])):
        yield DataFault(
            "sign", "force", f"the feet carry {total[2]:.2f} of the weight: pull for push", True
        )


def _leg_faults(
    inputs: LeggedInputs, walk: SensorSignals, *, swapped_axes: bool
) -> Iterator[DataFault]:
    """Each foot's vertical force against its predicted load."""
    legs = inputs.trial.joints
    load, seen = walk.force_n[..., 2], inputs.force_n[..., 2]
    alike = _correlations(seen, load)
    overall = np.nanmedian(np.diag(alike))
    for k, leg in enumerate(legs):
        if alike[k, k] < -0.7 and overall > 0 and not swapped_axes:
            yield DataFault(
                "sign",
                f"force_{leg}_z_n",
                f"falls when the foot is loaded (correlation {alike[k, k]:.2f})",
                True,
            )
    for j in range(len(legs)):
        for k in range(j + 1, len(legs)):
            if min(alike[j, k], alike[k, j]) > 0.85 and max(alike[j, j], alike[k, k]) < 0.5:
                yield DataFault(
                    "swapped",
                    f"force_{legs[j]}_z_n",
                    f"is loaded when {legs[k]} should be, and the other way round",
                    True,
                )


def _correlations(seen: FloatArray, expected: FloatArray) -> FloatArray:
    count = seen.shape[1]
    out = np.full((count, count), np.nan)
    for j in range(count):
        for k in range(count):
            both = np.isfinite(seen[:, j]) & np.isfinite(expected[:, k])
            a, b = seen[both, j], expected[both, k]
            if both.sum() > 20 and np.ptp(a) > 0 and np.ptp(b) > 0:
                out[j, k] = np.corrcoef(a, b)[0, 1]
    return out


def _means(feet: FloatArray, known: BoolArray) -> FloatArray:
    """Mean place of each foot where it is known, (N, 3); NaN where it never is."""
    total = np.where(known[..., None], feet, 0.0).sum(axis=0)
    count = known.sum(axis=0)[:, None].astype(np.float64)
    means: FloatArray = total / np.where(count > 0, count, np.nan)
    return means


def _foot_faults(inputs: LeggedInputs, walk: SensorSignals) -> Iterator[DataFault]:
    """Foot markers against where the linkage puts the feet."""
    legs = inputs.trial.joints
    known: BoolArray = np.all(np.isfinite(inputs.foot_m + walk.foot_m), axis=2)
    if known.sum() < 20:
        return
    seen, wanted = _means(inputs.foot_m, known), _means(walk.foot_m, known)
    scale = float(np.nanmedian(np.linalg.norm(seen, axis=1) / np.linalg.norm(wanted, axis=1)))
    unit = _unit(scale, LENGTH_UNITS)
    if unit:
        yield DataFault(
            "unit", "foot", f"feet are {scale:.3g} times as far as the drawing: in {unit}", True
        )
        seen = seen / scale
    error = np.nanmean(np.abs(seen - wanted))
    best = min(
        permutations(range(3)), key=lambda order: np.nanmean(np.abs(seen[:, list(order)] - wanted))
    )
    if best != (0, 1, 2) and np.nanmean(np.abs(seen[:, list(best)] - wanted)) < error / 4:
        yield DataFault(
            "swapped",
            "foot",
            f"axes fit the drawing when read as {', '.join(AXES[k] for k in best)}",
            True,
        )
        return
    for axis, letter in enumerate(AXES):
        if (
            np.nanmean(np.abs(seen[:, axis] + wanted[:, axis])) < 0.25 * np.nanmean(np.abs(wanted[:, axis]))
            and np.nanmean(np.abs(seen[:, axis] - wanted[:, axis])) > np.nanmean(np.abs(wanted[:, axis]))
        ):  # fmt: skip
            yield DataFault(
                "sign", f"foot_{letter}", "feet lie on the other side of the body", True
            )
    away = np.linalg.norm(seen[:, None, :2] - wanted[None, :, :2], axis=2)
    for j in range(len(legs)):
        for k in range(j + 1, len(legs)):
            if max(away[j, k], away[k, j]) < 0.35 * min(away[j, j], away[k, k]):
                yield DataFault(
                    "swapped",
                    f"foot_{legs[j]}",
                    f"lies where {legs[k]} should be, and the other way round",
                    True,
                )


def _body_faults(inputs: LeggedInputs, walk: SensorSignals) -> Iterator[DataFault]:
    """Pose against the height and tilt at which the legs carry the body."""
    height = inputs.body_m[:, 2]
    if np.isfinite(height).any() and np.isfinite(walk.body_m[:, 2]).any():
        ratio = float(np.nanmedian(height) / np.nanmedian(walk.body_m[:, 2]))
        unit = _unit(abs(ratio), LENGTH_UNITS)
        if unit:
            yield DataFault(
                "unit",
                "body",
                f"the body is {ratio:.3g} times as high as its legs: in {unit}",
                True,
            )
        elif ratio < -0.7:
            yield DataFault("sign", "body_z_m", "the body is below the ground", True)
    for axis, name in enumerate(("body_roll_rad", "body_pitch_rad")):
        seen, wanted = inputs.body_rad[:, axis], walk.body_rad[:, axis]
        both = np.isfinite(seen) & np.isfinite(wanted)
        if both.sum() < 50 or np.std(wanted[both]) < 1e-3:
            continue
        x, y = wanted[both] - wanted[both].mean(), seen[both] - seen[both].mean()
        alike = float(x @ y / np.sqrt((x @ x) * (y @ y))) if y.any() else 0.0
        slope = float(x @ y / (x @ x))
        if alike < -0.7:
            yield DataFault("sign", name, f"tilts against the legs (correlation {alike:.2f})", True)
        if abs(alike) > 0.7 and abs(abs(slope) / DEGREES - 1) < 0.4:
            yield DataFault(
                "unit", name, f"tilts {slope:.3g} times as far as the legs: in degrees", True
            )


def _clock_faults(inputs: LeggedInputs, walk: SensorSignals) -> Iterator[DataFault]:
    time_s = inputs.grid.time_s
    frames = inputs.grid.frames
    streams = (
        ("force", walk.force_n[..., 2], inputs.force_n[..., 2]),
        (
            "body",
            walk.foot_m[..., 0].reshape(frames, -1),
            inputs.foot_m[..., 0].reshape(frames, -1),
        ),
        ("body", walk.body_rad[:, :2], inputs.body_rad[:, :2]),
    )
    reported: set[str] = set()
    for channel, wanted, seen in streams:
        if channel in reported or not np.isfinite(seen).any() or lag(time_s, wanted, seen)[1] < 0:
            continue
        faults = stream_faults(time_s, wanted, seen, channel, "the shafts")
        reported |= {fault.channel for fault in faults}
        yield from faults
