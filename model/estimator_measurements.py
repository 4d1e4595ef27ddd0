"""What the estimator expects its sensors to say, with derivatives, noise and gates.

A measurement is a stack of blocks (one leg's load, one leg's horizontal force, a pose); each block
passes a gate of its own before all that passed are used at once.
"""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from model.estimator_settings import EstimatorSettings
from model.estimator_types import (
    FIXED,
    GYRO_BIAS,
    POSE,
    SCALE,
    VELOCITY,
    YAW,
    OdometryInputs,
    friction_of,
    stiffness_of,
)
from model.kalman import Stack
from model.neighbourhood import Neighbourhood
from model.signals import BoolArray, FloatArray, FootMotion


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """Measurements that are believed or not together.

    Attributes:
        innovation: Measured less expected, (m,).
        rows: Derivatives of what is expected, (m, n).
        variance: Of the noise, (m,).
        gate: Largest normalised innovation squared; infinite for none.
        kind: 0 a leg's load, 1 a leg's horizontal force, 2 the absolute pose, -1 anything else.
        leg: Leg it belongs to.
    """

    innovation: FloatArray
    rows: FloatArray
    variance: FloatArray
    gate: float = np.inf
    kind: int = -1
    leg: int = 0


def load_blocks(
    share: FloatArray, model: Neighbourhood, weight_n: float, settings: EstimatorSettings, size: int
) -> list[Block]:
    """Each foot's share of the vertical force, which tells of stiffness.

    Args:
        share: Measured, (N,); NaN where there is none.
        model: The model's answer.
        weight_n: Weight carried [N].
        settings: Noise.
        size: n.
    """
    legs = len(share)
    place = stiffness_of(legs)
    rows = np.zeros((legs, 1, size))
    rows[:, 0, place] = model.load_by_stiffness / weight_n
    left = share - model.load_n / weight_n
    variance = np.array([settings.load_sd**2])
    return [
        Block(left[k : k + 1], rows[k], variance, settings.gate_load, 0, k)
        for k in np.flatnonzero(np.isfinite(share) & (model.load_n > 0)).tolist()
    ]


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


def friction_blocks(
    mean: FloatArray,
    force_share: FloatArray,
    slip: FloatArray,
    feet: FootMotion,
    which: BoolArray,
    mu: FloatArray,
    settings: EstimatorSettings,
    bent: FloatArray | None = None,
) -> list[Block]:
    """Horizontal forces of feet that clearly slip: regularised Coulomb friction at the measured load.

    Tells of the velocity (friction points against the slip), of log mu and of the common friction.
    A foot at rest tells of neither: its force is a reaction.

    Args:
        mean: State, (n,).
        force_share: Measured forces over the weight, (N, 3).
        slip: Slip at this state, (N, 2).
        feet: Feet, (N, 3) each.
        which: Feet to use, (N,).
        mu: The robot file's friction coefficients, (N,).
        settings: Noise.
        bent: Variance that second derivatives add, over the square of the pull, (N,); none if None.
    """
    legs, size = len(mu), len(mean)
    place = friction_of(legs).start
    blocks = []
    for k in np.flatnonzero(which).tolist():
        ux, uy = slip[k].tolist()
        measured = force_share[k, :2]
        pull = float(mu[k] * np.exp(mean[SCALE] + mean[place + k]) * force_share[k, 2])
        length = (ux * ux + uy * uy + settings.creep_speed**2) ** 0.5
        expected = np.array([-pull * ux / length, -pull * uy / length])
        rows = np.zeros((2, size))
        cube = pull / length**3
        xx = -pull / length + cube * ux * ux
        xy = cube * ux * uy
        yy = -pull / length + cube * uy * uy
        x, y, _ = feet.position_m[k].tolist()
        rows[:, VELOCITY] = [[xx, xy, -y * xx + x * xy], [xy, yy, -y * xy + x * yy]]
        rows[:, place + k] = expected
        rows[:, SCALE] = expected
        variance = settings.force_sd**2 + settings.force_share_sd**2 * float(measured @ measured)
        variance += 0.0 if bent is None else pull**2 * float(bent[k])
        blocks.append(
            Block(measured - expected, rows, np.full(2, variance), settings.gate_pair, 1, k)
        )
    return blocks


def gauge_block(mean: FloatArray, legs: int, settings: EstimatorSettings) -> Block:
    """Log mu adds up to 0: their common part is the state of its own."""
    place = friction_of(legs)
    rows = np.zeros((1, len(mean)))
    rows[0, place] = 1.0
    return Block(-mean[place].sum(keepdims=True), rows, np.array([settings.gauge_sd**2]))


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


def stacked(blocks: list[Block]) -> Stack:
    """Blocks, not none, one behind the other for the filter."""
    places, begin = [], 0
    for block in blocks:
        places.append((begin, block.kind, block.leg))
        begin += len(block.innovation)
    return Stack(
        innovation=np.concatenate([block.innovation for block in blocks]),
        rows=np.concatenate([block.rows for block in blocks]),
        variance=np.concatenate([block.variance for block in blocks]),
        gates=np.array([block.gate for block in blocks]),
        blocks=np.array(places),
    )
