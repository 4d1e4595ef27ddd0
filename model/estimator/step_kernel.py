"""The step of a walking robot, compiled: mean, Jacobian and noise, and the arc that the pose goes along.

Plain loops over small arrays: in numpy this is three dozen calls that cost more than their work.
"""

from typing import NamedTuple

import numpy as np

from model.compiled import compiled
from model.estimator.neighbourhood import Neighbourhood
from model.motion.se2 import sinc
from model.values.arrays import FloatArray

STRAIGHT = 1e-3  # half a turn below which the slope of sinc is taken from its series [rad]
_sinc = compiled(sinc)


class Prediction(NamedTuple):
    """A step of the process.

    Attributes:
        mean: State after it, (n,).
        transition: Its Jacobian F, (n, n).
        noise: Q, (n, n).
    """

    mean: FloatArray
    transition: FloatArray
    noise: FloatArray


class WalkNoise(NamedTuple):
    """Numbers of ``EstimatorSettings``, where each of this name is explained, and the weight [N]."""

    lag_s: float
    bias_time_s: float
    bias_speed_sd: float
    bias_speed_per_slip: float
    bias_turn_sd: float
    bias_turn_per_slip: float
    foot_speed_sd: float
    speed_sd: float
    speed_per_slip: float
    turn_sd: float
    turn_per_slip: float
    bend: float
    parameter_walk: float
    slip_speed: float
    dead_leg_speed_sd: float
    dead_leg_turn_sd: float
    load_on: float
    weight_n: float


@compiled
def walk_kernel(
    mean: FloatArray,
    covariance: FloatArray,
    model: Neighbourhood,
    settings: WalkNoise,
    dt_s: float,
    dead_legs: int,
    step: Prediction,
) -> None:
    """A step while the feet carry the robot.

    Args:
        mean: State, (n,); places as in ``model.values.estimate``.
        covariance: Of the state, (n, n): how far off the parameters may be.
        model: The model's answer at the step's end.
        settings: Noise.
        dt_s: Length of the step [s].
        dead_legs: Legs without encoder.
        step: Out: its matrices are zero before.
    """
    after, to, noise = step.mean, step.transition, step.noise
    size = mean.size
    legs = model.force_B.shape[0]
    parameters = 2 * legs
    fixed = size - parameters
    slopes = model.slopes
    walk = settings.parameter_walk**2 * dt_s
    square, loaded = 0.0, 0
    for k in range(legs):
        own = model.slip_B[k, 0] ** 2 + model.slip_B[k, 1] ** 2
        load = model.force_B[k, 2]
        if load > 0.0:
            square += own
            loaded += 1
        # where nothing tells of a parameter it does not walk: friction also needs a slip
        if load > settings.load_on * settings.weight_n:
            noise[fixed + legs + k, fixed + legs + k] = walk
            if own > settings.slip_speed**2:
                noise[fixed + k, fixed + k] = walk
    rms = np.sqrt(square / loaded) if loaded > 0 else 0.0
    lag = np.exp(-dt_s / settings.lag_s) if settings.lag_s > 0.0 else 0.0
    memory = np.exp(-dt_s / settings.bias_time_s)
    for i in range(size):
        after[i] = mean[i]
        to[i, i] = 1.0
    for i in range(3):
        after[3 + i] = lag * mean[3 + i] + (1.0 - lag) * (model.velocity_B[i] + mean[6 + i])
        after[6 + i] = memory * mean[6 + i]
        to[3 + i, 3 + i] = lag
        to[3 + i, 6 + i] = 1.0 - lag
        to[6 + i, 6 + i] = memory
        bent = 0.0
        for j in range(parameters):
            to[3 + i, fixed + j] = (1.0 - lag) * slopes[j, i]
            for k in range(parameters):
                bent += slopes[j, i] * covariance[fixed + j, fixed + k] * slopes[k, i]
        if i < 2:
            bias = settings.bias_speed_sd + settings.dead_leg_speed_sd * dead_legs
            bias += settings.bias_speed_per_slip * rms
            white = settings.speed_sd + settings.speed_per_slip * rms
        else:
            bias = settings.bias_turn_sd + settings.dead_leg_turn_sd * dead_legs
            bias += settings.bias_turn_per_slip * rms
            white = settings.turn_sd + settings.turn_per_slip * rms
        long_run = bias**2 + settings.bend**2 * bent  # variance that the bias comes back to
        noise[6 + i, 6 + i] = long_run * (1.0 - memory * memory)
        noise[3 + i, 3 + i] = white**2
    share = ((1.0 - lag) * settings.foot_speed_sd) ** 2
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(parameters, parameters + legs):
                total += slopes[k, i] * slopes[k, j]
            noise[3 + i, 3 + j] += share * total
    carry_kernel(mean, dt_s, step)


@compiled
def carry_kernel(mean: FloatArray, dt_s: float, step: Prediction) -> None:
    """Move the pose along the arc of the mean velocity; fill its rows of F and Q in place.

    Noise of the velocity at the end of the step enters the pose by half.

    Args:
        mean: State before, (n,).
        dt_s: [s].
        step: In: velocity after the step, its rows of F and its part of Q; out: those of the pose.
    """
    after, to, noise = step.mean, step.transition, step.noise
    size = mean.size
    vx = 0.5 * dt_s * (mean[3] + after[3])
    vy = 0.5 * dt_s * (mean[4] + after[4])
    half = 0.25 * dt_s * (mean[5] + after[5])
    # an arc is a chord of length sinc(half the turn), turned by half the turn
    chord = _sinc(half)
    slope = (np.cos(half) - chord) / half if abs(half) > STRAIGHT else -half / 3.0
    c, s = np.cos(mean[2] + half), np.sin(mean[2] + half)
    along_x, along_y = c * vx - s * vy, s * vx + c * vy
    after[0] = mean[0] + chord * along_x
    after[1] = mean[1] + chord * along_y
    after[2] = mean[2] + 2.0 * half
    by = np.zeros((3, 3))
    by[0, 0], by[0, 1] = chord * c * dt_s, -chord * s * dt_s
    by[1, 0], by[1, 1] = chord * s * dt_s, chord * c * dt_s
    by[0, 2] = 0.5 * dt_s * (slope * along_x - chord * along_y)
    by[1, 2] = 0.5 * dt_s * (slope * along_y + chord * along_x)
    by[2, 2] = dt_s
    for i in range(3):
        for j in range(3, size):
            total = 0.0
            for k in range(3):
                total += by[i, k] * 0.5 * (to[3 + k, j] + (1.0 if j == 3 + k else 0.0))
            to[i, j] += total
    to[0, 2] -= chord * along_y
    to[1, 2] += chord * along_x
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += 0.5 * by[i, k] * noise[3 + k, 3 + j]
            noise[i, 3 + j] = total
            noise[3 + j, i] = total
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(3):
                total += noise[i, 3 + k] * 0.5 * by[j, k]
            noise[i, j] = total
