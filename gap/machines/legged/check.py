"""Faults of a legged robot's data that geometry and weight show: units, signs, exchanges, clocks."""

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from gap.constants import SURELY_MIRRORED
from gap.data.columns import Sign, exchanged, faults_of, likeness, paired, slope, unit_of
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
ALIKE = 0.5  # correlation from which two streams show the same motion
AXES = "xyz"


def check_legged(
    inputs: LeggedInputs, walk: SensorSignals, weight_n: float
) -> tuple[DataFault, ...]:
    """Compare measured streams with what the unchanged simulator reads from measured shafts."""
    axes = tuple(faults_of("force", _forces(inputs, weight_n)))
    swapped = any(fault.kind == "swapped" for fault in axes)
    return (
        *axes,
        *_leg_faults(inputs, walk, swapped_axes=swapped),
        *_foot_faults(inputs, walk),
        *_body_faults(inputs, walk),
        *_clock_faults(inputs, walk),
    )


def _forces(inputs: LeggedInputs, weight_n: float) -> Iterator[Sign]:
    """The feet together carry the weight, along z."""
    if not np.isfinite(inputs.force_n).all(axis=(1, 2)).any():
        return
    total = np.nanmedian(inputs.force_n.sum(axis=1), axis=0) / weight_n
    largest = int(np.argmax(np.abs(total)))
    if largest != 2 and abs(abs(total[largest]) - 1) < 0.3 and abs(total[2]) < 0.3:
        words = (
            f"the feet's {AXES[largest]} forces sum up to {total[largest]:.2f} of the weight, z to "
        )
        yield "swapped", f"{words}{total[2]:.2f}: axes are exchanged", True
        return
    unit = unit_of(abs(float(total[2])), FORCE_UNITS, CLOSE)
    if unit:
        words = f"the feet carry {total[2]:.3g} of the weight together: forces are in {unit}"
        yield "unit", words, True
    if total[2] < -0.3 * (1.0 if unit is None else abs(total[2])):
        yield "sign", f"the feet carry {total[2]:.2f} of the weight: pull for push", True


def _leg_faults(
    inputs: LeggedInputs, walk: SensorSignals, *, swapped_axes: bool
) -> Iterator[DataFault]:
    """Each foot's vertical force against its predicted load."""
    legs = inputs.trial.legs
    alike = likeness(inputs.force_n[..., 2], walk.force_n[..., 2])
    each = np.diag(alike)
    overall = np.median(each[np.isfinite(each)]) if np.isfinite(each).any() else 0.0
    for leg, own in zip(legs, each, strict=True):
        if own < -0.7 and overall > 0 and not swapped_axes:
            words = f"falls when the foot is loaded (correlation {own:.2f})"
            yield DataFault("sign", f"force_{leg}_z_n", words, True)
    for j, k in exchanged(alike, 0.85, 0.5):
        words = f"is loaded when {legs[k]} should be, and the other way round"
        yield DataFault("swapped", f"force_{legs[j]}_z_n", words, True)


def _means(feet: FloatArray, known: BoolArray) -> FloatArray:
    """Mean place of each foot where it is known, (N, 3); NaN where it never is."""
    total = np.where(known[..., None], feet, 0.0).sum(axis=0)
    count = known.sum(axis=0)[:, None].astype(np.float64)
    means: FloatArray = total / np.where(count > 0, count, np.nan)
    return means


