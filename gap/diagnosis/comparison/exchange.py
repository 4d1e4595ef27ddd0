"""A run that shows a gap which no fitted run shows is fitted to, and another run judges in its place.

Which runs judge is settled by gait and order, before anything is predicted. Where a cause acts in some
runs only, a servo at the limit of its speed in the fastest one, that may hold out all there is to fit to.
"""

import numpy as np

from gap.constants import EXCHANGED_FROM
from gap.diagnosis.comparison.study import Exchange, Study
from gap.residuals.evidence import Evidence
from model.values.arrays import FloatArray


def with_gap_fitted(study: Study) -> Study:
    """Return the study with the held-out run of most energy fitted to, if no fitted one has nearly as much.

    The fitted run of its gait with least energy is held out instead. Nothing is exchanged where runs are
    held out by choice, in part, or without references, which say what energy is expected.
    """
    whole = not {part.trial for part in study.held} & {part.trial for part in study.fitted}
    if not (whole and study.held and study.references and study.evenly):
        return study
    fitted, held = study.evidence(study.local), study.held_evidence(study.local)
    there, hidden = _energies(fitted), _energies(held)
    most = int(hidden.argmax())
    if not hidden[most] > EXCHANGED_FROM * max(1.0, float(there.max())):
        return study
    of_gait = [i for i, part in enumerate(study.fitted) if part.gait == study.held[most].gait]
    least = min(of_gait, key=lambda i: (there[i], i))  # every gait keeps one
    return study.exchanged(Exchange(study.held[most].trial, study.fitted[least].trial))


def _energies(evidence: Evidence) -> FloatArray:
    """Energy over expectation of each run, in the median of its blocks, (R,)."""
    blocks = evidence.per_block(evidence.base**2).sum(axis=1) / np.fmax(
        evidence.count.sum(axis=1), 1e-9
    )
    return np.array(
        [np.median(blocks[evidence.block_part == run]) for run in range(len(evidence.parts))]
    )
