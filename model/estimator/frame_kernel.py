"""The model around one frame, compiled: the answer, and the neighbouring answers that Jacobians need.

One call solves support and traction at the given parameters and once more for every parameter stepped by
a little, so that an estimator gets all derivatives for the price of a few dozen frames.

Rows of the answers: 0 the frame itself, then N by log mu of one foot, N by log K, N by a foot's speed along
x (legs swing fore and aft: that is where a shaft's noise goes).
"""

from typing import NamedTuple

import numpy as np

from model.compiled import compile_for, compiled, given, in_place, out
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.sway_kernel import SwaySpace, sway_space, tilt_sway
from model.support.kernel import ROWS, support_kernel
from model.traction.coulomb_frame import BalanceSpace, balance_frame, balance_space
from model.traction.coulomb_kernel import FootLaw
from model.traction.kernel import (
    CREEP_SPEED_M_S,
    coulomb_scale,
    foot_speeds,
    lay_anisotropy,
    traction_kernel,
)
from model.values.arrays import BoolArray, FloatArray
from model.values.estimate import FIXED, SCALE

NOT_A_NUMBER = 1
FRAME, STIFFNESS, FRICTION, SPEED = 0, 1, 2, 3  # what is stepped
LOG_STEP = 0.01  # of log mu and log K
SPEED_STEP_M_S = 1e-4  # of a foot's speed
CLEAR_M = 1e-3  # beyond how far a foot moves in a moment: what the body's own tilt may add


@in_place
@compiled
def _lay(given: FloatArray, out: FloatArray) -> None:
    """Copy rows: what ``out[:] = given`` does, for a tenth of the compiler's time."""
    for k in range(given.shape[0]):
        _lay_row(given[k], out[k])


@in_place
@compiled
def _lay_row(given: FloatArray, out: FloatArray) -> None:
    """Copy one row."""
    for i in range(given.size):
        out[i] = given[i]


@in_place
@compiled
def lay_parameters(
    mean: FloatArray, stiffness: FloatArray, mu: FloatArray, spring: FloatArray, grip: FloatArray
) -> None:
    """Fill stiffness [N/m] and friction of N legs as the state has them, from those of the robot file."""
    count = mu.size
    for k in range(count):
        grip[k] = mu[k] * np.exp(mean[SCALE] + mean[FIXED + k])
        spring[k] = stiffness[k] * np.exp(mean[FIXED + count + k])


@in_place
@compiled
def _aloft(
    feet: FloatArray, feet_velocity: FloatArray, pose: FloatArray, k: int, step_s: float
) -> bool:
    """Whether a foot is too high to touch the ground a moment before or after."""
    clearance = pose[2] + feet[k, 2] - pose[0] * feet[k, 0] + pose[1] * feet[k, 1]
    high: bool = clearance > CLEAR_M + 2.0 * step_s * abs(feet_velocity[k, 2])
    return high


@in_place
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


@in_place
@compiled
def _blend(
    work: FloatArray,
    loads: FloatArray,
    mu: FloatArray,
    share: float,
    force: FloatArray,
    ansatz: tuple[FloatArray, FloatArray, FloatArray],
) -> None:
    """Take the rest of the forces from the viscous ansatz, on the scale nearest to Coulomb's law."""
    twist, slip, viscous = ansatz
    if share >= 1.0 or traction_kernel(work, loads, mu, twist, slip, viscous) != 0:
        return
    rest = (1.0 - share) * coulomb_scale(slip, viscous, CREEP_SPEED_M_S)
    for k in range(loads.size):
        for i in range(2):
            force[k, i] = share * force[k, i] + rest * viscous[k, i]


