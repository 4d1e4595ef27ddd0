"""The model around one frame, compiled: the answer, and the answers beside it that Jacobians need.

One call solves support and traction at the given parameters and once more for every parameter stepped by
a little, so that an estimator gets all derivatives for the price of a few dozen frames.

Rows of the answers: 0 the frame itself, then N with log mu of one foot stepped, N with log K stepped,
N with a foot's speed along x stepped (legs swing fore and aft: that is where a shaft's noise goes).
"""

from typing import Any

import numpy as np

from model.compiled import COMPILED, compiled
from model.coulomb_frame import coulomb_frame
from model.signals import BoolArray, FloatArray
from model.support_kernel import ROWS, support_kernel
from model.traction_kernel import foot_speeds, lay_anisotropy, traction_kernel

NOT_A_NUMBER = 1
CREEP_SPEED_M_S = 1e-3  # as in ``model.frame_kernel``: puts the ansatz' forces on a scale
CLEAR_M = 1e-3  # beyond how far a foot moves in a moment: what the body's own tilt may add


@compiled
def _sway(
    feet: FloatArray,
    feet_velocity: FloatArray,
    ground: FloatArray,
    stiffness: FloatArray,
    load: float,
    step_s: float,
    height: float,
    work: FloatArray,
) -> tuple[float, float]:
    """Horizontal velocity of the body origin as it tilts over the ground below it.

    Slopes a moment before and after, from the feet's own velocities: exact, and without the delay of a
    filter. Where either has no support there is no sway to speak of.
    """
    count = feet.shape[0]
    after = np.empty(3)
    before = np.empty(3)
    loads = np.empty(count)
    found = support_kernel(
        feet + step_s * feet_velocity, ground, stiffness, load, after, loads, work
    )
    if found < 0:
        return 0.0, 0.0
    found = support_kernel(
        feet - step_s * feet_velocity, ground, stiffness, load, before, loads, work
    )
    if found < 0:
        return 0.0, 0.0
    share = height / (2.0 * step_s)
    return share * (after[0] - before[0]), -share * (after[1] - before[1])


@compiled
def _aloft(
    feet: FloatArray, feet_velocity: FloatArray, pose: FloatArray, k: int, step_s: float
) -> bool:
    """Whether a foot is too high to touch the ground a moment before or after."""
    clearance = pose[2] + feet[k, 2] - pose[0] * feet[k, 0] + pose[1] * feet[k, 1]
    high: bool = clearance > CLEAR_M + 2.0 * step_s * abs(feet_velocity[k, 2])
    return high


@compiled
def _traction(
    coulomb: bool,
    work: FloatArray,
    loads: FloatArray,
    mu: FloatArray,
    warm: bool,
    twist: FloatArray,
    slip: FloatArray,
    force: FloatArray,
    rested: BoolArray,
) -> int:
    if coulomb:
        reason, _ = coulomb_frame(work, loads, mu, warm, twist, slip, force, rested)
        return reason
    return traction_kernel(work, loads, mu, twist, slip, force)


@compiled
def _slip_share(loads: FloatArray, slip: FloatArray, rested: BoolArray, rest_speed: float) -> float:
    """How far Coulomb's law may be asked for forces: 0 where feet rest, 1 where they slide.

    Where several feet rest it leaves their forces open, and where they creep, real friction has not
    reached its full size yet.
    """
    square, loaded, resting = 0.0, 0, 0
    for k in range(loads.size):
        if loads[k] > 0.0:
            square += slip[k, 0] ** 2 + slip[k, 1] ** 2
            loaded += 1
            resting += rested[k]
    if loaded == 0 or resting > 1:
        return 0.0
    square /= loaded
    share: float = square / (square + rest_speed**2) if square > 0.0 else 0.0
    return share


@compiled
def _blend(
    work: FloatArray, loads: FloatArray, mu: FloatArray, share: float, force: FloatArray
) -> None:
    """Take the rest of the forces from the viscous ansatz, on the scale nearest to Coulomb's law."""
    count = loads.size
    twist = np.empty(3)
    slip = np.empty((count, 2))
    ansatz = np.empty((count, 2))
    if share >= 1.0 or traction_kernel(work, loads, mu, twist, slip, ansatz) != 0:
        return
    power, aim = 0.0, 0.0
    for k in range(count):
        square = ansatz[k, 0] ** 2 + ansatz[k, 1] ** 2
        power += square
        if square > 0.0:
            aim += square / (np.sqrt(slip[k, 0] ** 2 + slip[k, 1] ** 2) + CREEP_SPEED_M_S)
    scale = aim / power if power > 0.0 else 0.0
    for k in range(count):
        for i in range(2):
            force[k, i] = share * force[k, i] + (1.0 - share) * scale * ansatz[k, i]


