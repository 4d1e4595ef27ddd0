"""The last part of a usual tick of a block, compiled: the state after it, and what is reported of it."""

import numpy as np

from model.compiled import COUNT, FLAG, compile_for, compiled, given, out
from model.estimator.block.places import (
    APART_COVARIANCE,
    APART_SHARE,
    BALANCE,
    BODY,
    BY_FOOT,
    CONTACT,
    COVARIANCE,
    COVARIANCE_BEFORE,
    EXPECTED,
    FIT,
    FORCE,
    FORCE_AGREE,
    FORCE_APART,
    FORCE_SPREAD,
    HEARD,
    HEIGHT,
    INFORMATION,
    INNOVATION,
    KINDS,
    LIKELIHOOD,
    MEAN,
    MEAN_BEFORE,
    MISFIT,
    NIS,
    NUMBERS,
    PULL,
    RECORDS,
    REJECTED,
    REJECTS,
    RIDGE,
    ROWS,
    SHAKING,
    SINCE,
    SLIP,
    SLIPPING,
    SOURCE_BIAS,
    SOURCE_DOF,
    SOURCE_NIS,
    SQUARE,
    STANDING_OUT,
    STRAIN,
    SUSPECTED,
    TILT,
    TOTAL,
    ZERO,
    matrix,
    vector,
)
from model.estimator.block.predict import FRESH, UNUSUAL, WHOLE
from model.estimator.health import contradicts_kernel, notable_kernel, strain_kernel
from model.estimator.kalman import LOG_TURN, settle_kernel, sound_kernel
from model.estimator.report import report_kernel
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.shaft_zeros import EVERY, NO_LEG, SMALL_RAD, evidence_kernel
from model.estimator.sources import ABSOLUTE, places_needed
from model.estimator.tolerances import robots_beside
from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.estimate import FIXED, YAW

ZEROS_DUE, NOTABLE = 1, 2  # what is left to do for a tick
NOT_MEASURED = -1


@compiled
def settle_in_row_kernel(
    k: int, heard: int, counted: tuple[int, int, float, float], error: FloatArray,
    spread: FloatArray, real: FloatArray, whole: IntArray, flags: BoolArray, spare: FloatArray,
    at: IntArray, feet: FloatArray, feet_velocity: FloatArray, stiffness: FloatArray,
    mu: FloatArray, anisotropy: FloatArray, shafts_rad_s: FloatArray, settings: Record,
    work: FloatArray,
) -> int:  # fmt: skip
    """Finish tick k in row k + 1.

    Args:
        k: The tick.
        heard: Of ``predict_kernel``.
        counted: Of ``weigh_in_row_kernel``: rejections, numbers used, their normalised innovation squared
            and the logarithm of their determinant; ``NOT_MEASURED`` numbers where none were weighed.
        error: Error of the mean that an update found, (n,); read only if numbers were used.
        spread: Covariance as it left it, (n, n); the same.
        real: Of ``StateRows``, as are the next three. Out: all that is left of the row.
        whole: Out: the same.
        flags: Out: the same.
        spare: Numbers of the tick.
        at: Of ``Shapes``.
        feet: (T, N, 3) [m].
        feet_velocity: (T, N, 3) [m/s].
        stiffness: Of the robot file, (N,) [N/m].
        mu: Of the robot file, (N,).
        anisotropy: (N, 2).
        shafts_rad_s: Of ``BlockInputs``, (T, N); (0, N) where legs have no shafts.
        settings: Of ``record_of``.
        work: Work space, (n, n).

    Returns:
        What is left to do, a sum of ``ZEROS_DUE`` and ``NOTABLE``; -1 for a tick that is not usual.
    """
    setting, legs = settings[0], mu.size
    rejects, used, nis, volume = counted
    size, before, now, past, present = (
        FIXED + 2 * legs,
        real[k],
        real[k + 1],
        whole[k],
        whole[k + 1],
    )
    reals, wholes, spares, contact = at[0], at[1], at[3], at[2, CONTACT]
    mean = vector(now, reals[MEAN], size)
    covariance = matrix(now, reals[COVARIANCE], size, size)
    mean_before = vector(now, reals[MEAN_BEFORE], size)
    covariance_before = matrix(now, reals[COVARIANCE_BEFORE], size, size)
    if used > 0:
        settle_kernel(
            mean_before, error, spread, FIXED, setting["parameter_limit"], mean, covariance
        )
    else:
        for i in range(size):
            mean[i] = mean_before[i]
            for j in range(size):
                covariance[i, j] = covariance_before[i, j]
    check = 0.0
    for i in range(size):
        check += 0.0 * mean[i]
    if check != 0.0 or not sound_kernel(covariance, work):
        return UNUSUAL
    fit = vector(now, reals[FIT], 3)
    _lay_fit(fit, used, nis, volume)
    if used <= 0:
        for i in range(3 * legs):
            now[reals[INNOVATION] + i] = np.nan
        for i in range(KINDS):
            now[reals[SOURCE_NIS] + i], present[wholes[SOURCE_DOF] + i] = np.nan, 0
    present[wholes[NUMBERS]] = max(used, 0)
    present[wholes[REJECTS]] = past[wholes[REJECTS]] + rejects
    misfit = vector(now, reals[MISFIT], KINDS)
    # an absolute pose that is doubted, or a source that disagrees, needs words
    if present[wholes[REJECTED] + ABSOLUTE * legs] != 0 or contradicts_kernel(misfit):
        return UNUSUAL
    strain = vector(now, reals[STRAIN], 3)
    for i in range(3):
        strain[i] = before[reals[STRAIN] + i]
    if used != NOT_MEASURED and setting["adaptive"] != 0.0:
        strain_kernel(misfit, strain)
    answer = matrix(spare, spares[ROWS], 1 + 3 * legs, 6 + 3 * legs)
    fit[HEIGHT] = answer[0, 5]
    expected = matrix(now, reals[EXPECTED], legs, 3)
    fresh = heard & FRESH != 0
    measured = matrix(spare, spares[HEARD], legs, 3) if fresh else expected
    apart, agree = vector(now, reals[FORCE_APART], 2), vector(now, reals[FORCE_AGREE], 2)
    balance, slipping = vector(now, reals[BALANCE], 4), at[2, SLIPPING]
    compared = report_kernel(
        mean, covariance, mu, stiffness, anisotropy, flags[k + 1, contact : contact + legs], answer,
        matrix(spare, spares[SLIP], legs, 2), matrix(now, reals[APART_COVARIANCE], 3, 3),
        vector(spare, spares[SHAKING], 3), settings, feet[k], feet_velocity[k],
        vector(before, reals[FORCE_APART], 2), vector(before, reals[FORCE_AGREE], 2), measured, fresh,
        expected, mean_before[YAW], spare[spares[TOTAL]], vector(before, reals[BALANCE], 4),
        matrix(now, reals[BY_FOOT], 6, legs), now[reals[BODY] : reals[BODY] + 18].reshape(2, 3, 3),
        vector(now, reals[TILT], 2),
        now[reals[FORCE_SPREAD] : reals[FORCE_SPREAD] + 9 * legs].reshape(legs, 3, 3),
        flags[k + 1, slipping : slipping + legs], matrix(now, reals[FORCE], legs, 3), apart, agree,
        balance,
    )  # fmt: skip
    if not compared:
        for i in range(2):
            apart[i], agree[i] = before[reals[FORCE_APART] + i], before[reals[FORCE_AGREE] + i]
    if not heard & WHOLE:
        for i in range(4):
            balance[i] = before[reals[BALANCE] + i]
    notable = past[wholes[SUSPECTED]] != NO_LEG or notable_kernel(
        vector(before, reals[MEAN], size), vector(before, reals[BALANCE], 4),
        vector(before, reals[SOURCE_BIAS], places_needed(legs)),
    )  # fmt: skip
    left = NOTABLE if notable else 0
    for i in range(4 * legs * legs + 2 * legs + 2 + 2 * legs):  # information to angles
        now[reals[INFORMATION] + i] = before[reals[INFORMATION] + i]
    for name in (RECORDS, STANDING_OUT, SINCE, SUSPECTED):
        present[wholes[name]] = past[wholes[name]]
    if shafts_rad_s.shape[0] > 0 and heard & WHOLE:
        records = past[wholes[RECORDS]] + 1
        present[wholes[RECORDS]] = records
        if records % EVERY == 0 and _stands_out(
            now, reals, spare, spares, feet_velocity[k], shafts_rad_s[k], setting["height_sd"]
        ):
            left += ZEROS_DUE
        elif records % EVERY == 0 and spare[spares[RIDGE]] >= 0.0:
            if past[wholes[STANDING_OUT]] != NO_LEG:
                present[wholes[SINCE]] = records
            present[wholes[STANDING_OUT]], present[wholes[SUSPECTED]] = NO_LEG, NO_LEG
    return left


