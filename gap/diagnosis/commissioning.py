"""What the simulator lacks on the healthy machine already: causes that stand before anything new is sought.

A simulator with another friction law than the machine's has the wrong signature for every effect of
friction, whatever is taken off its mean misfit. So the references are first explained by effects of the
whole machine, as far as these foretell conditions that they were not fitted to; the diagnosis then asks
what is new beside them.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gap.interfaces import Cause, Drive, Simulator
from gap.residuals.evidence import errors, local_drive, make_evidence
from gap.residuals.floor import Floor, make_floor
from gap.residuals.parts import Part, whole_part
from gap.residuals.predictions import Predictor
from gap.search.candidates import Candidate, candidates_of
from gap.search.screen import make_signatures
from gap.search.selection import Search, select
from record.trial.trial import Trial

MISFIT_SHARE = 0.1
FEWEST_CONDITIONS = 2
MOST_TRIALS = 3
SENSING = "sensing"
# What stands must be large enough to change what other effects do; smaller misfit is taken off as it is.
LAWS = Search(shortlist=4, most=6, least_share=0.01, rounds=3, least_gain=0.04)
SENSORS = Search(shortlist=3, most=3, least_share=0.01, rounds=3, least_gain=0.01)


def commission(
    predictor: Predictor,
    references: Sequence[Part],
    drive: Drive,
    progress: Callable[[float], None] = lambda share: None,
) -> tuple[Cause, ...]:
    """Return the causes that healthy runs show, or none where there are too few conditions to tell.

    Args:
        predictor: Predicts with the simulator as it stands.
        references: Healthy runs.
        drive: What feeds the stages.
        progress: Told the share that is done.
    """
    parts = conditions_of(references)
    if len(parts) < FEWEST_CONDITIONS:
        return ()
    # what one leg has and another has not is no law of the machine, and differs from day to day
    whole = tuple(one for one in candidates_of(predictor.simulator) if not one.joints)
    found = _stands(predictor, parts, drive, whole, LAWS, lambda share: progress(0.8 * share))
    # a sensor's own delay adds to a new one, however small it is
    sensors = tuple(one for one in whole if one.effect.stage == SENSING)
    after = predictor.with_standing(found)
    return (
        *found,
        *_stands(after, parts, drive, sensors, SENSORS, lambda share: progress(0.8 + 0.2 * share)),
    )


def _stands(
    predictor: Predictor,
    parts: Sequence[Part],
    drive: Drive,
    candidates: Sequence[Candidate],
    search: Search,
    progress: Callable[[float], None],
) -> tuple[Cause, ...]:
    known = list(zip(parts, errors(predictor, parts, drive), strict=True))
    floor = loosened(predictor, parts, drive, make_floor(predictor.simulator.channels, (), known))
    evidence = make_evidence(predictor, parts, drive, floor)
    taken = {(one.effect, one.joints) for one in predictor.standing}
    free = [one for one in candidates if one.key not in taken]
    if not free or not (evidence.count > 0).any():
        return ()
    effects = {effect.name: effect for effect in predictor.simulator.effects}
    signatures = make_signatures(evidence, free, (), lambda share: progress(0.2 * share))
    found = select(
        evidence, free, signatures, effects, 0.0, lambda share: progress(0.2 + 0.8 * share),
        search=search,
    )  # fmt: skip
    return found.fitted.causes


def standing_of(references: Sequence[Trial], simulator: Simulator) -> tuple[Cause, ...]:
    """Return the causes that healthy runs show: what ``diagnose`` finds by itself, for many diagnoses.

    Args:
        references: Healthy runs of one machine.
        simulator: Its simulator.

    Raises:
        GapError: A run cannot be compared with the simulator.
    """
    predictor = Predictor(simulator, references)
    parts = [whole_part(i, one, simulator.observe(one)) for i, one in enumerate(references)]
    return commission(predictor, parts, local_drive(predictor, parts)) if parts else ()


def conditions_of(references: Sequence[Part]) -> tuple[Part, ...]:
    """Return one run of some conditions, as different as they are there."""
    seen: dict[tuple[str, float], Part] = {}
    for part in references:
        seen.setdefault((part.gait, round(part.frequency_hz, 3)), part)
    order = sorted(seen)
    picks = np.linspace(0, len(order) - 1, min(MOST_TRIALS, len(order))).round().astype(int)
    return tuple(seen[order[i]] for i in picks)


def loosened(predictor: Predictor, parts: Sequence[Part], drive: Drive, floor: Floor) -> Floor:
    """Without references, expect a share of the misfit that is there.

    Against sensor noise alone any model of a real machine is wrong everywhere, and the score would only
    care for the few blocks that can be made perfect.
    """
    own = errors(predictor, parts, drive)
    power = np.array([np.nanmean(np.vstack([e[:, [c]] for e in own]) ** 2) if
                      any(np.isfinite(e[:, c]).any() for e in own) else 0.0
                      for c in range(len(floor.sigma))])  # fmt: skip
    return replace(floor, sigma=np.fmax(floor.sigma, MISFIT_SHARE * np.sqrt(power)))