@compiled
def neighbourhood_kernel(
    feet: FloatArray,
    feet_velocity: FloatArray,
    stiffness: FloatArray,
    mu: FloatArray,
    anisotropy: FloatArray,
    load: float,
    coulomb: bool,
    sway_step: float,
    log_step: float,
    speed_step: float,
    rest_speed: float,
    velocity: FloatArray,
    loads: FloatArray,
    pose: FloatArray,
    sway: FloatArray,
    slip: FloatArray,
    force: FloatArray,
    rested: BoolArray,
) -> int:
    """Solve a frame and its neighbours; a neighbour without an answer repeats the frame's own.

    Args:
        feet: (N, 3) [m], body frame.
        feet_velocity: (N, 3) [m/s].
        stiffness: (N,) [N/m].
        mu: (N,).
        anisotropy: (N, 2).
        load: [N].
        coulomb: Coulomb's law, else the viscous ansatz.
        sway_step: Time either way that slopes are differenced over [s]; 0 leaves sway out.
        log_step: Step of log mu and log K.
        speed_step: Step of a foot's speed [m/s].
        rest_speed: Coulomb's law only: slip at which half of the forces comes from the ansatz [m/s].
        velocity: Out: vx, vy, yaw rate with sway, (1 + 3 N, 3).
        loads: Out: of the frame and with K stepped, (1 + N, N) [N].
        pose: Out: slope_x, slope_y, height of the same, (1 + N, 3).
        sway: Out: (2,) [m/s].
        slip: Out: the frame's slips, (N, 2) [m/s].
        force: Out: horizontal forces of the frame, with mu and with K stepped, (1 + 2 N, N, 2).
        rested: Out: feet at rest, (N,).

    Returns:
        0, or why the frame has no answer (``model.frames.Reason``).
    """
    count = feet.shape[0]
    ground = np.zeros(count)
    work = np.empty((ROWS, count))
    lay_anisotropy(anisotropy, work)
    stepped = np.exp(log_step)
    other = np.empty(3)
    side = np.zeros((count, 2))
    pull = np.zeros((count, 2))
    rest = np.zeros(count, dtype=np.bool_)
    spare = np.empty((ROWS, count))
    own = np.empty((ROWS, count))
    still = np.zeros(3)
    share = 1.0
    sway[:] = 0.0
    for k in range(count + 1):
        if k > 0:
            if loads[0, k - 1] <= 0.0 and _aloft(feet, feet_velocity, pose[0], k - 1, sway_step):
                loads[k, :] = np.nan  # its spring changes nothing
                continue
            changed = stiffness.copy()
            changed[k - 1] *= stepped
        else:
            changed = stiffness
        found = support_kernel(feet, ground, changed, load, pose[k], loads[k], work)
        if found < 0:
            if k == 0:
                return -found
            loads[k, :] = np.nan
            continue
        dx, dy = 0.0, 0.0
        if sway_step > 0.0:
            dx, dy = _sway(feet, feet_velocity, ground, changed, load, sway_step, pose[k, 2], spare)
        if not foot_speeds(feet_velocity, pose[k], False, work):
            return NOT_A_NUMBER
        if k > 0:
            other[0], other[1], other[2] = still[0], still[1], still[2]
            rest[:] = rested
        reason = _traction(coulomb, work, loads[k], mu, k > 0, other, side, pull, rest)
        if reason != 0:
            if k == 0:
                return reason
            loads[k, :] = np.nan
            continue
        if k == 0:
            still[:] = other
            velocity[0, :] = other
            sway[0], sway[1] = dx, dy
            slip[:, :] = side
            rested[:] = rest
            own[:, :] = work
            share = _slip_share(loads[0], slip, rested, rest_speed) if coulomb else 1.0
        row = 0 if k == 0 else count + k
        _blend(work, loads[k], mu, share, pull)
        force[row, :, :] = pull
        velocity[row, 0] = other[0] + dx
        velocity[row, 1] = other[1] + dy
        velocity[row, 2] = other[2]
    work = own
    for k in range(count):
        if not np.isfinite(loads[1 + k, 0]):
            loads[1 + k, :] = loads[0]
            pose[1 + k, :] = pose[0]
            velocity[1 + count + k, :] = velocity[0]
            force[1 + count + k, :, :] = force[0]
    for k in range(2 * count):
        row = 1 + k if k < count else 1 + count + k
        if k < count:
            force[row, :, :] = force[0]
        if loads[0, k % count] <= 0.0:  # a foot in the air changes nothing
            velocity[row, :] = velocity[0]
            continue
        other[0] = velocity[0, 0] - sway[0]
        other[1] = velocity[0, 1] - sway[1]
        other[2] = velocity[0, 2]
        rest[:] = rested
        if k < count:
            changed = mu.copy()
            changed[k] *= stepped
            reason = _traction(coulomb, work, loads[0], changed, True, other, side, pull, rest)
        else:
            moved = feet_velocity.copy()
            moved[k - count, 0] += speed_step
            foot_speeds(moved, pose[0], False, work)
            reason = _traction(coulomb, work, loads[0], mu, True, other, side, pull, rest)
        if reason != 0:
            velocity[row, :] = velocity[0]
            continue
        if k < count:
            _blend(work, loads[0], changed, share, pull)
            force[row, :, :] = pull
        velocity[row, 0] = other[0] + sway[0]
        velocity[row, 1] = other[1] + sway[1]
        velocity[row, 2] = other[2]
    return 0


def prepare() -> None:
    """Compile for read-only inputs, which writable ones fit too, and for nothing else after."""
    dispatcher: Any = neighbourhood_kernel
    if not COMPILED or dispatcher.signatures:
        return
    from numba import types

    number, flag = types.float64, types.boolean
    given = [types.Array(number, axes, "C", readonly=True) for axes in (2, 2, 1, 1, 2)]
    out = [types.Array(number, axes, "C") for axes in (2, 2, 2, 1, 2, 3)]
    dispatcher.compile((
        *given, number, flag, number, number, number, number, *out, types.Array(flag, 1, "C"),
    ))  # fmt: skip
    dispatcher.disable_compile()
