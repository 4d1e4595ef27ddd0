"""The constant a sensor reads while nothing touches it, and whether nothing really did.

The samples are cut into blocks in time. A sensor at rest has blocks whose means differ by what the noise
inside them explains; one that was touched, or is warming up, has not.
"""

from dataclasses import dataclass

import numpy as np

from model.errors import ModelError
from model.values.arrays import BoolArray, FloatArray, readonly
from model.values.force_calibration import AXES

BLOCKS = 10
LEAST_SAMPLES = 50
# Largest standard deviation and largest difference between block means of a sensor left alone. An ATI
# Gamma SI-130-10 resolves 0.025 N and 0.00125 N m; a hand or a swinging leg moves newtons.
LARGEST_SPREAD = np.array([0.5, 0.5, 0.5, 0.025, 0.025, 0.025])
LARGEST_DRIFT = np.array([0.2, 0.2, 0.2, 0.01, 0.01, 0.01])


@dataclass(frozen=True, slots=True, eq=False)
class Bias:
    """Bias of N sensors.

    Attributes:
        mean: (N, 6) [N, N m]; NaN for a sensor without enough samples.
        standard_error: Of the mean, from the blocks, (N, 6).
        spread: Standard deviation of a sample, (N, 6).
        drift: Largest difference between two block means, (N, 6).
        samples: Samples used of each sensor, (N,).
    """

    mean: FloatArray
    standard_error: FloatArray
    spread: FloatArray
    drift: FloatArray
    samples: tuple[int, ...]

    @property
    def known(self) -> BoolArray:
        """Which sensors have a bias, (N,)."""
        return np.asarray(np.isfinite(self.mean).all(axis=1))


def measure_bias(sensed: FloatArray) -> Bias:
    """Average readings.

    Args:
        sensed: (T, N, 6) [N, N m], NaN where a sensor was absent or saturated.
    """
    count = sensed.shape[1]
    mean, error, spread, drift = (np.full((count, 6), np.nan) for _ in range(4))
    samples = []
    for leg in range(count):
        sound = sensed[np.isfinite(sensed[:, leg]).all(axis=1), leg]
        samples.append(len(sound))
        if len(sound) < LEAST_SAMPLES:
            continue
        blocks = np.array([block.mean(axis=0) for block in np.array_split(sound, BLOCKS)])
        mean[leg] = sound.mean(axis=0)
        error[leg] = blocks.std(axis=0, ddof=1) / np.sqrt(BLOCKS)
        spread[leg] = sound.std(axis=0, ddof=1)
        drift[leg] = np.ptp(blocks, axis=0)
    return Bias(readonly(mean), readonly(error), readonly(spread), readonly(drift), tuple(samples))


def require_rest(bias: Bias, legs: tuple[str, ...]) -> None:
    """Refuse a bias of sensors that were touched or drifted.

    Raises:
        ModelError: A sensor was not at rest, or none gave enough samples.
    """
    if not bias.known.any():
        raise ModelError(f"no sensor gave {LEAST_SAMPLES} sound samples; measure for longer")
    for what, values, limits in (
        ("spreads by", bias.spread, LARGEST_SPREAD),
        ("wanders by", bias.drift, LARGEST_DRIFT),
    ):
        beyond = np.argwhere(bias.known[:, None] & (values > limits))
        if len(beyond):
            leg, axis = beyond[0].tolist()
            unit = "N" if axis < 3 else "N m"
            raise ModelError(
                f"{legs[leg]}: {AXES[axis]} {what} {values[leg, axis]:.3g} {unit} (limit "
                f"{limits[axis]:g}): the robot was touched or the sensor is warming up; "
                "leave it hanging free and measure again"
            )
