"""Whether an estimate can be relied on, by what its measurements say of it, and what they say of the robot.

Three answers. Health: whether the numbers may be used, with the reason. Strain: by how much the innovations
ask for more noise of the velocity than the settings give. Remarks: what of the robot file or the ground
does not agree with the measurements, though the covariance covers it.
"""

from collections.abc import Iterator, Sequence
from math import atan, cos, degrees, hypot, inf, log, sin, sqrt
from typing import NamedTuple

import numpy as np

from model.compiled import compile_for, compiled, given, in_place, out
from model.estimator.settings import EstimatorSettings
from model.estimator.shaft_zeros import NO_LEG
from model.estimator.sources import FORCE, GYRO, LOAD, TILT
from model.values.arrays import FloatArray, readonly
from model.values.estimate import (
    BETWEEN,
    FIXED,
    NEVER,
    EstimatorState,
    Health,
    OdometryInputs,
    SourceMemory,
)

UNKNOWN = readonly(np.zeros(4))  # mean of all forces before the first record
ENOUGH = 100.0  # records of all forces before something is said of their mean
# Mean normalised innovation squared of a source beyond which its noise, or the model, is not as the
# settings say. Robots within the tolerances stay below (docs/odometry.md).
USUAL = (1.5, 3.0, inf, 1.2, 3.0)  # by source
DEGRADED = (3.0, 6.0, inf, 2.0, 6.0)
MOST_STRAIN = 100.0
LEAST_SLOPE = 0.03  # of the horizontal force to the vertical, which is that of the ground
WEIGHT_SHARE = 0.1  # of the weight that may be missing, or too much
RATIO, RATIO_SD = (
    2.0,
    0.15,
)  # of friction and stiffness to the robot file's, and how well it must be known
LOG_RATIO = log(RATIO)
LOAD_SHARE = 0.05  # of the weight, by which a foot may carry more or less in the mean


class HealthVerdict(NamedTuple):
    """Health, the reason in words, and what the next step has to know of it.

    Attributes:
        health: Health.
        reason: Why it is not ok; empty if it is.
        fine_ns: Since when all has been in order, -1 if it is not.
        lost: Whether the estimate is lost.
        remark: What does not agree with the measurements, though the covariance covers it.
    """

    health: Health
    reason: str
    fine_ns: int
    lost: bool
    remark: str


@in_place
@compiled
def balance_kernel(
    share: FloatArray, total: float, yaw: float, before: FloatArray, least: float, after: FloatArray
) -> None:
    """Take a record of forces into the mean of all forces together.

    Args:
        share: Forces of all feet over their sum, (N, 3).
        total: That sum over the weight.
        yaw: [rad].
        before: Of ``EstimatorState.balance``, (4,).
        least: Least share of a record in the mean; at first, all records count alike.
        after: Out: the mean with this record, (4,).
    """
    x, y = share[0, 0], share[0, 1]
    for k in range(1, share.shape[0]):
        x += share[k, 0]
        y += share[k, 1]
    c, s = cos(yaw), sin(yaw)
    count = before[3] + 1.0
    part = max(least, 1.0 / count)
    after[0] = (1.0 - part) * before[0] + part * (c * x - s * y)
    after[1] = (1.0 - part) * before[1] + part * (s * x + c * y)
    after[2] = (1.0 - part) * before[2] + part * total
    after[3] = count


def strain(sources: SourceMemory) -> FloatArray:
    """Variance of the noise of vx, vy, yaw rate over that of the settings, as innovations ask for, (3,)."""
    asked = np.empty(3)
    strain_kernel(sources.misfit, asked)
    return readonly(asked)


@in_place
@compiled
def strain_kernel(misfit: FloatArray, asked: FloatArray) -> None:
    """Fill what ``strain`` returns, (3,), from ``SourceMemory.misfit``, (S,)."""
    both = max(1.0, misfit[LOAD] / USUAL[LOAD], misfit[FORCE] / USUAL[FORCE])
    turn = max(both, misfit[GYRO] / USUAL[GYRO])
    asked[0] = asked[1] = min(both, MOST_STRAIN)
    asked[2] = min(turn, MOST_STRAIN)


@in_place
@compiled
def contradicts_kernel(misfit: FloatArray) -> bool:
    """Whether a source does not agree with the model, by ``SourceMemory.misfit``, (S,)."""
    beyond = False
    for kind in (LOAD, FORCE, GYRO, TILT):
        beyond = beyond or misfit[kind] > DEGRADED[kind]
    return beyond


def contradictions(sources: SourceMemory, names: Sequence[str]) -> Iterator[str]:
    """Say which sources do not agree with the model, and where most."""
    if not contradicts_kernel(sources.misfit):
        return
    legs = len(names)
    misfit = sources.misfit.tolist()
    if misfit[LOAD] > DEGRADED[LOAD]:
        worst = int(np.argmax(np.abs(sources.bias[:legs])))
        yield (
            f"loads are not those of the robot file (NIS {misfit[LOAD]:.1f}), "
            f"most {names[worst]}: {100 * sources.bias[worst]:+.0f} % of the weight"
        )
    if misfit[FORCE] > DEGRADED[FORCE]:
        pairs = np.abs(sources.bias[legs : 3 * legs]).reshape(legs, 2).sum(axis=1)
        most = names[int(np.argmax(pairs))]
        yield f"horizontal forces are not the model's (NIS {misfit[FORCE]:.1f}), most {most}"
    if misfit[GYRO] > DEGRADED[GYRO]:
        yield f"the yaw gyro contradicts the feet (NIS {misfit[GYRO]:.1f}): sign, axis, unit, or the feet?"
    if misfit[TILT] > DEGRADED[TILT]:
        yield f"roll and pitch contradict the legs (NIS {misfit[TILT]:.1f}): mounting, unit, stiffness?"


