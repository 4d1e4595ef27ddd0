"""How well fitted causes predict blocks that they were not fitted to.

Fits without a fold are one Newton step from the fit to all: exact for what is linear, and it needs no
further prediction. Gains of two sets are paired block by block.
"""

from dataclasses import dataclass

import numpy as np

from gap.evidence import Evidence
from gap.fit import Fitted
from model.signals import FloatArray


@dataclass(frozen=True, slots=True)
class Advantage:
    """How much better one set of causes predicts unseen blocks than another.

    Attributes:
        nats: Sum over the blocks.
        error: Its standard error, from the scatter of blocks.
    """

    nats: float
    error: float


def unseen_residual(evidence: Evidence, fitted: Fitted) -> FloatArray:
    """Whitened residual of each frame under the fit without its fold, (F, C)."""
    if not len(fitted.away):
        return fitted.residual
    weights = evidence.weights(fitted.residual)
    size = len(fitted.away)
    fold_of_frame = evidence.folds[evidence.block_of_frame]
    folds = np.unique(evidence.folds)
    grams, pulls = np.empty((len(folds), size, size)), np.empty((len(folds), size))
    for i, fold in enumerate(folds):
        on = fold_of_frame == fold
        slopes = fitted.slopes[:, on]
        weighted = slopes * weights[on]
        grams[i] = np.einsum("pfc,qfc->pq", weighted, slopes)
        pulls[i] = np.einsum("pfc,fc->p", weighted, fitted.residual[on])
    whole_gram, whole_pull = grams.sum(axis=0), pulls.sum(axis=0) - fitted.away
    out = fitted.residual.copy()
    for i, fold in enumerate(folds):
        gram = whole_gram - grams[i] + np.eye(size)
        step = np.linalg.solve(gram, whole_pull - pulls[i])
        on = fold_of_frame == fold
        out[on] = fitted.residual[on] - np.einsum("p,pfc->fc", step, fitted.slopes[:, on])
    return out


def unseen_score(evidence: Evidence, fitted: Fitted) -> FloatArray:
    """Score of each block under the fit without its fold, (B,)."""
    return np.asarray(evidence.score(unseen_residual(evidence, fitted)).sum(axis=1))


def advantage(of: FloatArray, over: FloatArray) -> Advantage:
    """Compare two scores block by block.

    Args:
        of: Scores of the one, (B,).
        over: Scores of the other, (B,).
    """
    gain = over - of
    count = len(gain)
    if count < 2:
        return Advantage(float(gain.sum()), float(np.abs(gain).sum()))
    return Advantage(float(gain.sum()), float(np.sqrt(count * np.var(gain, ddof=1))))
