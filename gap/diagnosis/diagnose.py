"""The diagnosis: is there a gap, where, which effect, how far it shrinks, what to run next."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.constants import MOSTLY
from gap.coverage.coverage import unwatched_stages
from gap.data.usual_spikes import without_usual_spikes
from gap.diagnosis.alternatives.ambiguity import OpenRival, open_rivals
from gap.diagnosis.alternatives.by_vibration import settled_by_vibration, shaken_channels
from gap.diagnosis.alternatives.probability import (
    Fit,
    RivalCause,
    chances,
    clear_of_nothing,
    left_of,
    none_if_nothing,
    none_of_them,
)
from gap.diagnosis.answer.caveats import resembling, warnings_of
from gap.diagnosis.answer.findings import Diagnosis, TrialFaults, Verdict
from gap.diagnosis.answer.named_cause import NamedCause
from gap.diagnosis.answer.verdict import gap_exists, named_causes, verdict_of
from gap.diagnosis.comparison.commissioning import commissioned_study
from gap.diagnosis.comparison.detection import Detection, detect, detectable
from gap.diagnosis.comparison.gap_evidence import GapEvidence, compare
from gap.diagnosis.comparison.how_far import HowFar, how_far
from gap.diagnosis.comparison.new_commands import new_commands
from gap.diagnosis.comparison.study import Study
from gap.diagnosis.comparison.trend import RunChange, change_in_runs, none_with, trends_of
from gap.diagnosis.comparison.where import clearest_there, where
from gap.diagnosis.held_out.drop_worse import adds_little, drop_unclear, drop_worse
from gap.diagnosis.held_out.second_look import second_look
from gap.experiments.next_run import NextRun
from gap.experiments.open_causes import discriminating_runs, open_sets
from gap.interfaces import DataFault, Proposal, Simulator
from gap.residuals.energies import chance_of_energies
from gap.residuals.hunting import Hunting
from gap.residuals.predictions import PredictsElsewhere
from gap.residuals.vibration import settled
from gap.search.candidates import Candidate, families_of
from gap.search.cross_validation import unseen_residual
from gap.search.options import closed_beyond, nats_beyond
from gap.search.selection import BY_ITSELF, WHOLE_SEARCH, closed_share, select
from gap.search.standard_errors import standard_errors, with_rough_means
from gap.search.steps import Selection
from record.trial.trial import Trial

Progress = Callable[[str, float], None]
Proposer = Callable[[], Sequence[Proposal]]
# Shares that ``progress`` gets are of the time that a walk takes whose causes stay open: starting the
# workers, fitting, and trying runs each take about a quarter of it. Without open causes it ends sooner.
NEXT_FROM = 0.75
# Probability of "none of these", from which no run is proposed to tell what is named.
SURELY_NONE = 0.9


def silent(words: str, share: float) -> None:
    """Take the progress of a diagnosis, and show nothing."""


def diagnose(
    trials: Sequence[Trial],
    simulator: Simulator,
    references: Sequence[Trial] = (),
    elsewhere: PredictsElsewhere | None = None,
    progress: Progress = silent,
    seed: int = 0,
    proposer: Proposer | None = None,
) -> Diagnosis:
    """Diagnose the gap between a simulator and measured trials.

    Args:
        trials: Measured runs.
        simulator: The simulator under diagnosis.
        references: Runs of the same machine assumed healthy; what they show is subtracted.
        elsewhere: Made by ``gap.residuals.pool.prediction_pool`` with the same trials, or a cluster;
            None uses this process.
        progress: Gets what is being done, and the share of the whole that is done.
        seed: Of every random draw; the same seed gives the same diagnosis.
        proposer: Makes the runs among which the next one is chosen.

    Raises:
        GapError: There are no trials, or nothing in them can be compared.
    """
    progress("baseline model errors", 0.02)
    study = commissioned_study(trials, simulator, references, elsewhere)
    return diagnose_study(study, progress, seed, proposer)


def diagnose_study(
    study: Study,
    progress: Progress = silent,
    seed: int = 0,
    proposer: Proposer | None = None,
) -> Diagnosis:
    """Diagnose the study of ``commissioned_study``, as ``diagnose`` does.

    Raises:
        GapError: Nothing can be compared.
    """
    progress("checking the data", 0.1)
    checked = study.predictor.checked()
    progress("measuring the baseline", 0.12)
    comparison = compare(study, lambda share: progress("effects one by one", 0.15 + 0.3 * share))
    selection = select(
        comparison.evidence, comparison.candidates, comparison.signatures,
        lambda share: progress("which effects", 0.45 + 0.27 * share), comparison.known,
        WHOLE_SEARCH if study.references else BY_ITSELF,
    )  # fmt: skip
    progress("how much is explained", 0.72)
    selection = settled_by_vibration(comparison.evidence, selection, comparison.healthy)
    selection, far = _judged_by_held_out(comparison, selection, seed)
    progress("where it lies", 0.74)
    answer = _answer(comparison, selection, far)
    progress("what to run next", NEXT_FROM)
    runs = _next_runs(comparison.study, selection, answer.worth_telling, proposer, progress)
    diagnosis = _diagnosis(comparison, selection, far, answer, _faults(study, checked), runs, seed)
    progress("done", 1.0)
    return diagnosis


def _judged_by_held_out(
    comparison: GapEvidence, selection: Selection, seed: int
) -> tuple[Selection, HowFar]:
    """Drop what held-out runs speak against or is not clear, and look again where no reference helps."""
    helpful, far = drop_worse(comparison, selection, seed)
    left, far = drop_unclear(comparison, helpful, far, seed)
    effects = comparison.evidence.effects
    dropped = families_of(selection.fitted.causes, effects) - families_of(
        left.fitted.causes, effects
    )
    more = second_look(comparison, left, dropped)
    if more is not left:
        left, far = more, how_far(comparison.held, more.fitted.causes, seed)
    kept = families_of(helpful.fitted.causes, effects)
    refused = tuple(one for one in selection.steps if one.chosen.added.family not in kept)
    return replace(left, refused=refused), far


@dataclass(frozen=True, slots=True)
class _Answer:
    """Is there a gap, what explains it, and what else could."""

    verdict: Verdict
    detection: Detection | None
    change: RunChange | None
    hunts: tuple[Hunting, ...]
    named: tuple[NamedCause, ...]
    rivals: tuple[RivalCause, ...]
    ambiguous: tuple[OpenRival, ...]
    none: float
    fit: Fit

    @property
    def worth_telling(self) -> tuple[OpenRival, ...]:
        """Alternatives that a further run should tell apart: not of causes that are most likely none."""
        return self.ambiguous if self.none < SURELY_NONE else ()


def _faults(study: Study, checked: Iterator[tuple[DataFault, ...]]) -> tuple[TrialFaults, ...]:
    every, trials = tuple(checked), len(study.trials)
    faults = without_usual_spikes(every[:trials], every[trials:])
    return tuple(TrialFaults(i, own) for i, own in enumerate(faults) if own)


def _answer(comparison: GapEvidence, selection: Selection, far: HowFar) -> _Answer:
    """Decide whether there is a gap, and whether it is explained."""
    evidence, known = comparison.evidence, comparison.known
    change = None if selection.steps else _change(comparison)
    p_change = change.chance if change else 1.0
    detection = detect(evidence, comparison.runs, selection.p, p_change) if known else None
    hunts = _hunts_for_nothing(comparison.study, selection)
    exists = gap_exists(evidence, detection, selection, bool(hunts))
    fit = _fit(comparison, selection, far)
    none = none_of_them(fit, len(selection.steps), bool(comparison.study.references))
    trends = trends_of(evidence, comparison.healthy, selection.fitted)
    none = none_with(trends, none, p_change, adds_little(far)) if exists else 0.0
    if exists and not selection.steps:
        none = 1.0  # nothing of it is named
    errors = standard_errors(evidence, comparison.healthy, selection.fitted)
    clear = clear_of_nothing(selection, evidence.effects, errors)
    shared = chances(selection, evidence.block_part, none, fit.nats_after, clear)
    none = none_if_nothing(none, clear)
    ambiguous = open_rivals(evidence, selection, [own for _, own in shared], fit.nats_after)
    reported = with_rough_means(evidence.effects, selection.fitted.causes, errors)
    named = named_causes(selection, [one for one, _ in shared], far, trends, reported, clear)
    helps = _helps(comparison.study, far) and not hunts
    return _Answer(
        verdict_of(exists, named, none, ambiguous, helps=helps),
        detection,
        change if detection is not None and detection.by_change else None,
        hunts,
        named,
        tuple(rival for _, own in shared for rival in own),
        ambiguous,
        none,
        fit,
    )


def _helps(study: Study, far: HowFar) -> bool:
    """Whether causes help to predict held-out runs, as far as these can tell.

    With references a small gap's share is lost in their scatter, and they judge what is left instead. But
    causes with which whole runs are surely predicted worse explain nothing; the end of a run that was cut
    is a few cycles, which say nothing surely.
    """
    if study.references:
        return study.cut or not far.surely_worse
    return not far.shrink < MOSTLY


def _hunts_for_nothing(study: Study, selection: Selection) -> tuple[Hunting, ...]:
    """Joints that hunt, and have no cause that does so."""
    chosen = [step.chosen.added for step in selection.steps]
    known = {one.joints for one in chosen if one.hunts}
    return tuple(one for one in study.hunting if (one.joint,) not in known)


def _change(comparison: GapEvidence) -> RunChange | None:
    """What changes in the course of trials without causes, where references were commanded like them.

    Trials that were cut to have something to judge by are no whole runs.
    """
    study, healthy = comparison.study, comparison.healthy
    if healthy is None or study.cut or new_commands((*study.fitted, *study.held), study.references):
        return None
    trials = (comparison.evidence, study.held_evidence(study.local))
    return change_in_runs(trials, healthy, comparison.candidates)


def _fit(comparison: GapEvidence, selection: Selection, far: HowFar) -> Fit:
    """What the causes explain, each block under the fit without its fold."""
    evidence, runs = comparison.evidence, comparison.runs
    unseen = unseen_residual(evidence, selection.fitted)
    if names := shaken_channels(selection):
        unseen = settled(evidence, unseen, names)
    unseen_score = evidence.score(unseen).sum(axis=1)
    measured = np.any(evidence.count > 0, axis=0)
    healthy, causes = comparison.healthy, selection.fitted.causes
    return Fit(
        closed=closed_share(evidence, unseen),
        excess_after=evidence.mean_excess(unseen),
        worst_after=float(np.nanmax(evidence.excess(unseen))),
        p_after=chance_of_energies(evidence, unseen, runs, joints_alike=False).p if runs else 0.0,
        nats_after=max(0.0, nats_beyond(evidence, unseen_score, healthy)),
        closed_acting=closed_beyond(evidence, unseen, runs) if causes else 1.0,
        left_there=left_of(far, causes, evidence.effects, evidence.simulator.channels)
        if runs
        else 0.0,
        unwatched=float(len(unwatched_stages(evidence.simulator.channels, measured))),
        rough=_roughness(selection, far) if runs else 0.0,
    )


def _roughness(selection: Selection, far: HowFar) -> float:
    """How roughly the form of the cause is known that closes most of the gap, 0 to 1.

    Where no gap is seen on held-out runs, of the cause that gains most: what it leaves of a large misfit
    counts there by its logarithm only.
    """
    chosen = [step.chosen for step in selection.steps]
    if not chosen:
        return 0.0
    closed = far.each if np.isfinite(far.each).all() else [one.over.nats for one in chosen]
    return chosen[int(np.argmax(closed))].added.effect.rough


def _diagnosis(
    comparison: GapEvidence, selection: Selection, far: HowFar, answer: _Answer,
    faults: tuple[TrialFaults, ...], runs: tuple[NextRun, ...], seed: int,
) -> Diagnosis:  # fmt: skip
    """Put together what is reported."""
    study, evidence, known = comparison.study, comparison.evidence, comparison.known
    before, remaining = (
        where(evidence, comparison.end_to_end, residual, seed)
        for residual in (evidence.base, selection.fitted.residual)
    )
    stage = answer.change.stage if answer.change else before.stage
    if answer.hunts:
        stage = next(one.stage for one in study.simulator.effects if one.hunts)
    stage = answer.named[0].stage if answer.named else stage
    return Diagnosis(
        simulator=study.simulator.name,
        verdict=answer.verdict,
        stage="" if answer.verdict is Verdict.NO_GAP else stage,
        data_faults=faults,
        standing=study.predictor.standing,
        floor_source=study.floor(study.local).source,
        detection=answer.detection,
        change=answer.change,
        causes=answer.named,
        rivals=answer.rivals,
        ambiguous=answer.ambiguous,
        none=answer.none,
        fit=answer.fit,
        where=before,
        remaining=remaining,
        far=far,
        fitted_trials=tuple(sorted({part.trial for part in study.fitted})),
        held_out_trials=tuple(sorted({part.trial for part in study.held})),
        baselines=comparison.simpler(),
        detectable=detectable(evidence, comparison.signatures, known, selection.fitted),
        next=runs,
        new_commands=new_commands((*study.fitted, *study.held), study.references),
        hunting=study.hunting,
        hunts_for_nothing=answer.hunts,
        warnings=(
            *warnings_of(
                study,
                len(evidence.starts),
                answer.named,
                far,
                answer.detection,
                selection,
            ),
            *resembling(answer.fit.left_there),
            *clearest_there([(one.effect, one.joints) for one in answer.named], remaining),
        ),
        predictions=study.predictor.count,
        seed=seed,
    )


def _next_runs(
    study: Study,
    selection: Selection,
    rivals: Sequence[OpenRival],
    proposer: Proposer | None,
    progress: Progress,
) -> tuple[NextRun, ...]:
    """Rank the runs that discriminate between the named causes and each open alternative."""
    proposals = proposer() if rivals and proposer is not None else ()
    if not proposals:
        return ()
    effects = {effect.name: effect for effect in study.simulator.effects}
    of = [(one.cause, Candidate(effects[one.form], one.joints)) for one in rivals]
    predictor, floor = study.predictor, study.floor(study.judging)
    sets = open_sets(predictor, study.trials, floor, selection.fitted.causes, of, study.judging)
    return discriminating_runs(
        predictor, floor, sets, proposals,
        lambda share: progress("what to run next", NEXT_FROM + (1.0 - NEXT_FROM) * share),
    )  # fmt: skip
