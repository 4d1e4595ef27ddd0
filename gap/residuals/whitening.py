"""Residuals in units of what is expected without a new cause: mean square 1, counted as independent.

Each frame is divided by its noise and by the root of the autocorrelation time; along the harmonics of the
phase, where references scatter too, it is shrunk by what they leave uncertain.
"""

from dataclasses import dataclass

import numpy as np

from gap.interfaces import used
from gap.residuals.floor import ExpectedMisfit, Floor
from gap.residuals.part_error import phase_basis
from gap.residuals.parts import TrialPart
from gap.residuals.starting import noise_of_frames
from model.compiled import compiled
from model.values.arrays import FloatArray, given_rows

SMALLEST = 1e-12
LARGEST = float(np.finfo(np.float64).max)


@dataclass(frozen=True, slots=True, eq=False)
class Whitener:
    """A linear map for one part, and the expected misfit that is subtracted first.

    Attributes:
        expected: Misfit that references predict, (F, C).
        gain: Root of the weight over the noise; 0 where nothing is compared, (F, C).
        basis: Orthonormal directions, (F, K).
        shrink: What is subtracted along them, 0 to 1, (K, C).
        count: Frames that count as independent, of each frame, (F, C).
        unsure: Standard deviation of all frames in the channel's unit, misfit and noise together, (C,).
    """

    expected: FloatArray
    gain: FloatArray
    basis: FloatArray
    shrink: FloatArray
    count: FloatArray
    unsure: FloatArray

    def whiten(self, error: FloatArray) -> FloatArray:
        """Map measured minus predicted, (F, C); NaN becomes 0."""
        scaled = np.empty(error.shape)
        given, expected, gain = map(given_rows, (error, self.expected, self.gain))
        _scale(given, expected, gain, scaled)
        if self.basis.shape[1]:
            along = self.shrink * (self.basis.T @ scaled)
            _take_out(given_rows(self.basis @ along), gain, scaled)
        return scaled

    def whiten_change(self, change: FloatArray) -> FloatArray:
        """Map by how much an error changes, (F, C): the expected misfit does not."""
        return self.whiten(change + self.expected)


@compiled
def _scale(error: FloatArray, expected: FloatArray, gain: FloatArray, out: FloatArray) -> None:
    """Errors beyond the expected ones in units of noise; 0 where they are unknown or do not count."""
    for f in range(error.shape[0]):
        for c in range(error.shape[1]):
            beyond = error[f, c] - expected[f, c]
            known = gain[f, c] > 0.0 and beyond == beyond
            out[f, c] = min(max(beyond, -LARGEST), LARGEST) * gain[f, c] if known else 0.0


@compiled
def _take_out(along: FloatArray, gain: FloatArray, out: FloatArray) -> None:
    """Subtract what counts as expected along some directions, where anything is compared."""
    for f in range(out.shape[0]):
        for c in range(out.shape[1]):
            if gain[f, c] > 0.0:
                out[f, c] -= along[f, c]


def make_whitener(part: TrialPart, floor: Floor, base: FloatArray) -> Whitener:
    """Make the map.

    The unchanged simulator, ``base`` (F, C), is compared where it has an answer.
    """
    on = used(part.observation) & np.isfinite(base) & floor.compared
    weight = np.where(on, part.observation.weight, 0.0)
    sigma = np.fmax(floor.sigma, SMALLEST)
    noisier = noise_of_frames(floor.starting, part)
    gain = np.sqrt(weight) / (sigma * np.sqrt(floor.dependence) * noisier)
    misfit = floor.expect(part.condition)
    basis = phase_basis(part)[:, : len(misfit.mean)]
    if len(misfit.mean) > basis.shape[1]:  # a trial without phase: only what is constant is known
        misfit = ExpectedMisfit(misfit.mean[: basis.shape[1]], misfit.variance[: basis.shape[1]])
    across, shrink = _directions(basis, misfit.variance, sigma**2 * floor.dependence)
    variance = sigma**2 * (noisier**2).mean(axis=0) + misfit.variance.sum(axis=0)
    return Whitener(
        expected=basis @ misfit.mean if len(misfit.mean) else np.zeros(base.shape),
        gain=gain,
        basis=across,
        shrink=shrink,
        count=weight / floor.dependence,
        unsure=np.sqrt(variance),
    )


def _directions(
    basis: FloatArray, variance: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Orthonormal directions (F, K) and how much of each to take off, (K, C)."""
    if not basis.shape[1]:
        return basis, variance
    across, triangle = np.linalg.qr(basis)
    # harmonics over whole cycles are orthogonal already, so the triangle is near diagonal
    left = np.sqrt(noise / (noise + triangle**2 @ variance))
    return across, 1.0 - left
