"""The forces on the feet, compiled: what a measured one tells of the state, and which are predicted."""

from typing import NamedTuple

import numpy as np

from model.compiled import FLAG, compile_for, compiled, given
from model.estimator.kalman import FORCE, LOAD, NO_STREAK, Stack
from model.estimator.neighbourhood import Neighbourhood, no_answer
from model.estimator.settings import EstimatorSettings, numbers_of
from model.values.arrays import BoolArray, FloatArray
from model.values.estimate import FIXED, SCALE

VX, VY, TURN = 3, 4, 5  # velocity in the state
MU, MU_SD, STIFFNESS, STIFFNESS_SD, SHARE, SHARE_SD = range(6)  # rows of what is read out


class FeetNumbers(NamedTuple):
    """Numbers of ``EstimatorSettings``, where each of this name is explained, and the weight [N]."""

    slip_speed: float
    clear_slip: float
    load_on: float
    creep_speed: float
    load_sd: float
    force_sd: float
    force_share_sd: float
    gate_load: float
    gate_pair: float
    gauge_sd: float
    weight_n: float


def stack_room(legs: int, size: int) -> Stack:
    """Room for what the forces on N feet may tell of a state of n numbers."""
    numbers, blocks = 3 * legs + 1, 2 * legs + 1
    return Stack(
        innovation=np.empty(numbers),
        rows=np.zeros((numbers, size)),
        variance=np.empty(numbers),
        gates=np.empty(blocks),
        blocks=np.empty((blocks, 3), dtype=np.int64),
    )


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
    numbers: FeetNumbers,
    at: int,
    stack: Stack,
) -> None:
    """Regularised Coulomb friction of one foot at its measured load: two numbers, with derivatives."""
    (ux, uy), (x, y) = slip, place
    own, rows = FIXED + k, stack.rows
    pull = mu * np.exp(mean[SCALE] + mean[own]) * share[2]
    length = np.sqrt(ux * ux + uy * uy + numbers.creep_speed**2)
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
        stack.innovation[at + i] = share[i] - expected
        rows[at + i, own] = rows[at + i, SCALE] = expected
        stack.variance[at + i] = numbers.force_sd**2 + numbers.force_share_sd**2 * level + bent


