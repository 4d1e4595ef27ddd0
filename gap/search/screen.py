"""Signatures of every candidate by finite differences, and how much each would gain to first order."""

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap.interfaces import Cause, Parameter
from gap.residuals.at_once import ahead_of
from gap.residuals.evidence import Evidence
from gap.search.candidates import (
    STEP,
    Candidate,
    away_starts,
    is_limit,
    only_a_limit,
    ratio_steps,
    starts_of,
    stepped,
)
from model.values.arrays import FloatArray

SILENT = 1e-6  # share of the independent frames below which a signature is none
BATCH = 16
EDGE_STARTS = 4  # between a value that shows and one that hardly does
EDGE_FALLS = (
    10.0  # times, from one value of a limit to the next, by which what shows falls at its edge
)
HARDLY_ACTS = 1e-4  # of the energy that a limit has which nothing gets past
FARTHEST = 1.5  # times its start: how far a slope of a limit is followed
LEAST_ROOM = 512  # rows of signatures, at first: address space until they are made
ROOM_BYTES = 2**30  # that rows have room for, too: to move to another room is to copy them all


@dataclass(frozen=True, slots=True, eq=False)
class Signature:
    """A candidate to first order about a start.

    Attributes:
        start: Values there.
        live: Indices of the parameters that leave a trace.
        rows: Rows of ``Signatures.matrix``: one a live parameter, for a change of one spread.
        offset: Row of the change that the start itself makes; -1 if none.
    """

    candidate: Candidate
    start: tuple[float, ...]
    live: tuple[int, ...]
    rows: tuple[int, ...]
    offset: int

    def moved(self, step: Sequence[float] | FloatArray) -> tuple[float, ...]:
        """Return the values so many spreads away from its start, one a live parameter, within bounds."""
        values = list(self.start)
        for i, size in zip(self.live, step, strict=True):
            p = self.candidate.effect.parameters[i]
            values[i] = float(np.clip(values[i] + size * p.spread, p.lower, p.upper))
        return tuple(values)


@dataclass(frozen=True, slots=True, eq=False)
class Signatures:
    """Signatures, and the whitened changes of the prediction that they name rows of, (rows, F C)."""

    each: tuple[Signature, ...]
    matrix: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Gain:
    """What a candidate would gain to first order in the score's quadratic, at which values."""

    signature: Signature
    values: tuple[float, ...]
    nats: float

    def change(self, signatures: "Signatures") -> FloatArray:
        """Return by how much the residual falls, to first order, (F C)."""
        one = self.signature
        changed = np.zeros(signatures.matrix.shape[1])
        if one.offset >= 0:
            changed += signatures.matrix[one.offset]
        for i, row in zip(one.live, one.rows, strict=True):
            spread = one.candidate.effect.parameters[i].spread
            changed += signatures.matrix[row] * ((self.values[i] - one.start[i]) / spread)
        return changed


def make_signatures(
    evidence: Evidence,
    candidates: Sequence[Candidate],
    standing: tuple[Cause, ...],
    progress: Callable[[float], None],
) -> Signatures:
    """Difference the simulator about the causes that are there already; progress gets the share done."""
    rows = _Rows(evidence, standing)
    # what begins with the squares of its numbers shows nothing there, and what is curved something else
    linear = [one for one in candidates if not one.effect.away]
    parameters = [(one, i) for one in linear for i in range(len(one.neutral))]
    moves = [stepped(one.effect.parameters, one.neutral, i, STEP) for one, i in parameters]
    at_neutral = iter(
        rows.add(
            [(one, values) for (one, _), values in zip(parameters, moves, strict=True)],
            [
                _spreads(one, i, values[i] - one.neutral[i])
                for (one, i), values in zip(parameters, moves, strict=True)
            ],
            lambda share: progress(0.7 * share),
        )
    )
    # a law that is there or not acts at its neutral values; one joint of each effect shows it
    firsts = {one.effect.name: one for one in reversed(linear)}
    acting = dict(
        zip(
            firsts,
            map(rows.seen, rows.add([(one, one.neutral) for one in firsts.values()])),
            strict=True,
        )
    )
    each: list[Signature] = []
    later: list[_Start] = []
    for one in candidates:
        if one.effect.away:
            later += [_Start(one, start, ()) for start in away_starts(one.effect)]
            continue
        own = tuple(itertools.islice(at_neutral, len(one.neutral)))
        live = tuple(i for i, row in enumerate(own) if rows.seen(row))
        if acting[one.effect.name]:
            later.append(_Start(one, one.neutral, live))
        elif own and len(live) == len(own):
            each.append(Signature(one, one.neutral, live, own, -1))
        else:
            silent = [i not in live for i in range(len(own))]
            starts = starts_of(one.effect, silent, evidence.reach_m)
            later += [_Start(one, start, live) for start in starts]
    each += rows.about(later, lambda share: progress(0.7 + 0.25 * share))
    each += rows.about(_at_edges(rows, each), lambda share: progress(0.95 + 0.05 * share))
    return Signatures(tuple(each), rows.all)


