"""What the estimator expects its sensors to say, with derivatives, noise and gates.

A measurement is a stack of blocks (one leg's load, one leg's horizontal force, a pose); each block
passes a gate of its own before all that passed are used at once.
"""

from functools import cache
from math import isfinite
from typing import NamedTuple

import numpy as np

from model.compiled import COUNT, FLAG, NUMBER, compile_for, compiled, given, out
from model.estimator.kalman import MeasurementStack
from model.estimator.neighbourhood import Neighbourhood
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.sources import ABSOLUTE, FORCE, GYRO, LOAD, NO_SOURCE, TILT
from model.estimator.tolerances import Apart
from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.estimate import FIXED, GYRO_BIAS, POSE, SCALE, TILT_BIAS, YAW, OdometryInputs
from model.values.legs import FootMotion

VX, VY, TURN = 3, 4, 5  # velocity in the state
FAR_SD = 5.0


class Belief(NamedTuple):
    """State, (n,), and its covariance, (n, n), before the measurements of a tick.

    ``doubt`` is what the model leaves open of the forces: variance over the squared weight, (N, 3), of
    ``doubt_of``; None for none.
    """

    mean: FloatArray
    covariance: FloatArray
    doubt: FloatArray | None = None


def feet_stack(
    belief: Belief,
    share: FloatArray,
    feet: FootMotion,
    usable: BoolArray,
    model: Neighbourhood,
    mu: FloatArray,
    settings: Record,
) -> MeasurementStack:
    """Stack the forces on the feet: the other arguments are those of ``feet_stack_kernel``.

    Loads tell of stiffness; friction of feet that clearly slip tells of the velocity, of log mu and of the
    common friction. The gauge says that log mu adds up to 0: what is common is a state of its own.
    """
    legs = len(mu)
    doubt = np.zeros((legs, 3)) if belief.doubt is None else belief.doubt
    room, most = 3 * legs + 1, 2 * legs + 1
    innovation, rows, variance = np.empty(room), np.zeros((room, len(belief.mean))), np.empty(room)
    gates, blocks = np.empty(most), np.empty((most, 3), dtype=np.int64)
    count, made = feet_stack_kernel(
        belief.mean, belief.covariance, share, feet.position_m, feet.velocity_m_s, usable, model.rows,
        model.sway_B, mu, settings, doubt, innovation, rows, variance, gates, blocks,
    )  # fmt: skip
    return MeasurementStack(
        innovation[:count], rows[:count], variance[:count], gates[:made], blocks[:made]
    )


def gyro_stack(
    mean: FloatArray, yaw_rate: float, shake: float, settings: EstimatorSettings
) -> MeasurementStack:
    """A yaw gyro: the yaw rate, its own bias, and how the body shakes, a variance [rad^2/s^2]."""
    rows = np.zeros((1, len(mean)))
    rows[0, TURN] = rows[0, GYRO_BIAS] = 1.0
    left = np.array([yaw_rate - mean[TURN] - mean[GYRO_BIAS]])
    return _one_block(left, rows, np.array([settings.gyro_sd**2 + shake]), settings.gate_load, GYRO)


def tilt_stacks(
    mean: FloatArray,
    tilt: tuple[float, float],
    model: Neighbourhood,
    settings: EstimatorSettings,
) -> list[MeasurementStack]:
    """Roll and pitch of an inclinometer against those of the support model: they tell of K.

    What is between them for good, the inclinometer's mounting and the slope of the ground, is a state each.
    """
    stacks = []
    for place, (measured, axis) in enumerate(zip(tilt, (1, 0), strict=True)):
        if not isfinite(measured):
            continue
        slope, offset = model.pose[axis], TILT_BIAS.start + place
        rows = np.zeros((1, len(mean)))
        by_stiffness = model.pose_by_stiffness[axis] / (1 + slope**2)
        rows[0, len(mean) - len(by_stiffness) :] = by_stiffness
        rows[0, offset] = 1.0
        left = np.array([measured - np.arctan(slope) - mean[offset]])
        noise = np.array([settings.tilt_sd**2])
        stacks.append(_one_block(left, rows, noise, settings.gate_load, TILT, place))
    return stacks


def pose_stack(
    mean: FloatArray, inputs: OdometryInputs, settings: EstimatorSettings
) -> MeasurementStack | None:
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


