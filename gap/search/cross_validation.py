"""How well fitted causes predict blocks that they were not fitted to.

Fits without a fold are one Newton step from the fit to all: exact for what is linear, and it needs no
further prediction. A fold is a trial, where there are several. What shows in one trial alone, such as a
limit that only its motion reaches, the others know nothing of; so the cycles of that trial are left out
instead, a third of them at a time. Gains of two sets are paired block by block.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy import linalg

from gap.constants import AHEAD_NATS
from gap.residuals.evidence import Evidence
from gap.search.fit import Fitted
from model.values.arrays import FloatArray, IntArray

FEWEST_FREE = 4
LOST = 1e-3  # share of what all blocks tell of some value, below which those without a fold tell nothing


@dataclass(frozen=True, slots=True)
class Advantage:
    """How much better one set of causes predicts held-out blocks than another, summed over the blocks.

    The standard error is from the scatter of blocks.
    """

    nats: float
    error: float

    @property
    def clear(self) -> bool:
        """Whether it is more than scatter, and than a nat or so."""
        return self.nats > max(self.error, AHEAD_NATS)


def steps_without(
    evidence: Evidence, fitted: Fitted, group_of_frame: IntArray
) -> tuple[IntArray, FloatArray]:
    """Return the groups of frames, (G,), and how far a fit without each moves the values, (G, P) [spreads].

    Args:
        evidence: What was fitted to.
        fitted: The fit to all.
        group_of_frame: Group of each frame, (F,).
    """
    return _steps(fitted, _normal_equations(evidence, fitted, group_of_frame))


class _Normal(NamedTuple):
    """Normal equations of a fit, from each of G groups of frames apart.

    Attributes:
        groups: Their numbers, (G,).
        grams: Products of the slopes with each other, (G, P, P).
        pulls: And with the residual, (G, P).
    """

    groups: IntArray
    grams: FloatArray
    pulls: FloatArray


def _normal_equations(evidence: Evidence, fitted: Fitted, group_of_frame: IntArray) -> _Normal:
    """What each group of frames tells of the values."""
    weights = evidence.weights(fitted.residual)
    groups, size = np.unique(group_of_frame), len(fitted.away)
    grams, pulls = np.empty((len(groups), size, size)), np.empty((len(groups), size))
    for i, group in enumerate(groups):
        on = group_of_frame == group
        weighted = fitted.slopes[:, on] * weights[on]
        grams[i] = np.einsum("pfc,qfc->pq", weighted, fitted.slopes[:, on])
        pulls[i] = np.einsum("pfc,fc->p", weighted, fitted.residual[on])
    return _Normal(groups, grams, pulls)


def _steps(fitted: Fitted, normal: _Normal) -> tuple[IntArray, FloatArray]:
    """Groups, and how far a fit without each moves the values."""
    gram = normal.grams.sum(axis=0) - normal.grams + np.eye(len(fitted.away))
    pull = normal.pulls.sum(axis=0) - fitted.away - normal.pulls
    return normal.groups, np.linalg.solve(gram, pull[:, :, None])[:, :, 0]


def unseen_residual(evidence: Evidence, fitted: Fitted) -> FloatArray:
    """Whitened residual of each frame under the fit without its fold, (F, C)."""
    if not len(fitted.away):
        return fitted.residual
    group_of_frame = evidence.folds[evidence.block_of_frame]
    normal = _normal_equations(evidence, fitted, group_of_frame)
    alone = _needed(normal)
    if len(alone):
        group_of_frame = _thirds_of(evidence, alone)[evidence.block_of_frame]
        normal = _normal_equations(evidence, fitted, group_of_frame)
    out = fitted.residual.copy()
    for group, step in zip(*_steps(fitted, normal), strict=True):
        on = group_of_frame == group
        out[on] -= np.einsum("p,pfc->fc", step, fitted.slopes[:, on])
    return out


def _needed(normal: _Normal) -> IntArray:
    """Folds without which the others tell nothing of some value."""
    whole = normal.grams.sum(axis=0)
    scale = 1.0 / np.sqrt(np.fmax(np.diagonal(whole), 1e-30))
    grams = normal.grams * np.outer(scale, scale)
    whole = grams.sum(axis=0) + LOST**2 * np.eye(len(scale))
    left = [linalg.eigh(whole - one, whole, eigvals_only=True)[0] for one in grams]
    return normal.groups[np.array(left) < LOST]


def _thirds_of(evidence: Evidence, folds: IntArray) -> IntArray:
    """Return the fold of each block, (B,), with thirds of the trials of some folds in place of them."""
    part, groups = evidence.block_part, evidence.folds.copy()
    for fold in folds:
        on = np.flatnonzero(evidence.folds == fold)
        place = np.arange(len(on)) - np.searchsorted(part[on], part[on])  # in its trial
        groups[on] = groups.max() + 1 + place * 3 // np.bincount(part)[part[on]]
    return groups


def unseen_score(evidence: Evidence, fitted: Fitted) -> FloatArray:
    """Score of each block under the fit without its fold, (B,)."""
    return np.asarray(evidence.score(unseen_residual(evidence, fitted)).sum(axis=1))


def advantage(of: FloatArray, over: FloatArray, strata: IntArray) -> Advantage:
    """Compare two scores block by block.

    What differs between trials is no scatter: an effect that shows in one gait only is still there. So the
    scatter is that of blocks about the mean of their trial.

    Args:
        of: Scores of the one, (B,).
        over: Scores of the other, (B,).
        strata: Trial of each block, (B,).
    """
    gain = over - of
    groups = np.unique(strata)
    free = len(gain) - len(groups)
    if free < FEWEST_FREE:  # too few blocks a trial: all that differs counts
        strata, groups, free = np.zeros_like(strata), groups[:1] * 0, len(gain) - 1
    if free < 1:
        return Advantage(float(gain.sum()), float(np.abs(gain).sum()))
    about = sum(
        float(np.sum((gain[strata == one] - gain[strata == one].mean()) ** 2)) for one in groups
    )
    return Advantage(float(gain.sum()), float(np.sqrt(len(gain) * about / free)))
