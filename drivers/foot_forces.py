"""From counts to the ground's force on each foot: pure."""

from collections.abc import Sequence

import numpy as np

from drivers.ati_calibration import Calibration
from drivers.settings import ForceSensorSettings
from model.signals import FootForces, ForceRecord, readonly


def foot_forces(
    record: ForceRecord | None,
    calibrations: Sequence[Calibration | None],
    settings: ForceSensorSettings,
) -> FootForces:
    """Calibrate one record.

    Args:
        record: The record, None if there never was one.
        calibrations: Calibration of each leg's transducer, None where unknown, N of them.
        settings: Transducer number, rotation and bias of each leg.

    Returns:
        Forces in body axes. NaN and ``valid`` False where a leg has no transducer, no calibration, is
        not in the record, or is saturated.
    """
    count = len(settings.names)
    force = np.full((count, 3), np.nan)
    valid = np.zeros(count, dtype=bool)
    if record is not None:
        for leg, calibration in enumerate(calibrations):
            index = int(settings.transducers[leg]) - 1
            if calibration is None or index < 0:
                continue
            if not record.present[index] or record.saturated[index]:
                continue
            sensed = record.counts[index, :3] / calibration.counts_per_n - settings.bias_n[leg]
            c, s = np.cos(settings.yaw_rad[leg]), np.sin(settings.yaw_rad[leg])
            force[leg] = c * sensed[0] - s * sensed[1], s * sensed[0] + c * sensed[1], sensed[2]
            valid[leg] = True
    t_ns = -1 if record is None else record.t_ns
    return FootForces(t_ns, readonly(force), readonly(valid))
