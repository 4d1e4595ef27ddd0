"""What causes add to the chain: every effect's numbers, combined, under the effect's name.

An effect that nothing names, or whose numbers are neutral, is not there at all: stages do not compute what
it would do, so neutral is bit for bit the unchanged chain. Settings compare and hash by value, so that
stages can be remembered by them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache
from typing import Any, TypeVar

import numpy as np

from model.effects.catalogue import (
    EFFECTS,
    TOGETHER,
    ChainEffect,
    Combine,
    places_of,
    touches_shafts,
)
from model.effects.causes import Cause, Effect, Scope, check_cause
from model.effects.machine_scale import RobotSize, effects_for
from model.errors import GapError
from model.values.arrays import FloatArray, readonly
from model.values.machine_names import MachineNames

Rows = tuple[tuple[float, ...], ...]
Signals = TypeVar("Signals")


@dataclass(frozen=True, slots=True, eq=False)
class UserEffect:
    """An effect of a user's own and what it does, see ``gap.effect_file``.

    Attributes:
        effect: Its name, stage, parameters, scopes and words.
        act: ``act(signals, values, legs)`` returns changed signals of the stage
            (``model.effects.signals``); values are in the order of the parameters, legs is a mask, (N,),
            or (J,) of joints in the stage of the actuation. At neutral values it must change nothing.
    """

    effect: Effect
    act: Callable[[Any, tuple[float, ...], tuple[bool, ...]], Any]


@dataclass(frozen=True, slots=True)
class Added:
    """A user's effect in use, with its values and a mask of its legs, (N,), or joints, (J,)."""

    user: UserEffect
    values: tuple[float, ...]
    legs: tuple[bool, ...]


@dataclass(frozen=True)
class Settings:
    """Everything that is added to a robot of J joints and N legs.

    Attributes:
        joints: J.
        legs: N.
        acting: The effects that do anything, in the order of the catalogue: name, and a row a parameter
            of N numbers (J where it touches shafts), or of one if it touches the whole robot; of effects
            whose causes act apart, these rows for each cause.
        added: Users' effects.
    """

    joints: int
    legs: int
    acting: tuple[tuple[str, Rows], ...] = ()
    added: tuple[Added, ...] = ()

    @cached_property
    def _acting(self) -> dict[str, Rows]:
        return dict(self.acting)

    def has(self, *effects: str) -> bool:
        """Whether any of some effects acts."""
        return not self._acting.keys().isdisjoint(effects)

    def whole(self, effect: str) -> tuple[float, ...]:
        """Return the numbers of an effect of the whole robot, in the order of its parameters."""
        return tuple(row[0] for row in self._rows(effect))

    def each(self, effect: str) -> FloatArray:
        """Return the numbers of an effect of single legs or joints, a row of N or J a parameter."""
        return _array(self._rows(effect))

    def apart(self, effect: str) -> tuple[Rows, ...]:
        """Return the rows of each cause of an effect whose causes act apart."""
        rows = self._acting.get(effect, ())
        count = len(EFFECTS[effect].parameters)
        return tuple(rows[i : i + count] for i in range(0, len(rows), count))

    def at(self, stage: str) -> tuple[Added, ...]:
        """Return the users' effects of a stage."""
        return tuple(added for added in self.added if added.user.effect.stage == stage)

    def acted(self, stage: str, signals: Signals) -> Signals:
        """Return the signals of a stage after the users' effects there."""
        for added in self.at(stage):
            signals = added.user.act(signals, added.values, added.legs)
        return signals

    def with_whole(self, effect: str, *values: float) -> "Settings":
        """Return settings with other numbers of an effect of the whole robot that acts."""
        return self._with(effect, tuple((value,) for value in values))

    def without(self, *effects: str) -> "Settings":
        """Return settings without some effects of the catalogue."""
        return replace(self, acting=tuple(one for one in self.acting if one[0] not in effects))

    def times(self, effect: str, factors: FloatArray) -> "Settings":
        """Return settings with ratios multiplied, (N,) or (J,), of an effect with one for each place."""
        return self._with(effect, (tuple((self.each(effect)[0] * factors).tolist()),))

    def _with(self, effect: str, rows: Rows) -> "Settings":
        acting = {**self._acting, effect: rows}
        return replace(
            self, acting=tuple((name, acting[name]) for name in EFFECTS if name in acting)
        )

    def _rows(self, effect: str) -> Rows:
        return (
            self._acting[effect]
            if effect in self._acting
            else _neutral(effect, self.joints, self.legs)
        )


@lru_cache(maxsize=256)
def _array(rows: Rows) -> FloatArray:
    array: FloatArray = readonly(np.array(rows))
    return array


@cache
def _neutral(effect: str, joints: int, legs: int) -> Rows:
    """A row a parameter at its neutral value: a number a leg or joint, one if the effect has neither."""
    known = EFFECTS[effect]
    width = 1
    if Scope.JOINT in known.scopes:
        width = joints if touches_shafts(known) else legs
    return tuple((parameter.neutral,) * width for parameter in known.parameters)


def settings_of(
    causes: Sequence[Cause],
    names: MachineNames,
    size: RobotSize,
    added: Sequence[UserEffect] = (),
) -> Settings:
    """Combine causes.

    Args:
        causes: Any number; two of one effect act together.
        names: Names of joints and legs.
        size: Size of the robot, which bounds depend on.
        added: Users' effects that causes may name too.

    Raises:
        GapError: A cause is not of the catalogue, or its joints or values do not fit.
    """
    counts = len(names.joints), len(names.legs)
    catalogue = effects_for(size)
    users = {user.effect.name: user for user in added}
    rows: dict[str, Rows] = {}
    extra = []
    for cause in causes:
        if cause.effect in users:
            user = users[cause.effect]
            mask = check_cause(cause, user.effect, places_of(user.effect, names))
            extra.append(Added(user, cause.values, mask))
        elif cause.effect in catalogue:
            effect = catalogue[cause.effect]
            mask = check_cause(cause, effect, places_of(effect, names))
            before = rows.get(effect.name)
            none = _neutral(effect.name, *counts)
            old = none if before is None or effect.apart else before
            new = _combined(effect, old, cause.values, mask)
            rows[effect.name] = (*(before or ()), *new) if effect.apart else new
        else:
            known = ", ".join([*catalogue, *users])
            raise GapError(f"{cause.effect!r} is no effect of this simulator; known are {known}")
    acting = tuple(
        (name, rows[name])
        for name, effect in catalogue.items()
        if name in rows and _acts(effect, rows[name], _neutral(name, *counts))
    )
    return Settings(*counts, acting, tuple(extra))


def _combined(
    effect: ChainEffect, old: Rows, values: tuple[float, ...], mask: tuple[bool, ...]
) -> Rows:
    return tuple(
        # a row of the whole robot has one number
        tuple(
            TOGETHER[how](x, value) if touched else x for x, touched in zip(row, mask, strict=False)
        )
        for row, value, how in zip(old, values, effect.combine, strict=True)
    )


def _acts(effect: ChainEffect, rows: Rows, neutral: Rows) -> bool:
    """Whether numbers do anything: those that only say where or how fast do not by themselves."""
    causes = len(rows) // max(len(effect.parameters), 1)
    known = zip(rows, neutral * causes, effect.combine * causes, strict=True)
    return not rows or any(row != none for row, none, how in known if how is not Combine.SET)
