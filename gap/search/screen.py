"""Signatures of every candidate by finite differences, and how much each would gain to first order."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import STEP, Candidate, starts_of, step_of
from model.values.arrays import FloatArray

SILENT = 1e-6  # share of the independent frames below which a signature is none
BATCH = 16


@dataclass(frozen=True, slots=True, eq=False)
class Signature:
    """A candidate to first order about a start.

    Attributes:
        candidate: The candidate.
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
    """All of them.

    Attributes:
        found: The signatures.
        matrix: Whitened changes of the prediction, (rows, F C).
    """

    found: tuple[Signature, ...]
    matrix: NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Gain:
    """What a candidate would gain to first order.

    Attributes:
        signature: The candidate and its start.
        values: Fitted values.
        nats: Gain in the score's quadratic.
    """

    signature: Signature
    values: tuple[float, ...]
    nats: float


def make_signatures(
    evidence: Evidence,
    candidates: Sequence[Candidate],
    standing: tuple[Cause, ...],
    progress: Callable[[float], None],
) -> Signatures:
    """Difference the simulator about the causes that are there already.

    Args:
        evidence: What is fitted to.
        candidates: Those to look at.
        standing: Causes that are there already.
        progress: Told the share that is done.
    """
    base = evidence.residuals([standing])[0]
    store = _Store(evidence, base, standing)
    neutral = store.changes(
        [
            (one, _moved(one, one.neutral, i))
            for one in candidates
            for i in range(len(one.effect.parameters))
        ],
        lambda share: progress(0.7 * share),
    )
    # a law that is there or not acts at its neutral values; one joint of each effect tells
    firsts = {one.effect.name: one for one in reversed(candidates)}
    acting = dict(
        zip(
            firsts,
            store.loud(store.changes([(one, one.neutral) for one in firsts.values()])),
            strict=True,
        )
    )
    found: list[Signature] = []
    later: list[tuple[Candidate, tuple[float, ...], tuple[int, ...]]] = []
    at = 0
    for one in candidates:
        size = len(one.effect.parameters)
        rows = neutral[at : at + size]
        at += size
        loud = store.loud(rows)
        if size and all(loud) and not acting[one.effect.name]:
            found.append(Signature(one, one.neutral, tuple(range(size)), tuple(rows), -1))
            continue
        live = tuple(i for i in range(size) if loud[i])
        starts = (
            [one.neutral]
            if acting[one.effect.name]
            else starts_of(one.effect, [not x for x in loud], evidence.reach_m)
        )
        later += [(one, start, live) for start in starts]
    found += store.expand(later, progress)
    return Signatures(tuple(found), store.matrix())


def _moved(one: Candidate, start: tuple[float, ...], i: int) -> tuple[float, ...]:
    step = step_of(one.effect.parameters[i], start[i], STEP)
    return tuple(value + (step if k == i else 0.0) for k, value in enumerate(start))


