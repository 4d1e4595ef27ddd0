"""The model at robots that differ from the file by its tolerances, compiled: what a wrong file would do.

No noise that is drawn again in every tick stands for a leg that is too long: its error comes back with each
stride, is large where feet come down and lift off, and adds up. So a few robots walk along beside the one
of the file, each with one foot, the centre of mass or the slope of the ground off by a standard deviation,
up or down. How far their answers lie apart is what tolerances do.
"""

from typing import NamedTuple

import numpy as np

from model.compiled import FLAG, NUMBER, compile_for, compiled, given, in_place, out
from model.estimator.frame_kernel import CLEAR_M, lay_parameters
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.sway_kernel import SwaySpace, sway_space, tilt_sway
from model.support.kernel import ROWS, support_kernel
from model.traction.coulomb_frame import BalanceSpace, balance_frame, balance_space
from model.traction.coulomb_kernel import FootLaw
from model.traction.kernel import FINE, foot_speeds, lay_anisotropy
from model.values.arrays import BoolArray, FloatArray
from model.values.estimate import VELOCITY

COM_X, COM_Y, SLOPE_X, SLOPE_Y = 0, 1, 2, 3  # behind the feet in a row of the design
OTHERS = 4
VX, VY = VELOCITY.start, VELOCITY.start + 1  # in the state
CREEP_M_S = 1e-5  # of feet that hold a robot on a slope


@compiled
def tolerance_kernel(
    mean: FloatArray, feet: FloatArray, feet_velocity: FloatArray, stiffness: FloatArray,
    mu: FloatArray, anisotropy: FloatArray, settings: Record, answer: FloatArray,
    slip: FloatArray, sway: FloatArray, design: FloatArray, dt_s: float, twist: FloatArray,
    resting: BoolArray, moved: FloatArray, apart: FloatArray, share: FloatArray,
    covariance: FloatArray,
) -> None:  # fmt: skip
    """Solve a frame at M robots beside the one of the file, and let them take the step that leads to it.

    Args:
        mean: State of the estimator, (n,).
        feet: (N, 3) [m], body frame.
        feet_velocity: (N, 3) [m/s].
        stiffness: Of the robot file, (N,) [N/m].
        mu: Of the robot file, (N,).
        anisotropy: (N, 2).
        settings: Of ``record_of``.
        answer: Row 0 of ``Neighbourhood``: the answer at the robot file.
        slip: Of its feet, of ``Neighbourhood``, (N, 2) [m/s]; exactly 0 for feet at rest.
        sway: Of ``Neighbourhood``, (2,) [m/s].
        design: Errors of each foot's height, of the centre of mass along x and y, and of the slope along x
            and y of the world, in standard deviations, (M, N + 4).
        dt_s: Length of the step [s].
        twist: In and out: of each robot, from which its next frame starts on a slope, (M, 3); NaN at first.
        resting: Out: its feet at rest, (M, N).
        moved: In and out: its pose minus that of the file's robot, as in ``Companions.apart``, (M, 3).
        apart: Out: its velocity minus that of the file's robot, (M, 3).
        share: Out: its loads minus those of the file's robot over the weight, (M, N).
        covariance: Out: of the poses, (3, 3).
    """
    _solve_beside(
        mean, feet, feet_velocity, stiffness, mu, anisotropy, settings, answer, slip, sway, design,
        dt_s, twist, resting, moved, apart, share, covariance, feet.copy(), feet_velocity.copy(),
        _robot_space(feet.shape[0]),
    )  # fmt: skip


class RobotSpace(NamedTuple):
    """Work space of ``tolerance_kernel`` for N feet.

    Attributes:
        feet: Ground below each foot, its stiffness, friction and load, (4, N).
        work: (ROWS, N).
        sway: Of ``tilt_sway``.
        tilt: Slopes and height, and the velocity, (2, 3).
        slips: Slip and force of the feet, (2, N, 2).
        rest: Feet at rest, (N,).
        outside: Push on the body, (5,).
        nothing: (0, 2).
        balance: Of ``balance_frame``.
    """

    feet: FloatArray
    work: FloatArray
    sway: SwaySpace
    tilt: FloatArray
    slips: FloatArray
    rest: BoolArray
    outside: FloatArray
    nothing: FloatArray
    balance: BalanceSpace


@compiled
def _robot_space(count: int) -> RobotSpace:
    """Work space for N feet."""
    return RobotSpace(
        np.empty((4, count)), np.empty((ROWS, count)), sway_space(count), np.empty((2, 3)),
        np.zeros((2, count, 2)), np.zeros(count, dtype=np.bool_), np.zeros(5), np.empty((0, 2)),
        balance_space(count),
    )  # fmt: skip


