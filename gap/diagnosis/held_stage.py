"""Whether a cause helps to predict held-out runs where each stage is fed what was measured.

End to end, from commands alone, is no fair judge of a cause whose trace cannot be predicted from commands:
where a body swings on its legs, nobody knows in which phase. Each stage fed what was measured knows.
"""

from gap.diagnosis.gap_evidence import GapEvidence
from gap.interfaces import Cause, Drive
from gap.search.cross_validation import advantage
from gap.search.options import worth
from gap.search.replacement import without


def helps_its_stage(
    comparison: GapEvidence, causes: tuple[Cause, ...], at: int, least: float = 0.0
) -> bool:
    """Whether held-out runs are clearly predicted better with cause number ``at`` than without it.

    ``least`` is the share of the score without it that it must close. False for a simulator in one piece,
    which cannot be fed what was measured.
    """
    study = comparison.study
    if study.local is Drive.COMMAND:
        return False
    held = study.held_evidence(study.local)
    with_it, without_it = (
        held.score(one).sum(axis=1) for one in held.residuals([causes, without(causes, at)])
    )
    gain = advantage(with_it, without_it, held.block_part)
    closes = float(without_it.sum() - with_it.sum()) >= least * float(without_it.sum())
    return closes and worth(gain, len(causes[at].values), len(with_it))
