"""How the estimator's state moves from tick to tick: the model as the evolution step of an observer.

The velocity follows the model's, plus a bias that forgets, with a first-order lag; the pose goes along
the arc of the mean velocity of the tick; parameters walk at random while their foot tells of them.
"""

import numpy as np

from model.compiled import COUNT, NUMBER, compile_for, given
from model.estimator.neighbourhood import Neighbourhood, no_answer
from model.estimator.settings import EstimatorSettings, numbers_of
from model.estimator.step_kernel import Prediction, WalkNoise, carry_kernel, walk_kernel
from model.values.arrays import FloatArray
from model.values.estimate import VELOCITY

SPEEDS = np.arange(VELOCITY.start, VELOCITY.stop)


def walking(
    mean: FloatArray,
    covariance: FloatArray,
    model: Neighbourhood,
    noise: WalkNoise,
    dt_s: float,
    dead_legs: int = 0,
) -> Prediction:
    """A step while the feet carry the robot.

    Args:
        mean: State, (n,).
        covariance: Of the state, (n, n): how far off the parameters may be.
        model: The model's answer at the tick's end and at this state's parameters.
        noise: Of ``numbers_of``.
        dt_s: Length of the step [s].
        dead_legs: Legs without encoder.
    """
    size = len(mean)
    step = Prediction(np.empty(size), np.zeros((size, size)), np.zeros((size, size)))
    walk_kernel(mean, covariance, model, noise, dt_s, dead_legs, step)
    return step


def nothing(mean: FloatArray) -> Prediction:
    """A step in no time."""
    size = len(mean)
    return Prediction(mean.copy(), np.eye(size), np.zeros((size, size)))


def standing(mean: FloatArray, settings: EstimatorSettings) -> Prediction:
    """A step while nothing moves: velocity 0, everything else held as it is."""
    step = nothing(mean)
    step.mean[SPEEDS] = step.transition[SPEEDS, SPEEDS] = 0.0
    step.noise[SPEEDS, SPEEDS] = settings.idle_speed_sd**2
    return step


def after_gap(mean: FloatArray, settings: EstimatorSettings, dt_s: float) -> Prediction:
    """A step over a time in which nobody looked: it may have been carried about all the while.

    Where it is now says nothing about how fast it is, and neither does how fast it was before.
    """
    step = standing(mean, settings)
    variance = _carried_variance(settings)
    pose = np.arange(3)
    step.noise[pose, pose] = 2 * variance * settings.carried_time_s * dt_s
    step.noise[SPEEDS, SPEEDS] = variance
    return step


def carried(mean: FloatArray, settings: EstimatorSettings, dt_s: float) -> Prediction:
    """A step without an answer of the model: any motion a person may give the robot."""
    step = nothing(mean)
    memory = np.exp(-dt_s / settings.carried_time_s)
    step.mean[SPEEDS] *= memory
    step.transition[SPEEDS, SPEEDS] = memory
    step.noise[SPEEDS, SPEEDS] = _carried_variance(settings) * (1 - memory**2)
    carry_kernel(mean, dt_s, step)
    return step


def _carried_variance(settings: EstimatorSettings) -> FloatArray:
    """Of the velocity of a robot that is carried about, (3,)."""
    return np.square([settings.carried_speed_sd] * 2 + [settings.carried_turn_sd])


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    step = Prediction(np.empty(0), np.empty((0, 0)), np.empty((0, 0)))
    noise = numbers_of(WalkNoise, EstimatorSettings(), 1.0)
    compile_for(walk_kernel, *given(1, 2), no_answer(1), noise, NUMBER, COUNT, step)
    compile_for(carry_kernel, *given(1), NUMBER, step)
