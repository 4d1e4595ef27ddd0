"""How the estimator's state moves from tick to tick: the model as the evolution step of an observer.

The velocity follows the model's, plus a bias that forgets, with a first-order lag; the pose goes along
the arc of the mean velocity of the tick; parameters walk at random while their foot tells of them.
"""

from dataclasses import dataclass
from math import exp

import numpy as np

from model.estimator.neighbourhood import Neighbourhood
from model.estimator.settings import EstimatorSettings
from model.estimator.step_kernel import carry_kernel, walk_kernel
from model.values.arrays import FloatArray
from model.values.estimate import VELOCITY


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """A step of the process: mean (n,), its Jacobian F (n, n) and noise Q (n, n)."""

    mean: FloatArray
    transition: FloatArray
    noise: FloatArray


def walking(
    mean: FloatArray,
    covariance: FloatArray,
    model: Neighbourhood,
    settings: EstimatorSettings,
    dt_s: float,
    weight_n: float,
    dead_legs: int,
) -> Prediction:
    """A step while the feet carry the robot.

    Args:
        mean: State, (n,).
        covariance: Of the state, (n, n): how far off the parameters may be.
        model: The model's answer at the tick's end and at this state's parameters.
        settings: Noise.
        dt_s: Length of the step [s].
        weight_n: Weight carried [N].
        dead_legs: Legs without encoder.
    """
    size = len(mean)
    speed_sd = settings.bias_speed_sd + settings.dead_leg_speed_sd * dead_legs
    turn_sd = settings.bias_turn_sd + settings.dead_leg_turn_sd * dead_legs
    after = np.empty(size)
    to = np.zeros((size, size))
    noise = np.zeros((size, size))
    walk_kernel(
        mean,
        covariance,
        model.velocity_B,
        model.by_parameters,
        model.by_speeds,
        model.slip_B,
        model.load_n,
        exp(-dt_s / settings.lag_s) if settings.lag_s > 0 else 0.0,
        exp(-dt_s / settings.bias_time_s),
        dt_s,
        settings.foot_speed_sd,
        np.array([
            settings.speed_sd, settings.turn_sd, settings.speed_per_slip, settings.turn_per_slip,
        ]),
        np.array([
            speed_sd, turn_sd, settings.bias_speed_per_slip, settings.bias_turn_per_slip,
        ]),
        settings.bend,
        settings.parameter_walk**2 * dt_s,
        settings.load_on * weight_n,
        settings.slip_speed,
        after,
        to,
        noise,
    )  # fmt: skip
    return Prediction(after, to, noise)


def standing(mean: FloatArray, settings: EstimatorSettings) -> Prediction:
    """A step while nothing moves: velocity 0, everything else held as it is."""
    size = len(mean)
    after = mean.copy()
    after[VELOCITY] = 0.0
    to = np.eye(size)
    to[VELOCITY, VELOCITY] = 0.0
    noise = np.zeros((size, size))
    axes = np.arange(3, 6)
    noise[axes, axes] = settings.idle_speed_sd**2
    return Prediction(after, to, noise)


def nothing(mean: FloatArray) -> Prediction:
    """A step in no time."""
    size = len(mean)
    return Prediction(mean.copy(), np.eye(size), np.zeros((size, size)))


def after_gap(mean: FloatArray, settings: EstimatorSettings, dt_s: float) -> Prediction:
    """A step over a time in which nobody looked: it may have been carried about all the while.

    Where it is now says nothing about how fast it is, and neither does how fast it was before.
    """
    step = standing(mean, settings)
    sd = np.array([settings.carried_speed_sd] * 2 + [settings.carried_turn_sd])
    axes = np.arange(3)
    step.noise[axes, axes] = 2 * sd**2 * settings.carried_time_s * dt_s
    step.noise[3 + axes, 3 + axes] = sd**2
    return step


def carried(mean: FloatArray, settings: EstimatorSettings, dt_s: float) -> Prediction:
    """A step without an answer of the model: any motion a person may give the robot."""
    size = len(mean)
    memory = np.exp(-dt_s / settings.carried_time_s)
    after = mean.copy()
    after[VELOCITY] = memory * mean[VELOCITY]
    to = np.eye(size)
    axes = np.arange(3, 6)
    to[axes, axes] = memory
    noise = np.zeros((size, size))
    sd = np.array([settings.carried_speed_sd] * 2 + [settings.carried_turn_sd])
    noise[axes, axes] = sd**2 * (1 - memory**2)
    return _carry_pose(mean, after, to, noise, dt_s)


def _carry_pose(
    mean: FloatArray, after: FloatArray, to: FloatArray, noise: FloatArray, dt_s: float
) -> Prediction:
    """Move the pose along the arc of the mean velocity; its rows of F and Q are filled in place."""
    carry_kernel(mean, dt_s, after, to, noise)
    return Prediction(after, to, noise)
