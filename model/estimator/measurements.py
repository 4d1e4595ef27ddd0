"""What the estimator expects its sensors to say, with derivatives, noise and gates.

A measurement is a stack of blocks (one leg's load, one leg's horizontal force, a pose); each block
passes a gate of its own before all that passed are used at once.
"""

from math import isfinite

import numpy as np

from model.estimator.feet_kernel import FeetNumbers, feet_stack_kernel, stack_room
from model.estimator.kalman import ABSOLUTE, NO_STREAK, Stack
from model.estimator.neighbourhood import Neighbourhood
from model.estimator.settings import EstimatorSettings
from model.values.arrays import BoolArray, FloatArray
from model.values.estimate import FIXED, GYRO_BIAS, POSE, VELOCITY, YAW, OdometryInputs
from model.values.legs import FootMotion

TURN = VELOCITY.stop - 1


def feet_stack(
    mean: FloatArray,
    covariance: FloatArray,
    share: FloatArray,
    feet: FootMotion,
    usable: BoolArray,
    model: Neighbourhood,
    mu: FloatArray,
    numbers: FeetNumbers,
) -> Stack:
    """Stack the forces on the feet: the arguments are those of ``feet_stack_kernel``.

    Loads tell of stiffness; friction of feet that clearly slip tells of the velocity, of log mu and of the
    common friction. The gauge says that log mu adds up to 0: what is common is a state of its own.
    """
    room = stack_room(len(mu), len(mean))
    count, blocks = feet_stack_kernel(
        mean, covariance, share, feet.position_m, feet.velocity_m_s, usable, model, mu, numbers,
        room,
    )  # fmt: skip
    return Stack(
        room.innovation[:count],
        room.rows[:count],
        room.variance[:count],
        room.gates[:blocks],
        room.blocks[:blocks],
    )


def gyro_stack(mean: FloatArray, yaw_rate: float, settings: EstimatorSettings) -> Stack:
    """A yaw gyro: the yaw rate and its own bias."""
    rows = np.zeros((1, len(mean)))
    rows[0, TURN] = rows[0, GYRO_BIAS] = 1.0
    left = np.array([yaw_rate - mean[TURN] - mean[GYRO_BIAS]])
    return _one_block(left, rows, np.array([settings.gyro_sd**2]), settings.gate_load)


def tilt_stacks(
    tilt: tuple[float, float], model: Neighbourhood, settings: EstimatorSettings
) -> list[Stack]:
    """Roll and pitch of an inclinometer against those of the support model: they tell of K."""
    stacks = []
    for measured, axis in zip(tilt, (1, 0), strict=True):
        if not isfinite(measured):
            continue
        slope = model.pose[axis]
        by_stiffness = model.pose_by_stiffness[axis] / (1 + slope**2)
        rows = np.concatenate([np.zeros(FIXED + len(by_stiffness)), by_stiffness])[None]
        left = np.array([measured - np.arctan(slope)])
        noise = np.array([settings.tilt_sd**2])
        stacks.append(_one_block(left, rows, noise, settings.gate_load))
    return stacks


def pose_stack(
    mean: FloatArray, inputs: OdometryInputs, settings: EstimatorSettings
) -> Stack | None:
    """An absolute pose; its yaw may be missing. The difference of yaw is taken the short way round."""
    if inputs.pose_W is None:
        return None
    left = inputs.pose_W - mean[POSE]
    left[YAW] = (left[YAW] + np.pi) % (2 * np.pi) - np.pi
    known = np.isfinite(left)
    if not known.any():
        return None
    place_sd = inputs.pose_sd_m if np.isfinite(inputs.pose_sd_m) else settings.pose_sd
    yaw_sd = inputs.yaw_sd_rad if np.isfinite(inputs.yaw_sd_rad) else settings.yaw_sd
    variance = np.array([place_sd, place_sd, yaw_sd]) ** 2
    rows = np.eye(3, len(mean))
    gate = settings.gate_pose
    return _one_block(left[known], rows[known], variance[known], gate, ABSOLUTE)


def _one_block(
    innovation: FloatArray,
    rows: FloatArray,
    variance: FloatArray,
    gate: float,
    kind: int = NO_STREAK,
) -> Stack:
    return Stack(innovation, rows, variance, np.array([gate]), np.array([[0, kind, 0]]))


def stacked(parts: list[Stack]) -> Stack | None:
    """All that was measured in a tick, one behind the other for the filter; None if nothing was."""
    if len(parts) < 2:
        return parts[0] if parts else None
    whole = Stack(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))
    lengths = [len(part.innovation) for part in parts]
    begins = np.repeat(np.cumsum([0, *lengths[:-1]]), [len(part.gates) for part in parts])
    whole.blocks[:, 0] += begins
    return whole
