"""What a tick's sensors amount to: forces on a scale, contact, standstill, silent encoders, a wrong IMU."""

from functools import cache
from math import isfinite
from typing import NamedTuple

import numpy as np

from model.estimator.neighbourhood import Neighbourhood
from model.estimator.settings import EstimatorSettings
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
    """

    share: FloatArray
    whole: bool
    total: float
    fresh: bool
    use: bool


def hear(
    state: EstimatorState, inputs: OdometryInputs, weight_n: float, settings: EstimatorSettings
) -> tuple[Heard, bool]:
    """Normalise forces so that the weight is 1, as the paper does.

    Returns:
        The forces, and whether they say that the robot has been picked up.
    """
    forces = inputs.forces
    age_ns = inputs.t_ns - forces.t_ns if forces is not None else 0
    valid = forces.valid.tolist() if forces is not None else []
    if (
        forces is None
        or forces.t_ns == NEVER
        or forces.t_ns <= state.force_ns
        or age_ns * 1e-9 > settings.stale_force_s
        or True not in valid
    ):
        stale_s = (inputs.t_ns - state.force_ns) * 1e-9
        believed = state.force_ns != NEVER and stale_s <= settings.stale_force_s
        return _nothing(len(state.contact)), state.airborne and believed
    force = forces.force_n
    if False in valid:
        force = np.where(forces.valid[:, None], force, np.nan)
    total = sum(force[:, 2].tolist())
    # with a transducer missing the sum is not the weight's; then the robot file's is taken
    whole = isfinite(total)
    airborne = whole and total < settings.airborne_share * weight_n
    unit = total if whole and total > 0 else weight_n
    due_s = (inputs.t_ns - state.used_ns) * 1e-9
    due = state.used_ns == NEVER or due_s > settings.force_period_s - 1e-3
    return Heard(
        force / unit, whole, total / weight_n, fresh=True, use=due and not airborne
    ), airborne


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


def idle_since(
    state: EstimatorState,
    t_ns: int,
    feet: FootMotion,
    heard: Heard,
    settings: EstimatorSettings,
) -> int:
    """Since when the feet stand still in the body under steady loads; -1 if they do not."""
    speed = feet.velocity_m_s
    # the mean square says the same of a walk, at a fraction of the cost of the largest
    if float(np.vdot(speed, speed)) > speed.size * settings.idle_speed**2:
        return NEVER
    if not np.abs(speed).max() < settings.idle_speed:
        return NEVER
    if heard.fresh and (np.abs(heard.share[:, 2] - state.share) > settings.steady_load).any():
        return NEVER
    return state.idle_ns if state.idle_ns != NEVER else t_ns


def contact(
    state: EstimatorState,
    model: Neighbourhood | None,
    heard: Heard,
    weight_n: float,
    settings: EstimatorSettings,
) -> BoolArray:
    """Loaded feet, with hysteresis, by the measured share where there is one, else the model's."""
    share: list[float] = heard.share[:, 2].tolist()
    if model is not None and not heard.whole:
        loads = (model.load_n / weight_n).tolist()
        share = [own if isfinite(own) else load for own, load in zip(share, loads, strict=True)]
    elif not heard.fresh:
        return state.contact
    limits = (settings.load_on, settings.load_off)
    touched = zip(share, state.contact.tolist(), strict=True)
    return np.array([load > limits[before] for load, before in touched])


def finite(feet: FootMotion) -> bool:
    """Whether all places and speeds are numbers: a sum of squares is one only if they are."""
    place, speed = feet.position_m, feet.velocity_m_s
    return isfinite(np.vdot(place, place)) and isfinite(np.vdot(speed, speed))


def bridged(now: FootMotion, before: FootMotion) -> tuple[FootMotion, BoolArray]:
    """Feet with those of silent encoders held where they were last seen; which ones those are."""
    if finite(now):
        return now, _none(len(now.position_m))
    both = np.hstack([now.position_m, now.velocity_m_s])
    known = np.asarray(np.isfinite(both).all(axis=1))
    position = np.where(known[:, None], now.position_m, before.position_m)
    velocity = np.where(known[:, None], now.velocity_m_s, 0.0)
    return FootMotion(position, velocity), ~known
