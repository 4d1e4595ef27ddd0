"""From the estimator's state to what it says: covariances, parameters, predicted foot forces."""

from math import atan

import numpy as np

from model.estimator.feet_kernel import (
    MU,
    MU_SD,
    SHARE,
    SHARE_SD,
    STIFFNESS,
    STIFFNESS_SD,
    FeetNumbers,
    readout_kernel,
    readout_room,
)
from model.estimator.health import Verdict
from model.estimator.kalman import Updated
from model.estimator.neighbourhood import Neighbourhood, no_answer
from model.values.arrays import readonly
from model.values.estimate import (
    BIAS,
    NEVER,
    POSE,
    VELOCITY,
    YAW,
    Estimate,
    EstimatorState,
)
from model.values.parameters import ContactParameters


def estimate(
    state: EstimatorState,
    contact: ContactParameters,
    numbers: FeetNumbers,
    model: Neighbourhood | None,
    used: Updated,
    verdict: Verdict,
    holding: bool,
) -> Estimate:
    """Read out a state after a step; its arrays are not to be written to from then on."""
    legs = len(contact.mu)
    mean, covariance = readonly(state.mean), readonly(state.covariance)
    answer = model if model is not None else no_answer(legs)
    feet = readout_room(legs)
    readout_kernel(
        mean, covariance, contact.mu, contact.stiffness, state.contact, answer, numbers, feet
    )
    if state.airborne:
        for gone in (feet.force, feet.spread, feet.rows[SHARE_SD]):
            gone.fill(np.nan)
    for array in feet:
        readonly(array)
    slope_x, slope_y, height = answer.pose.tolist()
    # views, not copies
    return Estimate(
        t_ns=state.t_ns,
        position_m=mean[:2],
        yaw_rad=float(mean[YAW]),
        velocity_B=mean[VELOCITY],
        pose_covariance=covariance[POSE, POSE],
        twist_covariance=covariance[VELOCITY, VELOCITY],
        bias_B=mean[BIAS],
        mu=feet.rows[MU],
        mu_sd=feet.rows[MU_SD],
        stiffness=feet.rows[STIFFNESS],
        stiffness_sd=feet.rows[STIFFNESS_SD],
        force_B=feet.force,
        force_covariance=feet.spread,
        load_share=feet.rows[SHARE],
        load_share_sd=feet.rows[SHARE_SD],
        tilt_rad=readonly(np.array([atan(slope_y), atan(slope_x)])),
        height_m=height,
        contact=readonly(state.contact),
        slipping=feet.slipping,
        holding=holding,
        nis=used.nis,
        nis_dof=used.numbers,
        log_likelihood=used.log_likelihood,
        innovation=used.innovation,
        rejects=state.rejects,
        force_age_s=np.nan if state.force_ns == NEVER else (state.t_ns - state.force_ns) * 1e-9,
        health=verdict.health,
        reason=verdict.reason,
    )
