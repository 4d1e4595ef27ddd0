"""The first part of a usual tick of a block, compiled: what was heard, and the step of the process.

A tick is usual if nothing in it needs words: the robot stands on its feet and moves, encoders and time are
in order, nothing was lost before. What is not usual is left to ``model.estimator.filter``.
"""

import numpy as np

from model.compiled import COUNT, FLAG, compile_for, compiled, given, out
from model.estimator.block.places import (
    AIRBORNE,
    ANCHORED,
    ANSWER_NS,
    APART,
    APART_COVARIANCE,
    APART_SHARE,
    APART_VELOCITY,
    COVARIANCE,
    FAR_POSES,
    FINE_NS,
    FORCE_NS,
    GYRO_NS,
    HEARD,
    IDLE_NS,
    LOST,
    MEAN,
    MEAN_BEFORE,
    NOISE,
    REJECTED,
    RESTING,
    ROWS,
    SHARE,
    SLIP,
    STRAIN,
    SWAY,
    T_NS,
    TOTAL,
    TRANSITION,
    TWIST,
    USED_NS,
    matrix,
    vector,
)
from model.estimator.senses import feet_kernel, share_kernel
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.sources import ABSOLUTE
from model.estimator.stride import stride_kernel
from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.estimate import FIXED, NEVER

UNUSUAL = -1
FRESH, WHOLE, USE = 1, 2, 4  # of the forces of a tick


