"""What an effect is, a cause with its numbers at its place, and whether the two fit."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum

from model.errors import GapError


class Scope(Enum):
    """What an effect can touch."""

    ALL = "all"  # the machine as a whole
    JOINT = "leg"  # one leg or joint (several: several causes, or one cause with several joints)


@dataclass(frozen=True, slots=True)
class Parameter:
    """One number of an effect.

    Attributes:
        name: As reports print it, with its unit as suffix, for example ``delay_s`` or ``ratio``.
        unit: SI unit, empty for a ratio.
        neutral: The value at which nothing happens.
        lower: Smallest value that makes sense.
        upper: Largest value that makes sense.
        spread: Prior standard deviation about ``neutral``: what a builder of such machines would expect.
        located: Whether it is a place along the world's x, to be sought where the machine went.
    """

    name: str
    unit: str
    neutral: float
    lower: float
    upper: float
    spread: float
    located: bool = False


@dataclass(frozen=True, slots=True)
class Shaking:
    """What vibrates with an effect.

    Attributes:
        channels: Names of the channels that vibrate.
        calm: Names of channels that vibrate less, group by group: what shakes the machine, or its joints,
            shakes them as well.
        steady: Names of effects that can predict the same and do not vibrate.
    """

    channels: tuple[str, ...]
    calm: tuple[tuple[str, ...], ...]
    steady: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Effect:
    """One thing that a model may lack.

    Attributes:
        stage: The stage in which it acts.
        parameters: Its numbers; none for a law that is there or not.
        scopes: What it can touch.
        physics: One sentence: what happens in the world.
        remedy: One sentence: what a person would check or change.
        parts: Names of what it touches one of; empty for the joints of its machine.
        alike: Effects that no run of this kind can tell it from, whatever the fits say, because nothing was
            measured between them; with
        tells: what would.
        by_forces: Whether it acts through forces (of contact, friction, springs) or is read from them,
            which a model has only approximately; else through what is measured or drawn.
        in_time: Whether it changes with time by its nature, so that a size that changes says nothing.
        wears: Whether its size may change while a machine runs: wear, heat, dust, a battery.
        each: Joints that have numbers of their own in an effect of all of them at once
            (``at_every_joint``), in the order of its parameters; empty for any other.
        form_of: Name of the effect that this is another form of: one cause by another path, tried with it
            as one candidate and reported under its name; empty for any other.
        even: Whether it is the same with all its numbers negated, so that near neutral it does nothing to
            first order.
        curved: Whether near neutral it looks unlike itself at a usual size.
        rough: How roughly its form is known, 0 to 1: 1 where machines have it in forms that differ from the
            modelled one by most of its change.
        shaking: What vibrates with it, faster than a model's frames follow; None if nothing does.
        hunts: Name of the channel that swings at the joint that has it, faster than frames follow; empty
            if none does.
        law: Whether it is another law with numbers of its own, which is there at their neutral values, too.
        least_size: Spreads from neutral that it must have to be named: machines built alike differ by as
            much as a smaller one.
    """

    name: str
    stage: str
    parameters: tuple[Parameter, ...]
    scopes: tuple[Scope, ...]
    physics: str
    remedy: str
    parts: tuple[str, ...] = field(default=(), kw_only=True)
    alike: tuple[str, ...] = field(default=(), kw_only=True)
    tells: str = field(default="", kw_only=True)
    by_forces: bool = field(default=False, kw_only=True)
    in_time: bool = field(default=False, kw_only=True)
    wears: bool = field(default=False, kw_only=True)
    each: tuple[str, ...] = field(default=(), kw_only=True)
    form_of: str = field(default="", kw_only=True)
    even: bool = field(default=False, kw_only=True)
    curved: bool = field(default=False, kw_only=True)
    rough: float = field(default=0.0, kw_only=True)
    shaking: Shaking | None = field(default=None, kw_only=True)
    hunts: str = field(default="", kw_only=True)
    law: bool = field(default=False, kw_only=True)
    least_size: float = field(default=0.0, kw_only=True)

    @property
    def away(self) -> bool:
        """Whether it is differenced away from neutral, as it looks unlike itself there."""
        return self.even or self.curved

    @property
    def family(self) -> str:
        """Name of the cause that it is a form of: its own if there is no other."""
        return self.form_of or self.name

    def named(self, values: Sequence[float]) -> dict[str, float]:
        """Return values, one a parameter, by the names of their parameters."""
        return dict(zip((p.name for p in self.parameters), values, strict=True))

    def by_joint(self, values: Sequence[float]) -> dict[str, tuple[float, ...]]:
        """Return the values of an effect of all joints at once, those of each joint by its name."""
        size = len(self.parameters) // max(len(self.each), 1)
        return {
            joint: tuple(values[size * at : size * (at + 1)]) for at, joint in enumerate(self.each)
        }


EVERY_JOINT = "_at_every_joint"


def at_every_joint(effect: Effect, joints: Sequence[str]) -> Effect:
    """Return an effect of single joints as one of all joints at once, with numbers of its own at each.

    It is a candidate as any other, so that what all joints lack is named once and not joint by joint.
    """
    parameters = tuple(
        replace(p, name=f"{p.name}@{joint}") for joint in joints for p in effect.parameters
    )
    return replace(
        effect,
        name=effect.name + EVERY_JOINT,
        parameters=parameters,
        scopes=(Scope.ALL,),
        alike=tuple(one + EVERY_JOINT for one in effect.alike),
        each=tuple(joints),
    )


@dataclass(frozen=True, slots=True)
class Cause:
    """An effect with its numbers, at its place.

    Attributes:
        joints: The joints that it touches; empty for the whole machine.
        values: In the order of the effect's parameters.
    """

    effect: str
    joints: tuple[str, ...]
    values: tuple[float, ...]

    @property
    def key(self) -> tuple[str, tuple[str, ...]]:
        """Its name and place, without its size."""
        return (self.effect, self.joints)


def joint_by_joint(cause: Cause, effect: Effect) -> tuple[Cause, ...]:
    """Return a cause at every joint as causes at single ones; any other as it is."""
    if not effect.each:
        return (cause,)
    name = effect.name.removesuffix(EVERY_JOINT)
    return tuple(Cause(name, (j,), own) for j, own in effect.by_joint(cause.values).items())


def check_cause(
    cause: Cause, effect: Effect, joints: Sequence[str], part: str = "leg"
) -> tuple[bool, ...]:
    """Return which of N joints a cause touches, (N,); ``part`` is what they are called in messages.

    Raises:
        GapError: Its joints or values do not fit the effect.
    """
    if len(cause.values) != len(effect.parameters):
        names = ", ".join(parameter.name for parameter in effect.parameters) or "no values"
        raise GapError(f"{effect.name} takes {names}, not {len(cause.values)} values")
    if not all(map(math.isfinite, cause.values)):
        raise GapError(f"{effect.name}: values must be finite numbers, not {cause.values}")
    for value, parameter in zip(cause.values, effect.parameters, strict=True):
        if not parameter.lower <= value <= parameter.upper:
            unit = f" {parameter.unit}" if parameter.unit else ""
            raise GapError(
                f"{effect.name}: {parameter.name} must be from {parameter.lower:g} to "
                f"{parameter.upper:g}{unit}, not {value:g}"
            )
    unknown = [joint for joint in cause.joints if joint not in joints]
    if unknown:
        names = ", ".join(joints) or "none"
        raise GapError(f"{effect.name}: {unknown[0]!r} is no {part}; {part}s are {names}")
    if cause.joints and Scope.JOINT not in effect.scopes:
        raise GapError(f"{effect.name} touches the whole robot; leave its {part}s out")
    if not cause.joints and Scope.ALL not in effect.scopes:
        raise GapError(f"{effect.name} touches single {part}s; name them")
    return tuple(not cause.joints or joint in cause.joints for joint in joints)
