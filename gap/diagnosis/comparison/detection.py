"""Whether there is a gap above what references show, and what size of a cause would have shown.

Three tests: the best candidate's size (``gap.search.healthy_search``); the energies of the trials against
those of references, whatever the candidates; where no cause is new, what changes in the course of the runs
(``gap.diagnosis.comparison.trend``). Each reference held out shows what the chances of the first two are
worth (``gap.residuals.chances``). Candidates have most of the level, because healthy machines hardly ever
reach that of energies.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.constants import CHANGE_LEVEL, ENERGY_LEVEL, FALSE_ALARMS, SHOWN
from gap.detectable import Detectable
from gap.residuals.chances import promised
from gap.residuals.energies import chance_of_energies
from gap.residuals.evidence import Evidence
from gap.residuals.healthy import Healthy, whitened_runs
from gap.residuals.same_day import days_of
from gap.rounding import count_words, percent_words
from gap.search.fit import Fitted
from gap.search.options import CAUSE_LEVEL, worth_size
from gap.search.screen import Signature, Signatures
from gap.search.steps import Known

LEAST_FIGURE = 1e-5  # a smaller chance is not put into figures
NEARLY = 2.0  # times its level, up to which a chance that is no gap is nearly one
NO_DAYS = "each run counts as a day of its own, as no file says its day"


@dataclass(frozen=True, slots=True)
class Detection:
    """Whether there is a gap.

    Attributes:
        below: Whether one of the chances is below its level.
        p: Chance of so much without one, in units of the level: there is a gap below ``FALSE_ALARMS``; NaN
            without references.
        p_cause: The same by the best candidate alone, among all that were tried.
        p_energy: By energies alone: the mean over channels, or the worst channel, of all that is left or of
            what is another in each cycle.
        p_change: By what changes in the course of a run; 1 if not tested, or if no change is large enough.
        promised: False alarms that these references can promise at most, as a share of healthy cases.
        references: How many there are.
        energy_in: The channel, with its joint, that is farthest ahead of references in energy.
        in_cycles: Whether it is so in what is another in each cycle.
        days: On how many days references were recorded; 0 where files do not say.
    """

    below: bool
    p: float
    p_cause: float
    p_energy: float
    p_change: float
    promised: float
    references: int
    energy_in: str = ""
    in_cycles: bool = False
    days: int = 0

    @property
    def by_energy(self) -> bool:
        """Whether energies alone show a gap, whatever the candidates."""
        return self.p_energy < ENERGY_LEVEL

    @property
    def by_change(self) -> bool:
        """Whether something changes in the course of the runs that does not in references."""
        return self.p_change < CHANGE_LEVEL

    @property
    def nearly(self) -> bool:
        """Whether there is nearly a gap."""
        return not self.below and self.p <= NEARLY * FALSE_ALARMS

    @property
    def nearest(self) -> str:
        """Which of ``cause``, ``change``, ``energy`` is nearest to a gap, or farthest beyond it."""
        levels = _in_levels(self.p_cause, self.p_change, self.p_energy)
        return min(levels, key=lambda one: levels[one])

    @property
    def why_words(self) -> str:
        """Which test says that there is a gap, and how often it would of a healthy machine."""
        chance, what = {
            "cause": (self.p_cause, "have so large a cause of some kind"),
            "change": (self.p_change, "change as much in the course of runs"),
            "energy": (self.p_energy, f"leave as much energy in {self.energy_in}"),
        }[self.nearest]
        if self.nearest == "energy" and self.in_cycles:
            what += " that differs from cycle to cycle"
        percent = f"{100.0 * chance:.2g}" if chance > LEAST_FIGURE else "less than 0.001"
        return (
            f"why a gap: {percent} % of healthy sets of trials {what}, if they scatter as estimated from "
            f"{self.references_words} ({percent_words(self.by_count)} by counting these alone)"
            f"{'' if self.days else '; ' + NO_DAYS}"
        )

    @property
    def references_words(self) -> str:
        """How many references there are, and of how many days, in words."""
        words = f"{self.references} references"
        return f"{words} of {count_words(self.days, 'day')}" if self.days else words

    @property
    def by_count(self) -> float:
        """Chance that one more healthy day is the most unusual of all: no count of them promises less."""
        return 1.0 / ((self.days or self.references) + 1)


def _in_levels(p_cause: float, p_change: float, p_energy: float) -> dict[str, float]:
    """Return each chance in units of its level: there is a gap below 1."""
    return {
        "cause": p_cause / CAUSE_LEVEL,
        "change": p_change / CHANGE_LEVEL,
        "energy": p_energy / ENERGY_LEVEL,
    }


def detect(
    evidence: Evidence, healthy: Sequence[Healthy], p_cause: float, p_change: float = 1.0
) -> Detection:
    """Decide with references.

    ``p_cause`` is the chance that a healthy machine shows any candidate as large as the best one,
    ``p_change`` that something changes as much in the course of its runs.
    """
    energy = chance_of_energies(evidence, evidence.base, healthy)
    p = min(1.0, FALSE_ALARMS * min(_in_levels(p_cause, p_change, energy.p).values()))
    at = evidence.simulator.channels[energy.channel] if energy.channel >= 0 else None
    days = len(set(days_of([one.part for one in healthy])))
    return Detection(
        below=p < FALSE_ALARMS,
        p=p,
        p_cause=p_cause,
        p_energy=energy.p,
        p_change=p_change,
        promised=promised(FALSE_ALARMS, days or len(healthy)),
        references=len(healthy),
        energy_in=f"{at.name} {at.joint}".strip() if at else "",
        in_cycles=energy.another,
        days=days,
    )


def detectable(
    evidence: Evidence, signatures: Signatures, known: Known | None, fitted: Fitted
) -> tuple[Detectable, ...]:
    """Return the smallest size of each effect's parameters that would have shown, at its blindest joint.

    Sizes are to first order, or to second of an effect that is even, by the rule that names a first cause:
    beyond the noise of the trials and, where references were searched, beyond their scatter and that of
    the trials. So large a cause is named in 90 % (``SHOWN``) of the sets of trials that scatter as these
    do. Their scatter is that of what the fitted causes leave of them.
    """
    times = {one: _by_noise(one, evidence, signatures) for one in signatures.each}
    if known is not None:
        held = known.held
        more = whitened_runs(held, held.residuals([fitted.causes])[0]) if held else ()
        search = known.search
        laid = search.left_in_trials(evidence, fitted.residual, more)
        for one, place, size in search.visible_sizes(CAUSE_LEVEL, laid):
            times[one][place] = max(times[one][place], size)
    worst: dict[tuple[str, str], Detectable] = {}
    for one in signatures.each:
        for i, size in zip(_numbers(one), times[one], strict=True):
            effect, p = one.candidate.effect, one.candidate.effect.parameters[i]
            off = _distance(one, i, size)
            if (effect.name, p.name) not in worst or off > worst[effect.name, p.name].size:
                joint = next(iter(one.candidate.joints), "")
                worst[effect.name, p.name] = Detectable(
                    effect.name, p.name, off, p.unit, p.neutral, p.lower, p.upper, joint
                )
    return tuple(worst[key] for key in sorted(worst))


def _numbers(one: Signature) -> tuple[int, ...]:
    """Indices of the parameters that have a size: each alone, or the one that is not neutral at a start."""
    away = one.candidate.effect.away
    if (one.offset >= 0) is not away:
        return ()
    moved = zip(one.start, one.candidate.neutral, strict=True)
    return tuple(i for i, (a, b) in enumerate(moved) if a != b) if away else one.live


def _by_noise(one: Signature, evidence: Evidence, signatures: Signatures) -> list[float]:
    """How many times each of its changes stands out from noise: of a spread, or of what a start makes."""
    rows = one.rows if one.offset < 0 else (one.offset,) * len(_numbers(one))
    energies = [float(signatures.matrix[row] @ signatures.matrix[row]) for row in rows]
    needed = worth_size(len(one.candidate.effect.parameters), len(evidence.starts), float(SHOWN))
    return [needed / float(np.sqrt(energy)) for energy in energies]


def _distance(one: Signature, i: int, times: float) -> float:
    """Return how far a parameter is from neutral, so many spreads, or so many times what a start makes.

    It is at least what is named at all; of causes of just that size half are fitted below it.
    """
    effect = one.candidate.effect
    p = effect.parameters[i]
    if one.offset < 0:
        return p.spread * max(times, effect.least_size)
    # the change goes with the square of what is the same with all numbers negated
    return abs(one.start[i] - p.neutral) * (math.sqrt(times) if effect.even else times)
