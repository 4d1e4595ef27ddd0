"""From counts to the ground's force on each foot: pure."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from drivers.ati_calibration import Calibration
from drivers.settings import ForceSensorSettings
from model.signals import FloatArray, FootForces, ForceRecord, readonly

UNKNOWN = (np.nan,) * 6


def sensed_wrenches(
    record: ForceRecord, calibrations: Sequence[Calibration | None], settings: ForceSensorSettings
) -> FloatArray:
    """Return what the transducers read, sensor axes, (N, 6) [N, N m], nothing subtracted.

    Args:
        record: The record.
        calibrations: Calibration of each leg's transducer, None where unknown, N of them.
        settings: Transducer number of each leg.

    Returns:
        NaN where a leg has no transducer, no calibration, is not in the record, or is saturated.
    """
    return np.array(_rows(record, calibrations, settings))


def _rows(
    record: ForceRecord, calibrations: Sequence[Calibration | None], settings: ForceSensorSettings
) -> list[tuple[float, ...]]:
    """The same as plain numbers, a row a leg: six rows are done sooner one by one."""
    counts: list[list[int]] = record.counts.tolist()
    heard = (record.present & ~record.saturated).tolist()
    sensed: list[tuple[float, ...]] = [UNKNOWN] * len(settings.names)
    numbered = zip(settings.transducers.tolist(), calibrations, strict=False)
    for leg, (number, calibration) in enumerate(numbered):
        if calibration is None or number < 1 or not heard[number - 1]:
            continue
        n, nm = calibration.counts_per_n, calibration.counts_per_nm
        fx, fy, fz, tx, ty, tz = counts[number - 1]
        sensed[leg] = (fx / n, fy / n, fz / n, tx / nm, ty / nm, tz / nm)
    return sensed


def foot_wrenches(
    sensed: FloatArray, settings: ForceSensorSettings, angle_rad: FloatArray
) -> FloatArray:
    """Return the ground's wrench on each foot at the sensors, sensor axes, (..., N, 6) [N, N m].

    The calibration file, where there is one, takes the place of the robot file's constant bias.

    Args:
        sensed: Readings, (..., N, 6).
        settings: Calibration or bias of each leg.
        angle_rad: Shaft angles, (..., N); a calibrated leg whose weight shows needs its own.
    """
    if settings.calibration is not None:
        return settings.calibration.foot_wrench(sensed, angle_rad)
    wrench = sensed.copy()
    wrench[..., :3] -= settings.bias_n
    return wrench


def foot_forces(
    record: ForceRecord | None,
    calibrations: Sequence[Calibration | None],
    settings: ForceSensorSettings,
    angle_rad: FloatArray,
) -> FootForces:
    """Calibrate one record.

    Args:
        record: The record, None if there never was one.
        calibrations: Calibration of each leg's transducer, None where unknown, N of them.
        settings: Transducer number, rotation, bias and in-situ calibration of each leg.
        angle_rad: Shaft angles, (N,), NaN where unknown.

    Returns:
        Forces in body axes. NaN and ``valid`` False where a leg has no transducer, no calibration, is
        not in the record, is saturated, or is not in the calibration file that is in use.
    """
    count = len(settings.names)
    if record is None:
        nothing = np.full((count, 3), np.nan)
        return FootForces(-1, readonly(nothing), readonly(np.zeros(count, dtype=bool)))
    sensed = _rows(record, calibrations, settings)
    cosines, sines, biases = _mounting(settings)
    if settings.calibration is not None:
        sensed = foot_wrenches(np.array(sensed), settings, angle_rad).tolist()
        biases = [[0.0, 0.0, 0.0]] * count
    found = []
    for row, c, s, (bx, by, bz) in zip(sensed, cosines, sines, biases, strict=True):
        x, y = row[0] - bx, row[1] - by
        found.append((c * x - s * y, s * x + c * y, row[2] - bz))
    force = np.array(found)
    valid = np.isfinite(force).all(axis=1)
    if False in valid.tolist():
        force[~valid] = np.nan
    return FootForces(record.t_ns, readonly(force), readonly(valid))


@lru_cache(maxsize=4)
def _mounting(
    settings: ForceSensorSettings,
) -> tuple[list[float], list[float], list[list[float]]]:
    """Cosine and sine of each sensor's yaw, and its bias: they never change."""
    yaw = settings.yaw_rad
    return np.cos(yaw).tolist(), np.sin(yaw).tolist(), settings.bias_n.tolist()
