"""The estimator's arithmetic that runs every tick, compiled: slopes, the walking step, soundness.

Plain loops over small arrays: in numpy each of these is two dozen calls that cost more than their work.
"""

import numpy as np

from model.compiled import NUMBER, compile_for, compiled, given, out
from model.values.arrays import FloatArray

STRAIGHT = 1e-3  # half a turn below which an arc is taken for its series [rad]


@compiled
def slopes_kernel(
    velocity: FloatArray,
    loads: FloatArray,
    pose: FloatArray,
    force: FloatArray,
    log_step: float,
    speed_step: float,
    by_parameters: FloatArray,
    by_speeds: FloatArray,
    load_by_stiffness: FloatArray,
    pose_by_stiffness: FloatArray,
    force_by_parameters: FloatArray,
) -> None:
    """Differences of the answers around a frame over their steps.

    Args:
        velocity: As ``neighbourhood_kernel`` gives it, with the next three.
        loads: (1 + N, N).
        pose: (1 + N, 3).
        force: (1 + 2 N, N, 2).
        log_step: Step of log mu and log K.
        speed_step: Step of a foot's speed [m/s].
        by_parameters: Out: (3, 2 N).
        by_speeds: Out: (3, N).
        load_by_stiffness: Out: (N, N).
        pose_by_stiffness: Out: (3, N).
        force_by_parameters: Out: (N, 2, 2 N).
    """
    count = loads.shape[1]
    for j in range(2 * count):
        for i in range(3):
            by_parameters[i, j] = (velocity[1 + j, i] - velocity[0, i]) / log_step
        for k in range(count):
            for i in range(2):
                force_by_parameters[k, i, j] = (force[1 + j, k, i] - force[0, k, i]) / log_step
    for j in range(count):
        for i in range(3):
            by_speeds[i, j] = (velocity[1 + 2 * count + j, i] - velocity[0, i]) / speed_step
            pose_by_stiffness[i, j] = (pose[1 + j, i] - pose[0, i]) / log_step
        for k in range(count):
            load_by_stiffness[k, j] = (loads[1 + j, k] - loads[0, k]) / log_step


@compiled
def walk_kernel(
    mean: FloatArray,
    covariance: FloatArray,
    velocity: FloatArray,
    by_parameters: FloatArray,
    by_speeds: FloatArray,
    slip: FloatArray,
    load: FloatArray,
    lag: float,
    memory: float,
    dt_s: float,
    foot_speed_sd: float,
    white_sd: FloatArray,
    bias_sd: FloatArray,
    bend: float,
    walk: float,
    least_load: float,
    least_slip: float,
    after: FloatArray,
    to: FloatArray,
    noise: FloatArray,
) -> None:
    """Mean, F and Q of a step while the feet carry the robot.

    Args:
        mean: State, (n,); places as in ``model.values.estimate``.
        covariance: Of the state, (n, n).
        velocity: The model's, (3,).
        by_parameters: (3, 2 N).
        by_speeds: (3, N).
        slip: (N, 2) [m/s].
        load: (N,) [N].
        lag: Share of the old velocity that is left.
        memory: Share of the old bias that is left.
        dt_s: [s].
        foot_speed_sd: Of a foot's speed [m/s].
        white_sd: Of the velocity in a tick: of its speed and of its yaw rate, and what these grow by
            over the root mean square slip of loaded feet, (4,).
        bias_sd: Of the bias in the long run, the same, (4,).
        bend: Bias that doubt about the parameters adds, over the velocity's sd from that doubt.
        walk: Variance that a parameter gains in the step. Where nothing tells of it, it gains none:
        least_load: stiffness needs a load above this [N], friction also
        least_slip: a slip above this [m/s].
        after: Out: (n,).
        to: Out: F, (n, n), all zero before.
        noise: Out: Q, (n, n), all zero before.
    """
    size = mean.size
    parameters = by_parameters.shape[1]
    fixed = size - parameters
    square, loaded = 0.0, 0
    for k in range(load.size):
        own = slip[k, 0] ** 2 + slip[k, 1] ** 2
        if load[k] > 0.0:
            square += own
            loaded += 1
        if load[k] > least_load:
            noise[fixed + load.size + k, fixed + load.size + k] = walk
            if own > least_slip**2:
                noise[fixed + k, fixed + k] = walk
    rms = np.sqrt(square / loaded) if loaded > 0 else 0.0
    for i in range(size):
        after[i] = mean[i]
        to[i, i] = 1.0
    for i in range(3):
        after[3 + i] = lag * mean[3 + i] + (1.0 - lag) * (velocity[i] + mean[6 + i])
        after[6 + i] = memory * mean[6 + i]
        to[3 + i, 3 + i] = lag
        to[3 + i, 6 + i] = 1.0 - lag
        to[6 + i, 6 + i] = memory
        for j in range(parameters):
            to[3 + i, fixed + j] = (1.0 - lag) * by_parameters[i, j]
        turns = i == 2
        bias = bias_sd[1] + bias_sd[3] * rms if turns else bias_sd[0] + bias_sd[2] * rms
        white = white_sd[1] + white_sd[3] * rms if turns else white_sd[0] + white_sd[2] * rms
        bent = 0.0
        for j in range(parameters):
            for k in range(parameters):
                doubt = covariance[fixed + j, fixed + k]
                bent += by_parameters[i, j] * doubt * by_parameters[i, k]
        noise[6 + i, 6 + i] = (bias**2 + bend**2 * bent) * (1.0 - memory * memory)
        noise[3 + i, 3 + i] = white**2
    share = ((1.0 - lag) * foot_speed_sd) ** 2
    for i in range(3):
        for j in range(3):
            total = 0.0
            for k in range(by_speeds.shape[1]):
                total += by_speeds[i, k] * by_speeds[j, k]
            noise[3 + i, 3 + j] += share * total
    carry_kernel(mean, dt_s, after, to, noise)


