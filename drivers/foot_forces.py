"""From counts to the ground's force on each foot: pure."""

from collections.abc import Sequence

import numpy as np

from drivers.ati_calibration import Calibration
from drivers.settings import ForceSensorSettings
from model.signals import FloatArray, FootForces, ForceRecord, readonly


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
    sensed = np.full((len(settings.names), 6), np.nan)
    for leg, calibration in enumerate(calibrations):
        index = int(settings.transducers[leg]) - 1
        if calibration is None or index < 0:
            continue
        if record.present[index] and not record.saturated[index]:
            sensed[leg, :3] = record.counts[index, :3] / calibration.counts_per_n
            sensed[leg, 3:] = record.counts[index, 3:] / calibration.counts_per_nm
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
    sensed = sensed_wrenches(record, calibrations, settings)
    x, y, z = foot_wrenches(sensed, settings, angle_rad)[:, :3].T
    c, s = np.cos(settings.yaw_rad), np.sin(settings.yaw_rad)
    force = np.stack([c * x - s * y, s * x + c * y, z], axis=1)
    valid = np.isfinite(force).all(axis=1)
    force[~valid] = np.nan
    return FootForces(record.t_ns, readonly(force), readonly(valid))
