"""The answers of three simpler methods on the same data."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.residuals.evidence import Evidence
from gap.search.screen import Gain, Signatures, Weighed

MOST = 5
GREEDY_NATS = 2.0
RIDGE = 1e-9
COLUMNS = 4096  # that are turned into double precision at a time


@dataclass(frozen=True, slots=True)
class Baseline:
    """The answer of a simpler method: effects with their joints, in the method's order."""

    method: str
    causes: tuple[tuple[str, tuple[str, ...]], ...]


def baselines(evidence: Evidence, signatures: Signatures) -> tuple[Baseline, ...]:
    """Return all three."""
    alike = Weighed(signatures, np.ones(evidence.base.shape))
    ranked = alike.gains(evidence.base)
    single = [one for one in ranked if len(one.signature.live) <= 1][:1]
    return (
        Baseline("largest single-parameter fit", _keys(single)),
        Baseline("forward selection by training error", _keys(_greedy(evidence, alike))),
        Baseline("least squares on all parameters", _all_at_once(evidence, signatures)),
    )


def _keys(each: Sequence[Gain]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    return tuple(one.signature.candidate.family for one in each)


def _greedy(evidence: Evidence, alike: Weighed) -> list[Gain]:
    residual = evidence.base
    chosen: list[Gain] = []
    while len(chosen) < MOST:
        taken = {one.signature.candidate.family for one in chosen}
        ranked = alike.gains(residual)
        ranked = [one for one in ranked if one.signature.candidate.family not in taken]
        if not ranked or ranked[0].nats < GREEDY_NATS:
            break
        best = ranked[0]
        residual = residual - best.change(alike.signatures).reshape(residual.shape)
        chosen.append(best)
    return chosen


def _all_at_once(
    evidence: Evidence, signatures: Signatures
) -> tuple[tuple[str, tuple[str, ...]], ...]:
    smooth = [one for one in signatures.each if one.offset < 0 and one.rows]
    rows = [row for one in smooth for row in one.rows]
    owners = [one.candidate.family for one in smooth for _ in one.rows]
    if not rows:
        return ()
    gram, pull, goal = np.zeros((len(rows),) * 2), np.zeros(len(rows)), evidence.base.ravel()
    for at in range(0, len(goal), COLUMNS):
        matrix = signatures.matrix[rows, at : at + COLUMNS].astype(np.float64)
        gram += matrix @ matrix.T
        pull += matrix @ goal[at : at + COLUMNS]
    gram += RIDGE * np.trace(gram) / len(rows) * np.eye(len(rows))
    sizes = np.abs(np.linalg.solve(gram, pull))
    order = np.argsort(-sizes, kind="stable")
    return tuple(dict.fromkeys(owners[i] for i in order[:1]))