class _Store:
    """Rows as they are made."""

    def __init__(self, evidence: Evidence, base: FloatArray, standing: tuple[Cause, ...]) -> None:
        self._evidence, self._base, self._standing = evidence, base, standing
        self._rows: list[NDArray[np.float32]] = []
        self._least = SILENT * max(float(evidence.count.sum()), 1.0)

    def changes(
        self,
        wanted: Sequence[tuple[Candidate, tuple[float, ...]]],
        progress: Callable[[float], None] = lambda share: None,
    ) -> list[int]:
        """Predict candidates at values and keep the whitened changes; return their rows."""
        first = len(self._rows)
        for at in range(0, len(wanted), BATCH):
            sets = [(*self._standing, one.cause(v)) for one, v in wanted[at : at + BATCH]]
            for (one, values), residual in zip(
                wanted[at : at + BATCH], self._evidence.residuals(sets), strict=True
            ):
                change = self._base - residual
                moved = [
                    (v - p.neutral) / p.spread
                    for v, p in zip(values, one.effect.parameters, strict=True)
                    if v != p.neutral
                ]
                scale = 1.0 / moved[0] if len(moved) == 1 else 1.0
                self._rows.append((change * scale).astype(np.float32).ravel())
            progress(min(1.0, (at + BATCH) / max(len(wanted), 1)))
        return list(range(first, len(self._rows)))

    def loud(self, rows: Sequence[int]) -> list[bool]:
        """Tell which rows are more than nothing."""
        return [float(self._rows[r] @ self._rows[r]) > self._least for r in rows]

    def expand(
        self,
        wanted: Sequence[tuple[Candidate, tuple[float, ...], tuple[int, ...]]],
        progress: Callable[[float], None],
    ) -> list[Signature]:
        """Make signatures about starts away from neutral."""
        found = []
        for number, (one, start, live) in enumerate(wanted):
            offset = self._plain(one, [start])[0]
            extra = tuple(i for i in range(len(start)) if i not in live)
            if not live and not self.loud([offset])[0]:
                continue  # nothing happens here
            steps = [_moved(one, start, i) for i in (*live, *extra)]
            rows = self._plain(one, steps)
            for row, values in zip(rows, steps, strict=True):
                moved = [i for i in range(len(start)) if values[i] != start[i]]
                i = moved[0] if moved else 0
                step = (values[i] - start[i]) / one.effect.parameters[i].spread
                self._rows[row] = (self._rows[row] - self._rows[offset]) / np.float32(step or 1.0)
            order = (*live, *extra)
            loud = self.loud(rows)
            keep = [k for k in range(len(order)) if loud[k]]
            made = offset if self.loud([offset])[0] else -1
            if keep or made >= 0:
                found.append(
                    Signature(
                        one,
                        start,
                        tuple(order[k] for k in keep),
                        tuple(rows[k] for k in keep),
                        made,
                    )
                )
            progress(0.7 + 0.3 * (number + 1) / len(wanted))
        return found

    def _plain(self, one: Candidate, values: Sequence[tuple[float, ...]]) -> list[int]:
        first = len(self._rows)
        sets = [(*self._standing, one.cause(v)) for v in values]
        for residual in self._evidence.residuals(sets) if sets else []:
            self._rows.append((self._base - residual).astype(np.float32).ravel())
        return list(range(first, len(self._rows)))

    def matrix(self) -> NDArray[np.float32]:
        """Return all rows."""
        return np.array(self._rows, dtype=np.float32)


def plain_gains(signatures: Signatures, residuals: FloatArray) -> FloatArray:
    """Return the largest gain of each of S residuals with all weights 1 and no bounds, (S,).

    A parameter costs half a nat, which is what noise gives it.

    Args:
        signatures: Signatures.
        residuals: Whitened, (S, F C).
    """
    along = (signatures.matrix @ residuals.T.astype(np.float32)).astype(np.float64)
    best = np.zeros(len(residuals))
    for one in signatures.found:
        rows = signatures.matrix[list(one.rows)]
        pull, nats = along[list(one.rows)], np.zeros(len(residuals))
        if one.offset >= 0:
            offset = signatures.matrix[one.offset]
            pull = pull - (rows @ offset).astype(np.float64)[:, None]
            nats = along[one.offset] - 0.5 * float(offset @ offset)
        if len(rows):
            gram = (rows @ rows.T).astype(np.float64) + np.eye(len(rows))
            nats = nats + 0.5 * np.sum(pull * np.linalg.solve(gram, pull), axis=0)
        best = np.maximum(best, nats - 0.5 * len(rows))
    return best


def gains(signatures: Signatures, residual: FloatArray, weights: FloatArray) -> list[Gain]:
    """Return what each candidate would gain, best first, one (its best start) each.

    Args:
        signatures: Signatures.
        residual: Whitened residual, (F, C).
        weights: Weight of each of its values, (F, C).
    """
    weight = weights.astype(np.float32).ravel()
    pull = (residual.astype(np.float32).ravel() * weight).astype(np.float32)
    along = (signatures.matrix @ pull).astype(np.float64)
    best: dict[tuple[str, tuple[str, ...]], Gain] = {}
    for one in signatures.found:
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
        step = (np.clip(start + step * spread, low, high) - start) / spread
        prior = 0.5 * float((away + step) @ (away + step) - away @ away)
        nats += float(pull @ step - 0.5 * step @ gram @ step) - prior
        for i, value in zip(one.live, start + step * spread, strict=True):
            values[i] = float(value)
    return Gain(one, tuple(values), nats)
