"""Everything that could be the cause: each effect at each place, and where its fit may begin.

An effect is linear about its neutral value, as a rule. Where a parameter leaves no trace there (a place, a
limit that is not reached, a law without a size) the fit begins at several values away from it.
"""

import itertools
import math
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.constants import VIBRATION_CLEAR
from gap.interfaces import NOWHERE, Cause, Effect, Parameter, Scope, Simulator, places_for
from gap.residuals.hunting import Hunting
from gap.residuals.vibration import ChannelVibration

NEARBY = 0.05  # of a value, the longest step of a limit
STEP = 0.25  # of the spread, for differences about the neutral value
FINE_STEP = 0.05  # about a fitted one
FINE_BELOW = 0.002  # of a fitted limit, whose edge may be near above it
AWAY = 2.0  # spreads from neutral, of an effect that looks unlike itself there
QUANTILES = (0.15, 0.35, 0.55, 0.75)
WIDE = 6.0  # spreads
APART_M = 0.05  # places from which a fit may find an edge
MOST_PLACES = 24
Family = tuple[str, tuple[str, ...]]
LOG_RANGE = 20.0  # a range wider than this from a positive end is walked by ratios


@dataclass(frozen=True, slots=True)
class Candidate:
    """An effect at a joint, or at none: on the whole machine.

    Attributes:
        forms: How many effects of the catalogue are forms of its cause, which are tried as one.
        vibration: What vibrates in the trials, if that tells it from another effect; None otherwise.
        hunts: How its joint hunts, as it would: which candidate it is, is known before anything is fitted.
            None otherwise.
    """

    effect: Effect
    joints: tuple[str, ...]
    forms: int = 1
    vibration: ChannelVibration | None = None
    hunts: Hunting | None = None

    @property
    def key(self) -> tuple[str, tuple[str, ...]]:
        """Its name and place: no other candidate has both."""
        return (self.effect.name, self.joints)

    @property
    def family(self) -> Family:
        """Name of its cause, whatever the form, and place: what a report names."""
        return (self.effect.family, self.joints)

    @property
    def price(self) -> float:
        """Log likelihood that it costs: several forms were tried, vibration speaks against it [nats]."""
        return math.log(self.forms) + max(0.0, -self.shaken)

    @property
    def shaken(self) -> float:
        """Log likelihood by which vibration speaks for it; below 0 against it, 0 if that is unknown."""
        if self.vibration is None:
            return 0.0
        return self.vibration.nats if self.effect.shaking else -self.vibration.nats

    @property
    def vibrates(self) -> bool:
        """Whether it surely vibrates in the trials, as is seen before anything is fitted."""
        return bool(self.effect.shaking) and self.shaken >= VIBRATION_CLEAR

    def cause(self, values: Sequence[float]) -> Cause:
        """Return it as a cause with these values."""
        return Cause(self.effect.name, self.joints, tuple(float(value) for value in values))

    @property
    def neutral(self) -> tuple[float, ...]:
        """Values at which nothing happens."""
        return tuple(p.neutral for p in self.effect.parameters)


def candidates_of(simulator: Simulator, standing: Sequence[Cause] = ()) -> tuple[Candidate, ...]:
    """Return every candidate, in an order that does not depend on the catalogue's.

    A law among the causes that are there already cannot be added again.
    """
    there = {cause.effect for cause in standing if not cause.values}
    listed = []
    forms = Counter(effect.family for effect in simulator.effects)
    for effect in sorted(simulator.effects, key=lambda one: one.name):
        if effect.name in there:
            continue
        places: list[tuple[str, ...]] = [()] if Scope.ALL in effect.scopes else []
        if Scope.JOINT in effect.scopes:
            places += [(joint,) for joint in places_for(effect, simulator)]
        listed += [Candidate(effect, place, forms[effect.family]) for place in places]
    return tuple(listed)


