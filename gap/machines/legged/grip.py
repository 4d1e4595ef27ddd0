"""Grip of each foot: the share of its load that it pushes sideways when it pushes most.

How feet that stick push against each other is another on each day, and no simulator predicts when each of
them slips. But a foot that slips at some time of a cycle pushes, then, with all the grip that it has. So
the largest share in each cycle is compared by itself, as its logarithm: measured with the grip that the
simulator's ground gives the foot there, whatever its law of friction says of the speed.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from gap.constants import ALL_ALIKE, GRIP_LARGEST, GRIP_LOADED, GRIP_WINDOW_S
from model.compiled import compiled
from model.effects.grid import Grid
from model.effects.ground import Sliding
from model.effects.sensing import READS_FORCES, read_sensors
from model.effects.settings import Settings
from model.effects.signals import SensorSignals
from model.values.arrays import FloatArray, IntArray, given_rows

FEWEST = 12  # loaded frames of a window; fewer have no largest share to speak of


@dataclass(frozen=True, slots=True, eq=False)
class Windows:
    """Windows of a trial in which each foot has one grip.

    Attributes:
        starts: First of F frames of each, and F at the end, (K + 1,).
        least_n: Load from which a foot counts as loaded.
    """

    starts: IntArray
    least_n: float

    @property
    def number(self) -> int:
        """Of windows, K."""
        return len(self.starts) - 1


def make_windows(time_s: FloatArray, cycle: FloatArray, weight_n: float) -> Windows:
    """Return windows of whole cycles of the gait, as short as they may be.

    Args:
        time_s: Of F frames.
        cycle: Cycles of the gait, (F,); NaN where there is none.
        weight_n: Of the machine.
    """
    turned = float(abs(cycle[-1] - cycle[0]))  # NaN if it is not known
    period_s = (time_s[-1] - time_s[0]) / turned if turned >= 1.0 else math.nan
    whole = np.abs(cycle - cycle[0]) if np.isfinite(period_s) else time_s - time_s[0]
    length = math.ceil(GRIP_WINDOW_S / period_s) if np.isfinite(period_s) else GRIP_WINDOW_S
    count = max(1, int((whole[-1] + 1e-9) // length))
    number = np.minimum((whole // length).astype(int), count - 1)
    starts = np.flatnonzero(np.diff(number, prepend=-1) > 0)
    return Windows(np.append(starts, len(time_s)), GRIP_LOADED * weight_n)


def grip_of(windows: Windows, force_n: FloatArray) -> FloatArray:
    """Return the logarithm of the largest share of each window, (F, N), of forces on feet, (F, N, 3).

    NaN where a foot is not loaded long enough, or its force is not known.
    """
    out = np.empty(force_n.shape[:2])
    _largest(windows.starts, windows.least_n, float(GRIP_LARGEST), given_rows(force_n), out)
    return out


def in_all_windows(grip: FloatArray) -> FloatArray:
    """Return grip, (F, N), of a foot that hardly has a load in a window as it is in the others."""
    known = np.isfinite(grip)
    if known.all():
        return grip
    mean = np.where(known, grip, 0.0).sum(axis=0) / np.fmax(known.sum(axis=0), 1)
    return np.where(known, grip, np.where(known.any(axis=0), mean, np.nan))


def with_all_grip(force_n: FloatArray, friction: FloatArray, anisotropy: FloatArray) -> FloatArray:
    """Return forces on feet that push with all their grip, along where they push, (F, N, 3).

    Args:
        force_n: Forces on feet, (F, N, 3).
        friction: Coefficient of each foot, (F, N).
        anisotropy: w of each foot, (F or 1, N, 2): forces are mu N (1 + w w') z with a unit vector z.
    """
    out = np.empty(force_n.shape)
    _push(given_rows(force_n), given_rows(friction), given_rows(anisotropy), out)
    return out


def given_grip(
    windows: Windows, grid: Grid, truth: SensorSignals, sliding: Sliding, settings: Settings
) -> FloatArray:
    """Return the grip that the ground gives each foot, (F, N), as the force sensors would read it."""
    friction, anisotropy = sliding.friction, sliding.anisotropy_B
    read = settings.has(*READS_FORCES) or bool(settings.at("sensing"))
    if not read and _always_alike(friction, anisotropy):
        return np.broadcast_to(np.log(friction[0]), (windows.starts[-1], friction.shape[1]))
    full = with_all_grip(truth.force_n, friction, anisotropy)
    if read:
        full = read_sensors(grid, replace(truth, force_n=full), settings).force_n
    return in_all_windows(grip_of(windows, full[::2]))


def _always_alike(friction: FloatArray, anisotropy: FloatArray) -> bool:
    """Whether the grip of each foot is the same in all frames and directions."""
    return not anisotropy.any() and bool((friction == friction[0]).all())


def weight_of_frames(windows: Windows, readings: float) -> float:
    """Return the weight of each frame with which each window counts as so many readings."""
    return readings * windows.number / ALL_ALIKE


@compiled
def _largest(
    starts: IntArray, least_n: float, quantile: float, force_n: FloatArray, out: FloatArray
) -> None:
    """Logarithm of the quantile of each window's shares while loaded, laid over its frames."""
    for w in range(len(starts) - 1):
        first, last = starts[w], starts[w + 1]
        some = np.empty(last - first)
        for k in range(force_n.shape[1]):
            count = 0
            for f in range(first, last):
                x, y, z = force_n[f, k, 0], force_n[f, k, 1], force_n[f, k, 2]
                if z > least_n and np.isfinite(x) and np.isfinite(y):
                    some[count] = np.sqrt(x * x + y * y) / z
                    count += 1
            value = np.nan
            if count >= FEWEST:
                ordered = np.sort(some[:count])
                at = quantile * (count - 1)
                low = int(at)
                high = min(low + 1, count - 1)
                largest = ordered[low] + (at - low) * (ordered[high] - ordered[low])
                if largest > 0.0:
                    value = np.log(largest)
            for f in range(first, last):
                out[f, k] = value


@compiled
def _push(
    force_n: FloatArray, friction: FloatArray, anisotropy: FloatArray, out: FloatArray
) -> None:
    for f in range(force_n.shape[0]):
        row = f if anisotropy.shape[0] > 1 else 0
        for k in range(force_n.shape[1]):
            a, b = anisotropy[row, k, 0], anisotropy[row, k, 1]
            x, y, load = force_n[f, k, 0], force_n[f, k, 1], force_n[f, k, 2]
            size = np.sqrt(x * x + y * y)
            if not size > 0.0:
                x, y, size = 1.0, 0.0, 1.0
            x, y = x / size, y / size
            # (1 + w w')^-1 shortens what is along w
            along = (a * x + b * y) / (1.0 + a * a + b * b)
            left = np.sqrt((x - a * along) ** 2 + (y - b * along) ** 2)
            push = friction[f, k] * load / left
            out[f, k, 0], out[f, k, 1], out[f, k, 2] = push * x, push * y, load