def _at_edges(rows: "_Rows", made: Sequence[Signature]) -> list["_Start"]:
    """Return starts at the edge of what shows, of limits: what hardly reaches one hardly shows.

    A little below it looks unlike itself far below, and each joint has its own.
    """
    limits = {
        one.candidate.key: one.candidate for one in made if only_a_limit(one.candidate.effect)
    }
    shown = {(one.candidate.key, *one.start): rows.energy(one.offset) for one in made}
    starts = []
    for key, candidate in limits.items():
        steps = ratio_steps(candidate.effect.parameters[0])
        energies = [shown.get((key, value), rows.least) for value in steps]
        for at in _edges(energies):
            between = np.geomspace(steps[at], steps[at + 1], EDGE_STARTS + 2)[1:-1]
            starts += [_Start(candidate, (float(value),), ()) for value in between]
    return starts


def _edges(energies: Sequence[float]) -> range:
    """Return between which values of a limit, the lowest first, its edge may be.

    As a rule what shows ceases at once. But where a recording begins with a shaft that is far behind, the
    first moments show how fast it catches up, and so even a limit that nothing else reaches; then the edge
    may be anywhere from where it hardly acts.
    """
    ceases = []
    for least in (0.0, HARDLY_ACTS * max(energies)):
        falls = [max(a, least) / max(b, least) for a, b in itertools.pairwise(energies)]
        at = int(np.argmax(falls))
        if falls[at] > EDGE_FALLS:
            ceases.append(at)
    if not ceases:
        return range(0)
    first, last = min(ceases), max(ceases)
    begin = first if first == last else max(first - 1, 0)
    return range(begin, last + 1)


def _spreads(one: Candidate, i: int, step: float) -> float:
    """A step in spreads; 1 where there is no room for one."""
    return step / one.effect.parameters[i].spread or 1.0


class _Start(NamedTuple):
    """Values away from neutral about which a candidate is differenced, and its parameters seen there."""

    candidate: Candidate
    values: tuple[float, ...]
    live: tuple[int, ...]


