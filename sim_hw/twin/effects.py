"""What can be wrong with a reality, as data: names, parameters, where it acts, and how it is made so.

Names, parameters, units and conventions of the effects with ``catalogued=True`` are those of the gap
diagnosis; the others are there to see what a diagnosis says about what it has never heard of.
"""

import difflib
import math
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from operator import attrgetter
from typing import Any

import numpy as np

from model.errors import ConfigError
from model.values.arrays import FloatArray, IntArray
from sim_hw.twin.twin import Twin

STAGES = ("actuation", "kinematics", "support", "friction", "dynamics", "external", "sensing")
LEG, ALL, BOTH = "leg", "all", "all, leg"

# Twin with nothing of this effect, the legs it acts on, values in the order of the parameters.
Apply = Callable[[Twin, IntArray, FloatArray], Twin]


@dataclass(frozen=True, slots=True)
class EffectParameter:
    """One number of an effect.

    Attributes:
        name: With its unit as suffix.
        unit: The unit in words.
        low: Smallest value taken.
        high: Largest.
        neutral: Value that changes nothing.
        mild: A size that measurements just show, for campaigns.
        strong: A size that nobody overlooks.
    """

    name: str
    unit: str
    low: float
    high: float
    neutral: float
    mild: float
    strong: float


@dataclass(frozen=True, slots=True)
class EffectKind:
    """One thing that can be wrong.

    Attributes:
        name: Its name.
        stage: Stage of the chain it belongs to.
        scope: ``leg`` (one must be named), ``all``, or ``all, leg``.
        parameters: Its numbers.
        acts: Where and how it acts in the twin, in words.
        apply: Makes a twin in which it is so; None where every twin is so.
        catalogued: Whether the gap diagnosis knows its name.
    """

    name: str
    stage: str
    scope: str
    parameters: tuple[EffectParameter, ...]
    acts: str
    apply: Apply | None = field(repr=False)
    catalogued: bool = True


def sized(name: str, unit: str, low: float, high: float, *sizes: float) -> EffectParameter:
    """Return a parameter from its bounds and its neutral, mild and strong size."""
    neutral, mild, strong = sizes
    return EffectParameter(name, unit, low, high, neutral, mild, strong)


def at(array: FloatArray, legs: IntArray, value: FloatArray | float) -> FloatArray:
    """Return a copy of a leg-wise array with another value at some legs."""
    changed = array.copy()
    changed[legs] = value
    return changed


def changed(twin: Twin, place: str, value: object) -> Twin:
    """Return the twin with one attribute replaced.

    Args:
        twin: The twin.
        place: Dotted name of the attribute, as in ``plant.drive.delay_s``.
        value: The replacement.
    """
    owner, _, rest = place.partition(".")
    if not rest:
        return replace(twin, **{owner: value})  # type: ignore[arg-type]
    return replace(twin, **{owner: changed(getattr(twin, owner), rest, value)})  # type: ignore[arg-type]


