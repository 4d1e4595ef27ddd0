"""What the estimator expects of the forces on its feet, compiled: loads, friction and gauge, one stack."""

import numpy as np

from model.compiled import COUNT, FLAG, compile_for, compiled, given, out
from model.values.arrays import BoolArray, FloatArray, IntArray
from model.values.estimate import FIXED, SCALE

# Numbers of the settings that go in, in this order.
(
    WEIGHT, SLIP_SPEED, CLEAR_SLIP, LOAD_ON, CREEP_SPEED, LOAD_SD, FORCE_SD, FORCE_SHARE_SD, GATE_LOAD,
    GATE_PAIR, GAUGE_SD, NUMBERS,
) = range(12)  # fmt: skip
VX, VY, TURN = 3, 4, 5  # velocity in the state
NO_COUNT, LOAD, FORCE = -1, 0, 1  # kinds of block


@compiled
def _friction(
    mean: FloatArray,
    covariance: FloatArray,
    share: FloatArray,
    ux: float,
    uy: float,
    x: float,
    y: float,
    k: int,
    mu: float,
    turned: float,
    numbers: FloatArray,
    innovation: FloatArray,
    rows: FloatArray,
    variance: FloatArray,
) -> None:
    """Regularised Coulomb friction of one foot at its measured load: two numbers, with derivatives."""
    place = FIXED + k
    pull = mu * np.exp(mean[SCALE] + mean[place]) * share[2]
    length = np.sqrt(ux * ux + uy * uy + numbers[CREEP_SPEED] ** 2)
    cube = pull / (length * length * length)
    xx = -pull / length + cube * ux * ux
    xy = cube * ux * uy
    yy = -pull / length + cube * uy * uy
    rows[0, VX], rows[0, VY], rows[0, TURN] = xx, xy, -y * xx + x * xy
    rows[1, VX], rows[1, VY], rows[1, TURN] = xy, yy, -y * xy + x * yy
    # what the second derivatives add, by the direction of the slip and by log mu, is noise
    doubt = covariance[place, place] + covariance[SCALE, SCALE] + 2.0 * covariance[SCALE, place]
    bent = pull**2 * (turned**2 + 0.5 * doubt**2)
    level = share[0] ** 2 + share[1] ** 2
    for i in range(2):
        expected = -pull * (ux if i == 0 else uy) / length
        innovation[i] = share[i] - expected
        rows[i, place] = expected
        rows[i, SCALE] = expected
        variance[i] = numbers[FORCE_SD] ** 2 + numbers[FORCE_SHARE_SD] ** 2 * level + bent


@compiled
def feet_stack_kernel(
    mean: FloatArray,
    covariance: FloatArray,
    share: FloatArray,
    load: FloatArray,
    load_by_stiffness: FloatArray,
    sway: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
    mu: FloatArray,
    usable: BoolArray,
    numbers: FloatArray,
    innovation: FloatArray,
    rows: FloatArray,
    variance: FloatArray,
    gates: FloatArray,
    blocks: IntArray,
) -> tuple[int, int]:
    """Stack loads of all feet, friction of those that clearly slip, and the gauge.

    A foot slips clearly if it is faster than a limit and than its own doubt. One that does not tells of
    neither velocity nor friction: its force is a reaction.

    Args:
        mean: State, (n,).
        covariance: P, (n, n).
        share: Measured forces over the weight, (N, 3); NaN where there are none.
        load: The model's, (N,) [N].
        load_by_stiffness: Its derivatives by log K, (N, N) [N].
        sway: Velocity of the body origin as it tilts over its feet, (2,) [m/s].
        position: Feet, (N, 3) [m].
        velocity: Of the feet, (N, 3) [m/s].
        mu: The robot file's friction coefficients, (N,).
        usable: Feet in contact whose encoders work, (N,).
        numbers: Of the settings, (NUMBERS,).
        innovation: Out: measured less expected, (3 N + 1,) or longer.
        rows: Out: derivatives, as many rows of n, all zero before.
        variance: Out: of the noise, as many.
        gates: Out: of each block, (2 N + 1,) or longer.
        blocks: Out: first number, kind and leg of each, (2 N + 1, 3) or longer.

    Returns:
        How many numbers, and how many blocks.
    """
    count = load.size
    at, block = 0, 0
    for k in range(count):
        if np.isfinite(share[k, 2]) and load[k] > 0.0:
            innovation[at] = share[k, 2] - load[k] / numbers[WEIGHT]
            for j in range(count):
                rows[at, FIXED + count + j] = load_by_stiffness[k, j] / numbers[WEIGHT]
            variance[at] = numbers[LOAD_SD] ** 2
            gates[block] = numbers[GATE_LOAD]
            blocks[block, 0], blocks[block, 1], blocks[block, 2] = at, LOAD, k
            at, block = at + 1, block + 1
    p, turn = covariance, mean[TURN]
    for k in range(count):
        if not (usable[k] and share[k, 2] > numbers[LOAD_ON] and np.isfinite(share[k].sum())):
            continue
        x, y = position[k, 0], position[k, 1]
        ux = mean[VX] - sway[0] - turn * y + velocity[k, 0]
        uy = mean[VY] - sway[1] + turn * x + velocity[k, 1]
        square = ux * ux + uy * uy
        doubt = 0.5 * (
            p[VX, VX] + p[VY, VY] + (x * x + y * y) * p[TURN, TURN]
            + 2.0 * (x * p[VY, TURN] - y * p[VX, TURN])
        )  # fmt: skip
        if square > max(numbers[SLIP_SPEED] ** 2, numbers[CLEAR_SLIP] ** 2 * doubt):
            turned = doubt / (square + numbers[CREEP_SPEED] ** 2)
            _friction(
                mean, covariance, share[k], ux, uy, x, y, k, mu[k], turned, numbers,
                innovation[at:], rows[at:], variance[at:],
            )  # fmt: skip
            gates[block] = numbers[GATE_PAIR]
            blocks[block, 0], blocks[block, 1], blocks[block, 2] = at, FORCE, k
            at, block = at + 2, block + 1
    total = 0.0
    for k in range(count):
        total += mean[FIXED + k]
        rows[at, FIXED + k] = 1.0
    innovation[at], variance[at], gates[block] = -total, numbers[GAUGE_SD] ** 2, np.inf
    blocks[block, 0], blocks[block, 1], blocks[block, 2] = at, NO_COUNT, 0
    return at + 1, block + 1


def prepare() -> None:
    """Compile for arrays in rows, read-only or not, and for nothing else after."""
    compile_for(
        feet_stack_kernel, *given(1, 2, 2, 1, 2, 1, 2, 2, 1), *given(1, kind=FLAG), *given(1),
        *out(1, 2, 1, 1), *out(2, kind=COUNT),
    )  # fmt: skip