def with_vibrations(
    candidates: Sequence[Candidate], vibrations: Mapping[str, ChannelVibration]
) -> tuple[Candidate, ...]:
    """Return candidates with what vibrates, by name of the effect that it tells from steady ones.

    Where something surely vibrates, other forms of its cause, which frames would show, are left out: how
    well they follow what is faster than frames is chance.
    """
    both = dict(vibrations)
    for one in candidates:
        if one.effect.shaking and (vibration := vibrations.get(one.effect.name)):
            both |= dict.fromkeys(one.effect.shaking.steady, vibration)
    listed = [replace(one, vibration=both.get(one.effect.name)) for one in candidates]
    sure = {one.effect.family for one in listed if one.vibrates}
    return tuple(one for one in listed if one.effect.shaking or one.effect.family not in sure)


def at_hunting(
    candidates: Sequence[Candidate], hunting: Sequence[Hunting]
) -> tuple[Candidate, ...]:
    """Return candidates without other forms of a cause at joints that hunt, as one of its forms does."""
    how: dict[tuple[str, ...], Hunting] = {(one.joint,): one for one in hunting}
    sure = {one.family for one in candidates if one.effect.hunts and one.joints in how}
    return tuple(
        replace(one, forms=1, hunts=how[one.joints]) if one.family in sure else one
        for one in candidates
        if one.effect.hunts or one.family not in sure
    )


def shares_of(families: Collection[Family]) -> dict[Family, float]:
    """Return the share of a level that each cause has, of a test that tries all of them.

    An effect of the whole machine has as much as one of single joints has at all of them: what is wrong is
    one thing, wherever it is. A level is kept by any shares that sum to 1 (Genovese, Roeder and Wasserman
    2006, doi:10.1093/biomet/93.3.509).
    """
    each = set(families)
    places = Counter((name, len(joints)) for name, joints in each)
    return {one: 1.0 / (len(places) * places[one[0], len(one[1])]) for one in each}


def families_of(causes: Sequence[Cause], effects: Mapping[str, Effect]) -> set[Family]:
    """Return name and place of causes, whatever their form."""
    return {(effects[cause.effect].family, cause.joints) for cause in causes}


def size_of(cause: Cause, effect: Effect) -> float:
    """Largest distance of a cause's numbers from neutral in spreads, places apart; endless for a law."""
    pairs = [(p, v) for p, v in zip(effect.parameters, cause.values, strict=True) if not p.located]
    return max((abs(v - p.neutral) / p.spread for p, v in pairs), default=math.inf)


def too_small(cause: Cause, effect: Effect, least_size: float = 0.0) -> bool:
    """Whether a cause is smaller than its effect, or a search, names any [spreads]."""
    least = max(least_size, effect.least_size)
    return least > 0.0 and size_of(cause, effect) < least


def step_of(parameter: Parameter, value: float, share: float) -> float:
    """Return a step within the bounds, negative if there is no room above."""
    step = share * parameter.spread
    room_up, room_down = parameter.upper - value, value - parameter.lower
    if room_up >= step:
        return step
    return -min(step, room_down) if room_down > room_up else max(room_up, 1e-12)


def fine_step(parameter: Parameter, value: float, share: float) -> float:
    """Return the step of a slope about a fitted value; a limit's is a short one to where it shows more."""
    if not is_limit(parameter):
        return step_of(parameter, value, share)
    step = FINE_BELOW * value
    return -step if value - step >= parameter.lower else step


def stepped(
    parameters: Sequence[Parameter], values: Sequence[float], i: int, share: float
) -> tuple[float, ...]:
    """Return values, one a parameter, with number i a share of its spread away, within its bounds."""
    p = parameters[i]
    step = step_of(p, values[i], share)
    if is_limit(p):  # a slope across the edge of what shows is none
        step = float(np.clip(step, -NEARBY * values[i], NEARBY * values[i]))
    moved = values[i] + step
    return (*values[:i], min(max(moved, p.lower), p.upper), *values[i + 1 :])


def away_starts(effect: Effect) -> list[tuple[float, ...]]:
    """Return where to difference an effect away from neutral."""
    neutral = tuple(p.neutral for p in effect.parameters)
    return [
        (*neutral[:at], min(p.neutral + AWAY * p.spread, p.upper), *neutral[at + 1 :])
        for at, p in enumerate(effect.parameters)
    ]


