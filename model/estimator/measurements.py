"""What the estimator expects its sensors to say, with derivatives, noise and gates.

A measurement is a stack of blocks (one leg's load, one leg's horizontal force, a pose); each block
passes a gate of its own before all that passed are used at once.
"""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from model.estimator import feet_kernel as kernel
from model.estimator.kalman import Stack
from model.estimator.neighbourhood import Neighbourhood
from model.estimator.settings import EstimatorSettings
from model.values.arrays import BoolArray, FloatArray, readonly
from model.values.estimate import FIXED, GYRO_BIAS, POSE, YAW, OdometryInputs
from model.values.legs import FootMotion


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Measurements beside the feet's that are believed or not together.

    Attributes:
        innovation: Measured less expected, (m,).
        rows: Derivatives of what is expected, (m, n).
        variance: Of the noise, (m,).
        gate: Largest normalised innovation squared; infinite for none.
        kind: 2 the absolute pose, -1 anything else; 0 and 1 are the feet's.
        leg: Leg it belongs to.
    """

    innovation: FloatArray
    rows: FloatArray
    variance: FloatArray
    gate: float = np.inf
    kind: int = -1
    leg: int = 0


def slip_of_feet(velocity: FloatArray, feet: FootMotion, sway: FloatArray) -> FloatArray:
    """Velocity of each foot over the ground at a body velocity, (N, 2) [m/s].

    Args:
        velocity: Of the body origin, (3,).
        feet: (N, 3) each.
        sway: Part of it that comes from tilting over the feet, (2,).
    """
    place, speed = feet.position_m, feet.velocity_m_s
    slip = np.empty((len(place), 2))
    slip[:, 0] = velocity[0] - sway[0] - velocity[2] * place[:, 1] + speed[:, 0]
    slip[:, 1] = velocity[1] - sway[1] + velocity[2] * place[:, 0] + speed[:, 1]
    return slip


def feet_numbers(settings: EstimatorSettings, weight_n: float) -> FloatArray:
    """Numbers of the settings that ``feet_stack`` asks for, (NUMBERS,)."""
    numbers = np.empty(kernel.NUMBERS)
    numbers[kernel.WEIGHT] = weight_n
    numbers[kernel.SLIP_SPEED], numbers[kernel.CLEAR_SLIP] = (
        settings.slip_speed,
        settings.clear_slip,
    )
    numbers[kernel.LOAD_ON], numbers[kernel.CREEP_SPEED] = settings.load_on, settings.creep_speed
    numbers[kernel.LOAD_SD], numbers[kernel.FORCE_SD] = settings.load_sd, settings.force_sd
    numbers[kernel.FORCE_SHARE_SD] = settings.force_share_sd
    numbers[kernel.GATE_LOAD], numbers[kernel.GATE_PAIR] = settings.gate_load, settings.gate_pair
    numbers[kernel.GAUGE_SD] = settings.gauge_sd
    return readonly(numbers)


def feet_stack(
    mean: FloatArray,
    covariance: FloatArray,
    share: FloatArray,
    feet: FootMotion,
    usable: BoolArray,
    model: Neighbourhood,
    mu: FloatArray,
    numbers: FloatArray,
) -> Stack:
    """Stack the forces on the feet.

    Loads tell of stiffness; friction of feet that clearly slip tells of the velocity, of log mu and of the
    common friction. The gauge says that log mu adds up to 0: what is common is a state of its own.

    Args:
        mean: State, (n,).
        covariance: P, (n, n).
        share: Measured forces over the weight, (N, 3); NaN where there are none.
        feet: Feet, (N, 3) each.
        usable: Feet in contact whose encoders work, (N,).
        model: The model's answer.
        mu: The robot file's friction coefficients, (N,).
        numbers: Of ``feet_numbers``.
    """
    legs, size = len(mu), len(mean)
    most = 3 * legs + 1
    innovation, rows, variance = np.empty(most), np.zeros((most, size)), np.empty(most)
    gates, blocks = np.empty(2 * legs + 1), np.empty((2 * legs + 1, 3), dtype=np.int64)
    count, found = kernel.feet_stack_kernel(
        mean, covariance, share, model.load_n, model.load_by_stiffness, model.sway_B,
        feet.position_m, feet.velocity_m_s, mu, usable, numbers, innovation, rows, variance, gates,
        blocks,
    )  # fmt: skip
    return Stack(innovation[:count], rows[:count], variance[:count], gates[:found], blocks[:found])


def gyro_block(mean: FloatArray, yaw_rate: float, settings: EstimatorSettings) -> Block:
    """A yaw gyro: the yaw rate and its own bias."""
    rows = np.zeros((1, len(mean)))
    rows[0, 5] = rows[0, GYRO_BIAS] = 1.0
    left = np.array([yaw_rate - mean[5] - mean[GYRO_BIAS]])
    return Block(left, rows, np.array([settings.gyro_sd**2]), settings.gate_load)


def tilt_blocks(
    tilt: tuple[float, float],
    model: Neighbourhood,
    settings: EstimatorSettings,
    size: int,
) -> list[Block]:
    """Roll and pitch of an inclinometer against those of the support model: they tell of K."""
    legs = len(model.load_n)
    blocks = []
    for measured, axis in zip(tilt, (1, 0), strict=True):
        if not isfinite(measured):
            continue
        slope = model.pose[axis]
        rows = np.zeros((1, size))
        rows[0, FIXED + legs :] = model.pose_by_stiffness[axis] / (1 + slope**2)
        left = np.array([measured - np.arctan(slope)])
        blocks.append(Block(left, rows, np.array([settings.tilt_sd**2]), settings.gate_load))
    return blocks


def pose_block(
    mean: FloatArray, inputs: OdometryInputs, settings: EstimatorSettings
) -> Block | None:
    """An absolute pose; its yaw may be missing. The difference of yaw is taken the short way round."""
    if inputs.pose_W is None:
        return None
    left = inputs.pose_W - mean[POSE]
    left[YAW] = (left[YAW] + np.pi) % (2 * np.pi) - np.pi
    known = np.isfinite(left)
    if not known.any():
        return None
    rows = np.zeros((3, len(mean)))
    rows[[0, 1, 2], [0, 1, 2]] = 1.0
    place_sd = inputs.pose_sd_m if np.isfinite(inputs.pose_sd_m) else settings.pose_sd
    yaw_sd = inputs.yaw_sd_rad if np.isfinite(inputs.yaw_sd_rad) else settings.yaw_sd
    variance = np.array([place_sd, place_sd, yaw_sd]) ** 2
    return Block(left[known], rows[known], variance[known], settings.gate_pose, 2)


def stacked(feet: Stack | None, others: list[Block]) -> Stack | None:
    """All that was measured in a tick, one behind the other for the filter; None if nothing was."""
    if not others:
        return feet
    first = feet if feet is not None else _NOTHING
    places, begin = [], len(first.innovation)
    for block in others:
        places.append((begin, block.kind, block.leg))
        begin += len(block.innovation)
    width = others[0].rows.shape[1]
    return Stack(
        innovation=np.concatenate([first.innovation, *(block.innovation for block in others)]),
        rows=np.concatenate([first.rows.reshape(-1, width), *(block.rows for block in others)]),
        variance=np.concatenate([first.variance, *(block.variance for block in others)]),
        gates=np.concatenate([first.gates, [block.gate for block in others]]),
        blocks=np.concatenate([first.blocks, np.array(places)]),
    )


_NOTHING = Stack(
    np.empty(0), np.empty((0, 0)), np.empty(0), np.empty(0), np.empty((0, 3), dtype=np.int64)
)
