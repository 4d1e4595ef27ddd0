"""From counts to the ground's force on each foot: pure."""

from collections.abc import Sequence
from math import isfinite

import numpy as np

from drivers.ati.calibration import Calibration
from drivers.ati.settings import ForceSensorSettings
from model.values.arrays import FloatArray, readonly
from model.values.legs import FootForces
from model.values.readings import ForceRecord

UNKNOWN = (np.nan,) * 6
NO_FORCE = (np.nan,) * 3


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
    present, saturated = record.present.tolist(), record.saturated.tolist()
    sensed: list[tuple[float, ...]] = [UNKNOWN] * len(settings.names)
    numbered = zip(settings.transducers.tolist(), calibrations, strict=False)
    for leg, (number, calibration) in enumerate(numbered):
        if calibration is None or number < 1:
            continue
        if not present[number - 1] or saturated[number - 1]:
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


def no_forces(count: int) -> FootForces:
    """What is known of the forces on so many feet before the first record."""
    nothing = np.full((count, 3), np.nan)
    return FootForces(-1, readonly(nothing), readonly(np.zeros(count, dtype=bool)))


class ForceScales:
    """Calibrates records, one a tick, with what never changes worked out beforehand.

    Args:
        calibrations: Calibration of each leg's transducer, None where unknown, N of them.
        settings: Transducer number, rotation, bias and in-situ calibration of each leg.
    """

    def __init__(
        self, calibrations: Sequence[Calibration | None], settings: ForceSensorSettings
    ) -> None:
        self._calibrations = calibrations
        self._settings = settings
        yaw = settings.yaw_rad
        in_situ = settings.calibration is not None
        bias_n = np.zeros_like(settings.bias_n) if in_situ else settings.bias_n
        self._mounting = tuple(
            zip(
                np.cos(yaw).tolist(),
                np.sin(yaw).tolist(),
                settings.up.tolist(),
                bias_n.tolist(),
                strict=True,
            )
        )

    def forces(self, record: ForceRecord, angle_rad: FloatArray) -> FootForces:
        """Calibrate one record.

        Args:
            record: The record.
            angle_rad: Shaft angles, (N,), NaN where unknown.

        Returns:
            Forces in body axes. NaN and ``valid`` False where a leg has no transducer, no calibration, is
            not in the record, is saturated, or is not in the calibration file that is in use.
        """
        sensed = _rows(record, self._calibrations, self._settings)
        if self._settings.calibration is not None:
            sensed = foot_wrenches(np.array(sensed), self._settings, angle_rad).tolist()
        forces: list[float] = []
        valid = []
        for (fx, fy, fz, *_), (c, s, up, (bx, by, bz)) in zip(sensed, self._mounting, strict=True):
            x, y = fx - bx, up * (fy - by)
            force = (c * x - s * y, s * x + c * y, up * (fz - bz))
            whole = isfinite(force[0] + force[1] + force[2])
            forces += force if whole else NO_FORCE
            valid.append(whole)
        force_n = readonly(np.array(forces).reshape(-1, 3))
        return FootForces(record.t_ns, force_n, readonly(np.array(valid)))

    def of_newest(self, records: Sequence[Sequence[ForceRecord]]) -> list[FootForces | None]:
        """Calibrate the newest record of each tick at once; the same numbers as ``forces``.

        Args:
            records: Of each tick, oldest first.

        Returns:
            None where a tick has none, and everywhere where a calibration file asks for the shafts' angles.
        """
        calibrated: list[FootForces | None] = [None] * len(records)
        places = [place for place, own in enumerate(records) if own]
        if not places or self._settings.calibration is not None:
            return calibrated
        newest = [records[place][-1] for place in places]
        counts = np.array([one.counts for one in newest], dtype=np.float64)
        usable = np.array([one.present for one in newest])
        usable &= ~np.array([one.saturated for one in newest])
        force = np.full((len(places), len(self._mounting), 3), np.nan)
        numbered = zip(self._settings.transducers.tolist(), self._calibrations, strict=False)
        for leg, (number, calibration) in enumerate(numbered):
            if calibration is None or number < 1:
                continue
            c, s, up, (bx, by, bz) = self._mounting[leg]
            fx, fy, fz = (counts[:, number - 1, :3] / calibration.counts_per_n).T
            x, y = fx - bx, up * (fy - by)
            force[:, leg, 0], force[:, leg, 1] = c * x - s * y, s * x + c * y
            force[:, leg, 2] = up * (fz - bz)
            force[~usable[:, number - 1], leg] = np.nan
        whole = np.isfinite(force[..., 0] + force[..., 1] + force[..., 2])
        force[~whole] = np.nan
        readonly(force)
        readonly(whole)
        for row, (place, one) in enumerate(zip(places, newest, strict=True)):
            calibrated[place] = FootForces(one.t_ns, force[row], whole[row])
        return calibrated
