"""What a force-torque sensor at a leg's base says about the foot: offset, leg gravity, cross-talk.

A reading s (6,) of a sensor that carries a leg is modelled as::

    s = C (w + gravity(q)) + offset      w: the ground's wrench on the foot, at the sensor's origin
    w = (I + D) (s - a(q))               a(q): what it reads with the foot in the air

a(q) is a Fourier series in the shaft angle q: the offset and, because the linkage turns once a turn of
the shaft, the weight of the leg's links in every posture. I + D is the inverse of C. All in sensor axes.

The idea follows "In-Situ Calibration of Six-Axis Force/Torque Transducers on a Six-Legged Robot" (ASME
J. Dyn. Sys. Meas. Control 147(3) 031003), of which only the abstract was at hand: the equations are ours.
Valid while the leg moves slowly: its inertia is left out.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.values.arrays import FloatArray, readonly

AXES = ("Fx", "Fy", "Fz", "Tx", "Ty", "Tz")
METHODS = ("bias", "in-situ")


@dataclass(frozen=True, slots=True, eq=False)
class ForceCalibration:
    """Calibration of N sensors to foot wrenches.

    Attributes:
        legs: Leg names, N of them.
        serials: Serial number of each leg's sensor, empty where unknown.
        unloaded: Fourier coefficients of a(q), (N, 6, 1 + 2 H) [N, N m]: constant, cos q, sin q,
            cos 2q, ... NaN for a leg that was not calibrated.
        correction: D, (N, 6, 6); entries mix N and N m as their row and column say.
        standard_error: Of a(q) at mid-stance, (N, 6) [N, N m]; NaN where unknown.
        method: ``bias`` (constant offsets only) or ``in-situ``.
        date: When it was made, ISO 8601.
        logs: Names of the logs it was made from.
    """

    legs: tuple[str, ...]
    serials: tuple[str, ...]
    unloaded: FloatArray
    correction: FloatArray
    standard_error: FloatArray
    method: str
    date: str
    logs: tuple[str, ...]

    def __post_init__(self) -> None:
        count = len(self.legs)
        fits = (
            len(self.serials) == count
            and self.unloaded.ndim == 3
            and self.unloaded.shape[:2] == (count, 6)
            and self.unloaded.shape[2] % 2 == 1
            and self.correction.shape == (count, 6, 6)
            and self.standard_error.shape == (count, 6)
        )
        if not fits:
            raise ModelError(
                f"a calibration of {count} sensors needs unloaded (N, 6, 1 + 2 H), correction "
                f"(N, 6, 6) and standard_error (N, 6), not {self.unloaded.shape}, "
                f"{self.correction.shape} and {self.standard_error.shape}"
            )

    @property
    def harmonics(self) -> int:
        """Number of harmonics H."""
        return int(self.unloaded.shape[2] - 1) // 2

    def unloaded_wrench(self, angle_rad: FloatArray) -> FloatArray:
        """Return a(q), (..., N, 6) [N, N m].

        Args:
            angle_rad: Shaft angles, (..., N) [rad]. NaN gives NaN, but only for a leg whose reading
                depends on the angle.
        """
        rows = fourier_rows(angle_rad, self.harmonics)
        steady = ~(self.unloaded[:, :, 1:] != 0).any(axis=(1, 2))  # (N,)
        rows = np.where(steady[:, None] & (np.arange(rows.shape[-1]) > 0), 0.0, rows)
        wrench: FloatArray = np.einsum("...nh,nah->...na", rows, self.unloaded)
        return wrench

    def foot_wrench(self, sensed: FloatArray, angle_rad: FloatArray) -> FloatArray:
        """Return the ground's wrench on each foot, sensor axes and origin, (..., N, 6) [N, N m].

        Args:
            sensed: Readings, (..., N, 6) [N, N m].
            angle_rad: Shaft angles, (..., N) [rad].
        """
        free = sensed - self.unloaded_wrench(angle_rad)
        corrected: FloatArray = free + np.einsum("nij,...nj->...ni", self.correction, free)
        return corrected


def fourier_rows(angle_rad: FloatArray, harmonics: int) -> FloatArray:
    """Return 1, cos q, sin q, ..., cos Hq, sin Hq, (..., 1 + 2 H)."""
    turns = np.multiply.outer(np.asarray(angle_rad, dtype=np.float64), np.arange(1, harmonics + 1))
    rows = np.empty((*turns.shape[:-1], 1 + 2 * harmonics))
    rows[..., 0] = 1.0
    rows[..., 1::2], rows[..., 2::2] = np.cos(turns), np.sin(turns)
    return rows


@dataclass(frozen=True, slots=True)
class CalibrationOrigin:
    """Where a calibration comes from.

    Attributes:
        serials: Serial number of each sensor, "" where it is not known.
        date: When it was made.
        logs: Names of the logs that it was made from.
    """

    serials: tuple[str, ...]
    date: str = ""
    logs: tuple[str, ...] = ()


def bias_only(
    legs: tuple[str, ...],
    origin: CalibrationOrigin,
    bias: FloatArray,
    standard_error: FloatArray,
) -> ForceCalibration:
    """Return a calibration that only subtracts constants, (N, 6) [N, N m]."""
    return ForceCalibration(
        legs=legs,
        serials=origin.serials,
        unloaded=readonly(bias[:, :, None].copy()),
        correction=readonly(np.zeros((len(legs), 6, 6))),
        standard_error=readonly(standard_error.copy()),
        method="bias",
        date=origin.date,
        logs=origin.logs,
    )
