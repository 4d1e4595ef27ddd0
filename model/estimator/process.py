"""How the estimator's state moves from tick to tick: the model as the evolution step of an observer.

The velocity follows the model's, plus a bias that forgets, with a first-order lag; the pose goes along
the arc of the mean velocity of the tick; parameters walk at random while their foot tells of them.
"""

from typing import NamedTuple

import numpy as np

from model.compiled import COUNT, NUMBER, compile_for, compiled, given, in_place, out
from model.estimator.neighbourhood import Neighbourhood
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.motion.se2 import sinc
from model.values.arrays import FloatArray, readonly
from model.values.estimate import GYRO_BIAS, VELOCITY

SPEEDS = np.arange(VELOCITY.start, VELOCITY.stop)
STRAIGHT = 1e-3  # half a turn below which the slope of sinc is taken from its series [rad]
_sinc = compiled(sinc)


class ProcessStep(NamedTuple):
    """A step of the process.

    Attributes:
        mean: State after it, (n,).
        transition: Its Jacobian F, (n, n).
        noise: Q, (n, n).
    """

    mean: FloatArray
    transition: FloatArray
    noise: FloatArray


class Beside(NamedTuple):
    """What adds to the noise of a walk, beside what the model's own answer says.

    Attributes:
        apart: Velocity of each companion minus that of the file's robot, (M, 3).
        strain: Variance of the velocity's noise over that of the settings, as innovations ask for, (3,).
        drift: Variance by which the biases of an IMU (yaw rate, roll, pitch) walk in a second, (3,).
    """

    apart: FloatArray
    strain: FloatArray
    drift: FloatArray


NOTHING_BESIDE = Beside(readonly(np.zeros((0, 3))), readonly(np.ones(3)), readonly(np.zeros(3)))


def walking(
    mean: FloatArray,
    covariance: FloatArray,
    model: Neighbourhood,
    settings: Record,
    dt_s: float,
    dead_legs: int = 0,
    beside: Beside = NOTHING_BESIDE,
) -> ProcessStep:
    """A step while the feet carry the robot.

    Args:
        mean: State, (n,).
        covariance: Of the state, (n, n): how far off the parameters may be.
        model: The model's answer at the tick's end and at this state's parameters.
        settings: Of ``record_of``.
        dt_s: Length of the step [s].
        dead_legs: Legs without encoder.
        beside: What adds to its noise.
    """
    size = len(mean)
    step = ProcessStep(np.empty(size), np.zeros((size, size)), np.zeros((size, size)))
    rows, slip, _ = model
    walk_kernel(mean, covariance, rows, slip, settings, dt_s, dead_legs, *beside, *step)
    return step


def nothing(mean: FloatArray) -> ProcessStep:
    """A step in no time."""
    size = len(mean)
    return ProcessStep(mean.copy(), np.eye(size), np.zeros((size, size)))


def standing(mean: FloatArray, settings: EstimatorSettings) -> ProcessStep:
    """A step while nothing moves: velocity 0, everything else held as it is."""
    step = nothing(mean)
    step.mean[SPEEDS] = step.transition[SPEEDS, SPEEDS] = 0.0
    step.noise[SPEEDS, SPEEDS] = settings.idle_speed_sd**2
    return step


def after_gap(mean: FloatArray, settings: EstimatorSettings, dt_s: float) -> ProcessStep:
    """A step over a time in which nobody looked: it may have been carried about all the while.

    Where it is now says nothing about how fast it is, and neither does how fast it was before.
    """
    step = standing(mean, settings)
    variance = _carried_variance(settings)
    pose = np.arange(3)
    step.noise[pose, pose] = 2 * variance * settings.carried_time_s * dt_s
    step.noise[SPEEDS, SPEEDS] = variance
    return step


def carried(mean: FloatArray, settings: EstimatorSettings, dt_s: float) -> ProcessStep:
    """A step without an answer of the model: any motion a person may give the robot."""
    step = nothing(mean)
    memory = np.exp(-dt_s / settings.carried_time_s)
    step.mean[SPEEDS] *= memory
    step.transition[SPEEDS, SPEEDS] = memory
    step.noise[SPEEDS, SPEEDS] = _carried_variance(settings) * (1 - memory**2)
    carry_kernel(mean, dt_s, *step)
    return step


def _carried_variance(settings: EstimatorSettings) -> FloatArray:
    """Of the velocity of a robot that is carried about, (3,)."""
    return np.square([settings.carried_speed_sd] * 2 + [settings.carried_turn_sd])


