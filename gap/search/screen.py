"""Signatures of every candidate by finite differences, and how much each would gain to first order."""

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import STEP, Candidate, starts_of, stepped
from model.values.arrays import FloatArray

SILENT = 1e-6  # share of the independent frames below which a signature is none
BATCH = 16


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


def make_signatures(
    evidence: Evidence,
    candidates: Sequence[Candidate],
    standing: tuple[Cause, ...],
    progress: Callable[[float], None],
) -> Signatures:
    """Difference the simulator about the causes that are there already; progress gets the share done."""
    rows = _Rows(evidence, standing)
    parameters = [(one, i) for one in candidates for i in range(len(one.neutral))]
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
    firsts = {one.effect.name: one for one in reversed(candidates)}
    acting = dict(
        zip(
            firsts,
            map(rows.seen, rows.add([(one, one.neutral) for one in firsts.values()])),
            strict=True,
        )
    )
    each: list[Signature] = []
    later: list[tuple[Candidate, tuple[float, ...], tuple[int, ...]]] = []
    for one in candidates:
        own = tuple(itertools.islice(at_neutral, len(one.neutral)))
        live = tuple(i for i, row in enumerate(own) if rows.seen(row))
        if acting[one.effect.name]:
            later.append((one, one.neutral, live))
        elif own and len(live) == len(own):
            each.append(Signature(one, one.neutral, live, own, -1))
        else:
            silent = [i not in live for i in range(len(own))]
            starts = starts_of(one.effect, silent, evidence.reach_m)
            later += [(one, start, live) for start in starts]
    for number, (one, start, live) in enumerate(later):
        made = rows.about(one, start, live)
        if made is not None:
            each.append(made)
            progress(0.7 + 0.3 * (number + 1) / len(later))
    return Signatures(tuple(each), np.array(rows.rows, dtype=np.float32))


def _spreads(one: Candidate, i: int, step: float) -> float:
    """A step in spreads; 1 where there is no room for one."""
    return step / one.effect.parameters[i].spread or 1.0


class _Rows:
    """Whitened changes of the prediction, as they are made."""

    def __init__(self, evidence: Evidence, standing: tuple[Cause, ...]) -> None:
        self.rows: list[NDArray[np.float32]] = []
        self._evidence, self._standing = evidence, standing
        self._base = evidence.residuals([standing])[0]
        self._least = SILENT * max(float(evidence.count.sum()), 1.0)

    def add(
        self,
        wanted: Sequence[tuple[Candidate, tuple[float, ...]]],
        steps: Sequence[float] | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> list[int]:
        """Predict candidates at values, keep the changes over their steps, and return their rows."""
        first = len(self.rows)
        for at in range(0, len(wanted), BATCH):
            sets = [(*self._standing, one.cause(v)) for one, v in wanted[at : at + BATCH]]
            for i, residual in enumerate(self._evidence.residuals(sets), at):
                change = self._base - residual
                self.rows.append((change / (steps[i] if steps else 1.0)).astype(np.float32).ravel())
            progress(min(1.0, (at + BATCH) / len(wanted)))
        return list(range(first, len(self.rows)))

    def seen(self, row: int) -> bool:
        """Whether a row is more than nothing."""
        return float(self.rows[row] @ self.rows[row]) > self._least

    def about(
        self, one: Candidate, start: tuple[float, ...], live: tuple[int, ...]
    ) -> Signature | None:
        """Make a signature about a start away from neutral; None where nothing happens."""
        offset = self.add([(one, start)])[0]
        acts = self.seen(offset)
        if not live and not acts:
            return None
        order = (*live, *(i for i in range(len(start)) if i not in live))
        moves = [stepped(one.effect.parameters, start, i, STEP) for i in order]
        made = self.add([(one, values) for values in moves])
        for i, row, values in zip(order, made, moves, strict=True):
            step = _spreads(one, i, values[i] - start[i])
            self.rows[row] = (self.rows[row] - self.rows[offset]) / np.float32(step)
        keep = [k for k, row in enumerate(made) if self.seen(row)]
        if not keep and not acts:
            return None
        rows = tuple(made[k] for k in keep)
        return Signature(one, start, tuple(order[k] for k in keep), rows, offset if acts else -1)


def gains(signatures: Signatures, residual: FloatArray, weights: FloatArray) -> list[Gain]:
    """Return what each candidate would gain, best first, one (its best start) each.

    The residual is whitened, (F, C), as is the weight of each of its values.
    """
    weight = weights.astype(np.float32).ravel()
    pull = (residual.astype(np.float32).ravel() * weight).astype(np.float32)
    along = (signatures.matrix @ pull).astype(np.float64)
    best: dict[tuple[str, tuple[str, ...]], Gain] = {}
    for one in signatures.each:
        gain = _gain(one, signatures.matrix, along, weight)
        old = best.get(one.candidate.key)
        if old is None or gain.nats > old.nats:
            best[one.candidate.key] = gain
    return sorted(best.values(), key=lambda g: (-g.nats, g.signature.candidate.key))


def _gain(
    one: Signature, matrix: NDArray[np.float32], along: FloatArray, weight: NDArray[np.float32]
) -> Gain:
    rows = matrix[list(one.rows)]
    weighted = rows * weight
    gram = (weighted @ rows.T).astype(np.float64)
    pull, nats = along[list(one.rows)], 0.0
    if one.offset >= 0:
        offset = matrix[one.offset]
        pull = pull - (weighted @ offset).astype(np.float64)
        nats = float(along[one.offset] - 0.5 * (offset * weight) @ offset)
    parameters = one.candidate.effect.parameters
    spread = np.array([parameters[i].spread for i in one.live])
    start = np.array([one.start[i] for i in one.live])
    neutral = np.array([parameters[i].neutral for i in one.live])
    values = list(one.start)
    if len(spread):
        away = (start - neutral) / spread
        step = np.linalg.solve(gram + np.eye(len(spread)), pull - away)
        low = np.array([parameters[i].lower for i in one.live])
        high = np.array([parameters[i].upper for i in one.live])
        reached = np.clip(start + step * spread, low, high)
        step = (reached - start) / spread
        prior = 0.5 * float((away + step) @ (away + step) - away @ away)
        nats += float(pull @ step - 0.5 * step @ gram @ step) - prior
        for i, value in zip(one.live, reached, strict=True):
            values[i] = float(value)
    return Gain(one, tuple(values), nats)