@compiled
def neighbourhood_kernel(
    mean: FloatArray, feet: FloatArray, feet_velocity: FloatArray, stiffness: FloatArray,
    mu: FloatArray, anisotropy: FloatArray, settings: Record, rows: FloatArray, slip: FloatArray,
    sway: FloatArray,
) -> int:  # fmt: skip
    """Solve a frame and its neighbours, and take differences; a neighbour without an answer gives none.

    Args:
        mean: State of the estimator, (n,): its parameters are factors of the next two.
        feet: (N, 3) [m], body frame.
        feet_velocity: (N, 3) [m/s].
        stiffness: Of the robot file, (N,) [N/m].
        mu: Of the robot file, (N,).
        anisotropy: (N, 2).
        settings: Of ``record_of``.
        rows: Out: of the frame: vx, vy, yaw rate with sway; slope_x, slope_y, height; each foot's
            horizontal force and load. Below it their derivatives, (1 + 3 N, 6 + 3 N).
        slip: Out: of the frame, (N, 2) [m/s].
        sway: Out: of the frame, (2,) [m/s].

    Returns:
        0, or why the frame has no answer (``model.quasistatic.frames.Reason``).
    """
    # all that is handed on may be written: machine code of its own for what may not costs seconds
    return _solve_around(
        mean, feet, feet_velocity, stiffness, mu, anisotropy, settings, rows, slip, sway,
        feet.copy(), feet_velocity.copy(), _frame_space(feet.shape[0]),
    )  # fmt: skip


class FrameSpace(NamedTuple):
    """Work space of ``neighbourhood_kernel`` for N feet.

    Attributes:
        springs: Stiffness in the frame, as it is stepped, (2, N).
        grips: Friction, the same way, (2, N).
        ground: Heights, all 0, (N,).
        sway: Of ``tilt_sway``.
        work: Rows of the frame now, and of the frame that is not stepped, (2, ROWS, N).
        tilt: Slopes and height, (3,).
        loads: As they are now, and of the frame that is not stepped, (2, N).
        twist: (3,).
        slips: Slip and force of the feet, (2, N, 2).
        ansatz: Of ``_blend``.
        rest: Feet at rest, now and in the frame that is not stepped, (2, N).
        nothing: (0,).
        balance: Of ``balance_frame``.
    """

    springs: FloatArray
    grips: FloatArray
    ground: FloatArray
    sway: SwaySpace
    work: FloatArray
    tilt: FloatArray
    loads: FloatArray
    twist: FloatArray
    slips: FloatArray
    ansatz: tuple[FloatArray, FloatArray, FloatArray]
    rest: BoolArray
    nothing: FloatArray
    balance: BalanceSpace


@compiled
def _frame_space(count: int) -> FrameSpace:
    """Work space for N feet."""
    return FrameSpace(
        np.empty((2, count)), np.empty((2, count)), np.zeros(count), sway_space(count),
        np.empty((2, ROWS, count)), np.empty(3), np.empty((2, count)), np.empty(3),
        np.zeros((2, count, 2)), (np.empty(3), np.empty((count, 2)), np.empty((count, 2))),
        np.zeros((2, count), dtype=np.bool_), np.empty(0), balance_space(count),
    )  # fmt: skip