def _each(places: Sequence[str], combine: Callable[[Any, Any], Any]) -> Apply:
    """Combine one attribute a parameter with it: at the legs concerned where it is leg-wise."""

    def apply(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
        for place, value in zip(places, values, strict=True):
            now = attrgetter(place)(twin)
            leg_wise = isinstance(now, np.ndarray)
            new = (
                at(now, legs, combine(now[legs], value)) if leg_wise else combine(now, float(value))
            )
            twin = changed(twin, place, new)
        return twin

    return apply


def sets(*places: str) -> Apply:
    """Set one attribute a parameter."""
    return _each(places, lambda _, value: value)


def adds(*places: str) -> Apply:
    """Add one parameter to each attribute."""
    return _each(places, operator.add)


def scales(place: str) -> Apply:
    """Multiply an attribute."""
    return _each((place,), operator.mul)


def sets_vector(place: str, *, leg_wise: bool = False) -> Apply:
    """Set one attribute to all parameters: the rows of the legs concerned, or the whole of it."""

    def apply(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
        now = attrgetter(place)(twin)
        return changed(twin, place, at(now, legs, values) if leg_wise else values.copy())

    return apply


def adds_vector(place: str, *, leg_wise: bool = False) -> Apply:
    """Add all parameters to one attribute: to the rows of the legs concerned, or to the whole of it."""

    def apply(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
        now = attrgetter(place)(twin)
        new = at(now, legs, now[legs] + values) if leg_wise else now + values
        return changed(twin, place, new)

    return apply


@dataclass(frozen=True, slots=True)
class TwinEffect:
    """An effect with its numbers.

    Attributes:
        name: Which.
        leg: Leg it acts on, empty for all.
        values: In the order of the parameters.
    """

    name: str
    leg: str
    values: tuple[float, ...]


def apply_effects(twin: Twin, effects: Sequence[TwinEffect], kinds: Sequence[EffectKind]) -> Twin:
    """Return the twin with all effects, in the order given.

    Args:
        twin: A healthy twin.
        effects: What is to be wrong.
        kinds: The catalogue.

    Raises:
        ConfigError: An effect is not known, or its leg or a number is impossible.
    """
    for effect in effects:
        kind = find_kind(effect.name, kinds)
        legs = _legs(effect, kind, twin.names)
        _check(effect, kind)
        if kind.apply is not None:
            twin = kind.apply(twin, legs, np.array(effect.values))
    return twin


def find_kind(name: str, kinds: Sequence[EffectKind]) -> EffectKind:
    """Return an effect by name.

    Raises:
        ConfigError: There is none of that name.
    """
    for kind in kinds:
        if kind.name == name:
            return kind
    near = difflib.get_close_matches(name, [kind.name for kind in kinds], n=1)
    hint = f"did you mean {near[0]}?" if near else "bigant sim effects lists them"
    raise ConfigError("effect", f"{name!r} is not known; {hint}")


def parse_effect(text: str, kinds: Sequence[EffectKind]) -> TwinEffect:
    """Read ``NAME[@LEG][:param=value,...]``; parameters left out are at their strong size.

    Raises:
        ConfigError: It makes no sense.
    """
    head, _, tail = text.partition(":")
    name, _, leg = head.partition("@")
    kind = find_kind(name.strip(), kinds)
    names = [parameter.name for parameter in kind.parameters]
    values = [parameter.strong for parameter in kind.parameters]
    given = [item.partition("=") for item in tail.split(",") if item.strip()]
    if given:  # a two-number effect of which one is given: the other is neutral, not strong
        values = [parameter.neutral for parameter in kind.parameters]
    for key, sign, value in given:
        if key.strip() not in names or not sign:
            known = ", ".join(names) if names else "none"
            raise ConfigError(f"effect {name}", f"has no parameter {key.strip()!r}; it has {known}")
        try:
            values[names.index(key.strip())] = float(value)
        except ValueError as error:
            raise ConfigError(f"effect {name}", f"{key} must be a number, not {value!r}") from error
    effect = TwinEffect(kind.name, leg.strip(), tuple(values))
    _check(effect, kind)
    return effect


def _check(effect: TwinEffect, kind: EffectKind) -> None:
    for parameter, value in zip(kind.parameters, effect.values, strict=True):
        if not (math.isfinite(value) and parameter.low <= value <= parameter.high):
            raise ConfigError(
                f"effect {effect.name}",
                f"{parameter.name} must be from {parameter.low:g} to "
                f"{f'{parameter.high:g} {parameter.unit}'.rstrip()}, not {value:g}",
            )


def _legs(effect: TwinEffect, kind: EffectKind, names: tuple[str, ...]) -> IntArray:
    if not effect.leg:
        if kind.scope == LEG:
            raise ConfigError(
                f"effect {effect.name}",
                f"acts on one leg; write {effect.name}@LEG with one of {', '.join(names)}",
            )
        return np.arange(len(names))
    if kind.scope == ALL:
        raise ConfigError(
            f"effect {effect.name}", f"acts on the whole robot; leave @{effect.leg} out"
        )
    if effect.leg not in names:
        raise ConfigError(
            f"effect {effect.name}", f"{effect.leg!r} is no leg; legs are {', '.join(names)}"
        )
    return np.array([names.index(effect.leg)])
