"""A single frame, compiled, for the control loop: one call in, one array of numbers out."""

import numpy as np

from model.compiled import FLAG, NUMBER, compile_for, compiled, given, out
from model.support.kernel import ROWS, support_kernel
from model.traction.kernel import foot_speeds, lay_anisotropy, traction_kernel
from model.values.arrays import BoolArray, FloatArray

NOT_A_NUMBER = 1
NEGATIVE = 7
# Slip below which a foot is taken to rest when forces are put on a scale [m/s].
CREEP_SPEED_M_S = 1e-3


@compiled
def solve(
    feet: FloatArray,
    feet_velocity: FloatArray,
    stiffness: FloatArray,
    mu: FloatArray,
    anisotropy: FloatArray,
    load: float,
    numbers: FloatArray,
    loaded: BoolArray,
) -> tuple[int, int]:
    """Support and viscous-Coulomb traction of one frame.

    Args:
        feet: (N, 3) [m], body frame.
        feet_velocity: (N, 3) [m/s].
        stiffness: (N,) [N/m].
        mu: (N,).
        anisotropy: (N, 2).
        load: [N].
        numbers: Out: slope_x, slope_y, height, vx, vy, yaw rate, force scale, then N loads,
            N x 2 slips (NaN in the air), N x 3 forces; NaN where there is no answer.
        loaded: Out: (N,).

    Returns:
        Steps of the contact search (negative: none found), and the reason (0 is fine).
    """
    count = feet.shape[0]
    numbers[:] = np.nan
    loaded[:] = False
    proper = load > 0.0
    # copies that may be written, as the estimator has them: one set of machine code serves both
    place, speed = np.empty((count, 3)), np.empty((count, 3))
    springs, grip = np.empty(count), np.empty(count)
    for k in range(count):
        proper = proper and stiffness[k] > 0.0
        springs[k], grip[k] = stiffness[k], mu[k]
        for i in range(3):
            place[k, i], speed[k, i] = feet[k, i], feet_velocity[k, i]
    if not proper:
        return -NEGATIVE, NEGATIVE
    work = np.empty((ROWS, count))
    lay_anisotropy(anisotropy, work)
    pose = numbers[:3]
    velocity = numbers[3:6]
    loads = numbers[7 : 7 + count]
    slip = numbers[7 + count : 7 + 3 * count].reshape(count, 2)
    force = numbers[7 + 3 * count :].reshape(count, 3)
    found = support_kernel(place, np.zeros(count), springs, load, pose, loads, work)
    if found < 0:
        return found, -found
    for k in range(count):
        loaded[k] = loads[k] > 0.0
    ansatz = np.empty((count, 2))
    untilted = count < 0
    if not foot_speeds(speed, pose, untilted, work):
        return found, NOT_A_NUMBER
    reason = traction_kernel(work, loads, grip, velocity, slip, ansatz)
    if reason != 0:
        velocity[:] = np.nan
        slip[:] = np.nan
        return found, reason
    # the scale that brings the ansatz nearest to Coulomb's law at the same slips
    power = 0.0
    aim = 0.0
    for k in range(count):
        square = ansatz[k, 0] ** 2 + ansatz[k, 1] ** 2
        power += square
        aim += square / (np.sqrt(slip[k, 0] ** 2 + slip[k, 1] ** 2) + CREEP_SPEED_M_S)
    scale = aim / power if power > 0.0 else 0.0
    numbers[6] = scale
    for k in range(count):
        force[k, 0] = scale * ansatz[k, 0]
        force[k, 1] = scale * ansatz[k, 1]
        force[k, 2] = loads[k]
        if not loaded[k]:
            slip[k, 0] = slip[k, 1] = np.nan
    return found, 0


def prepare() -> None:
    """Compile for read-only inputs, which writable ones fit too, and for nothing else after."""
    compile_for(solve, *given(2, 2, 1, 1, 2), NUMBER, *out(1), *out(1, kind=FLAG))
