"""What is read out of a state at the end of a tick, in one compiled call: numbers, forces, their mean.

The forces are those of ``force_blend``, the numbers those of ``output``, the mean of all forces together is
that of ``health``.
"""

from math import nan, sqrt
from typing import NamedTuple

import numpy as np

from model.compiled import FLAG, NUMBER, compile_for, compiled, given, in_place, out
from model.estimator.force_blend import forces_kernel
from model.estimator.health import HealthVerdict, balance_kernel
from model.estimator.kalman import Updated
from model.estimator.neighbourhood import Neighbourhood
from model.estimator.output import SHARE_SD, readout_kernel
from model.estimator.senses import Heard
from model.estimator.settings import RECORD_S, EstimatorSettings, Record, record_of
from model.values.arrays import BoolArray, FloatArray
from model.values.estimate import (
    BIAS,
    GYRO_BIAS,
    NEVER,
    VELOCITY,
    YAW,
    Estimate,
    EstimatorState,
    ForceMemory,
)
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters


class Report(NamedTuple):
    """What a tick says.

    Attributes:
        force_n: Predicted forces, as they were known before the tick's record, (N, 3); NaN where no foot
            carries the robot.
        forces: How predictions compare with measurements now.
        balance: Of ``EstimatorState``, now.
        feet: Of ``readout_kernel``, as are the next four.
        body: (2, 3, 3).
        tilt: (2,).
        spread: (N, 3, 3).
        slipping: (N,).
    """

    force_n: FloatArray
    forces: ForceMemory
    balance: FloatArray
    feet: FloatArray
    body: FloatArray
    tilt: FloatArray
    spread: FloatArray
    slipping: BoolArray


class Believed(NamedTuple):
    """A state after its measurements.

    Attributes:
        mean: (n,).
        covariance: (n, n).
        contact: Loaded feet, (N,).
        yaw: Before the measurements [rad].
    """

    mean: FloatArray
    covariance: FloatArray
    contact: BoolArray
    yaw: float


class Observed(NamedTuple):
    """What was measured in a tick.

    Attributes:
        feet: Of the tick, one behind the other in memory.
        heard: Forces.
        expected: The filter's forces over the weight, (N, 3).
    """

    feet: FootMotion
    heard: Heard
    expected: FloatArray


class Answered(NamedTuple):
    """What the model answers.

    Attributes:
        model: Its answer, NaN without one.
        companions: Covariance of the pose by the companions, (3, 3).
        shake: Variance that vibration adds to the velocity, (3,).
    """

    model: Neighbourhood
    companions: FloatArray
    shake: FloatArray


def estimate(
    state: EstimatorState,
    readout: Report,
    height_m: float,
    holding: bool,
    used: Updated,
    verdict: HealthVerdict,
) -> Estimate:
    """Put an estimate together; the arrays of the state are not to be written to from then on.

    Args:
        state: After the tick.
        readout: What was read out of it.
        height_m: Of the body over the ground; NaN without an answer.
        holding: Whether pose and parameters are held because nothing moves.
        used: How measurements fitted.
        verdict: Health.
    """
    mean, covariance, contact = state.mean, state.covariance, state.contact
    for mine in (mean, covariance, contact):
        mine.setflags(write=False)
    mu, mu_sd, stiffness, stiffness_sd, share, share_sd = readout.feet
    pose_covariance, twist_covariance = readout.body
    gyro = state.gyro_ns != NEVER
    # views, not copies
    return Estimate(
        state.t_ns, mean[:2], float(mean[YAW]), mean[VELOCITY], pose_covariance,
        state.companions.apart, twist_covariance, mean[BIAS], mu, mu_sd, stiffness, stiffness_sd,
        readout.force_n, readout.spread, share, share_sd, readout.tilt, height_m, contact, readout.slipping,
        holding, used.nis, used.numbers, used.source_nis, used.source_dof, state.sources.scale,
        used.log_likelihood, used.innovation, state.rejects,
        nan if state.force_ns == NEVER else (state.t_ns - state.force_ns) * 1e-9,
        verdict.health, verdict.reason,
        float(mean[GYRO_BIAS]) if gyro else nan,
        sqrt(covariance[GYRO_BIAS, GYRO_BIAS]) if gyro else nan,
        verdict.remark,
    )  # fmt: skip