@in_place
@compiled
def _solve_beside(
    mean: FloatArray, feet: FloatArray, feet_velocity: FloatArray, stiffness: FloatArray,
    mu: FloatArray, anisotropy: FloatArray, settings: Record, answer: FloatArray,
    slip: FloatArray, sway: FloatArray, design: FloatArray, dt_s: float, twist: FloatArray,
    resting: BoolArray, moved: FloatArray, apart: FloatArray, share: FloatArray,
    covariance: FloatArray, place: FloatArray, speed: FloatArray, space: RobotSpace,
) -> None:  # fmt: skip
    """``tolerance_kernel`` in a work space; ``place`` and ``speed`` are copies of the feet."""
    setting = settings[0]
    load, height = setting["weight_n"], answer[5]
    count, robots = feet.shape[0], design.shape[0]
    sway_step, work = setting["sway_step_s"], space.work
    lay_anisotropy(anisotropy, work)
    ground, spring, grip, carried = space.feet[0], space.feet[1], space.feet[2], space.feet[3]
    lay_parameters(mean, stiffness, mu, spring, grip)
    tilt, own, side, pull = space.tilt[0], space.tilt[1], space.slips[0], space.slips[1]
    rest, outside, nothing, balance = space.rest, space.outside, space.nothing, space.balance
    law = FootLaw(setting["coulomb"], 0.0, 1.0, 1.0, 1.0)
    # the exact law knows no push: on a slope feet that hold creep, too slowly to matter
    pushed = FootLaw(setting["coulomb"], CREEP_M_S, 1.0, 1.0, 1.0)
    up, aside = setting["height_sd"] * height, setting["com_sd"] * height
    c, s = np.cos(mean[2]), np.sin(mean[2])
    alike = -1  # the first robot that differs only in feet which touch nothing
    for robot in range(robots):
        if _touches_alike(feet, feet_velocity, answer, design[robot], up, sway_step):
            if alike >= 0:
                for i in range(3):
                    twist[robot, i], apart[robot, i] = twist[alike, i], apart[alike, i]
                for k in range(count):
                    resting[robot, k], share[robot, k] = resting[alike, k], share[alike, k]
                continue
            alike = robot
        steep_x = setting["slope_sd"] * design[robot, count + SLOPE_X]
        steep_y = setting["slope_sd"] * design[robot, count + SLOPE_Y]
        down_x, down_y = c * steep_x + s * steep_y, -s * steep_x + c * steep_y
        # gravity acts below the centre of mass, and on a slope farther downhill
        x = aside * design[robot, count + COM_X] + height * down_x
        y = aside * design[robot, count + COM_Y] + height * down_y
        for k in range(count):
            ground[k] = up * design[robot, k]
            place[k, 0], place[k, 1] = feet[k, 0] - x, feet[k, 1] - y
        apart[robot, 0] = apart[robot, 1] = apart[robot, 2] = 0.0
        for k in range(count):
            share[robot, k] = 0.0
        if support_kernel(place, ground, spring, load, tilt, carried, work) < 0:
            continue
        if not foot_speeds(speed, work):
            continue
        sway_x, sway_y = 0.0, 0.0
        if sway_step > 0.0:
            sway_x, sway_y = tilt_sway(
                place, speed, ground, spring, load, sway_step, tilt[2], space.sway
            )
        outside[0], outside[1] = load * down_x, load * down_y
        # what rests in the file's robot nearly always rests here too; on a slope all feet creep
        steep = down_x != 0.0 or down_y != 0.0
        own[0], own[1], own[2] = answer[0] - sway[0], answer[1] - sway[1], answer[2]
        for i in range(3 if steep else 0):
            own[i] = twist[robot, i]
        for k in range(count):
            rest[k] = setting["coulomb"] and answer[8 + 3 * k] > 0.0
            rest[k] = rest[k] and slip[k, 0] == 0.0 and slip[k, 1] == 0.0
        reason, _ = balance_frame(
            work, carried, grip, pushed if steep else law, outside, nothing, True, own, side, pull,
            rest, False, balance,
        )  # fmt: skip
        if reason != FINE:
            twist[robot, 0] = np.nan
            continue
        for i in range(3):
            twist[robot, i] = own[i]
        for k in range(count):
            resting[robot, k] = rest[k]
            share[robot, k] = (carried[k] - answer[8 + 3 * k]) / load
        # the velocity of the body's origin, which lies beside that of gravity
        apart[robot, 0] = own[0] + own[2] * y + sway_x - answer[0]
        apart[robot, 1] = own[1] - own[2] * x + sway_y - answer[1]
        apart[robot, 2] = own[2] - answer[2]
    # one that heads elsewhere goes elsewhere with the whole velocity
    along, aside = s * mean[VX] + c * mean[VY], c * mean[VX] - s * mean[VY]
    for robot in range(robots):
        vx, vy, turned = apart[robot, 0], apart[robot, 1], moved[robot, 2]
        moved[robot, 0] += dt_s * (c * vx - s * vy - turned * along)
        moved[robot, 1] += dt_s * (s * vx + c * vy + turned * aside)
        moved[robot, 2] += dt_s * apart[robot, 2]
    for i in range(3):
        for j in range(3):
            total = 0.0
            for robot in range(robots):
                total += 0.5 * moved[robot, i] * moved[robot, j]
            covariance[i, j] = total


@in_place
@compiled
def _touches_alike(
    feet: FloatArray, feet_velocity: FloatArray, answer: FloatArray, errors: FloatArray, up: float,
    step_s: float,
) -> bool:  # fmt: skip
    """Whether a robot differs from the file's only in the height of feet that touch nothing either way.

    Neither do they a moment before or after.
    """
    count = feet.shape[0]
    for i in range(count, errors.size):
        if errors[i] != 0.0:
            return False
    for k in range(count):
        if errors[k] != 0.0:
            clear = answer[5] + feet[k, 2] - answer[3] * feet[k, 0] + answer[4] * feet[k, 1]
            near = CLEAR_M + up * abs(errors[k]) + 2.0 * step_s * abs(feet_velocity[k, 2])
            if answer[8 + 3 * k] > 0.0 or not clear > near:
                return False
    return True


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        tolerance_kernel, *given(1, 2, 2, 1, 1, 2), settings, *given(1, 2, 1, 2), NUMBER,
        *out(2), *out(2, kind=FLAG), *out(2, 2, 2, 2),
    )  # fmt: skip