@compiled
def feet_stack_kernel(
    mean: FloatArray,
    covariance: FloatArray,
    share: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
    usable: BoolArray,
    model: Neighbourhood,
    mu: FloatArray,
    numbers: FeetNumbers,
    stack: Stack,
) -> tuple[int, int]:
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
        model: The model's answer.
        mu: The robot file's friction coefficients, (N,).
        numbers: Of the settings.
        stack: Out: of ``stack_room``.

    Returns:
        How many numbers, and how many blocks.
    """
    count = mu.size
    gates, blocks = stack.gates, stack.blocks
    at, block = 0, 0
    for k in range(count):
        load = model.force_B[k, 2]
        if np.isfinite(share[k, 2]) and load > 0.0:
            stack.innovation[at] = share[k, 2] - load / numbers.weight_n
            for j in range(count):
                by_stiffness = model.slopes[count + j, 8 + 3 * k]
                stack.rows[at, FIXED + count + j] = by_stiffness / numbers.weight_n
            stack.variance[at] = numbers.load_sd**2
            gates[block] = numbers.gate_load
            blocks[block, 0], blocks[block, 1], blocks[block, 2] = at, LOAD, k
            at, block = at + 1, block + 1
    p, turn = covariance, mean[TURN]
    for k in range(count):
        heard = np.isfinite(share[k, 0] + share[k, 1] + share[k, 2])
        if not (usable[k] and heard and share[k, 2] > numbers.load_on):
            continue
        x, y = position[k, 0], position[k, 1]
        ux = mean[VX] - model.sway_B[0] - turn * y + velocity[k, 0]
        uy = mean[VY] - model.sway_B[1] + turn * x + velocity[k, 1]
        square = ux * ux + uy * uy
        doubt = 0.5 * (
            p[VX, VX] + p[VY, VY] + (x * x + y * y) * p[TURN, TURN]
            + 2.0 * (x * p[VY, TURN] - y * p[VX, TURN])
        )  # fmt: skip
        if square > max(numbers.slip_speed**2, numbers.clear_slip**2 * doubt):
            turned = doubt / (square + numbers.creep_speed**2)
            _friction(
                mean, covariance, share[k], (ux, uy), (x, y), k, mu[k], turned, numbers, at, stack
            )
            gates[block] = numbers.gate_pair
            blocks[block, 0], blocks[block, 1], blocks[block, 2] = at, FORCE, k
            at, block = at + 2, block + 1
    total = 0.0
    for k in range(count):
        total += mean[FIXED + k]
        stack.rows[at, FIXED + k] = 1.0
    stack.innovation[at], stack.variance[at] = -total, numbers.gauge_sd**2
    gates[block] = np.inf
    blocks[block, 0], blocks[block, 1], blocks[block, 2] = at, NO_STREAK, 0
    return at + 1, block + 1


class Readout(NamedTuple):
    """What is said of N feet after a step.

    Attributes:
        rows: MU and the sd of its logarithm, STIFFNESS [N/m] and that of its, SHARE of the weight and its
            own, (6, N).
        force: Predicted, (N, 3) [N].
        spread: Its covariance, (N, 3, 3) [N^2].
        slipping: Feet that clearly slip, (N,).
    """

    rows: FloatArray
    force: FloatArray
    spread: FloatArray
    slipping: BoolArray


def readout_room(legs: int) -> Readout:
    """Room for what is said of N feet."""
    flags = np.empty(legs, dtype=np.bool_)
    return Readout(np.empty((6, legs)), np.empty((legs, 3)), np.empty((legs, 3, 3)), flags)


@compiled
def _spread(
    model: Neighbourhood, covariance: FloatArray, numbers: FeetNumbers, spread: FloatArray
) -> None:
    """Covariance of predicted forces: from that of the parameters, and the noise of a measured one.

    A prediction cannot be better than the model that it is judged by.
    """
    count = spread.shape[0]
    size = covariance.shape[0] - SCALE  # the common friction, the gyro's bias, the parameters
    by, half = np.zeros((3, size)), np.empty((3, size))
    for k in range(count):
        by[0, 0], by[1, 0] = model.force_B[k, 0], model.force_B[k, 1]
        for i in range(3):
            for j in range(2 * count):
                by[i, FIXED - SCALE + j] = model.slopes[j, 6 + 3 * k + i]
            for j in range(size):
                total = 0.0
                for other in range(size):
                    total += by[i, other] * covariance[SCALE + other, SCALE + j]
                half[i, j] = total
        for i in range(3):
            for j in range(i + 1):
                total = 0.0
                for other in range(size):
                    total += half[i, other] * by[j, other]
                spread[k, i, j] = spread[k, j, i] = total
        if model.force_B[k, 2] > 0.0:
            level = by[0, 0] ** 2 + by[1, 0] ** 2
            flat = (numbers.force_sd * numbers.weight_n) ** 2 + numbers.force_share_sd**2 * level
            spread[k, 0, 0] += flat
            spread[k, 1, 1] += flat
            spread[k, 2, 2] += (numbers.load_sd * numbers.weight_n) ** 2


@compiled
def readout_kernel(
    mean: FloatArray,
    covariance: FloatArray,
    mu: FloatArray,
    stiffness: FloatArray,
    contact: BoolArray,
    model: Neighbourhood,
    numbers: FeetNumbers,
    out: Readout,
) -> None:
    """Read out a state. Where the model has no answer it is NaN, and so is what follows from it.

    Args:
        mean: (n,).
        covariance: P, (n, n).
        mu: The robot file's friction coefficients, (N,).
        stiffness: Its stiffnesses, (N,) [N/m].
        contact: Loaded feet, (N,).
        model: The model's answer.
        numbers: Of the settings.
        out: Out.
    """
    count = mu.size
    _spread(model, covariance, numbers, out.spread)
    for k in range(count):
        grip, spring = FIXED + k, FIXED + count + k
        out.rows[MU, k] = mu[k] * np.exp(mean[SCALE] + mean[grip])
        # log of the common friction and log mu of a leg vary together
        both = covariance[grip, grip] + covariance[SCALE, SCALE] + 2.0 * covariance[SCALE, grip]
        out.rows[MU_SD, k] = np.sqrt(max(both, 0.0))
        out.rows[STIFFNESS, k] = stiffness[k] * np.exp(mean[spring])
        out.rows[STIFFNESS_SD, k] = np.sqrt(covariance[spring, spring])
        for i in range(3):
            out.force[k, i] = model.force_B[k, i]
        out.rows[SHARE, k] = model.force_B[k, 2] / numbers.weight_n
        out.rows[SHARE_SD, k] = np.sqrt(out.spread[k, 2, 2]) / numbers.weight_n
        slip = np.sqrt(model.slip_B[k, 0] ** 2 + model.slip_B[k, 1] ** 2)
        out.slipping[k] = contact[k] and slip > numbers.slip_speed


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    numbers, flags = numbers_of(FeetNumbers, EstimatorSettings(), 1.0), given(1, kind=FLAG)
    arrays = given(1, 2, 2, 2, 2)
    compile_for(
        feet_stack_kernel, *arrays, *flags, no_answer(1), *given(1), numbers, stack_room(1, 0)
    )
    compile_for(readout_kernel, *given(1, 2, 1, 1), *flags, no_answer(1), numbers, readout_room(1))
