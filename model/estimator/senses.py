"""What a tick's sensors amount to: forces on a scale, contact, standstill, silent encoders, a wrong IMU."""

from functools import cache
from math import isfinite
from typing import NamedTuple

import numpy as np

from model.compiled import FLAG, NUMBER, compile_for, compiled, given, in_place, out
from model.estimator.neighbourhood import Neighbourhood, no_answer
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.values.arrays import BoolArray, FloatArray, readonly
from model.values.estimate import NEVER, EstimatorState, OdometryInputs
from model.values.legs import FootMotion


class Heard(NamedTuple):
    """Forces of a tick.

    Attributes:
        share: Over the weight, (N, 3); NaN where there are none.
        whole: Whether all feet have a load.
        total: Vertical force of all feet over the weight of the robot file; NaN unless whole.
        fresh: Whether the record is a new one.
        use: Whether it is also time to use one.
        steady: Whether each foot carries what it carried in the record before.
    """

    share: FloatArray
    whole: bool
    total: float
    fresh: bool
    use: bool
    steady: bool = True


class TickFeet(NamedTuple):
    """Feet of a tick.

    Attributes:
        feet: Those of silent encoders are where they were last seen; one behind the other in memory.
        dead: Feet of silent encoders, (N,).
        dead_legs: How many these are.
        finite: Whether all places and speeds are numbers now.
        still: Whether all of them stand still in the body.
    """

    feet: FootMotion
    dead: BoolArray
    dead_legs: int
    finite: bool
    still: bool


def hear(
    state: EstimatorState, inputs: OdometryInputs, weight_n: float, settings: EstimatorSettings
) -> tuple[Heard, bool]:
    """Normalise forces so that the weight is 1, as the paper does.

    Returns:
        The forces, and whether they say that the robot has been picked up.
    """
    forces, t_ns, force_ns = inputs.forces, inputs.t_ns, state.force_ns
    if (
        forces is not None
        and forces.t_ns != NEVER
        and forces.t_ns > force_ns
        and (t_ns - forces.t_ns) * 1e-9 <= settings.stale_force_s
    ):
        share = np.empty(forces.force_n.shape)
        some, total, steady = share_kernel(
            np.ascontiguousarray(forces.force_n), np.ascontiguousarray(forces.valid), weight_n,
            state.share, settings.steady_load, share,
        )  # fmt: skip
        if some:
            whole = isfinite(total)
            airborne = whole and total < settings.airborne_share * weight_n
            due = state.used_ns == NEVER or (
                (t_ns - state.used_ns) * 1e-9 > settings.force_period_s - 1e-3
            )
            return (
                Heard(share, whole, total / weight_n, True, due and not airborne, steady),
                airborne,
            )
    stale_s = (t_ns - force_ns) * 1e-9
    believed = force_ns != NEVER and stale_s <= settings.stale_force_s
    return _nothing(len(state.contact)), state.airborne and believed


@in_place
@compiled
def share_kernel(
    force_n: FloatArray, valid: BoolArray, weight_n: float, before: FloatArray, limit: float,
    share: FloatArray,
) -> tuple[bool, float, bool]:  # fmt: skip
    """Put forces on a scale on which the feet carry 1.

    With a transducer missing the sum is not the weight's; then the robot file's is taken.

    Args:
        force_n: (N, 3) [N].
        valid: Which of them are there, (N,).
        weight_n: Of the robot file [N].
        before: Share of each foot in the record before, (N,).
        limit: Largest change of a share that is steady.
        share: Out: over the weight, (N, 3); NaN where there are none.

    Returns:
        Whether there are any, the sum of vertical forces [N], NaN if some are missing, and whether none
        changed by more than the limit.
    """
    total, some, steady = 0.0, False, True
    for k in range(valid.size):
        some = some or valid[k]
        total += force_n[k, 2] if valid[k] else np.nan
    unit = total if abs(total) < np.inf and total > 0.0 else weight_n
    for k in range(valid.size):
        for i in range(3):
            share[k, i] = force_n[k, i] / unit if valid[k] else np.nan
        steady = steady and not abs(share[k, 2] - before[k]) > limit
    return some, total, steady


@cache
def _none(legs: int) -> BoolArray:
    """No leg of so many."""
    return readonly(np.zeros(legs, dtype=bool))


@cache
def _nothing(legs: int) -> Heard:
    """No forces at all, of so many feet."""
    return Heard(
        readonly(np.full((legs, 3), np.nan)), whole=False, total=np.nan, fresh=False, use=False
    )


def idle_since(state: EstimatorState, t_ns: int, feet: TickFeet, heard: Heard) -> int:
    """Since when the feet stand still in the body under steady loads; -1 if they do not."""
    if not feet.still or (heard.fresh and not heard.steady):
        return NEVER
    return state.idle_ns if state.idle_ns != NEVER else t_ns


