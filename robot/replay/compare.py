"""Comparing ticks with ticks: the largest difference of every field, and the first that is too large."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from model.values.arrays import BoolArray, FloatArray
from model.values.tick import Tick
from record.log.recording import LEGS
from robot.replay.fields import Field

# Ticks compared at a time: enough that numpy's overhead does not count.
BLOCK_TICKS = 256


@dataclass(frozen=True, slots=True)
class FieldResult:
    """How one field of the replay agrees with the log.

    Attributes:
        stage: Stage of the pipeline.
        name: Name of the field.
        unit: Unit, empty for flags and codes.
        tolerance: Largest difference allowed, absolute up to 1 unit and relative beyond.
        largest: Largest difference; infinite where one of two is not a number.
        ticks_beyond: Ticks in which some element differs by more than allowed.
        why: Where a difference within the tolerance can come from.
    """

    stage: str
    name: str
    unit: str
    tolerance: float
    largest: float
    ticks_beyond: int
    why: str


@dataclass(frozen=True, slots=True)
class Difference:
    """The first difference that is too large.

    Attributes:
        t_s: Time since the first tick.
        index: Number of the tick.
        stage: Stage of the pipeline.
        name: Name of the field.
        element: Which element of it, empty for a single number.
        recorded: Value in the log, in words.
        replayed: Value today, in words.
        unit: Unit of both.
    """

    t_s: float
    index: int
    stage: str
    name: str
    element: str
    recorded: str
    replayed: str
    unit: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ComparedRun:
    """A run replayed and compared.

    Attributes:
        path: The log.
        ticks: Ticks replayed.
        duration_s: How much of the run they are.
        wall_s: How long the replay took; loading the model's machine code before it is not counted.
        fields: How each field of the ticks agrees.
        first: The first difference that is too large, None if there is none.
        notes: What had to be assumed or left out, in words.
    """

    path: Path
    ticks: int
    duration_s: float
    wall_s: float
    fields: tuple[FieldResult, ...]
    first: Difference | None
    notes: tuple[str, ...]

    @property
    def equal(self) -> bool:
        """Whether every field agrees within its tolerance."""
        return self.first is None


class Comparison:
    """Compares pairs of ticks as they come.

    Args:
        fields: What to compare, in the order of the pipeline.
        names: Leg names.
        scale: Factor on all tolerances.
        start_ns: When the log begins.
    """

    def __init__(
        self, fields: Sequence[Field], names: tuple[str, ...], scale: float, start_ns: int
    ) -> None:
        self.ticks = 0
        self.first: Difference | None = None
        self._fields = tuple(fields)
        self._names = names
        self._scale = scale
        self._pairs: list[tuple[Tick, Tick]] = []
        self._largest = [0.0] * len(self._fields)
        self._beyond = [0] * len(self._fields)
        self._start_ns = start_ns

    def add_equal(self) -> None:
        """Count a tick that is the same in every bit."""
        self.ticks += 1

    def add(self, recorded: Tick, replayed: Tick) -> None:
        """Compare one tick."""
        self.ticks += 1
        self._pairs.append((recorded, replayed))
        if len(self._pairs) >= BLOCK_TICKS:
            self._compare()

    def results(self) -> tuple[FieldResult, ...]:
        """Return how each field agrees."""
        self._compare()
        compared = zip(self._fields, self._largest, self._beyond, strict=True)
        return tuple(
            FieldResult(f.stage, f.name, f.unit, f.tolerance * self._scale, largest, beyond, f.why)
            for f, largest, beyond in compared
        )

    def _compare(self) -> None:
        pairs, self._pairs = self._pairs, []
        if not pairs:
            return
        beyond: list[tuple[int, int]] = []  # place in the block, number of the field
        for number, field in enumerate(self._fields):
            size, bad = differences(
                [field.take(one) for one, _ in pairs],
                [field.take(other) for _, other in pairs],
                field.tolerance * self._scale,
            )
            self._largest[number] = max(self._largest[number], size)
            self._beyond[number] += int(bad.sum())
            if bad.any():
                beyond.append((int(np.argmax(bad)), number))
        if beyond and self.first is None:
            place, number = min(beyond)
            self.first = self._describe(self._fields[number], *pairs[place])

    def _describe(self, field: Field, recorded: Tick, replayed: Tick) -> Difference:
        one, other = np.asarray(field.take(recorded)), np.asarray(field.take(replayed))
        where: tuple[int, ...] = ()
        if one.ndim:
            excess = _excess(one[None], other[None], field.tolerance * self._scale)[0]
            where = tuple(int(i) for i in np.unravel_index(int(np.argmax(excess)), one.shape))
        return Difference(
            t_s=(recorded.t_ns - self._start_ns) * 1e-9,
            index=recorded.index,
            stage=field.stage,
            name=field.name,
            element=self._element(field, where),
            recorded=_words(field, one[where]),
            replayed=_words(field, other[where]),
            unit=field.unit,
        )

    def _element(self, field: Field, where: tuple[int, ...]) -> str:
        words = []
        if where and field.shape[0] == LEGS:
            words.append(self._names[where[0]])
        elif len(where) > 1:
            words.append(str(where[0] + 1))
        if where and field.parts:
            words.append(field.parts[where[-1]])
        return " ".join(words)


def differences(
    recorded: Sequence[ArrayLike], replayed: Sequence[ArrayLike], tolerance: float
) -> tuple[float, BoolArray]:
    """Compare one field over some ticks.

    Args:
        recorded: Values in the log, one a tick.
        replayed: Values today.
        tolerance: Allowed: ``|a - b| <= tolerance * max(1, |a|)``. NaN equals NaN only.

    Returns:
        The largest difference, and for every tick whether it has one that is too large.
    """
    one, other = np.array(recorded), np.array(replayed)
    flat = (len(one), -1)
    excess = _excess(one, other, tolerance).reshape(flat)
    beyond: BoolArray = np.any(excess > 0, axis=1)
    return float(_distance(one, other).max(initial=0.0)), beyond


def _distance(one: np.ndarray, other: np.ndarray) -> FloatArray:
    if one.dtype == object or other.dtype == object:
        return np.asarray(one != other, dtype=np.float64)
    a, b = one.astype(np.float64), other.astype(np.float64)
    # what is absent in both is the same; what is infinite in both too
    same = (a == b) | (np.isnan(a) & np.isnan(b))
    with np.errstate(invalid="ignore"):
        distance = np.where(same, 0.0, np.abs(a - b))
    return np.asarray(np.where(np.isnan(distance), np.inf, distance))


def _excess(one: np.ndarray, other: np.ndarray, tolerance: float) -> FloatArray:
    """Return the distance beyond what is allowed, at most 0 where it is allowed."""
    distance = _distance(one, other)
    if one.dtype == object or other.dtype == object or tolerance == 0:
        return distance
    size = np.nan_to_num(np.abs(one.astype(np.float64)), nan=0.0, posinf=0.0)
    return np.asarray(distance - tolerance * np.maximum(1.0, size))


def _words(field: Field, value: object) -> str:
    if field.codes is not None:
        return field.codes(int(np.asarray(value))).name
    if isinstance(value, np.bool_ | bool):
        return "yes" if value else "no"
    array = np.asarray(value)
    if array.dtype.kind in "OU":  # texts
        return str(value) or "none"
    number = float(array)
    return "absent" if math.isnan(number) else f"{number:.12g}"
