"""What a simulator leaves of a part of a run: what repeats with the phase of the gait, and the rest.

A floor is measured from many sets of the same references, as each of them is judged by the others; what one
of them adds is computed once.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from gap.constants import ALL_ALIKE, FRAMES_A_PERIOD, SHORTEST_CYCLES, UNCORRELATED
from gap.residuals.parts import TrialPart
from gap.residuals.starting import Starting, noise_of_frames
from model.values.arrays import BoolArray, FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Repeating:
    """Least squares on the phase's first harmonics.

    Attributes:
        coefficients: Of the K columns of the basis, (K, C).
        left: What they leave, (F, C); NaN where unused.
        rest: Its root mean square, less where the machine starts, (C,).
        dependence: Its integrated autocorrelation time in frames, (C,).
    """

    coefficients: FloatArray
    left: FloatArray
    rest: FloatArray
    dependence: FloatArray


@dataclass(frozen=True, eq=False)
class PartError:
    """Measured minus predicted of a part of a run, (F, C); NaN where unused.

    ``starting`` is how much noisier it is at the beginning; None is not at all.
    """

    part: TrialPart
    error: FloatArray
    starting: Starting | None = None
    _by_width: dict[int, Repeating] = field(default_factory=dict, repr=False)

    @cached_property
    def noise(self) -> FloatArray:
        """Median noise of each channel's sensor, (C,)."""
        return np.asarray(np.nanmedian(self.part.observation.noise, axis=0))

    @cached_property
    def measurable(self) -> int:
        """How many of the columns of ``phase_basis`` the part is long enough to measure."""
        cycle = self.part.observation.cycle
        turned = abs(cycle[-1] - cycle[0]) >= SHORTEST_CYCLES or self.part.once
        return phase_basis(self.part).shape[1] if turned else 1

    def repeating(self, width: int) -> Repeating:
        """Return what repeats with the phase, by so many columns of ``phase_basis``."""
        if width not in self._by_width:
            noisier = noise_of_frames(self.starting, self.part)
            repeated, coefficients = _locked(self.part, self.error, width, 1.0 / noisier**2)
            left = self.error - repeated
            rest = left / noisier
            self._by_width[width] = Repeating(coefficients, left, rms(rest), _dependence(rest))
        return self._by_width[width]


def phase_basis(part: TrialPart) -> FloatArray:
    """Return constant and harmonics of the phase, (F, K), each of mean square 1 over whole cycles.

    They are 1, and cosine and sine of each harmonic in turn; as many as the frames can tell apart.
    """
    cycle = part.cycle
    one = np.ones((part.frames, 1))
    if not np.isfinite(cycle).all():
        return one
    turned = abs(cycle[-1] - cycle[0])
    most = part.harmonics if turned == 0.0 else int((part.frames - 1) / turned / FRAMES_A_PERIOD)
    angle = 2 * np.pi * cycle[:, None] * np.arange(1, min(part.harmonics, most) + 1)
    waves = np.stack([np.cos(angle), np.sin(angle)], axis=2).reshape(part.frames, -1)
    return np.hstack([one, np.sqrt(2) * waves])[:, : part.frames]


def _locked(
    part: TrialPart, error: FloatArray, width: int, weight: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Least squares on the phase's harmonics: the fitted part (F, C) and its coefficients (K, C)."""
    basis = phase_basis(part)[:, :width]
    coefficients = np.zeros((basis.shape[1], error.shape[1]))
    known, counted = np.isfinite(error), np.broadcast_to(weight, error.shape)
    # channels whose frames count alike, as most do, share a factorisation
    for own in columns_alike(known, counted):
        on = known[:, own[0]]
        if on.sum() > 2 * basis.shape[1]:
            rows = basis[on]
            weighed = rows * counted[on, own[0], None]
            gram = weighed.T @ rows + 1e-3 * on.sum() * np.eye(basis.shape[1])
            coefficients[:, own] = np.linalg.solve(gram, weighed.T @ error[on][:, own])
    return basis @ coefficients, coefficients


def columns_alike(*each: BoolArray | FloatArray) -> list[list[int]]:
    """Return the numbers of the columns, of arrays of (F, C), that are alike in all of them, by group."""
    groups: dict[bytes, list[int]] = {}
    for number, columns in enumerate(zip(*(one.T for one in each), strict=True)):
        groups.setdefault(b"".join(one.tobytes() for one in columns), []).append(number)
    return list(groups.values())


def rms(values: FloatArray) -> FloatArray:
    """Root mean square of the columns of (F, C) without NaN, (C,); 0 where there is nothing else."""
    known = np.isfinite(values)
    total = np.where(known, values, 0.0)
    return np.asarray(np.sqrt(np.sum(total**2, axis=0) / np.fmax(known.sum(axis=0), 1)))


def most_dependent(frames: int) -> float:
    """Return the largest autocorrelation time of a run with so many frames, in frames."""
    return max(frames / ALL_ALIKE, 1.0)


def _dependence(error: FloatArray) -> FloatArray:
    """Integrated autocorrelation time in frames, (C,), at least 1."""
    frames = len(error)
    known = np.isfinite(error)
    mean = np.where(known, error, 0.0).sum(axis=0) / np.fmax(known.sum(axis=0), 1)
    centred = np.where(known, error - mean, 0.0)
    size = 2 ** int(np.ceil(np.log2(2 * frames)))
    spectrum = np.abs(np.fft.rfft(centred, size, axis=0)) ** 2
    lags = np.fft.irfft(spectrum, size, axis=0)[: max(frames // 4, 2)]
    lags = lags / np.where(lags[0] > 0, lags[0], 1.0)
    # summed up to the first lag that is not above chance
    gone = lags < UNCORRELATED
    end = np.where(gone.any(axis=0), gone.argmax(axis=0), len(lags))
    before: BoolArray = np.arange(len(lags))[:, None] < end
    return np.asarray(np.clip(2 * np.sum(lags * before, axis=0) - 1, 1.0, most_dependent(frames)))
