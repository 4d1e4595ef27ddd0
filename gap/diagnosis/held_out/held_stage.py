"""Whether a cause helps to predict held-out runs where each stage is fed what was measured.

End to end, from commands alone, is no fair judge of a cause whose trace cannot be predicted from commands:
where a body swings on its legs, nobody knows in which phase. Each stage fed what was measured knows.
"""

from dataclasses import dataclass, replace

import numpy as np

from gap.constants import HELD_OUT_MOST
from gap.diagnosis.comparison.gap_evidence import GapEvidence
from gap.interfaces import Cause, Drive
from gap.residuals.evidence import Evidence
from gap.search.cross_validation import Advantage, advantage
from gap.search.options import acting, share_closed, usual_energy, worth
from gap.search.replacement import without
from model.values.arrays import FloatArray


def helps_its_stage(comparison: GapEvidence, causes: tuple[Cause, ...], at: int) -> bool:
    """Whether held-out runs are clearly predicted better with cause number ``at`` than without it.

    It is clear from a scatter over cycles; or where the cause explains most of what its channels show in
    most cycles: of a few cycles, in which a robot begins to walk, one can be unlike the others.
    False for a simulator in one piece, which cannot be fed what was measured.
    """
    judged = _judged(comparison, causes, at)
    if judged is None:
        return False
    clear = worth(judged.gain, judged.parameters, len(judged.score_without))
    return clear or (judged.agrees() and _explains_most(judged, comparison.healthy))


def agrees(comparison: GapEvidence, causes: tuple[Cause, ...], at: int, least: float = 0.0) -> bool:
    """Whether held-out runs are predicted better with cause number ``at``, by more than its numbers cost.

    How clear that is has been asked of the blocks that were fitted to, each left out in turn. Held-out runs
    of a few slow cycles cannot say it: a sensor that drifts is worse in each cycle than in the one before.
    ``least`` is the share of the score without the cause that it must close.
    """
    judged = _judged(comparison, causes, at)
    return judged is not None and judged.agrees(least)


def share_of_stage(comparison: GapEvidence, causes: tuple[Cause, ...], at: int) -> float:
    """Return the share of held-out runs' score that cause number ``at`` closes in its channels.

    Each stage is fed what was measured; 0 for a simulator in one piece, and where it closes nothing.
    """
    judged = _judged(comparison, causes, at)
    if judged is None:
        return 0.0
    return share_closed(judged.held, judged.without_it, judged.with_it)


@dataclass(frozen=True, slots=True, eq=False)
class _Judged:
    """A cause on held-out runs.

    Attributes:
        held: The runs, each stage fed what was measured.
        with_it: What all causes leave, (F, C).
        without_it: What all others leave, (F, C).
        parameters: Of the cause.
        score_without: Of each block, without it, (B,).
        gain: What it gains.
    """

    held: Evidence
    with_it: FloatArray
    without_it: FloatArray
    parameters: int
    score_without: FloatArray
    gain: Advantage

    def agrees(self, least: float = 0.0) -> bool:
        """Whether it gains more than its numbers cost, and this share of the score."""
        closes = self.gain.nats >= least * float(self.score_without.sum())
        certain = replace(self.gain, error=0.0)
        return closes and worth(certain, self.parameters, len(self.score_without))


def _judged(comparison: GapEvidence, causes: tuple[Cause, ...], at: int) -> _Judged | None:
    """One cause, judged; None for a simulator that cannot be fed what was measured."""
    study = comparison.study
    if study.local is Drive.COMMAND:
        return None
    held = study.held_evidence(study.local)
    with_it, without_it = held.residuals([causes, without(causes, at)])
    score, score_without = (held.score(one).sum(axis=1) for one in (with_it, without_it))
    gain = advantage(score, score_without, held.block_part)
    return _Judged(held, with_it, without_it, len(causes[at].values), score_without, gain)


def _explains_most(judged: _Judged, healthy: Evidence | None) -> bool:
    """Whether most of the energy beyond healthy runs' is explained, in the median of held-out cycles."""
    if healthy is None:
        return False
    held, with_it, without_it = judged.held, judged.with_it, judged.without_it
    on = acting((held.score(without_it) - held.score(with_it)).sum(axis=0))
    before = held.per_block(without_it**2)
    closed = (before - held.per_block(with_it**2))[:, on].sum(axis=1)
    beyond = (before - usual_energy(held, healthy))[:, on].sum(axis=1)
    there = np.fmax(beyond, closed)
    shares = closed / np.where(there > 0.0, there, np.inf)
    return float(np.median(shares)) > HELD_OUT_MOST
