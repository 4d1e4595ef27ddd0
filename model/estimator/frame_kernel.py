"""The model around one frame, compiled: the answer, and the answers beside it that Jacobians need.

One call solves support and traction at the given parameters and once more for every parameter stepped by
a little, so that an estimator gets all derivatives for the price of a few dozen frames.

Rows of the answers: 0 the frame itself, then N with log mu of one foot stepped, N with log K stepped,
N with a foot's speed along x stepped (legs swing fore and aft: that is where a shaft's noise goes).
"""

import numpy as np

from model.compiled import FLAG, NUMBER, compile_for, compiled, given, out
from model.support.kernel import ROWS, support_kernel
from model.traction.coulomb_frame import coulomb_frame
from model.traction.kernel import foot_speeds, lay_anisotropy, traction_kernel
from model.values.arrays import BoolArray, FloatArray

NOT_A_NUMBER = 1
CREEP_SPEED_M_S = 1e-3  # as in ``model.frame_kernel``: puts the ansatz' forces on a scale
FRAME, STIFFNESS, FRICTION, SPEED = 0, 1, 2, 3  # what is stepped
CLEAR_M = 1e-3  # beyond how far a foot moves in a moment: what the body's own tilt may add


@compiled
def _lay(given: FloatArray, out: FloatArray) -> None:
    """Copy rows: what ``out[:] = given`` does, for a tenth of the compiler's time."""
    for k in range(given.shape[0]):
        for i in range(given.shape[1]):
            out[k, i] = given[k, i]


@compiled
def _lay_row(given: FloatArray, out: FloatArray) -> None:
    """Copy one row."""
    for i in range(given.size):
        out[i] = given[i]


@compiled
def _sway(
    feet: FloatArray,
    feet_velocity: FloatArray,
    ground: FloatArray,
    stiffness: FloatArray,
    load: float,
    step_s: float,
    height: float,
    moved: FloatArray,
    work: FloatArray,
) -> tuple[float, float]:
    """Horizontal velocity of the body origin as it tilts over the ground below it.

    Slopes a moment before and after, from the feet's own velocities: exact, and without the delay of a
    filter. Where either has no support there is no sway to speak of.
    """
    tilt = np.empty(3)
    loads = np.empty(feet.shape[0])
    turn_x, turn_y = 0.0, 0.0
    for before in range(2):
        way = 1.0 - 2.0 * before
        for k in range(feet.shape[0]):
            for i in range(3):
                moved[k, i] = feet[k, i] + way * step_s * feet_velocity[k, i]
        if support_kernel(moved, ground, stiffness, load, tilt, loads, work) < 0:
            return 0.0, 0.0
        turn_x += way * tilt[0]
        turn_y += way * tilt[1]
    share = height / (2.0 * step_s)
    return share * turn_x, -share * turn_y


@compiled
def _aloft(
    feet: FloatArray, feet_velocity: FloatArray, pose: FloatArray, k: int, step_s: float
) -> bool:
    """Whether a foot is too high to touch the ground a moment before or after."""
    clearance = pose[0, 2] + feet[k, 2] - pose[0, 0] * feet[k, 0] + pose[0, 1] * feet[k, 1]
    high: bool = clearance > CLEAR_M + 2.0 * step_s * abs(feet_velocity[k, 2])
    return high


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
        0, or why the frame has no answer (``model.quasistatic.frames.Reason``).
    """
    count = feet.shape[0]
    # All that is handed on may be written: machine code of its own for what may not costs seconds.
    place, speed = np.empty((count, 3)), np.empty((count, 3))
    springs, grip = np.empty(count), np.empty(count)
    _lay(feet, place)
    _lay(feet_velocity, speed)
    _lay_row(stiffness, springs)
    _lay_row(mu, grip)
    ground, moved = np.zeros(count), np.empty((count, 3))
    work, spare, own = np.empty((ROWS, count)), np.empty((ROWS, count)), np.empty((ROWS, count))
    lay_anisotropy(anisotropy, work)
    stepped = np.exp(log_step)
    tilt, carried, twist = np.empty(3), np.empty(count), np.empty(3)
    side, pull = np.zeros((count, 2)), np.zeros((count, 2))
    rest = np.zeros(count, dtype=np.bool_)
    share, dx, dy = 1.0, 0.0, 0.0
    untilted = count < 0
    # the frame, then K, mu and foot speeds stepped: one loop, so that there is one copy of the solvers
    for number in range(1 + 3 * count):
        stage = (number + count - 1) // count
        k = max(number - 1, 0) % count
        row = number
        if stage == STIFFNESS:
            row = number + count
            _lay_row(loads[0], loads[number])
            _lay_row(pose[0], pose[number])
        elif stage == FRICTION:
            row = number - count
        if stage != FRAME:
            _lay_row(velocity[0], velocity[row])
            if stage != SPEED:
                _lay(force[0], force[row])
            if number == 1 + count:
                _lay(own, work)
                _lay_row(pose[0], tilt)
                _lay_row(loads[0], carried)
                dx, dy = sway[0], sway[1]
            # a foot in the air changes nothing, nor does its spring if it stays there
            if loads[0, k] <= 0.0 and (
                stage != STIFFNESS or _aloft(place, speed, pose, k, sway_step)
            ):
                continue
        if stage == FRICTION:
            grip[k] = mu[k] * stepped
        elif stage == SPEED:
            speed[k, 0] = feet_velocity[k, 0] + speed_step
        else:
            springs[k] = stiffness[k] * stepped if stage == STIFFNESS else stiffness[k]
            found = support_kernel(place, ground, springs, load, tilt, carried, work)
            if found >= 0 and sway_step > 0.0:
                dx, dy = _sway(
                    place, speed, ground, springs, load, sway_step, tilt[2], moved, spare
                )
            springs[k] = stiffness[k]
            if found < 0:
                if stage == FRAME:
                    return -found
                continue
        if not foot_speeds(speed, tilt, untilted, work):
            return NOT_A_NUMBER
        speed[k, 0] = feet_velocity[k, 0]
        twist[0], twist[1], twist[2] = (
            velocity[0, 0] - sway[0],
            velocity[0, 1] - sway[1],
            velocity[0, 2],
        )
        for j in range(count):
            rest[j] = rested[j]
        warm = stage != FRAME
        if coulomb:
            reason, _ = coulomb_frame(work, carried, grip, warm, twist, side, pull, rest)
        else:
            reason = traction_kernel(work, carried, grip, twist, side, pull)
        if reason != 0:
            if stage == FRAME:
                return reason
            grip[k] = mu[k]
            continue
        if stage == FRAME:
            sway[0], sway[1] = dx, dy
            _lay(side, slip)
            for j in range(count):
                rested[j] = rest[j]
            _lay(work, own)
            share = _slip_share(carried, slip, rested, rest_speed) if coulomb else 1.0
        if stage in (FRAME, STIFFNESS):
            _lay_row(carried, loads[number])
            _lay_row(tilt, pose[number])
        if stage != SPEED:
            _blend(work, carried, grip, share, pull)
            _lay(pull, force[row])
        grip[k] = mu[k]
        velocity[row, 0] = twist[0] + dx
        velocity[row, 1] = twist[1] + dy
        velocity[row, 2] = twist[2]
    return 0


def prepare() -> None:
    """Compile for read-only inputs, which writable ones fit too, and for nothing else after."""
    compile_for(
        neighbourhood_kernel, *given(2, 2, 1, 1, 2), NUMBER, FLAG, *(NUMBER,) * 4,
        *out(2, 2, 2, 1, 2, 3), *out(1, kind=FLAG),
    )  # fmt: skip