def judge(
    before: EstimatorState,
    inputs: OdometryInputs,
    force_ns: int,
    answer_ns: int,
    settings: EstimatorSettings,
    trouble: list[str],
    names: Sequence[str],
) -> HealthVerdict:
    """Judge a step.

    Args:
        before: State before it: since when all is fine, and whether all was lost.
        inputs: What was known in it; with an absolute pose nothing is lost.
        force_ns: Time of the newest force record, -1 for none.
        answer_ns: Last time that the model had an answer, -1 for never.
        settings: Limits.
        trouble: What happened in it; the checks here add to it.
        names: Of the legs.
    """
    if force_ns != NEVER:
        age_s = (inputs.t_ns - force_ns) * 1e-9
        if age_s > settings.stale_force_s:
            trouble.append(f"no forces for {age_s:.1f} s")
    silent_s = (inputs.t_ns - answer_ns) * 1e-9 if answer_ns != NEVER else 0.0
    lost = (before.lost or silent_s > settings.lost_after_s) and inputs.pose_W is None
    fine_ns = NEVER
    if not trouble:
        fine_ns = before.fine_ns if before.fine_ns != NEVER else inputs.t_ns
        lost = lost and (inputs.t_ns - fine_ns) * 1e-9 < settings.recover_s
    words, remark = BETWEEN.join(trouble), remarks(before, names)
    if lost:
        words = words or "the feet have only just begun to carry again"
        return HealthVerdict(Health.LOST, words, fine_ns, lost=True, remark=remark)
    health = Health.DEGRADED if words else Health.OK
    return HealthVerdict(health, words, fine_ns, lost=False, remark=remark)


def remarks(state: EstimatorState, names: Sequence[str]) -> str:
    """Say what of the robot file or the ground does not agree with the measurements."""
    zeros = state.zeros.suspected
    if not notable_kernel(state.mean, state.balance, state.sources.bias) and zeros == NO_LEG:
        return ""
    largest = max(map(abs, state.mean[FIXED:].tolist()))
    return BETWEEN.join(
        (
            *_of_forces(state.balance),
            *(_of_zeros(state, names) if zeros != NO_LEG else ()),
            *(_of_legs(state, names) if largest > LOG_RATIO else ()),
            *_of_loads(state, names),
        )
    )


@in_place
@compiled
def notable_kernel(mean: FloatArray, balance: FloatArray, bias: FloatArray) -> bool:
    """Whether parameters, (n,), all forces, (4,), or mean innovations may ask for a remark."""
    legs = (mean.size - FIXED) // 2
    for i in range(FIXED, mean.size):
        if abs(mean[i]) > LOG_RATIO:
            return True
    for k in range(legs):
        if abs(bias[k]) > LOAD_SHARE:
            return True
    if balance[3] < ENOUGH:
        return False
    steep: bool = hypot(balance[0], balance[1]) > LEAST_SLOPE
    return steep or abs(balance[2] - 1.0) > WEIGHT_SHARE


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    compile_for(notable_kernel, *given(1, 1, 1))
    compile_for(strain_kernel, *given(1), *out(1))
    compile_for(contradicts_kernel, *given(1))


def _of_forces(forces: FloatArray) -> Iterator[str]:
    x, y, z, count = forces.tolist()
    if count < ENOUGH:
        return
    # feet push uphill against what gravity pulls down
    steep = hypot(x, y)
    if steep > LEAST_SLOPE:
        uphill = degrees(np.arctan2(y, x))
        yield f"the ground rises by {degrees(atan(steep)):.1f} degrees towards {uphill:.0f} degrees of yaw"
    if abs(z - 1.0) > WEIGHT_SHARE:
        yield f"the feet carry {z:.2f} of the robot file's weight"


def _of_zeros(state: EstimatorState, names: Sequence[str]) -> Iterator[str]:
    leg = state.zeros.suspected
    size = degrees(abs(state.zeros.angle_rad[0, leg]))
    yield f"the zero of {names[leg]} seems to be off by {size:.0f} degrees"


def _of_legs(state: EstimatorState, names: Sequence[str]) -> Iterator[str]:
    legs = len(names)
    for first, what in ((FIXED, "the friction"), (FIXED + legs, "the stiffness")):
        for place, name in enumerate(names, start=first):
            ratio, sd = np.exp(state.mean[place]), sqrt(state.covariance[place, place])
            if sd < RATIO_SD and not 1 / RATIO < ratio < RATIO:
                yield f"{name} has {ratio:.2g} times {what} of the robot file"


def _of_loads(state: EstimatorState, names: Sequence[str]) -> Iterator[str]:
    for name, surplus in zip(names, state.sources.bias.tolist(), strict=False):
        if abs(surplus) > LOAD_SHARE:
            side = "more" if surplus > 0 else "less"
            yield f"{name} carries {100 * abs(surplus):.0f} % of the weight {side} than the model says"