@compiled
def _stands_out(
    now: FloatArray, reals: IntArray, spare: FloatArray, spares: IntArray,
    feet_velocity: FloatArray, shafts_rad_s: FloatArray, height_sd: float,
) -> bool:  # fmt: skip
    """Take the loads of a record into account; whether the zero of a shaft may then stand out."""
    legs = shafts_rad_s.size
    both, angle = 2 * legs, matrix(now, reals[ZERO], 2, legs)
    height = spare[spares[ROWS] + 5]
    spare[spares[RIDGE]] = evidence_kernel(
        matrix(spare, spares[HEARD], legs, 3), matrix(now, reals[EXPECTED], legs, 3),
        matrix(spare, spares[APART_SHARE], robots_beside(legs), legs), feet_velocity, shafts_rad_s,
        height_sd * height, matrix(now, reals[INFORMATION], both, both),
        vector(now, reals[PULL], both), vector(now, reals[SQUARE], 2), angle,
    )  # fmt: skip
    if spare[spares[RIDGE]] <= 0.0:
        return False
    large = False
    for leg in range(legs):
        large = large or not abs(angle[0, leg]) < SMALL_RAD
    return large


@compiled
def _lay_fit(fit: FloatArray, used: int, nis: float, volume: float) -> None:
    """How what was used fitted; NaN where nothing was."""
    fit[NIS], fit[LIKELIHOOD] = np.nan, np.nan
    if used > 0:
        fit[NIS], fit[LIKELIHOOD] = nis, -0.5 * (nis + volume + used * LOG_TURN)


def prepare() -> None:
    """Load or make the machine code now; that of the filter has to be there already."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        settle_in_row_kernel, COUNT, COUNT, (1, 1, 1.0, 1.0), *out(1, 2, 2), *out(2, kind=COUNT),
        *out(2, kind=FLAG), *out(1), *given(2, kind=COUNT), *given(3, 3, 1, 1, 2, 2), settings, *out(2),
    )  # fmt: skip
