"""What the simulator lacks on the healthy machine already, so that only new causes are searched for.

A simulator with another friction law than the machine's has the wrong signature for every effect of
friction, whatever is subtracted from its mean misfit. So the references are first explained by effects of
the whole machine, as far as these predict conditions that they were not fitted to; the diagnosis then asks
what is new beside them. Whatever measures a gap works on that commissioned study: a figure without them is
of another simulator than that of the diagnosis, and may have the other sign.
"""

from collections.abc import Callable, Sequence

import numpy as np

from gap.constants import LAW_GAIN, LAW_SHARE, SENSOR_GAIN
from gap.diagnosis.comparison.exchange import with_gap_fitted
from gap.diagnosis.comparison.study import Study, make_study
from gap.interfaces import Cause, Drive, Simulator
from gap.residuals.hold_out import HoldOut
from gap.residuals.parts import TrialPart, whole_parts
from gap.residuals.predictions import Predictor, PredictsElsewhere
from gap.search.candidates import Candidate, candidates_of
from gap.search.screen import make_signatures
from gap.search.selection import select
from gap.search.steps import Search
from record.trial.trial import Trial

FEWEST_CONDITIONS = 2
MOST_TRIALS = 3
SENSING = "sensing"
# A cause here must be large enough to change what other effects do; smaller misfit is subtracted as it is.
LAWS = Search(
    shortlist=4, most=6, least_share=LAW_SHARE, rounds=3, least_gain=LAW_GAIN, laws=True, walk=True
)
SENSORS = Search(
    shortlist=3, most=3, least_share=LAW_SHARE, rounds=3, least_gain=SENSOR_GAIN, walk=True
)


def commissioned_study(
    trials: Sequence[Trial],
    simulator: Simulator,
    references: Sequence[Trial] = (),
    elsewhere: PredictsElsewhere | None = None,
    hold_out: HoldOut | None = None,
    standing: tuple[Cause, ...] | None = None,
    find: Callable[[Study], tuple[Cause, ...]] | None = None,
) -> Study:
    """Assemble trials and references, and add the baseline model errors to every prediction.

    Args:
        trials: Measured runs.
        simulator: The simulator under diagnosis.
        references: Runs of the same machine assumed healthy.
        elsewhere: Where predictions are made; None uses this process.
        hold_out: Which of the trials judge; None holds out evenly, and exchanges a run that alone shows the
            gap. With the runs that a diagnosis held out, its study is made again.
        standing: Baseline model errors, if they are known: those that an answer says make the simulator of
            that answer again, and cost nothing. None searches the references.
        find: Searches them, in place of ``baseline_errors``; a command keeps what it found.

    Raises:
        GapError: There are no trials, or one cannot be compared with the simulator.
    """
    study = make_study(trials, simulator, references, elsewhere, hold_out)
    if standing is None:
        standing = (find or baseline_errors)(study)
    return with_gap_fitted(study.with_standing(standing))


def baseline_errors(study: Study) -> tuple[Cause, ...]:
    """Return the baseline model errors that a study's references show; none where they are too few."""
    return commission(study) if study.calibrated else ()


def commission(study: Study) -> tuple[Cause, ...]:
    """Return the causes that the references of a study show, or none where there are too few conditions."""
    parts = conditions_of(study.references)
    if len(parts) < FEWEST_CONDITIONS:
        return ()
    # what one leg has and another has not is no law of the machine, and differs from day to day
    whole = tuple(one for one in candidates_of(study.simulator) if not one.joints)
    laws = _explained(Study(study.predictor, parts), study.local, whole, LAWS)
    # a sensor's own delay adds to a new one, however small it is
    sensors = tuple(one for one in whole if one.effect.stage == SENSING)
    after = Study(study.predictor.with_standing(laws), parts)
    return (*laws, *_explained(after, study.local, sensors, SENSORS))


def _explained(
    study: Study, drive: Drive, candidates: Sequence[Candidate], search: Search
) -> tuple[Cause, ...]:
    """Causes of what is fitted to, with a share of the misfit expected."""
    evidence = study.loose_evidence(drive)
    taken = {one.key for one in study.predictor.standing}
    free = [one for one in candidates if one.key not in taken]
    if not free or not (evidence.count > 0).any():
        return ()
    signatures = make_signatures(evidence, free, (), lambda share: None)
    return select(
        evidence, free, signatures, lambda share: None, search=search
    ).fitted.causes  # fmt: skip


def standing_of(references: Sequence[Trial], simulator: Simulator) -> tuple[Cause, ...]:
    """Return the causes that healthy runs show: what ``diagnose`` finds by itself, for many diagnoses.

    Raises:
        GapError: A run cannot be compared with the simulator.
    """
    if not references:
        return ()
    predictor = Predictor(simulator, references)
    return commission(Study(predictor, (), references=whole_parts(simulator, references)))


def enough_conditions(references: Sequence[Trial]) -> bool:
    """Whether runs differ enough in gait or frequency to show a baseline."""
    conditions = {_condition(one.header.gait, one.header.frequency_hz) for one in references}
    return len(conditions) >= FEWEST_CONDITIONS


def _condition(gait: str, frequency_hz: float) -> tuple[str, float]:
    """What two runs have alike that were walked under the same condition."""
    return gait, round(frequency_hz, 3)


def conditions_of(references: Sequence[TrialPart]) -> tuple[TrialPart, ...]:
    """Return one run of some conditions, as different as they are there."""
    seen: dict[tuple[str, float], TrialPart] = {}
    for part in references:
        seen.setdefault(_condition(part.gait, part.frequency_hz), part)
    order = sorted(seen)
    picks = np.linspace(0, len(order) - 1, min(MOST_TRIALS, len(order))).round().astype(int)
    return tuple(seen[order[i]] for i in picks)