@in_place
@compiled
def walk_kernel(
    mean: FloatArray, covariance: FloatArray, rows: FloatArray, slip: FloatArray, settings: Record,
    dt_s: float, dead_legs: int, apart: FloatArray, strain: FloatArray, drift: FloatArray,
    after: FloatArray, to: FloatArray, noise: FloatArray,
) -> None:  # fmt: skip
    """A step while the feet carry the robot: the arguments of ``walking``, and what it returns.

    Args:
        mean: State, (n,); places as in ``model.values.estimate``.
        covariance: Of the state, (n, n).
        rows: Of ``Neighbourhood``.
        slip: Of the feet, (N, 2) [m/s].
        settings: Of ``record_of``.
        dt_s: Length of the step [s].
        dead_legs: Legs without encoder.
        apart: Of ``Beside``, (M, 3).
        strain: Of ``Beside``, (3,).
        drift: Of ``Beside``, (3,).
        after: Out: mean after the step, (n,).
        to: In: zero, out: F, (n, n).
        noise: In: zero, out: Q, (n, n).
    """
    size = mean.size
    legs = slip.shape[0]
    parameters = 2 * legs
    fixed = size - parameters
    setting = settings[0]
    velocity, slopes = rows[0], rows[1:]
    walk = setting["parameter_walk"] ** 2 * dt_s
    square, loaded = 0.0, 0
    for k in range(legs):
        own = slip[k, 0] ** 2 + slip[k, 1] ** 2
        load = rows[0, 8 + 3 * k]
        if load > 0.0:
            square += own
            loaded += 1
        # where nothing tells of a parameter it does not walk: friction also needs a slip
        if load > setting["load_on"] * setting["weight_n"]:
            noise[fixed + legs + k, fixed + legs + k] = walk
            if own > setting["slip_speed"] ** 2:
                noise[fixed + k, fixed + k] = walk
    rms = np.sqrt(square / loaded) if loaded > 0 else 0.0
    lag = np.exp(-dt_s / setting["lag_s"]) if setting["lag_s"] > 0.0 else 0.0
    memory = np.exp(-dt_s / setting["bias_time_s"])
    for i in range(size):
        after[i] = mean[i]
        to[i, i] = 1.0
    for i in range(3):
        after[3 + i] = lag * mean[3 + i] + (1.0 - lag) * (velocity[i] + mean[6 + i])
        after[6 + i] = memory * mean[6 + i]
        to[3 + i, 3 + i] = lag
        to[3 + i, 6 + i] = 1.0 - lag
        to[6 + i, 6 + i] = memory
        bent = 0.0
        for j in range(parameters):
            to[3 + i, fixed + j] = (1.0 - lag) * slopes[j, i]
            if slopes[j, i] == 0.0:  # of a foot in the air
                continue
            for k in range(parameters):
                bent += slopes[j, i] * covariance[fixed + j, fixed + k] * slopes[k, i]
        if i < 2:
            bias = setting["bias_speed_sd"] + setting["dead_leg_speed_sd"] * dead_legs
            bias += setting["bias_speed_per_slip"] * rms
            white = setting["speed_sd"] + setting["speed_per_slip"] * rms
            if i == 1:
                bias *= setting["side_share"]
                white *= setting["side_share"]
        else:
            bias = setting["bias_turn_sd"] + setting["dead_leg_turn_sd"] * dead_legs
            bias += setting["bias_turn_per_slip"] * rms
            white = setting["turn_sd"] + setting["turn_per_slip"] * rms
        long_run = bias**2 + setting["bend"] ** 2 * bent  # variance that the bias comes back to
        noise[6 + i, 6 + i] = long_run * (1.0 - memory * memory)
        noise[3 + i, 3 + i] = white**2
    share = ((1.0 - lag) * setting["foot_speed_sd"]) ** 2
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(parameters, parameters + legs):
                total += slopes[k, i] * slopes[k, j]
            noise[3 + i, 3 + j] += share * total
    carry_kernel(mean, dt_s, after, to, noise)
    # one with an error up and one with it down: half the second moment is the covariance of both
    for i in range(3):
        for j in range(3):
            total = 0.0
            for robot in range(apart.shape[0]):
                total += 0.5 * apart[robot, i] * apart[robot, j]
            grown = np.sqrt(strain[i]) * np.sqrt(strain[j])
            noise[3 + i, 3 + j] = (noise[3 + i, 3 + j] + total) * grown
        noise[GYRO_BIAS + i, GYRO_BIAS + i] += drift[i] * dt_s


@compiled
def carry_kernel(
    mean: FloatArray, dt_s: float, after: FloatArray, to: FloatArray, noise: FloatArray
) -> None:
    """Move the pose along the arc of the mean velocity; fill its rows of F and Q in place.

    Noise of the velocity at the end of the step enters the pose by half.

    Args:
        mean: State before, (n,).
        dt_s: [s].
        after: In: velocity after the step, out: the pose as well, (n,).
        to: In: the velocity's rows of F, out: the pose's as well, (n, n).
        noise: In: the velocity's part of Q, out: the pose's as well, (n, n).
    """
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


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        walk_kernel, *given(1, 2, 2, 2), settings, NUMBER, COUNT, *given(2, 1, 1), *out(1, 2, 2)
    )
    compile_for(carry_kernel, *given(1), NUMBER, *out(1, 2, 2))