@compiled
def carry_kernel(
    mean: FloatArray, dt_s: float, after: FloatArray, to: FloatArray, noise: FloatArray
) -> None:
    """Move the pose along the arc of the mean velocity; fill its rows of F and Q in place.

    Noise of the velocity at the end of the step enters the pose by half.

    Args:
        mean: State before, (n,).
        dt_s: [s].
        after: State after, its velocity known; its pose is put in, (n,).
        to: F, velocity's rows known, (n, n).
        noise: Q, velocity's part known, (n, n).
    """
    size = mean.size
    vx = 0.5 * dt_s * (mean[3] + after[3])
    vy = 0.5 * dt_s * (mean[4] + after[4])
    turn = 0.25 * dt_s * (mean[5] + after[5])
    # an arc is a chord of length sinc(half turn), turned by half the turn
    sinc, slope = 1.0 - turn * turn / 6.0, -turn / 3.0
    if abs(turn) > STRAIGHT:
        sinc = np.sin(turn) / turn
        slope = (np.cos(turn) - sinc) / turn
    c, s = np.cos(mean[2] + turn), np.sin(mean[2] + turn)
    along_x, along_y = c * vx - s * vy, s * vx + c * vy
    after[0] = mean[0] + sinc * along_x
    after[1] = mean[1] + sinc * along_y
    after[2] = mean[2] + 2.0 * turn
    by = np.zeros((3, 3))
    by[0, 0], by[0, 1] = sinc * c * dt_s, -sinc * s * dt_s
    by[1, 0], by[1, 1] = sinc * s * dt_s, sinc * c * dt_s
    by[0, 2] = 0.5 * dt_s * (slope * along_x - sinc * along_y)
    by[1, 2] = 0.5 * dt_s * (slope * along_y + sinc * along_x)
    by[2, 2] = dt_s
    for i in range(3):
        for j in range(3, size):
            total = 0.0
            for k in range(3):
                total += by[i, k] * 0.5 * (to[3 + k, j] + (1.0 if j == 3 + k else 0.0))
            to[i, j] += total
    to[0, 2] -= sinc * along_y
    to[1, 2] += sinc * along_x
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


@compiled
def sound_kernel(covariance: FloatArray) -> bool:
    """Whether a matrix is finite and positive definite: Cholesky's pivots, in place of a copy."""
    size = covariance.shape[0]
    root = np.zeros((size, size))
    for i in range(size):
        for j in range(i + 1):
            total = covariance[i, j]
            for k in range(j):
                total -= root[i, k] * root[j, k]
            if i == j:
                if not (total > 0.0 and total < np.inf):
                    return False
                root[i, i] = np.sqrt(total)
            else:
                root[i, j] = total / root[j, j]
    return True


def prepare() -> None:
    """Compile for arrays in rows, read-only or not, and for nothing else after."""
    compile_for(slopes_kernel, *given(2, 2, 2, 3), NUMBER, NUMBER, *out(2, 2, 2, 2, 3))
    compile_for(
        walk_kernel, *given(1, 2, 1, 2, 2, 2, 1), *(NUMBER,) * 4, *given(1, 1), *(NUMBER,) * 4,
        *out(1, 2, 2),
    )  # fmt: skip
    compile_for(carry_kernel, *given(1), NUMBER, *out(1, 2, 2))
    compile_for(sound_kernel, *given(2))
