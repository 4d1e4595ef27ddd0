"""Naive against fitted parameters: the fit, the errors of both, and the paper's table."""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.traction.force_scale import force_scale
from model.values.arrays import BoolArray, FloatArray
from model.values.parameters import ContactParameters
from robot.report.contact_fit import NAIVE_MU, NAIVE_STIFFNESS, Fits
from robot.report.walk_frames import WalkFrames

QUANTITIES = ("heading", "side", "turning", "roll", "pitch", "Fx", "Fy", "Fz")
UNITS = ("mm/s", "mm/s", "mrad/s", "mrad", "mrad", "N", "N", "N")
TO_UNITS = np.array([1e3, 1e3, 1e3, 1e3, 1e3, 1.0, 1.0, 1.0])
# How the paper's errors changed from fitted to naive parameters [%] (sec:tripod).
PAPER_CHANGE = (14.0, -5.5, 1.5, -22.0, 24.0, 4.0, 3.0, 2.0)


@dataclass(frozen=True, slots=True, eq=False)
class Sensitivity:
    """Errors of the model on frames that it was not fitted to, in the units of ``UNITS``.

    Attributes:
        fitted: RMSE under fitted parameters, (8,), in the order of ``QUANTITIES``.
        naive: Under naive parameters, (8,).
        frames: Frames judged.
        without_answer: Frames left out because either model had none.
        clamped: Frames whose force scale would have been negative, fitted and naive.
    """

    fitted: FloatArray
    naive: FloatArray
    frames: int
    without_answer: int
    clamped: tuple[int, int]

    @property
    def change(self) -> FloatArray:
        """Change from fitted to naive, (8,) [%]; NaN where the fitted error is 0."""
        there = self.fitted > 0
        ratio = np.divide(self.naive, self.fitted, out=np.full(8, np.nan), where=there)
        percent: FloatArray = 100 * (ratio - 1)
        return percent

    @property
    def rows(self) -> list[tuple[object, ...]]:
        """Each quantity: its name, unit, fitted and naive RMSE, change and the paper's change [%]."""
        columns = (QUANTITIES, UNITS, self.fitted, self.naive, self.change, PAPER_CHANGE)
        return list(zip(*columns, strict=True))


def compare(walk: WalkFrames, fits: Fits) -> Sensitivity:
    """Judge fitted and naive parameters on the same frames.

    Raises:
        ModelError: The model has an answer for none of them.
    """
    legs = walk.feet.shape[1]
    naive = ContactParameters(
        np.full(legs, NAIVE_STIFFNESS * fits.weight_n),
        np.full(legs, NAIVE_MU),
        np.zeros((legs, 2)),
    )
    (fitted, known, fitted_clamped), (poor, known_too, naive_clamped) = (
        _errors(walk, contact, fits) for contact in (fits.contact, naive)
    )
    both = known & known_too
    if not both.any():
        raise ModelError("the model has no answer for any of the frames to judge by")
    rmse = [
        TO_UNITS * [np.sqrt(np.mean(error[both] ** 2)) for error in errors]
        for errors in (fitted, poor)
    ]
    return Sensitivity(
        fitted=rmse[0],
        naive=rmse[1],
        frames=int(both.sum()),
        without_answer=int((~both).sum()),
        clamped=(int(fitted_clamped[both].sum()), int(naive_clamped[both].sum())),
    )


def _errors(
    walk: WalkFrames, contact: ContactParameters, fits: Fits
) -> tuple[list[FloatArray], BoolArray, BoolArray]:
    """Error of each quantity by frame (or frame and foot), which frames have one, which were clamped."""
    solved = solve_frames(walk.motion, contact, fits.weight_n, law=fits.law)
    if fits.law is FrictionLaw.VISCOUS:
        fitted = force_scale(solved.force_xy_B, walk.force[..., :2])
        scale, clamped = fitted.scale, fitted.clamped
    else:  # Coulomb's forces are in newtons
        scale, clamped = np.ones(walk.count), np.zeros(walk.count, dtype=bool)
    velocity = solved.velocity_B - walk.velocity
    horizontal = scale[:, None, None] * solved.force_xy_B - walk.force[..., :2]
    tilt = solved.pose[:, 1::-1] - walk.slope
    vertical = solved.load_n - walk.force[..., 2]
    errors = [*velocity.T, *tilt.T, horizontal[..., 0], horizontal[..., 1], vertical]
    return errors, solved.valid & np.isfinite(scale), clamped
