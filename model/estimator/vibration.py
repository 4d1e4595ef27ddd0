"""How the body shakes: feet that stick and slip by turns move it faster than a model of frames follows.

Friction that is stronger at rest than in sliding makes feet let go and catch again many times a second.
That moves the body to and fro about the velocity that is estimated. It adds nothing to the pose, so it is
no part of the state: it is a variance of the velocity that is reported, and of a gyro's reading, which is
never of the very moment of the tick.
"""

import numpy as np
from scipy.constants import g as standard_gravity

from model.estimator.neighbourhood import Neighbourhood
from model.estimator.senses import Heard
from model.estimator.settings import EstimatorSettings
from model.values.arrays import FloatArray, readonly
from model.values.estimate import EstimatorState, OdometryInputs, Vibration
from model.values.legs import FootMotion

MEMORY_S = 0.3
MOST = 9.0  # of a squared change over the mean of them: a kick is no vibration
UNKNOWN = readonly(np.full(3, np.nan))
AT_REST = Vibration(UNKNOWN, readonly(np.zeros(3)), np.nan, 0.0)


def learn(
    state: EstimatorState,
    inputs: OdometryInputs,
    feet: FootMotion,
    heard: Heard,
    left: float,
    settings: EstimatorSettings,
) -> Vibration:
    """Learn how forces and a gyro change from one record to the next.

    What lasts longer than that is left out: it is no vibration, but a contradiction of the model.

    Args:
        state: Before the tick.
        inputs: Its time.
        feet: Of the tick.
        heard: Forces of the tick.
        left: A gyro's innovation, NaN without one [rad/s].
        settings: Noise; whether anything is learned.
    """
    before, dt_s = state.vibration, (inputs.t_ns - state.t_ns) * 1e-9
    if not settings.adaptive or not 0 < dt_s <= settings.longest_gap_s:
        return AT_REST
    part = min(dt_s / MEMORY_S, 1.0)
    force, change = before.force, before.force_change
    if heard.fresh and heard.whole:
        x, y = feet.position_m[:, 0], feet.position_m[:, 1]
        along, aside = heard.share[:, 0], heard.share[:, 1]
        force = np.array([along.sum(), aside.sum(), np.vdot(x, aside) - np.vdot(y, along)])
        if np.isfinite(before.force + force).all():
            half = 0.5 * np.square(force - before.force)
            most = MOST * np.maximum(change, settings.force_sd**2)
            change = change + part * (np.minimum(half, most) - change)
    elif (inputs.t_ns - state.force_ns) * 1e-9 > settings.stale_force_s:
        force = UNKNOWN
    turn, turn_change = before.turn, before.turn_change
    if np.isfinite(left):
        turn = left
    elif (inputs.t_ns - state.gyro_ns) * 1e-9 > settings.stale_force_s:
        turn = np.nan
    if np.isfinite(before.turn + left):
        half_turn = 0.5 * (left - before.turn) ** 2
        most_turn = MOST * max(turn_change, settings.gyro_sd**2)
        turn_change += part * (min(half_turn, most_turn) - turn_change)
    return Vibration(readonly(force), readonly(change), turn, turn_change)


def variance(
    known: Vibration, model: Neighbourhood, feet: FootMotion, settings: EstimatorSettings
) -> FloatArray:
    """Variance of vx, vy [m^2/s^2] and yaw rate [rad^2/s^2] that vibration adds, (3,).

    Forces that change by so much from record to record accelerate the body as much; a gyro shows its
    turning itself. Where neither is there it is taken to grow with the slip that the model predicts.

    Args:
        known: What was learned.
        model: The model's answer at the tick.
        feet: Of the tick.
        settings: How long a force lasts, what is assumed without forces and gyro, noise of both.
    """
    carried = model.load_n > 0
    span = np.square(feet.position_m[carried, :2]).sum() / np.count_nonzero(carried)
    turning = max(known.turn_change - settings.gyro_sd**2, 0.0)
    if np.isfinite(known.force).all():
        noise = np.full(3, float(len(carried)))
        noise[2] = np.square(feet.position_m[:, :2]).sum()
        change = np.maximum(known.force_change - settings.force_white_sd**2 * noise, 0.0)
        added = change * (standard_gravity * settings.vibration_s) ** 2
        added[2] = max(added[2] / span**2, turning)  # the mass lies about as far out as the feet
        return added
    if np.isfinite(known.turn):  # about one of the feet
        return np.array([0.5 * span * turning, 0.5 * span * turning, turning])
    slip = np.square(model.slip_B[carried]).sum() / np.count_nonzero(carried)
    return np.array([0.0, 0.0, settings.vibration_per_slip**2 * slip])