def report(
    before: EstimatorState,
    now: Believed,
    observed: Observed,
    answered: Answered,
    contact: ContactParameters,
    settings: Record,
    *,
    airborne: bool,
) -> Report:
    """Read out a state.

    Args:
        before: State before the tick.
        now: State after it.
        observed: What was measured.
        answered: What the model answers.
        contact: Leg springs and friction of the robot file.
        settings: Of ``record_of``.
        airborne: Whether the robot is picked up: what its feet will carry is then not known.
    """
    feet, heard, expected = observed
    model, companions, shake = answered
    legs, forces, known = len(contact.mu), before.forces, before.balance
    predicted, apart, agree = np.empty((legs, 3)), np.empty(2), np.empty(2)
    by_foot, body, tilt = np.empty((6, legs)), np.empty((2, 3, 3)), np.empty(2)
    spread, slipping = np.empty((legs, 3, 3)), np.empty(legs, np.bool_)
    together, fresh = np.empty(4), heard.fresh
    compared = report_kernel(
        now.mean, now.covariance, contact.mu, contact.stiffness, contact.anisotropy, now.contact,
        model.rows, model.slip_B, companions, shake, settings, feet.position_m, feet.velocity_m_s,
        forces.apart, forces.agree, heard.share if fresh else expected, fresh, expected, now.yaw,
        heard.total, known, by_foot, body, tilt, spread, slipping, predicted, apart, agree, together,
    )  # fmt: skip
    if airborne:
        spread.fill(nan)
        by_foot[SHARE_SD].fill(nan)
    for mine in (by_foot, body, tilt, spread, slipping, predicted):
        mine.setflags(write=False)
    if compared:
        apart.setflags(write=False)
        agree.setflags(write=False)
        forces = ForceMemory(apart, agree)
    if fresh and heard.whole:
        together.setflags(write=False)
        known = together
    return Report(predicted, forces, known, by_foot, body, tilt, spread, slipping)


@in_place
@compiled
def report_kernel(
    mean: FloatArray, covariance: FloatArray, mu: FloatArray, stiffness: FloatArray,
    anisotropy: FloatArray, contact: BoolArray, rows: FloatArray, slip: FloatArray,
    elsewhere: FloatArray, shake: FloatArray, settings: Record, position: FloatArray,
    velocity: FloatArray, apart: FloatArray, agree: FloatArray, measured: FloatArray, fresh: bool,
    expected: FloatArray, yaw: float, total: float, balance: FloatArray, feet: FloatArray,
    body: FloatArray, tilt: FloatArray, spread: FloatArray, slipping: BoolArray,
    predicted: FloatArray, apart_now: FloatArray, agree_now: FloatArray, balance_now: FloatArray,
) -> bool:  # fmt: skip
    """Read out a state, predict forces, and take those measured into their mean.

    Args:
        mean: Of ``readout_kernel``, (n,).
        covariance: Of ``readout_kernel``, (n, n).
        mu: Of the robot file, (N,).
        stiffness: Of the robot file, (N,) [N/m].
        anisotropy: Of the robot file, (N, 2).
        contact: Of ``readout_kernel``, (N,), as are the next four.
        rows: Of ``Neighbourhood``.
        slip: (N, 2) [m/s].
        elsewhere: (3, 3).
        shake: (3,).
        settings: Of ``record_of``.
        position: Feet, (N, 3) [m].
        velocity: Of the feet, (N, 3) [m/s].
        apart: Of ``forces_kernel``, (2,), as are the next four.
        agree: (2,).
        measured: Over the weight, (N, 3).
        fresh: Whether they are there.
        expected: The filter's, (N, 3).
        yaw: Of ``balance_kernel`` [rad], as are the next two.
        total: Over the weight.
        balance: (4,).
        feet: Out: of ``readout_kernel``, (6, N), as are the next four.
        body: Out: (2, 3, 3).
        tilt: Out: (2,).
        spread: Out: (N, 3, 3).
        slipping: Out: (N,).
        predicted: Out: of ``forces_kernel``, (N, 3), as are the next two.
        apart_now: Out: (2,).
        agree_now: Out: (2,).
        balance_now: Out: of ``balance_kernel``, (4,); to be used only of a record of all feet.

    Returns:
        Whether predicted forces were compared with measured ones.
    """
    setting = settings[0]
    part = RECORD_S / setting["learning_s"]
    compared = forces_kernel(
        position, velocity, stiffness, mu, anisotropy, setting["weight_n"], apart, agree, measured,
        fresh, expected, part, predicted, apart_now, agree_now,
    )  # fmt: skip
    readout_kernel(
        mean, covariance, mu, stiffness, contact, rows, slip, elsewhere, shake, settings, feet, body,
        tilt, spread, slipping,
    )  # fmt: skip
    balance_kernel(measured, total, yaw, balance, part, balance_now)
    known: bool = compared
    return known


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        report_kernel, *given(1, 2, 1, 1, 2), *given(1, kind=FLAG), *given(2, 2, 2, 1), settings,
        *given(2, 2, 1, 1, 2), FLAG, *given(2), NUMBER, NUMBER, *given(1), *out(2, 3, 1, 3),
        *out(1, kind=FLAG), *out(2, 1, 1, 1),
    )  # fmt: skip
