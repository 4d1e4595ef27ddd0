"""What follows from measured columns where it was not measured: shaft speeds from shaft angles."""

from dataclasses import replace

import numpy as np

from model.motion.differentiate import centred_rate
from model.values.arrays import readonly
from record.trial.header import LEGGED
from record.trial.table_check import TableFinding
from record.trial.trial import Trial

# Samples on either side that give the speed [s]; more where they lie farther apart.
HALF_WINDOW_S = 0.05
FEWEST_PERIODS = 1.5


def with_speeds(trial: Trial) -> tuple[Trial, tuple[TableFinding, ...]]:
    """Return a trial of a legged robot whose shafts with angles and without any speed have one, and how.

    The estimator's model is of speeds; a bench compares angles. The header says it too (``derived``).
    """
    angles, speeds = np.isfinite(trial.shaft_rad), np.isfinite(trial.shaft_rad_s)
    wanted = np.flatnonzero((angles.sum(axis=0) > 1) & ~speeds.any(axis=0))
    if not len(wanted) or trial.header.kind != LEGGED:
        return trial, ()
    half_s = max(HALF_WINDOW_S, FEWEST_PERIODS * float(np.median(np.diff(trial.time_s))))
    t_ns = np.round((trial.time_s - trial.time_s[0]) * 1e9).astype(np.int64)
    rates = trial.shaft_rad_s.copy()
    rates[:, wanted] = centred_rate(t_ns, trial.shaft_rad[:, wanted], round(half_s * 1e9))
    names = ", ".join(f"shaft_{trial.joints[at]}_rad_s" for at in wanted)
    how = f"from angles, their slope over {2 * half_s:.2g} s"
    header = replace(trial.header, derived=(*trial.header.derived, f"{names}: {how}"))
    finding = TableFinding("derived", names, len(wanted), 0, f"not measured; worked out {how}")
    return replace(trial, header=header, shaft_rad_s=readonly(rates)), (finding,)
