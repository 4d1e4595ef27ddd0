"""From the estimator's state to what it says: covariances, parameters, predicted foot forces."""

import numpy as np

from model.estimator_health import NEVER, Verdict
from model.estimator_measurements import Stack
from model.estimator_settings import EstimatorSettings
from model.estimator_step_kernel import force_kernel
from model.estimator_types import (
    BIAS,
    POSE,
    SCALE,
    VELOCITY,
    YAW,
    EstimatorState,
    OdometryEstimate,
    friction_of,
    stiffness_of,
)
from model.neighbourhood import Neighbourhood
from model.params import ContactParameters
from model.signals import FloatArray, readonly


def estimate(
    state: EstimatorState,
    contact: ContactParameters,
    weight_n: float,
    settings: EstimatorSettings,
    model: Neighbourhood | None,
    stack: Stack | None,
    verdict: Verdict,
    holding: bool,
) -> OdometryEstimate:
    """Read out a state after a step."""
    legs = len(contact.mu)
    mean, covariance = state.mean, state.covariance
    sd = np.sqrt(np.diagonal(covariance))
    force, force_covariance = _forces(state, weight_n, settings, model)
    share = np.full(legs, np.nan)
    slipping = np.zeros(legs, dtype=bool)
    tilt, height = np.full(2, np.nan), np.nan
    if model is not None:
        share = model.load_n / weight_n
        speed = np.sqrt(np.einsum("ki,ki->k", model.slip_B, model.slip_B))
        slipping = state.contact & (speed > settings.slip_speed)
        tilt, height = np.arctan(model.pose[1::-1]), float(model.pose[2])
    common = np.exp(mean[SCALE])
    # log of the common friction and log mu of a leg vary together
    place = friction_of(legs)
    mu_variance = sd[place] ** 2 + covariance[SCALE, SCALE] + 2 * covariance[SCALE, place]
    age_s = np.nan if state.force_ns == NEVER else (state.t_ns - state.force_ns) * 1e-9
    known = stack is not None and len(stack.innovation) > 0
    # views, not copies: nothing is ever written to a state that was handed out
    return OdometryEstimate(
        t_ns=state.t_ns,
        position_m=readonly(mean[0:2]),
        yaw_rad=float(mean[YAW]),
        velocity_B=readonly(mean[VELOCITY]),
        pose_covariance=readonly(covariance[POSE, POSE]),
        twist_covariance=readonly(covariance[VELOCITY, VELOCITY]),
        bias_B=readonly(mean[BIAS]),
        mu=readonly(contact.mu * common * np.exp(mean[place])),
        mu_sd=readonly(np.sqrt(np.maximum(mu_variance, 0.0))),
        stiffness=readonly(contact.stiffness * np.exp(mean[stiffness_of(legs)])),
        stiffness_sd=readonly(sd[stiffness_of(legs)]),
        force_B=readonly(force),
        force_covariance=readonly(force_covariance),
        load_share=readonly(share),
        load_share_sd=readonly(np.sqrt(force_covariance[:, 2, 2]) / weight_n),
        tilt_rad=readonly(tilt),
        height_m=height,
        contact=readonly(state.contact),
        slipping=readonly(slipping),
        holding=holding,
        nis=stack.nis if stack is not None and known else np.nan,
        nis_dof=len(stack.innovation) if stack is not None and known else 0,
        log_likelihood=stack.log_likelihood if stack is not None else np.nan,
        innovation=readonly(_innovation(stack, legs)),
        rejects=state.rejects,
        force_age_s=age_s,
        health=verdict.health,
        reason=verdict.reason,
    )


def _innovation(stack: Stack | None, legs: int) -> FloatArray:
    """Normalised innovations of the feet's forces in their places."""
    found = np.full((legs, 3), np.nan)
    if stack is None:
        return found
    normal = stack.innovation / stack.sd
    at = 0
    for block in stack.accepted:
        size = len(block.innovation)
        if block.kind == 0:
            found[block.leg, 2] = normal[at]
        elif block.kind == 1:
            found[block.leg, :2] = normal[at : at + 2]
        at += size
    return found


def _forces(
    state: EstimatorState,
    weight_n: float,
    settings: EstimatorSettings,
    model: Neighbourhood | None,
) -> tuple[FloatArray, FloatArray]:
    """Predicted forces (N, 3) and their covariance (N, 3, 3) from that of the parameters.

    Beside the parameters' part each foot has the noise that the filter gives a measured force: a
    prediction cannot be better than the model that it is judged by.
    """
    legs = len(state.contact)
    if model is None or state.airborne:
        nothing = np.full((legs, 3), np.nan)
        return nothing, np.full((legs, 3, 3), np.nan)
    force = np.empty((legs, 3))
    covariance = np.empty((legs, 3, 3))
    force_kernel(
        model.force_B,
        model.load_n,
        model.force_by_parameters,
        model.load_by_stiffness,
        state.covariance,
        SCALE,
        settings.force_sd * weight_n,
        settings.force_share_sd,
        settings.load_sd * weight_n,
        force,
        covariance,
    )
    return force, covariance