class Expected(NamedTuple):
    """What is expected of the feet.

    Attributes:
        contact: Loaded feet, with hysteresis, by the measured share where there is one, else the model's.
        share: The model's forces over the weight, (N, 3); NaN without an answer.
    """

    contact: BoolArray
    share: FloatArray


def expect(
    state: EstimatorState,
    model: Neighbourhood | None,
    heard: Heard,
    settings: Record,
    *,
    airborne: bool,
) -> Expected:
    """Say which feet are loaded, and with what.

    Args:
        state: Before the tick: which feet were loaded.
        model: The model's answer.
        heard: Forces of the tick.
        settings: Of ``record_of``.
        airborne: Whether the robot is picked up: nobody knows what it would do.
    """
    before = state.contact
    legs = len(before)
    nothing = no_answer(legs).rows
    by_model = model is not None and not heard.whole
    loaded, share = np.empty(legs, np.bool_), np.empty((legs, 3))
    expect_kernel(
        heard.share, model.rows if model is not None and by_model else nothing,
        model.rows if model is not None and not airborne else nothing, before, settings, loaded, share,
    )  # fmt: skip
    return Expected(loaded if by_model or heard.fresh else before, share)


@in_place
@compiled
def expect_kernel(
    heard: FloatArray, standing_in: FloatArray, rows: FloatArray, before: BoolArray,
    settings: Record, loaded: BoolArray, share: FloatArray,
) -> None:  # fmt: skip
    """Which feet carry more than a limit, lower for those that did before, and what the model says.

    Args:
        heard: Measured forces over the weight, (N, 3); NaN where there are none.
        standing_in: Rows of ``Neighbourhood``, whose loads stand in for those that are missing; NaN if
            they should not.
        rows: Rows of ``Neighbourhood``.
        before: Feet that were loaded, (N,).
        settings: Of ``record_of``.
        loaded: Out: feet that are loaded, (N,).
        share: Out: the model's forces over the weight, (N, 3).
    """
    setting = settings[0]
    weight = setting["weight_n"]
    for k in range(before.size):
        load, known = heard[k, 2], standing_in[0, 8 + 3 * k]
        if not abs(load) < np.inf and abs(known) < np.inf:
            load = known / weight
        loaded[k] = load > (setting["load_off"] if before[k] else setting["load_on"])
        for i in range(3):
            share[k, i] = rows[0, 6 + 3 * k + i] / weight


def see(now: FootMotion, before: FootMotion, idle_speed: float) -> TickFeet:
    """Look at feet; those of silent encoders are held where they were last seen.

    Args:
        now: Feet of the tick; NaN for a leg without encoder.
        before: Where they were last seen.
        idle_speed: Feet slower than this stand still [m/s].
    """
    position, velocity = (
        np.ascontiguousarray(now.position_m),
        np.ascontiguousarray(now.velocity_m_s),
    )
    finite, still = feet_kernel(position, velocity, idle_speed)
    if finite:
        feet = now
        if position is not now.position_m or velocity is not now.velocity_m_s:
            feet = FootMotion(position, velocity)
        return TickFeet(feet, _none(len(position)), 0, True, still)
    known = np.asarray(np.isfinite(np.hstack([position, velocity])).all(axis=1))
    position = np.where(known[:, None], position, before.position_m)
    velocity = np.where(known[:, None], velocity, 0.0)
    finite, still = feet_kernel(position, velocity, idle_speed)
    return TickFeet(
        FootMotion(position, velocity), ~known, int(np.count_nonzero(~known)), finite, still
    )


@in_place
@compiled
def feet_kernel(position: FloatArray, velocity: FloatArray, idle_speed: float) -> tuple[bool, bool]:
    """Whether all places and speeds, (N, 3), are numbers, and whether all speeds are below a limit."""
    check, still = 0.0, True
    for k in range(position.shape[0]):
        for i in range(3):
            speed = abs(velocity[k, i])
            check += 0.0 * (position[k, i] + speed)
            still = still and speed < idle_speed
    return check == 0.0, still


def prepare() -> None:
    """Load or make the machine code now, so that no tick has to wait for it."""
    compile_for(feet_kernel, *given(2, 2), NUMBER)
    compile_for(
        share_kernel, *given(2), *given(1, kind=FLAG), NUMBER, *given(1), NUMBER, *out(2)
    )  # fmt: skip
    settings = record_of(EstimatorSettings(), 1.0)
    compile_for(
        expect_kernel, *given(2, 2, 2), *given(1, kind=FLAG), settings, *out(1, kind=FLAG), *out(2)
    )  # fmt: skip