@compiled
def predict_kernel(
    k: int, real: FloatArray, whole: IntArray, flags: BoolArray, spare: FloatArray, at: IntArray,
    t_ns: IntArray, feet: FloatArray, feet_velocity: FloatArray, force_ns: IntArray,
    force_n: FloatArray, force_there: BoolArray, stiffness: FloatArray, mu: FloatArray,
    anisotropy: FloatArray, design: FloatArray, drift: FloatArray, settings: Record,
) -> int:  # fmt: skip
    """Listen to the forces of tick k, and take the step of the process that leads to it.

    Args:
        k: The tick; the state before it is in row k.
        real: Of ``StateRows``, as are the next three. Out: mean and transition in row k + 1.
        whole: Out: times in row k + 1.
        flags: Out: companions at rest in row k + 1.
        spare: Out: noise, and the answers of the model.
        at: Of ``Shapes``.
        t_ns: Of ``BlockInputs``, as are the next five.
        feet: (T, N, 3) [m].
        feet_velocity: (T, N, 3) [m/s].
        force_ns: (T,).
        force_n: (T, N, 3) [N].
        force_there: (T, N).
        stiffness: Of the robot file, (N,) [N/m].
        mu: Of the robot file, (N,).
        anisotropy: (N, 2).
        design: Of ``tolerance_kernel``, (M, N + 4).
        drift: Of ``process.Beside``, (3,).
        settings: Of ``record_of``.

    Returns:
        What there is of the forces, a sum of ``FRESH``, ``WHOLE`` and ``USE``; -1 for a tick that is not
        usual.
    """
    setting, legs, robots = settings[0], mu.size, design.shape[0]
    before, now, past, present = real[k], real[k + 1], whole[k], whole[k + 1]
    reals, wholes, truths, spares = at[0], at[1], at[2], at[3]
    was, becomes = flags[k], flags[k + 1]
    if was[truths[LOST]] or was[truths[AIRBORNE]] or past[wholes[FAR_POSES]] != 0:
        return UNUSUAL
    if past[wholes[REJECTED] + ABSOLUTE * legs] != 0 or past[wholes[T_NS]] == NEVER:
        return UNUSUAL
    dt_s = (t_ns[k] - past[wholes[T_NS]]) * 1e-9
    if not 0.0 < dt_s <= setting["longest_gap_s"]:
        return UNUSUAL
    finite, still = feet_kernel(feet[k], feet_velocity[k], setting["idle_speed"])
    if not finite:
        return UNUSUAL
    heard, share = 0, matrix(spare, spares[HEARD], legs, 3)
    heard_ns, steady, total = past[wholes[FORCE_NS]], True, np.nan
    newest, weight = force_ns[k], setting["weight_n"]
    some = False
    if (
        newest != NEVER
        and newest > heard_ns
        and (t_ns[k] - newest) * 1e-9 <= setting["stale_force_s"]
    ):
        some, total, steady = share_kernel(
            force_n[k], force_there[k], weight, vector(before, reals[SHARE], legs),
            setting["steady_load"], share,
        )  # fmt: skip
    if some:
        heard, heard_ns = FRESH, newest
        if np.isfinite(total):
            heard += WHOLE
            if total < setting["airborne_share"] * weight:
                return UNUSUAL
        used_ns = past[wholes[USED_NS]]
        if used_ns == NEVER or (t_ns[k] - used_ns) * 1e-9 > setting["force_period_s"] - 1e-3:
            heard += USE
    else:
        total = np.nan
        for leg in range(legs):
            for i in range(3):
                share[leg, i] = np.nan
    if heard_ns != NEVER and (t_ns[k] - heard_ns) * 1e-9 > setting["stale_force_s"]:
        return UNUSUAL
    idle_ns = np.int64(NEVER)
    if still and (not some or steady):
        idle_ns = past[wholes[IDLE_NS]] if past[wholes[IDLE_NS]] != NEVER else t_ns[k]
        if (t_ns[k] - idle_ns) * 1e-9 >= setting["idle_time_s"]:
            return UNUSUAL
    size = FIXED + 2 * legs
    reason = stride_kernel(
        vector(before, reals[MEAN], size), matrix(before, reals[COVARIANCE], size, size), feet[k],
        feet_velocity[k], stiffness, mu, anisotropy, settings, vector(spare, 0, 0),
        vector(spare, 0, 0), design, dt_s, 0, vector(before, reals[STRAIN], 3), drift,
        matrix(before, reals[TWIST], robots, 3), matrix(was, truths[RESTING], robots, legs),
        matrix(before, reals[APART], robots, 3),
        matrix(spare, spares[ROWS], 1 + 3 * legs, 6 + 3 * legs),
        matrix(spare, spares[SLIP], legs, 2), vector(spare, spares[SWAY], 2),
        matrix(now, reals[TWIST], robots, 3), matrix(becomes, truths[RESTING], robots, legs),
        matrix(now, reals[APART], robots, 3), matrix(spare, spares[APART_VELOCITY], robots, 3),
        matrix(spare, spares[APART_SHARE], robots, legs),
        matrix(now, reals[APART_COVARIANCE], 3, 3), vector(now, reals[MEAN_BEFORE], size),
        matrix(now, reals[TRANSITION], size, size), matrix(spare, spares[NOISE], size, size),
    )  # fmt: skip
    if reason != 0:
        return UNUSUAL
    spare[spares[TOTAL]] = total / weight
    present[wholes[T_NS]], present[wholes[FORCE_NS]] = t_ns[k], heard_ns
    present[wholes[USED_NS]] = t_ns[k] if heard & USE else past[wholes[USED_NS]]
    present[wholes[IDLE_NS]], present[wholes[ANSWER_NS]] = idle_ns, t_ns[k]
    fine_ns = past[wholes[FINE_NS]]
    present[wholes[FINE_NS]] = fine_ns if fine_ns != NEVER else t_ns[k]
    present[wholes[GYRO_NS]], present[wholes[FAR_POSES]] = past[wholes[GYRO_NS]], 0
    becomes[truths[LOST]], becomes[truths[AIRBORNE]] = False, False
    becomes[truths[ANCHORED]] = was[truths[ANCHORED]]
    return heard


def prepare() -> None:
    """Load or make the machine code now; that of the filter has to be there already."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        predict_kernel, COUNT, *out(2), *out(2, kind=COUNT), *out(2, kind=FLAG), *out(1),
        *given(2, kind=COUNT), *given(1, kind=COUNT), *given(3, 3), *given(1, kind=COUNT), *given(3),
        *given(2, kind=FLAG), *given(1, 1, 2, 2, 1), settings,
    )  # fmt: skip