@in_place
@compiled
def _solve_around(
    mean: FloatArray, feet: FloatArray, feet_velocity: FloatArray, stiffness: FloatArray,
    mu: FloatArray, anisotropy: FloatArray, settings: Record, rows: FloatArray, slip: FloatArray,
    sway: FloatArray, place: FloatArray, speed: FloatArray, space: FrameSpace,
) -> int:  # fmt: skip
    """``neighbourhood_kernel`` in a work space; ``place`` and ``speed`` are copies of the feet."""
    load, coulomb = settings[0]["weight_n"], settings[0]["coulomb"]
    sway_step, rest_speed = settings[0]["sway_step_s"], settings[0]["rest_speed"]
    count = feet.shape[0]
    spring, springs, friction, grip = (
        space.springs[0], space.springs[1], space.grips[0], space.grips[1],
    )  # fmt: skip
    ground, work, own = space.ground, space.work[0], space.work[1]
    tilt, twist, carried, loads = space.tilt, space.twist, space.loads[0], space.loads[1]
    side, pull, ansatz = space.slips[0], space.slips[1], space.ansatz
    rest, rested, nothing, balance = space.rest[0], space.rest[1], space.nothing, space.balance
    lay_parameters(mean, stiffness, mu, spring, friction)
    _lay_row(spring, springs)
    _lay_row(friction, grip)
    lay_anisotropy(anisotropy, work)
    exact = FootLaw(coulomb, 0.0, 1.0, 1.0, 1.0)
    stepped = np.exp(LOG_STEP)
    share, scale, dx, dy = 1.0, 1.0, 0.0, 0.0
    # the frame, then K, mu and foot speeds stepped: one loop, so that there is one copy of the solvers
    for number in range(1 + 3 * count):
        stage = (number + count - 1) // count
        k = max(number - 1, 0) % count
        row = number
        if stage == STIFFNESS:
            row = number + count
        elif stage == FRICTION:
            row = number - count
        if stage != FRAME:
            _lay_row(rows[0], rows[row])
            if number == 1 + count:
                _lay(own, work)
                _lay_row(rows[0, 3:6], tilt)
                _lay_row(loads, carried)
                dx, dy = sway[0], sway[1]
            # a foot in the air changes nothing, nor does its spring if it stays there
            if loads[k] <= 0.0 and (
                stage != STIFFNESS or _aloft(place, speed, rows[0, 3:6], k, sway_step)
            ):
                continue
        if stage == FRICTION:
            grip[k] = friction[k] * stepped
        elif stage == SPEED:
            speed[k, 0] = feet_velocity[k, 0] + SPEED_STEP_M_S
        else:
            springs[k] = spring[k] * stepped if stage == STIFFNESS else spring[k]
            reason = support_kernel(place, ground, springs, load, tilt, carried, work)
            if reason >= 0 and sway_step > 0.0:
                dx, dy = tilt_sway(
                    place, speed, ground, springs, load, sway_step, tilt[2], space.sway
                )
            springs[k] = spring[k]
            if reason < 0:
                if stage == FRAME:
                    return -reason
                continue
        if not foot_speeds(speed, work):
            return NOT_A_NUMBER
        speed[k, 0] = feet_velocity[k, 0]
        warm = stage != FRAME
        if warm:
            twist[0], twist[1], twist[2] = rows[0, 0] - sway[0], rows[0, 1] - sway[1], rows[0, 2]
        for j in range(count):
            rest[j] = rested[j]
        if coulomb:
            # with several feet at rest no force is taken from here: ``_slip_share`` is 0
            creep = warm and share > 0.0
            reason, _ = balance_frame(
                work, carried, grip, exact, nothing, side[:0], warm, twist, side, pull, rest, creep,
                balance,
            )  # fmt: skip
        else:
            reason = traction_kernel(work, carried, grip, twist, side, pull)
        if reason != 0:
            if stage == FRAME:
                return reason
            grip[k] = friction[k]
            continue
        if stage == FRAME:
            sway[0], sway[1] = dx, dy
            _lay(side, slip)
            for j in range(count):
                rested[j] = rest[j]
            _lay(work, own)
            _lay_row(carried, loads)
            if coulomb:
                share = _slip_share(carried, side, rest, rest_speed)
            else:
                scale = coulomb_scale(side, pull, CREEP_SPEED_M_S)
        if stage in (FRAME, STIFFNESS):
            _lay_row(tilt, rows[row, 3:6])
            for j in range(count):
                rows[row, 8 + 3 * j] = carried[j]
        if stage != SPEED:
            _blend(work, carried, grip, share, pull, ansatz)
            for j in range(count):
                rows[row, 6 + 3 * j] = scale * pull[j, 0]
                rows[row, 7 + 3 * j] = scale * pull[j, 1]
        grip[k] = friction[k]
        rows[row, 0] = twist[0] + dx
        rows[row, 1] = twist[1] + dy
        rows[row, 2] = twist[2]
    for row in range(1, 1 + 3 * count):
        step = LOG_STEP if row <= 2 * count else SPEED_STEP_M_S
        for i in range(rows.shape[1]):
            rows[row, i] = (rows[row, i] - rows[0, i]) / step
    return 0


def prepare() -> None:
    """Compile for read-only inputs, which writable ones fit too, and for nothing else after."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(neighbourhood_kernel, *given(1, 2, 2, 1, 1, 2), settings, *out(2, 2, 1))
