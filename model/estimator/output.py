"""From the estimator's state to what it says: covariances, parameters, predicted foot forces."""

from math import atan

import numpy as np

from model.estimator.health import NEVER, Verdict
from model.estimator.kalman import Updated
from model.estimator.neighbourhood import Neighbourhood, no_answer
from model.estimator.readout_kernel import (
    MU,
    MU_SD,
    ROWS,
    SHARE,
    SHARE_SD,
    STIFFNESS,
    STIFFNESS_SD,
    readout_kernel,
)
from model.estimator.settings import EstimatorSettings
from model.parameters.robot import ContactParameters
from model.values.arrays import readonly
from model.values.estimate import (
    BIAS,
    POSE,
    SCALE,
    VELOCITY,
    YAW,
    Estimate,
    EstimatorState,
)


def estimate(
    state: EstimatorState,
    contact: ContactParameters,
    weight_n: float,
    settings: EstimatorSettings,
    model: Neighbourhood | None,
    used: Updated | None,
    verdict: Verdict,
    holding: bool,
) -> Estimate:
    """Read out a state after a step."""
    legs = len(contact.mu)
    mean, covariance = state.mean, state.covariance
    answer = model if model is not None else no_answer(legs)
    feet = np.empty((ROWS, legs))
    slipping = np.empty(legs, dtype=np.bool_)
    # Beside the parameters' part each foot has the noise that the filter gives a measured force: a
    # prediction cannot be better than the model that it is judged by.
    force, force_covariance = np.empty((legs, 3)), np.empty((legs, 3, 3))
    readout_kernel(
        mean,
        covariance,
        contact.mu,
        contact.stiffness,
        answer.force_B,
        answer.load_n,
        answer.force_by_parameters,
        answer.load_by_stiffness,
        answer.slip_B,
        state.contact,
        SCALE,
        weight_n,
        settings.force_sd * weight_n,
        settings.force_share_sd,
        settings.load_sd * weight_n,
        settings.slip_speed,
        feet,
        slipping,
        force,
        force_covariance,
    )
    if state.airborne:
        force[:], force_covariance[:], feet[SHARE_SD] = np.nan, np.nan, np.nan
    slope_x, slope_y, height = answer.pose.tolist()
    age_s = np.nan if state.force_ns == NEVER else (state.t_ns - state.force_ns) * 1e-9
    readonly(feet)
    # views, not copies: nothing is ever written to a state that was handed out
    return Estimate(
        t_ns=state.t_ns,
        position_m=readonly(mean[0:2]),
        yaw_rad=float(mean[YAW]),
        velocity_B=readonly(mean[VELOCITY]),
        pose_covariance=readonly(covariance[POSE, POSE]),
        twist_covariance=readonly(covariance[VELOCITY, VELOCITY]),
        bias_B=readonly(mean[BIAS]),
        mu=feet[MU],
        mu_sd=feet[MU_SD],
        stiffness=feet[STIFFNESS],
        stiffness_sd=feet[STIFFNESS_SD],
        force_B=readonly(force),
        force_covariance=readonly(force_covariance),
        load_share=feet[SHARE],
        load_share_sd=feet[SHARE_SD],
        tilt_rad=readonly(np.array([atan(slope_y), atan(slope_x)])),
        height_m=height,
        contact=readonly(state.contact),
        slipping=readonly(slipping),
        holding=holding,
        nis=used.nis if used is not None else np.nan,
        nis_dof=used.numbers if used is not None else 0,
        log_likelihood=used.log_likelihood if used is not None else np.nan,
        innovation=readonly(used.innovation if used is not None else np.full((legs, 3), np.nan)),
        rejects=state.rejects,
        force_age_s=age_s,
        health=verdict.health,
        reason=verdict.reason,
    )
