"""How the body shakes: feet that stick and slip by turns move it faster than a model of frames follows.

Friction that is stronger at rest than in sliding makes feet let go and catch again many times a second.
That moves the body to and fro about the velocity that is estimated. It adds nothing to the pose, so it is
no part of the state: it is a variance of the velocity that is reported, and of a gyro's reading, which is
never of the very moment of the tick.
"""

from math import isfinite

import numpy as np

from model.compiled import NUMBER, compile_for, compiled, given, in_place, out
from model.estimator.neighbourhood import Neighbourhood
from model.estimator.senses import Heard
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.values.arrays import FloatArray, readonly
from model.values.estimate import EstimatorState, OdometryInputs, Vibration
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootMotion

MEMORY_S = 0.3
MOST = 9.0  # of a squared change over the mean of them: a kick is no vibration
UNKNOWN = readonly(np.full(3, np.nan))
AT_REST = Vibration(UNKNOWN, readonly(np.zeros(3)), np.nan, 0.0)


def learn(
    state: EstimatorState,
    inputs: OdometryInputs,
    feet: FootMotion,
    heard: Heard,
    left: float,
    settings: EstimatorSettings,
) -> Vibration:
    """Learn how forces and a gyro change from one record to the next.

    What lasts longer than that is left out: it is no vibration, but a contradiction of the model.

    Args:
        state: Before the tick.
        inputs: Its time.
        feet: Of the tick.
        heard: Forces of the tick.
        left: A gyro's innovation, NaN without one [rad/s].
        settings: Noise; whether anything is learned.
    """
    before, dt_s = state.vibration, (inputs.t_ns - state.t_ns) * 1e-9
    if not settings.adaptive or not 0 < dt_s <= settings.longest_gap_s:
        return AT_REST
    part = min(dt_s / MEMORY_S, 1.0)
    force, change = before.force, before.force_change
    if heard.fresh and heard.whole:
        force, change = np.empty(3), np.empty(3)
        change_kernel(
            np.ascontiguousarray(feet.position_m), heard.share, before.force, before.force_change,
            part, settings.force_sd**2, force, change,
        )  # fmt: skip
    elif (inputs.t_ns - state.force_ns) * 1e-9 > settings.stale_force_s:
        force = UNKNOWN
    turn, turn_change = before.turn, before.turn_change
    if isfinite(left):
        turn = left
    elif (inputs.t_ns - state.gyro_ns) * 1e-9 > settings.stale_force_s:
        turn = np.nan
    if isfinite(before.turn + left):
        half_turn = 0.5 * (left - before.turn) ** 2
        most_turn = MOST * max(turn_change, settings.gyro_sd**2)
        turn_change += part * (min(half_turn, most_turn) - turn_change)
    return Vibration(readonly(force), readonly(change), turn, turn_change)


def variance(
    known: Vibration, model: Neighbourhood, feet: FootMotion, settings: Record
) -> FloatArray:
    """Variance of vx, vy [m^2/s^2] and yaw rate [rad^2/s^2] that vibration adds, (3,).

    Forces that change by so much from record to record accelerate the body as much; a gyro shows its
    turning itself. Where neither is there it is taken to grow with the slip that the model predicts.

    Args:
        known: What was learned.
        model: The model's answer at the tick.
        feet: Of the tick.
        settings: Of ``record_of``: how long a force lasts, what is assumed without forces and gyro, noise
            of both.
    """
    added = np.empty(3)
    variance_kernel(
        np.ascontiguousarray(feet.position_m), known.force, known.force_change, known.turn,
        known.turn_change, model.rows, model.slip_B, settings, added,
    )  # fmt: skip
    return added


@in_place
@compiled
def change_kernel(
    position: FloatArray, share: FloatArray, force: FloatArray, change: FloatArray, part: float,
    least: float, force_now: FloatArray, change_now: FloatArray,
) -> None:  # fmt: skip
    """Learn how forces change with a new record.

    Args:
        position: Feet, (N, 3) [m].
        share: Measured forces over the weight, (N, 3).
        force: Of ``Vibration``, (3,): of the record before.
        change: Of ``Vibration``, (3,): what is known.
        part: Share of this record in it.
        least: Variance of the forces, below which a change is no kick.
        force_now: Out: of this record, (3,).
        change_now: Out: what is known now, (3,).
    """
    x, y, turning, back = 0.0, 0.0, 0.0, 0.0
    for k in range(position.shape[0]):
        x += share[k, 0]
        y += share[k, 1]
        turning += position[k, 0] * share[k, 1]
        back += position[k, 1] * share[k, 0]
    force_now[0], force_now[1], force_now[2] = x, y, turning - back
    check = 0.0
    for i in range(3):
        check += 0.0 * (force[i] + force_now[i])
    for i in range(3):
        change_now[i] = change[i]
        if check == 0.0:
            half = 0.5 * (force_now[i] - force[i]) ** 2
            change_now[i] += part * (min(half, MOST * max(change[i], least)) - change[i])


@in_place
@compiled
def variance_kernel(
    position: FloatArray, force: FloatArray, change: FloatArray, turn: float, turn_change: float,
    rows: FloatArray, slip: FloatArray, settings: Record, added: FloatArray,
) -> None:  # fmt: skip
    """Variance that vibration adds: ``variance``.

    Args:
        position: Feet, (N, 3) [m].
        force: Of ``Vibration``, (3,), as are the next three.
        change: (3,).
        turn: [rad/s].
        turn_change: [rad^2/s^2].
        rows: Of ``Neighbourhood``.
        slip: Of the feet, (N, 2) [m/s].
        settings: Of ``record_of``.
        added: Out: (3,).
    """
    setting, count = settings[0], position.shape[0]
    carried, span, wide, slipping = 0, 0.0, 0.0, 0.0
    for k in range(count):
        square = position[k, 0] ** 2 + position[k, 1] ** 2
        wide += square
        if rows[0, 8 + 3 * k] > 0.0:
            carried += 1
            span += square
            slipping += slip[k, 0] ** 2 + slip[k, 1] ** 2
    span, slipping = span / carried, slipping / carried
    turning = max(turn_change - setting["gyro_sd"] ** 2, 0.0)
    if abs(force[0]) < np.inf and abs(force[1]) < np.inf and abs(force[2]) < np.inf:
        push = (STANDARD_GRAVITY * setting["vibration_s"]) ** 2
        for i in range(3):
            noise = setting["force_white_sd"] ** 2 * (wide if i == 2 else float(count))
            added[i] = max(change[i] - noise, 0.0) * push
        # the mass lies about as far out as the feet
        added[2] = max(added[2] / span**2, turning)
    elif abs(turn) < np.inf:  # about one of the feet
        added[0] = added[1] = 0.5 * span * turning
        added[2] = turning
    else:
        added[0] = added[1] = 0.0
        added[2] = setting["vibration_per_slip"] ** 2 * slipping


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(change_kernel, *given(2, 2, 1, 1), NUMBER, NUMBER, *out(1, 1))
    compile_for(variance_kernel, *given(2, 1, 1), NUMBER, NUMBER, *given(2, 2), settings, *out(1))
