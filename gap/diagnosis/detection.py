"""Whether there is a gap above what references show, and what size of a cause would have shown.

Two tests: the best candidate's size (``gap.search.healthy_search``), and the energies of the trials against
those of references, whatever the candidates. Each reference held out shows what their chances are worth
(``gap.residuals.chances``). Candidates have most of the level, because healthy machines hardly ever
reach that of energies.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.constants import ENERGY_LEVEL, FALSE_ALARMS, SHOWN
from gap.diagnosis.detectable import Detectable
from gap.residuals.chances import promised
from gap.residuals.energies import chance_of_energies
from gap.residuals.evidence import Evidence
from gap.residuals.healthy import Healthy
from gap.search.healthy_search import HealthySearch
from gap.search.options import CAUSE_LEVEL, worth_size
from gap.search.screen import Signatures
from model.values.arrays import FloatArray


@dataclass(frozen=True, slots=True)
class Detection:
    """Whether there is a gap.

    Attributes:
        below: Whether either chance is below its level.
        p: Chance of so much without one, in units of the level: there is a gap below ``FALSE_ALARMS``; NaN
            without references.
        p_cause: The same by the best candidate alone, among all that were tried.
        p_energy: By energies alone: the mean over channels, or the worst channel.
        promised: False alarms that these references can promise at most, as a share of healthy cases.
        references: How many there are.
    """

    below: bool
    p: float
    p_cause: float
    p_energy: float
    promised: float
    references: int

    @property
    def by_energy(self) -> bool:
        """Whether energies alone show a gap, whatever the candidates."""
        return self.p_energy < ENERGY_LEVEL


def detect(evidence: Evidence, healthy: Sequence[Healthy], p_cause: float) -> Detection:
    """Decide with references.

    ``p_cause`` is the chance that a healthy machine shows any candidate as large as the best one.
    """
    p_energy = chance_of_energies(evidence, evidence.base, healthy)
    nearest = min(p_cause / CAUSE_LEVEL, p_energy / ENERGY_LEVEL)
    p = min(1.0, FALSE_ALARMS * nearest)
    rate = promised(FALSE_ALARMS, len(healthy))
    return Detection(p < FALSE_ALARMS, p, p_cause, p_energy, rate, len(healthy))


def detectable(
    evidence: Evidence, signatures: Signatures, search: HealthySearch | None, residual: FloatArray
) -> tuple[Detectable, ...]:
    """Return the smallest size of each effect's parameters that would have shown, at its blindest joint.

    Sizes are to first order, by the rule that names a first cause: beyond the noise of the trials and,
    where references were searched, beyond their scatter and that of the trials. So large a cause is named
    in 90 % (``SHOWN``) of the sets of trials that scatter as these do. The residual is what the named
    causes leave of the trials, (F, C).
    """
    blocks = len(evidence.starts)
    spreads: dict[int, float] = {}
    for one in signatures.each:
        parameters = len(one.candidate.effect.parameters)
        for row in one.rows if one.offset < 0 else ():
            energy = float(signatures.matrix[row] @ signatures.matrix[row])
            spreads[row] = worth_size(parameters, blocks, float(SHOWN)) / np.sqrt(energy)
    if search is not None:
        laid = search.left_in_trials(evidence, residual)
        for one, place, size in search.visible_sizes(CAUSE_LEVEL, laid):
            spreads[one.rows[place]] = max(spreads[one.rows[place]], size)
    worst: dict[tuple[str, str], Detectable] = {}
    for one in signatures.each:
        for i, row in zip(one.live, one.rows, strict=True):
            if row not in spreads:
                continue
            name, p = one.candidate.effect.name, one.candidate.effect.parameters[i]
            size = p.spread * spreads[row]
            if (name, p.name) not in worst or size > worst[name, p.name].size:
                worst[name, p.name] = Detectable(
                    name, p.name, size, p.unit, p.neutral, p.lower, p.upper
                )
    return tuple(worst[key] for key in sorted(worst))
