"""Residuals in units of what is expected without a new cause: mean square 1, counted as independent.

Each frame is divided by its noise and by the root of the autocorrelation time; along the harmonics of the
phase, where references scatter too, it is shrunk by what they leave uncertain.
"""

from dataclasses import dataclass

import numpy as np

from gap.interfaces import used
from gap.residuals.floor import ExpectedMisfit, Floor, phase_basis
from gap.residuals.parts import TrialPart
from model.values.arrays import FloatArray

SMALLEST = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class Whitener:
    """A linear map for one part, and the expected misfit that is subtracted first.

    Attributes:
        expected: Misfit that references predict, (F, C).
        gain: Root of the weight over the noise; 0 where nothing is compared, (F, C).
        basis: Orthonormal directions, (F, K).
        shrink: What is subtracted along them, 0 to 1, (K, C).
        count: Frames that count as independent, of each frame, (F, C).
        unsure: Standard deviation of a frame in the channel's unit, misfit and noise together, (C,).
    """

    expected: FloatArray
    gain: FloatArray
    basis: FloatArray
    shrink: FloatArray
    count: FloatArray
    unsure: FloatArray

    def whiten(self, error: FloatArray) -> FloatArray:
        """Map measured minus predicted, (F, C); NaN becomes 0."""
        new = np.nan_to_num(error - self.expected)
        scaled = np.where(self.gain > 0.0, new, 0.0) * self.gain
        if self.basis.shape[1]:
            along = self.shrink * (self.basis.T @ scaled)
            scaled = scaled - (self.basis @ along) * (self.gain > 0.0)
        return scaled

    def whiten_change(self, change: FloatArray) -> FloatArray:
        """Map by how much an error changes, (F, C): the expected misfit does not."""
        return self.whiten(change + self.expected)


def make_whitener(part: TrialPart, floor: Floor, base: FloatArray) -> Whitener:
    """Make the map.

    The unchanged simulator, ``base`` (F, C), is compared where it has an answer.
    """
    on = used(part.observation) & np.isfinite(base)
    weight = np.where(on, part.observation.weight, 0.0)
    sigma = np.fmax(floor.sigma, SMALLEST)
    gain = np.sqrt(weight) / (sigma * np.sqrt(floor.dependence))
    misfit = floor.expect(part.condition)
    basis = phase_basis(part)[:, : len(misfit.mean)]
    if len(misfit.mean) > basis.shape[1]:  # a trial without phase: only what is constant is known
        misfit = ExpectedMisfit(misfit.mean[: basis.shape[1]], misfit.variance[: basis.shape[1]])
    across, shrink = _directions(basis, misfit.variance, sigma**2 * floor.dependence)
    variance = sigma**2 + misfit.variance.sum(axis=0)
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