class _Rows:
    """Whitened changes of the prediction, as they are made."""

    def __init__(self, evidence: Evidence, standing: tuple[Cause, ...]) -> None:
        # hundreds of megabytes, which are not to be copied more often than they must
        fit = ROOM_BYTES // (max(1, evidence.base.size) * np.dtype(np.float32).itemsize)
        self._room = np.empty((max(LEAST_ROOM, fit), evidence.base.size), dtype=np.float32)
        self._count = 0
        self._evidence, self._standing = evidence, standing
        self._base = evidence.residuals([standing])[0]
        self.least = SILENT * max(float(evidence.count.sum()), 1.0)

    def add(
        self,
        wanted: Sequence[tuple[Candidate, tuple[float, ...]]],
        steps: Sequence[float] | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> list[int]:
        """Predict candidates at values, keep the changes over their steps, and return their rows."""
        first = self._count
        for at, residuals in self._batches(wanted):
            for i, residual in enumerate(residuals, at):
                change = self._base - residual
                self._append(change, steps[i] if steps else 1.0)
            progress(min(1.0, (at + BATCH) / len(wanted)))
        return list(range(first, self._count))

    def _batches(
        self, wanted: Sequence[tuple[Candidate, tuple[float, ...]]]
    ) -> Iterator[tuple[int, list[FloatArray]]]:
        """Yield residuals batch by batch, with where each begins; the next ones are under way."""
        sets = [(*self._standing, one.cause(v)) for one, v in wanted]
        batches = [sets[at : at + BATCH] for at in range(0, len(sets), BATCH)]
        made = ahead_of(batches, self._evidence.residuals, self._evidence.predictor.at_once)
        yield from zip(range(0, len(sets), BATCH), made, strict=True)

    def _append(self, change: FloatArray, step: float) -> None:
        if self._count == len(self._room):
            grown = np.empty((2 * self._count, self._room.shape[1]), dtype=np.float32)
            grown[: self._count] = self._room
            self._room = grown
        np.divide(change.ravel(), step, out=self._room[self._count], casting="same_kind")
        self._count += 1

    @property
    def all(self) -> NDArray[np.float32]:
        """Every row that was made, (rows, F C)."""
        return self._room[: self._count]

    def seen(self, row: int) -> bool:
        """Whether a row is more than nothing."""
        return float(self._room[row] @ self._room[row]) > self.least

    def energy(self, row: int) -> float:
        """Return that of a row, and that of next to nothing of none, -1."""
        return max(float(self._room[row] @ self._room[row]), self.least) if row >= 0 else self.least

    def about(self, starts: Sequence[_Start], progress: Callable[[float], None]) -> list[Signature]:
        """Make signatures about starts away from neutral, of those where something happens."""
        offsets = self.add(
            [(one.candidate, one.values) for one in starts],
            progress=lambda share: progress(0.2 * share),
        )
        wanted: list[tuple[Candidate, tuple[float, ...]]] = []
        about: list[tuple[_Start, int, tuple[int, ...]]] = []
        for start, offset in zip(starts, offsets, strict=True):
            if start.live or self.seen(offset):
                values, parameters = start.values, start.candidate.effect.parameters
                # a parameter that left no trace, and leaves none there, leaves none by a step from there
                silent = range(len(values)) if self.seen(offset) else ()
                rest = (i for i in silent if i not in start.live)
                about.append((start, offset, (*start.live, *rest)))
                wanted += [
                    (start.candidate, stepped(parameters, values, i, STEP)) for i in about[-1][2]
                ]
        made = self.add(wanted, progress=lambda share: progress(0.2 + 0.8 * share))
        rows = iter(zip(made, wanted, strict=True))
        each = (self._signature(s, offset, order, rows) for s, offset, order in about)
        return [one for one in each if one is not None]

    def _signature(
        self,
        start: _Start,
        offset: int,
        order: tuple[int, ...],
        made: Iterator[tuple[int, tuple[Candidate, tuple[float, ...]]]],
    ) -> Signature | None:
        """Make one of the row of its start and the next rows of moves from there; None for nothing."""
        own: list[int] = []
        for i, (row, (one, values)) in zip(order, made, strict=False):
            step = _spreads(one, i, values[i] - start.values[i])
            self._room[row] = (self._room[row] - self._room[offset]) / np.float32(step)
            own.append(row)
        keep = [k for k, row in enumerate(own) if self.seen(row)]
        acts = self.seen(offset)
        if not keep and not acts:
            return None
        live, rows = tuple(order[k] for k in keep), tuple(own[k] for k in keep)
        return Signature(start.candidate, start.values, live, rows, offset if acts else -1)


def gains(signatures: Signatures, residual: FloatArray, weights: FloatArray) -> list[Gain]:
    """Return what each candidate would gain, best first, one (its best start) each.

    The residual is whitened, (F, C), as is the weight of each of its values.
    """
    return Weighed(signatures, weights).gains(residual)


class Weighed:
    """Signatures with the weight of each value of a residual, (F, C): their products are made once."""

    def __init__(self, signatures: Signatures, weights: FloatArray) -> None:
        self.signatures = signatures
        self._weight = weights.astype(np.float32).ravel()
        self._products = [
            _products(one, signatures.matrix, self._weight) for one in signatures.each
        ]

    def gains(self, residual: FloatArray) -> list[Gain]:
        """Return what each candidate would gain of a whitened residual, (F, C), as ``gains`` does."""
        pull = (residual.astype(np.float32).ravel() * self._weight).astype(np.float32)
        along = (self.signatures.matrix @ pull).astype(np.float64)
        best: dict[tuple[str, tuple[str, ...]], Gain] = {}
        for one, products in zip(self.signatures.each, self._products, strict=True):
            gain = _gain(one, products, along)
            old = best.get(one.candidate.key)
            if old is None or gain.nats > old.nats:
                best[one.candidate.key] = gain
        return sorted(best.values(), key=lambda g: (-g.nats, g.signature.candidate.key))


def _range(p: Parameter, start: float, offset: int) -> tuple[float, float]:
    """Values that a slope at a start may lead to; of a limit not far, where it shows nothing any more."""
    if offset < 0 or not is_limit(p):
        return p.lower, p.upper
    return max(p.lower, start / FARTHEST), min(p.upper, start * FARTHEST)


class _Products(NamedTuple):
    """Of a signature's D rows with each other, (D, D), with its offset, (D,), and of that with itself."""

    gram: FloatArray
    with_offset: FloatArray
    of_offset: float


def _products(
    one: Signature, matrix: NDArray[np.float32], weight: NDArray[np.float32]
) -> _Products:
    rows = matrix[list(one.rows)]
    weighted = rows * weight
    gram = (weighted @ rows.T).astype(np.float64)
    if one.offset < 0:
        return _Products(gram, np.zeros(len(rows)), 0.0)
    offset = matrix[one.offset]
    with_offset = (weighted @ offset).astype(np.float64)
    return _Products(gram, with_offset, float((offset * weight) @ offset))


def _gain(one: Signature, products: _Products, along: FloatArray) -> Gain:
    gram, pull, nats = products.gram, along[list(one.rows)] - products.with_offset, 0.0
    if one.offset >= 0:
        nats = float(along[one.offset]) - 0.5 * products.of_offset
    values = list(one.start)
    parameters = one.candidate.effect.parameters
    spread = np.array([parameters[i].spread for i in one.live])
    start = np.array([one.start[i] for i in one.live])
    neutral = np.array([parameters[i].neutral for i in one.live])
    if len(spread):
        away = (start - neutral) / spread
        step = np.linalg.solve(gram + np.eye(len(spread)), pull - away)
        low, high = np.array([_range(parameters[i], one.start[i], one.offset) for i in one.live]).T
        reached = np.clip(start + step * spread, low, high)
        step = (reached - start) / spread
        prior = 0.5 * float((away + step) @ (away + step) - away @ away)
        nats += float(pull @ step - 0.5 * step @ gram @ step) - prior
        for i, value in zip(one.live, reached, strict=True):
            values[i] = float(value)
    return Gain(one, tuple(values), nats)