def _foot_faults(inputs: LeggedInputs, walk: SensorSignals) -> Iterator[DataFault]:
    """Foot markers against where the linkage puts the feet."""
    legs = inputs.trial.legs
    known: BoolArray = np.all(np.isfinite(inputs.foot_m + walk.foot_m), axis=2)
    if known.sum() < 20:
        return
    seen, wanted = _means(inputs.foot_m, known), _means(walk.foot_m, known)
    scale = float(np.nanmedian(np.linalg.norm(seen, axis=1) / np.linalg.norm(wanted, axis=1)))
    if unit := unit_of(scale, LENGTH_UNITS, CLOSE):
        words = f"feet are {scale:.3g} times as far as the drawing: in {unit}"
        yield DataFault("unit", "foot", words, True)
        seen = seen / scale

    def error(order: tuple[int, ...]) -> float:
        return float(np.nanmean(np.abs(seen[:, order] - wanted)))

    best = min(permutations(range(3)), key=error)
    if best != (0, 1, 2) and error(best) < error((0, 1, 2)) / 4:
        words = f"axes fit the drawing when read as {', '.join(AXES[k] for k in best)}"
        yield DataFault("swapped", "foot", words, True)
        return
    # the same, of the other sign, and of nothing at all: one a axis
    off, mirrored, size = (
        np.nanmean(np.abs(one), axis=0) for one in (seen - wanted, seen + wanted, wanted)
    )
    for axis in np.flatnonzero((mirrored < 0.25 * size) & (off > size)):
        words = "feet lie on the other side of the body"
        yield DataFault("sign", f"foot_{AXES[axis]}", words, True)
    away = np.linalg.norm(seen[:, None, :2] - wanted[None, :, :2], axis=2)
    for j in range(len(legs)):
        for k in range(j + 1, len(legs)):
            if max(away[j, k], away[k, j]) < 0.35 * min(away[j, j], away[k, k]):
                words = f"lies where {legs[k]} should be, and the other way round"
                yield DataFault("swapped", f"foot_{legs[j]}", words, True)


def _body_faults(inputs: LeggedInputs, walk: SensorSignals) -> Iterator[DataFault]:
    """Pose against the height and tilt at which the legs carry the body."""
    height = inputs.body_m[:, 2]
    if np.isfinite(height).any() and np.isfinite(walk.body_m[:, 2]).any():
        ratio = float(np.nanmedian(height) / np.nanmedian(walk.body_m[:, 2]))
        if unit := unit_of(abs(ratio), LENGTH_UNITS, CLOSE):
            words = f"the body is {ratio:.3g} times as high as its legs: in {unit}"
            yield DataFault("unit", "body", words, True)
        elif ratio < -0.7:
            yield DataFault("sign", "body_z_m", "the body is below the ground", True)
    for axis, name in enumerate(("body_roll_rad", "body_pitch_rad")):
        wanted, seen = paired(walk.body_rad[:, axis], inputs.body_rad[:, axis])
        if len(wanted) >= 50 and np.std(wanted) >= 1e-3:
            yield from faults_of(name, _tilt(wanted, seen))


def _tilt(wanted: FloatArray, seen: FloatArray) -> Iterator[Sign]:
    alike = float(np.corrcoef(wanted, seen)[0, 1]) if np.ptp(seen) > 0 else 0.0
    ratio = slope(wanted, seen)
    if alike < -0.7:
        # a joint that is off tilts the legs' own answer, too, though never so exactly the other way
        words = f"tilts against the legs (correlation {alike:.2f})"
        yield "sign", words, alike < -SURELY_MIRRORED
    if abs(alike) > 0.7 and abs(abs(ratio) / DEGREES - 1) < 0.4:
        yield "unit", f"tilts {ratio:.3g} times as far as the legs: in degrees", True


def _clock_faults(inputs: LeggedInputs, walk: SensorSignals) -> Iterator[DataFault]:
    """Streams that come later or earlier than the shaft angles predict.

    Pose and foot markers have one clock: the stream of which the lag is known best tells it.
    """
    time_s = inputs.grid.time_s
    clocks = (
        ("force", ((walk.force_n[..., 2], inputs.force_n[..., 2]),)),
        ("body", (
            (walk.foot_m[..., 0], inputs.foot_m[..., 0]),
            (walk.body_rad[:, :2], inputs.body_rad[:, :2]),
        )),
    )  # fmt: skip
    for channel, streams in clocks:
        known = [
            (late, wanted, seen)
            for wanted, seen in streams
            if np.isfinite(seen).any() and (late := lag(time_s, wanted, seen)).correlation > ALIKE
        ]
        if known:
            late, wanted, seen = min(known, key=lambda one: one[0].sd_s)
            yield from stream_faults(time_s, wanted, seen, channel, "the shafts", late)