def too_far(stack: MeasurementStack, covariance: FloatArray, settings: EstimatorSettings) -> bool:
    """Whether an absolute position is farther from the estimate than a robot on its feet can be.

    Args:
        stack: Of ``pose_stack``.
        covariance: P, (n, n).
        settings: With the limit.
    """
    place = stack.rows[:, :YAW].any(axis=1)
    rows = stack.rows[place]
    variance = np.einsum("ij,jk,ik->", rows, covariance, rows) + stack.variance[place].sum()
    distance = np.hypot.reduce(stack.innovation[place], initial=0.0)
    return bool(distance > settings.pose_limit + FAR_SD * np.sqrt(variance))


def _one_block(
    innovation: FloatArray,
    rows: FloatArray,
    variance: FloatArray,
    gate: float,
    source: int,
    place: int = 0,
) -> MeasurementStack:
    blocks = np.array([[0, source, place]])
    return MeasurementStack(innovation, rows, variance, np.array([gate]), blocks)


def stacked(parts: list[MeasurementStack]) -> MeasurementStack | None:
    """All that was measured in a tick, one behind the other for the filter; None if nothing was."""
    if len(parts) < 2:
        return parts[0] if parts else None
    whole = MeasurementStack(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))
    lengths = [len(part.innovation) for part in parts]
    begins = np.repeat(np.cumsum([0, *lengths[:-1]]), [len(part.gates) for part in parts])
    whole.blocks[:, 0] += begins
    return whole


@compiled
def _friction(
    mean: FloatArray,
    covariance: FloatArray,
    share: FloatArray,
    slip: tuple[float, float],
    place: tuple[float, float],
    k: int,
    mu: float,
    turned: float,
    settings: Record,
    at: int,
    innovation: FloatArray,
    rows: FloatArray,
    variance: FloatArray,
) -> None:
    """Regularised Coulomb friction of one foot at its measured load: two numbers, with derivatives."""
    (ux, uy), (x, y) = slip, place
    own, setting = FIXED + k, settings[0]
    pull = mu * np.exp(mean[SCALE] + mean[own]) * share[2]
    length = np.sqrt(ux * ux + uy * uy + setting["creep_speed"] ** 2)
    cube = pull / (length * length * length)
    xx = -pull / length + cube * ux * ux
    xy = cube * ux * uy
    yy = -pull / length + cube * uy * uy
    rows[at, VX], rows[at, VY], rows[at, TURN] = xx, xy, -y * xx + x * xy
    rows[at + 1, VX], rows[at + 1, VY], rows[at + 1, TURN] = xy, yy, -y * xy + x * yy
    # what the second derivatives add, by the direction of the slip and by log mu, is noise
    doubt = covariance[own, own] + covariance[SCALE, SCALE] + 2.0 * covariance[SCALE, own]
    bent = pull**2 * (turned**2 + 0.5 * doubt**2)
    level = share[0] ** 2 + share[1] ** 2
    for i in range(2):
        expected = -pull * slip[i] / length
        innovation[at + i] = share[i] - expected
        rows[at + i, own] = rows[at + i, SCALE] = expected
        variance[at + i] = setting["force_sd"] ** 2 + setting["force_share_sd"] ** 2 * level + bent