def starts_of(
    effect: Effect,
    silent: Sequence[bool],
    reach_m: tuple[float, float] = NOWHERE,
) -> list[tuple[float, ...]]:
    """Return where fits may begin, given which parameters leave no trace at neutral.

    The reach is between which places the machine touched its world, NaN if unknown.
    """
    parameters = effect.parameters
    neutral = tuple(p.neutral for p in parameters)
    quiet = [i for i, one in enumerate(silent) if one]
    if len(quiet) == 1 or (quiet and all(silent)):
        starts = [
            (*neutral[:at], value, *neutral[at + 1 :])
            for at in quiet
            for value in _ladder(parameters[at], reach_m)
        ]
    else:
        starts = [neutral]
        for signs in itertools.product((-1.0, 1.0), repeat=min(len(quiet), 2)):
            values = list(neutral)
            for i, sign in zip(quiet, signs, strict=False):
                p = parameters[i]
                values[i] = float(np.clip(p.neutral + sign * p.spread, p.lower, p.upper))
            starts.append(tuple(values))
    return list(dict.fromkeys(starts))  # a bound may cut several of them to one


def _ladder(p: Parameter, reach_m: tuple[float, float]) -> list[float]:
    """Values over the range of a parameter."""
    low, high = p.lower, p.upper
    if p.located and all(map(math.isfinite, reach_m)):
        # an edge is seen by feet beyond it: a start that is more than a stride off finds another slope
        first, last = float(np.clip(reach_m[0], low, high)), float(np.clip(reach_m[1], low, high))
        count = int(np.clip(round((last - first) / APART_M), 2, MOST_PLACES))
        return [float(first + (k + 0.5) * (last - first) / count) for k in range(count)]
    if by_ratios(p):
        return ratio_steps(p)
    if high - low > WIDE * p.spread:  # where it is likely, not where it may be at most
        return [
            float(np.clip(p.neutral + k * p.spread, low, high)) for k in (-1.0, -0.5, 0.0, 0.5, 1.0)
        ]
    return [float(low + q * (high - low)) for q in QUANTILES]


def by_ratios(p: Parameter) -> bool:
    """Whether a parameter's range is so wide that it is walked by ratios."""
    return p.lower > 0 and p.upper / p.lower > LOG_RANGE


def is_limit(p: Parameter) -> bool:
    """Whether a parameter is a limit: it may be anywhere, and where it is highest nothing reaches it."""
    return by_ratios(p) and p.neutral >= p.upper


def only_a_limit(effect: Effect) -> bool:
    """Whether an effect has one number, which is a limit."""
    return len(effect.parameters) == 1 and is_limit(effect.parameters[0])


def ratio_steps(p: Parameter) -> list[float]:
    """Values over the range of a parameter that is walked by ratios."""
    return [float(p.lower * (p.upper / p.lower) ** q) for q in (0.1, *QUANTILES, 0.9)]


def on_bound(p: Parameter, value: float) -> bool:
    """Whether a value lies on a bound, or nearer than rounding.

    Neutral is no limit of the effect, even where it lies on a bound: it is without this number.
    """
    edge = 1e-6 * min(p.upper - p.lower, p.spread)  # a range may be without end
    inside = p.lower + edge < value < p.upper - edge
    return not inside and abs(value - p.neutral) > edge


def off_bounds(causes: tuple[Cause, ...], effects: Mapping[str, Effect]) -> tuple[Cause, ...]:
    """Return causes with every value that lies on a bound moved half way to neutral."""
    listed = []
    for cause in causes:
        pairs = zip(effects[cause.effect].parameters, cause.values, strict=True)
        listed.append(
            replace(cause, values=tuple(_towards_neutral(p, value) for p, value in pairs))
        )
    return tuple(listed)


def _towards_neutral(p: Parameter, value: float) -> float:
    if not on_bound(p, value):
        return value
    if by_ratios(p):
        return float(np.sqrt(value * p.neutral))
    return 0.5 * (value + p.neutral)
