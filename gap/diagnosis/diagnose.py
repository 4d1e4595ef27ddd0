"""The diagnosis: is there a gap, where, which effect, how far it shrinks, what to run next."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor

import numpy as np

from gap.diagnosis.ambiguity import OpenRival, open_rivals
from gap.diagnosis.baselines import baselines
from gap.diagnosis.commissioning import commission
from gap.diagnosis.detection import Detection, Healthy, detect, detectable, energies
from gap.diagnosis.findings import Diagnosis, TrialFaults, Verdict
from gap.diagnosis.how_far import how_far
from gap.diagnosis.probability import Fit, chances, none_of_them
from gap.diagnosis.study import FEWEST_REFERENCES, Study, make_study
from gap.diagnosis.verdict import gap_exists, named_causes, verdict_of, warnings_of
from gap.diagnosis.where import where
from gap.experiments.imitation import imitate
from gap.experiments.next_run import NextRun, next_runs
from gap.interfaces import Cause, Drive, Proposal, Simulator
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate, candidates_of
from gap.search.cross_validation import unseen_residual
from gap.search.options import nats_beyond
from gap.search.screen import make_signatures
from gap.search.selection import Selection, closed_share, select
from model.errors import GapError
from record.trial.trial import Trial

Progress = Callable[[str, float], None]
Proposer = Callable[[], Sequence[Proposal]]
# Shares that ``progress`` gets are of the time that a walk takes whose causes stay open: starting the
# workers, fitting, and trying runs each take about a quarter of it. Without open causes it ends sooner.
NEXT_FROM = 0.75


def silent(words: str, share: float) -> None:
    """Hear how far a diagnosis is, and show nothing."""


def diagnose(
    trials: Sequence[Trial],
    simulator: Simulator,
    references: Sequence[Trial] = (),
    executor: Executor | None = None,
    progress: Progress = silent,
    seed: int = 0,
    proposer: Proposer | None = None,
) -> Diagnosis:
    """Diagnose the gap between a simulator and measured trials.

    Args:
        trials: Measured runs.
        simulator: The simulator under diagnosis.
        references: Runs of the same machine believed healthy; what they show is subtracted.
        executor: Made by ``gap.residuals.predictions.prediction_pool`` with the same trials; None uses this
            process.
        progress: Gets what is being done, and the share of the whole that is done.
        seed: Of every random draw; the same seed gives the same diagnosis.
        proposer: Makes the runs among which the next one is chosen.

    Raises:
        GapError: There are no trials, or nothing in them can be compared.
    """
    study = make_study(trials, simulator, references, executor)
    return diagnose_study(study, progress, seed, proposer)


def diagnose_study(
    study: Study,
    progress: Progress = silent,
    seed: int = 0,
    proposer: Proposer | None = None,
    standing: tuple[Cause, ...] | None = None,
) -> Diagnosis:
    """Diagnose trials and references that are assembled already, as ``diagnose`` does.

    ``standing`` is what the references show already (``gap.diagnosis.commissioning``); None finds out.

    Raises:
        GapError: Nothing can be compared.
    """
    progress("checking the data", 0.0)
    checked = [study.simulator.check(one) for one in study.predictor.trials]
    faults = tuple(TrialFaults(i, own) for i, own in enumerate(checked) if own)

    # what healthy runs show already, and what is expected beside it
    local = study.local
    if standing is None and len(study.references) >= FEWEST_REFERENCES:
        progress("baseline model errors", 0.08)
        standing = commission(study)
    study = study.with_standing(standing or ())
    progress("measuring the baseline", 0.12)
    evidence = study.evidence(local) if study.references else study.loose_evidence(local)
    if not (evidence.count > 0).any():
        raise GapError("no measured channel can be compared with the simulator; check the columns")
    end_to_end, held = study.evidence(Drive.COMMAND), study.held_evidence()
    healthy = study.healthy_evidence(local)

    # which causes
    candidates = candidates_of(study.simulator, study.predictor.standing)
    signatures = make_signatures(
        evidence, candidates, (), lambda share: progress("effects one by one", 0.15 + 0.3 * share)
    )
    selection = select(
        evidence, candidates, signatures,
        lambda share: progress("which effects", 0.45 + 0.27 * share), healthy,
    )  # fmt: skip

    # is there a gap, and is it explained
    progress("is there a gap", 0.72)
    runs = study.healthy_runs(local)
    detection: Detection | None = None
    if healthy is not None:
        detection = detect(evidence, signatures, runs, selection.p, seed)
    fit = _fit(evidence, selection, healthy, runs if detection else ())
    exists = gap_exists(evidence, detection, selection)
    referenced = bool(study.references)
    none = none_of_them(fit, len(selection.steps), referenced) if exists else 0.0
    shared = chances(selection, evidence.block_part, none, fit.nats_after)
    rivals = open_rivals(evidence, selection, [own for _, own in shared], fit.nats_after)
    verdict = verdict_of(exists, selection, none, bool(rivals))

    # how far it shrinks, and where it lies
    progress("how far it shrinks", 0.73)
    far = how_far(held, selection.fitted.causes, seed)
    progress("where it lies", 0.74)
    before = where(evidence, end_to_end, evidence.base, seed)
    named = named_causes(evidence, selection, [one for one, _ in shared], far, healthy)
    stage = named[0].stage if named else before.stage

    # what to run next
    progress("what to run next", NEXT_FROM)
    runs_next = _next_runs(study, selection, rivals, proposer, progress) if rivals else ()
    diagnosis = Diagnosis(
        simulator=study.simulator.name,
        verdict=verdict,
        stage="" if verdict is Verdict.NO_GAP else stage,
        data_faults=faults,
        standing=study.predictor.standing,
        floor_source=study.floor(local).source,
        detection=detection,
        causes=named,
        rivals=tuple(rival for _, own in shared for rival in own),
        ambiguous=rivals,
        none=none,
        fit=fit,
        where=before,
        remaining=where(evidence, end_to_end, selection.fitted.residual, seed),
        far=far,
        fitted_trials=tuple(sorted({part.trial for part in study.fitted})),
        held_out_trials=tuple(sorted({part.trial for part in study.held})),
        baselines=baselines(evidence, signatures),
        detectable=detectable(signatures, detection.threshold if detection else 0.0),
        next=runs_next,
        warnings=tuple(warnings_of(study, faults, len(evidence.starts), named)),
        predictions=study.predictor.count,
        seed=seed,
    )
    progress("done", 1.0)
    return diagnosis


def _fit(
    evidence: Evidence,
    selection: Selection,
    healthy: Evidence | None,
    runs: Sequence[Healthy],
) -> Fit:
    """What the causes explain, each block under the fit without its fold."""
    unseen = unseen_residual(evidence, selection.fitted)
    return Fit(
        closed=closed_share(evidence, unseen),
        excess_after=evidence.mean_excess(unseen),
        worst_after=float(np.nanmax(evidence.excess(unseen))),
        p_after=min(energies(evidence, unseen, runs)) if runs else 0.0,
        nats_after=max(0.0, nats_beyond(evidence, selection.unseen, healthy)),
    )


def _next_runs(
    study: Study,
    selection: Selection,
    rivals: Sequence[OpenRival],
    proposer: Proposer | None,
    progress: Progress,
) -> tuple[NextRun, ...]:
    """Rank the runs that discriminate between the named causes and each open rival in place of one."""
    proposals = proposer() if proposer is not None else ()
    if not proposals:
        return ()
    simulator, floor = study.simulator, study.floor(Drive.COMMAND)
    standing = study.predictor.standing
    named = (*standing, *selection.fitted.causes)
    effects = {effect.name: effect for effect in simulator.effects}
    sets = [named]
    trials = study.trials[:2]
    for one in rivals:
        rival, of = Candidate(effects[one.effect], one.joints), len(standing) + one.cause
        sets.append(imitate(simulator, trials, named, of, rival, floor))
    return next_runs(
        proposals, simulator, sets, floor,
        lambda share: progress("what to run next", NEXT_FROM + (1.0 - NEXT_FROM) * share),
    )  # fmt: skip