@compiled
def feet_stack_kernel(
    mean: FloatArray, covariance: FloatArray, share: FloatArray, position: FloatArray,
    velocity: FloatArray, usable: BoolArray, answer: FloatArray, sway: FloatArray, mu: FloatArray,
    settings: Record, doubted: FloatArray, innovation: FloatArray, rows: FloatArray,
    variance: FloatArray, gates: FloatArray, blocks: IntArray,
) -> tuple[int, int]:  # fmt: skip
    """Stack loads of all feet, friction of those that clearly slip, and the gauge.

    A foot slips clearly if it is faster than a limit and than its own doubt. One that does not tells of
    neither velocity nor friction: its force is a reaction.

    Args:
        mean: State, (n,).
        covariance: P, (n, n).
        share: Measured forces over the weight, (N, 3); NaN where there are none.
        position: Feet, (N, 3) [m].
        velocity: Of the feet, (N, 3) [m/s].
        usable: Feet in contact whose encoders work, (N,).
        answer: Rows of ``Neighbourhood``.
        sway: Of ``Neighbourhood``, (2,) [m/s].
        mu: The robot file's friction coefficients, (N,).
        settings: Of ``record_of``.
        doubted: Variance to be added to that of each force, (N, 3).
        innovation: Out: as in ``MeasurementStack``, with the next four; the rows are zero before.
        rows: Out.
        variance: Out.
        gates: Out.
        blocks: Out.

    Returns:
        How many numbers, and how many blocks.
    """
    count = mu.size
    setting = settings[0]
    at, block = 0, 0
    for k in range(count):
        load = answer[0, 8 + 3 * k]
        if np.isfinite(share[k, 2]) and load > 0.0:
            innovation[at] = share[k, 2] - load / setting["weight_n"]
            for j in range(count):
                by_stiffness = answer[1 + count + j, 8 + 3 * k]
                rows[at, FIXED + count + j] = by_stiffness / setting["weight_n"]
            variance[at] = setting["load_sd"] ** 2 + doubted[k, 2]
            gates[block] = setting["gate_load"]
            blocks[block, 0], blocks[block, 1], blocks[block, 2] = at, LOAD, k
            at, block = at + 1, block + 1
    p, turn = covariance, mean[TURN]
    for k in range(count):
        heard = np.isfinite(share[k, 0] + share[k, 1] + share[k, 2])
        if not (usable[k] and heard and share[k, 2] > setting["load_on"]):
            continue
        x, y = position[k, 0], position[k, 1]
        ux = mean[VX] - sway[0] - turn * y + velocity[k, 0]
        uy = mean[VY] - sway[1] + turn * x + velocity[k, 1]
        square = ux * ux + uy * uy
        doubt = 0.5 * (
            p[VX, VX] + p[VY, VY] + (x * x + y * y) * p[TURN, TURN]
            + 2.0 * (x * p[VY, TURN] - y * p[VX, TURN])
        )  # fmt: skip
        if square > max(setting["slip_speed"] ** 2, setting["clear_slip"] ** 2 * doubt):
            turned = doubt / (square + setting["creep_speed"] ** 2)
            _friction(
                mean, covariance, share[k], (ux, uy), (x, y), k, mu[k], turned, settings, at,
                innovation, rows, variance,
            )  # fmt: skip
            variance[at] += doubted[k, 0]
            variance[at + 1] += doubted[k, 1]
            gates[block] = setting["gate_pair"]
            blocks[block, 0], blocks[block, 1], blocks[block, 2] = at, FORCE, k
            at, block = at + 2, block + 1
    total = 0.0
    for k in range(count):
        total += mean[FIXED + k]
        rows[at, FIXED + k] = 1.0
    innovation[at], variance[at] = -total, setting["gauge_sd"] ** 2
    gates[block] = np.inf
    blocks[block, 0], blocks[block, 1], blocks[block, 2] = at, NO_SOURCE, 0
    return at + 1, block + 1


def doubt_of(
    expected: FloatArray, before: FloatArray, dt_s: float, apart: Apart | None, settings: Record
) -> FloatArray:
    """Noise of forces by what tolerances do to loads, and a wrong time to all, (N, 3).

    Args:
        expected: Forces over the weight, (N, 3).
        before: The same in the tick before; NaN where nothing was expected.
        dt_s: Time since that tick [s].
        apart: What companions answered; None if they were not asked.
        settings: Of ``record_of``: how late forces may be.
    """
    doubt = np.empty(expected.shape)
    share = apart.load_share if apart is not None else _nobody(len(expected))
    doubt_kernel(expected, before, dt_s, share, settings, doubt)
    return doubt


@cache
def _nobody(legs: int) -> FloatArray:
    """Loads of no companions."""
    return np.empty((0, legs))


@compiled
def doubt_kernel(
    expected: FloatArray, before: FloatArray, dt_s: float, apart: FloatArray, settings: Record,
    doubt: FloatArray,
) -> None:  # fmt: skip
    """Fill the noise of forces, (N, 3): the arguments of ``doubt_of``, with loads of companions, (M, N)."""
    late = settings[0]["delay_sd"] / dt_s if dt_s > 0.0 else 0.0
    for k in range(doubt.shape[0]):
        for i in range(3):
            moved = late * (expected[k, i] - before[k, i])
            doubt[k, i] = moved * moved if moved == moved else 0.0
        square = 0.0
        for robot in range(apart.shape[0]):
            square += apart[robot, k] * apart[robot, k]
        # one with an error up and one with it down: half the second moment is the variance of both
        doubt[k, 2] += 0.5 * square


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        feet_stack_kernel, *given(1, 2, 2, 2, 2), *given(1, kind=FLAG), *given(2, 1, 1), settings,
        *given(2), *out(1, 2, 1, 1), *out(2, kind=COUNT),
    )  # fmt: skip
    compile_for(doubt_kernel, *given(2, 2), NUMBER, *given(2), settings, *out(2))
