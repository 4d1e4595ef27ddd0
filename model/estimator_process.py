"""How the estimator's state moves from tick to tick: the model as the evolution step of an observer.

The velocity follows the model's, plus a bias that forgets, with a first-order lag; the pose goes along
the arc of the mean velocity of the tick; parameters walk at random while their foot tells of them.
"""

from dataclasses import dataclass
from math import exp, sqrt

import numpy as np

from model.estimator_settings import EstimatorSettings
from model.estimator_step_kernel import carry_kernel, walk_kernel
from model.estimator_types import BIAS, VELOCITY
from model.neighbourhood import Neighbourhood
from model.signals import BoolArray, FloatArray

BIASES = np.arange(BIAS.start, BIAS.stop)


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """A step of the process: mean (n,), its Jacobian F (n, n) and noise Q (n, n)."""

    mean: FloatArray
    transition: FloatArray
    noise: FloatArray


def walking(
    mean: FloatArray,
    model: Neighbourhood,
    settings: EstimatorSettings,
    dt_s: float,
    telling: tuple[BoolArray, BoolArray],
    dead_legs: int,
    doubt: FloatArray | None = None,
) -> Prediction:
    """A step while the feet carry the robot.

    Args:
        mean: State, (n,).
        model: The model's answer at the tick's end and at this state's parameters.
        settings: Noise.
        dt_s: Length of the step [s].
        telling: Feet whose friction, and feet whose stiffness may walk, (N,) each.
        dead_legs: Legs without encoder.
        doubt: Covariance of log mu and log K, (2 N, 2 N), to doubt its derivatives by; None for not at all.
    """
    size = len(mean)
    lag = exp(-dt_s / settings.lag_s) if settings.lag_s > 0 else 0.0
    slip = _slip_size(model)
    speed_sd = settings.speed_sd + settings.speed_per_slip * slip
    turn_sd = settings.turn_sd + settings.turn_per_slip * slip
    after = np.empty(size)
    to = np.zeros((size, size))
    noise = np.zeros((size, size))
    walk_kernel(
        mean,
        model.velocity_B,
        model.by_parameters,
        model.by_speeds,
        lag,
        exp(-dt_s / settings.bias_time_s),
        dt_s,
        settings.foot_speed_sd,
        np.array([speed_sd, speed_sd, turn_sd]),
        bias_size(settings, slip, dead_legs),
        np.concatenate(telling).astype(np.float64) * (settings.parameter_walk**2 * dt_s),
        after,
        to,
        noise,
    )
    if doubt is not None:
        bent = settings.bend**2 * ((model.by_parameters @ doubt) * model.by_parameters).sum(axis=1)
        noise[BIASES, BIASES] += bent * (1 - exp(-2 * dt_s / settings.bias_time_s))
    return Prediction(after, to, noise)


def bias_size(settings: EstimatorSettings, slip_m_s: float, dead_legs: int) -> FloatArray:
    """Standard deviation of the velocity bias at rest of its memory, (3,): it grows with slip."""
    speed = (
        settings.bias_speed_sd
        + settings.bias_speed_per_slip * slip_m_s
        + settings.dead_leg_speed_sd * dead_legs
    )
    turn = (
        settings.bias_turn_sd
        + settings.bias_turn_per_slip * slip_m_s
        + settings.dead_leg_turn_sd * dead_legs
    )
    return np.array([speed, speed, turn])


def _slip_size(model: Neighbourhood) -> float:
    """Root mean square slip of loaded feet [m/s]."""
    carrying = [slip for slip, load in zip(model.slip_B.tolist(), model.load_n.tolist(), strict=True)
                if load > 0]  # fmt: skip
    squares = sum(part * part for slip in carrying for part in slip)
    return sqrt(2 * squares / (2 * len(carrying))) if carrying else 0.0


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
