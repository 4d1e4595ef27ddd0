"""Whether a cause helps to predict held-out runs where each stage is fed what was measured.

End to end, from commands alone, is no fair judge of a cause whose trace cannot be predicted from commands:
where a body swings on its legs, nobody knows in which phase. Each stage fed what was measured knows.
"""

from dataclasses import replace

import numpy as np

from gap.constants import ACTS, HELD_OUT_MOST
from gap.diagnosis.gap_evidence import GapEvidence
from gap.interfaces import Cause, Drive
from gap.search.cross_validation import Advantage, advantage
from gap.search.options import usual_energy, worth
from gap.search.replacement import without
from model.values.arrays import FloatArray


def helps_its_stage(comparison: GapEvidence, causes: tuple[Cause, ...], at: int) -> bool:
    """Whether held-out runs are clearly predicted better with cause number ``at`` than without it.

    It is clear from a scatter over cycles; or where the cause explains most of what its channels show in
    most cycles: of a few cycles, in which a robot begins to walk, one can be unlike the others.
    False for a simulator in one piece, which cannot be fed what was measured.
    """
    scores = _held_scores(comparison, causes, at)
    if scores is None:
        return False
    clear = worth(scores[0], len(causes[at].values), len(scores[1]))
    return clear or _explains_most(comparison, causes, at)


def _explains_most(comparison: GapEvidence, causes: tuple[Cause, ...], at: int) -> bool:
    """Whether most of the energy beyond healthy runs' is explained, in the median of held-out cycles."""
    healthy = comparison.healthy
    if healthy is None or not agrees(comparison, causes, at):
        return False
    held = comparison.study.held_evidence(comparison.study.local)
    with_it, without_it = held.residuals([causes, without(causes, at)])
    gained = (held.score(without_it) - held.score(with_it)).sum(axis=0)
    acts = gained > ACTS * gained.max()
    before = held.per_block(without_it**2)
    closed = (before - held.per_block(with_it**2))[:, acts].sum(axis=1)
    usual = usual_energy(held, healthy)
    there = np.fmax((before - usual)[:, acts].sum(axis=1), closed)
    shares = closed / np.where(there > 0.0, there, np.inf)
    return float(np.median(shares)) > HELD_OUT_MOST


def agrees(comparison: GapEvidence, causes: tuple[Cause, ...], at: int, least: float = 0.0) -> bool:
    """Whether held-out runs are predicted better with cause number ``at``, by more than its numbers cost.

    How clear that is has been asked of the blocks that were fitted to, each left out in turn. Held-out runs
    of a few slow cycles cannot say it: a sensor that drifts is worse in each cycle than in the one before.
    ``least`` is the share of the score without the cause that it must close.
    """
    scores = _held_scores(comparison, causes, at)
    if scores is None:
        return False
    gain, without_it = scores
    closes = gain.nats >= least * float(without_it.sum())
    return closes and worth(replace(gain, error=0.0), len(causes[at].values), len(without_it))


def _held_scores(
    comparison: GapEvidence, causes: tuple[Cause, ...], at: int
) -> tuple[Advantage, FloatArray] | None:
    """What a cause gains on held-out runs, and the score of each block without it; None if unknown."""
    study = comparison.study
    if study.local is Drive.COMMAND:
        return None
    held = study.held_evidence(study.local)
    with_it, without_it = (
        held.score(one).sum(axis=1) for one in held.residuals([causes, without(causes, at)])
    )
    return advantage(with_it, without_it, held.block_part), without_it
