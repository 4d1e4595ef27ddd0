"""The diagnosis: is there a gap, where, which effect, how far it shrinks, what to run next."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import replace

import numpy as np

from gap.diagnosis.ambiguity import Alike, alike
from gap.diagnosis.baselines import baselines
from gap.diagnosis.commissioning import commission, loosened
from gap.diagnosis.detection import (
    Detection,
    Healthy,
    detect,
    detectable,
    energies,
    healthy_runs,
)
from gap.diagnosis.findings import Diagnosis, RivalCause, TrialFaults, Verdict
from gap.diagnosis.how_far import how_far
from gap.diagnosis.probability import Calibration, Left, chances, none_of_them
from gap.diagnosis.verdict import (
    FEWEST_REFERENCES,
    named_causes,
    sentence,
    verdict_of,
    warnings_of,
)
from gap.diagnosis.where import where
from gap.experiments.imitation import imitate
from gap.experiments.next_run import NextRun, Proposal, Proposer, next_runs
from gap.interfaces import Cause, Drive, Simulator
from gap.residuals.evidence import Evidence, errors, evidence_of, local_drive, make_evidence
from gap.residuals.floor import Condition, Floor, make_floor
from gap.residuals.parts import Part, split, whole_part
from gap.residuals.predictions import Predictor
from gap.search.candidates import Candidate, candidates_of
from gap.search.cross_validation import unseen_residual
from gap.search.options import nats_beyond
from gap.search.screen import make_signatures
from gap.search.selection import Selection, closed_share, select
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial

Progress = Callable[[str, float], None]
MOST_INFLATION = 4.0
# Without references: energy over expectation of a channel from which nothing found is still a gap.
CLEAR_EXCESS = 1.5
# Shares that ``progress`` is told are of the time that a walk takes whose causes stay open: starting the
# workers, fitting, and trying runs each take about a quarter of it. Without open causes it ends sooner.
NEXT_FROM = 0.75


def diagnose(
    trials: Sequence[Trial],
    simulator: Simulator,
    references: Sequence[Trial] = (),
    executor: Executor | None = None,
    progress: Progress | None = None,
    seed: int = 0,
    calibration: Calibration | None = None,
    proposer: Proposer | None = None,
    standing: tuple[Cause, ...] | None = None,
) -> Diagnosis:
    """Diagnose the gap between a simulator and measured trials.

    Args:
        trials: Measured runs.
        simulator: The simulator under diagnosis.
        references: Runs of the same machine believed healthy; what they show is taken off.
        executor: Made by ``gap.residuals.predictions.prediction_pool`` with the same trials; None uses this
        process.
        progress: Told what is being done, and the share of the whole that is done.
        seed: Of every random draw; the same seed gives the same diagnosis.
        calibration: Constants of the probabilities.
        proposer: Makes the runs among which the next one is chosen.
        standing: What the references show already, if it is known (``gap.diagnosis.commissioning``); None
        finds out.

    Raises:
        GapError: There are no trials, or nothing in them can be compared.
    """
    tell = progress or (lambda words, share: None)
    if not trials:
        raise GapError("there is no trial to diagnose; give at least one")
    everything = (*trials, *references)
    tell("checking the data", 0.0)
    faults = tuple(
        TrialFaults(i, found) for i, one in enumerate(everything) if (found := simulator.check(one))
    )
    observations = [simulator.observe(one) for one in everything]
    predictor = Predictor(simulator, everything, executor)
    fitted_parts, held_parts = split(trials, observations[: len(trials)])
    reference_parts = [
        whole_part(len(trials) + i, one, observations[len(trials) + i])
        for i, one in enumerate(references)
    ]
    local = local_drive(predictor, fitted_parts)
    if standing is None and len(references) >= FEWEST_REFERENCES:
        tell("what healthy runs lack", 0.08)
        standing = commission(predictor, reference_parts, local)
    predictor = Predictor(simulator, everything, executor, standing or ())
    tell("measuring the floor", 0.12)
    local_floor, healthy = measure_floor(predictor, reference_parts, fitted_parts, local)
    whole_floor, _ = measure_floor(predictor, reference_parts, fitted_parts, Drive.COMMAND)
    judged = local_floor if references else loosened(predictor, fitted_parts, local, local_floor)
    evidence = make_evidence(predictor, fitted_parts, local, judged)
    if not (evidence.count > 0).any():
        raise GapError("no measured channel can be compared with the simulator; check the columns")
    end_to_end = make_evidence(predictor, fitted_parts, Drive.COMMAND, whole_floor)
    held = make_evidence(predictor, held_parts, Drive.COMMAND, whole_floor)

    candidates = candidates_of(simulator, predictor.standing)
    effects = {effect.name: effect for effect in simulator.effects}
    signatures = make_signatures(
        evidence,
        candidates,
        (),
        lambda share: tell("what each effect would do", 0.15 + 0.3 * share),
    )
    calm: Evidence | None = None
    if len(healthy) >= FEWEST_REFERENCES:
        whiteners = [one.whitener for one in healthy]
        calm = evidence_of(predictor, reference_parts, local, local_floor, whiteners)
    selection = select(
        evidence, candidates, signatures, effects, 0.0,
        lambda share: tell("which effects", 0.45 + 0.27 * share), calm,
    )  # fmt: skip
    tell("is there a gap", 0.72)
    detection: Detection | None = None
    if len(healthy) >= FEWEST_REFERENCES:
        detection = detect(evidence, signatures, healthy, selection.p, seed)
    threshold = detection.threshold if detection else 0.0
    tell("how far it shrinks", 0.73)
    unseen = unseen_residual(evidence, selection.fitted)
    closed = closed_share(evidence, unseen)
    left = _excess(evidence, unseen)
    exists = _exists(evidence, detection, selection)
    constants = calibration or Calibration()
    worst = float(np.nanmax(evidence.excess(unseen)))
    p_left = min(energies(evidence, unseen, healthy)) if detection else 0.0
    nats = max(0.0, nats_beyond(evidence, selection.unseen, calm))
    none = 0.0
    if exists:
        rest = Left(closed, left, worst, len(selection.steps), bool(references), p_left)
        none = none_of_them(rest, constants)
    shared = chances(selection, evidence.block_part, none, nats, constants)
    open_rivals = alike(evidence, selection, nats)
    verdict = verdict_of(exists, selection, none, open_rivals)
    far = how_far(held, simulator.channels, selection.fitted.causes, seed)
    tell("where it lies", 0.74)
    before = where(evidence, end_to_end, simulator.channels, simulator.stages, evidence.base, seed)
    after = where(
        evidence, end_to_end, simulator.channels, simulator.stages, selection.fitted.residual, seed
    )
    named = named_causes(evidence, selection, effects, shared, far, calm)
    rivals = tuple(
        RivalCause(
            i, one.effect, one.joints, one.probability, one.behind, one.error,
            selection.steps[i].chosen.added.key,
        )
        for i, group in enumerate(shared)
        for one in group[1:]
    )  # fmt: skip
    stage = "" if verdict is Verdict.NO_GAP else (named[0].stage if named else before.stage)
    proposals = proposer.proposals() if proposer is not None and open_rivals else ()
    tell("what to run next", NEXT_FROM)
    sets = _rival_sets(predictor, trials, selection, open_rivals, whole_floor) if proposals else []
    diagnosis = Diagnosis(
        simulator=simulator.name,
        verdict=verdict,
        sentence="",
        stage=stage,
        data_faults=faults,
        standing=predictor.standing,
        floor_source=local_floor.source,
        detection=detection,
        causes=named,
        rivals=rivals,
        ambiguous=open_rivals,
        ambiguous_of=tuple(selection.steps[one.cause].chosen.added.key for one in open_rivals),
        none=none,
        closed=closed,
        left=left,
        left_worst=worst,
        left_p=p_left,
        left_nats=nats,
        excess=_excess(evidence, evidence.base),
        where=before,
        remaining=after,
        far=far,
        fitted_trials=tuple(sorted({part.trial for part in fitted_parts})),
        held_out_trials=tuple(sorted({part.trial for part in held_parts})),
        baselines=baselines(evidence, signatures),
        detectable=detectable(signatures, threshold),
        next=_next_runs(proposals, simulator, sets, whole_floor, tell),
        warnings=warnings_of(faults, references, evidence, fitted_parts, held_parts, named),
        predictions=predictor.count,
        seed=seed,
    )
    tell("done", 1.0)
    return replace(diagnosis, sentence=sentence(diagnosis))


def measure_floor(
    predictor: Predictor,
    references: Sequence[Part],
    fitted: Sequence[Part],
    drive: Drive,
) -> tuple[Floor, tuple[Healthy, ...]]:
    """Measure the floor; where references do not foretell each other as well as it says, it is raised."""
    channels = predictor.simulator.channels
    known = list(zip(references, errors(predictor, references, drive), strict=True))
    own = list(zip(fitted, errors(predictor, fitted, drive), strict=True))
    floor = make_floor(channels, known, own)
    healthy = healthy_runs(
        channels, known, [Condition(part.gait, part.frequency_hz) for part in fitted]
    )
    if not healthy:
        return floor, healthy
    excess = np.array([one.excess for one in healthy])
    factor = np.ones(len(channels))
    names = [channel.name for channel in channels]
    for name in set(names):
        on = np.array([one == name for one in names])
        seen = excess[:, on][np.isfinite(excess[:, on])]
        if len(seen):
            factor[on] = np.clip(np.mean(seen), 1.0, MOST_INFLATION)
    raised = replace(floor, sigma=floor.sigma * np.sqrt(factor), power=floor.power * factor)
    calm = tuple(
        replace(
            one,
            whitener=replace(one.whitener, gain=one.whitener.gain / np.sqrt(factor)),
            residual=one.residual / np.sqrt(factor),
            excess=one.excess / factor,
        )
        for one in healthy
    )
    return raised, calm


def _excess(evidence: Evidence, residual: FloatArray) -> float:
    return float((residual**2).sum() / evidence.count.sum())


def _exists(evidence: Evidence, detection: Detection | None, selection: Selection) -> bool:
    if detection is not None:
        return bool(selection.steps) or detection.by_energy
    if selection.steps:
        return True
    excess, count = evidence.excess(evidence.base), evidence.count.sum(axis=0)
    limit = np.fmax(CLEAR_EXCESS, 1.0 + 5.0 * np.sqrt(2.0 / np.fmax(count, 1.0)))
    return bool(np.any(excess > limit))


def _next_runs(
    proposals: Sequence[Proposal],
    simulator: Simulator,
    sets: Sequence[tuple[Cause, ...]],
    floor: Floor,
    tell: Progress,
) -> tuple[NextRun, ...]:
    if not proposals:
        return ()
    return next_runs(
        proposals, simulator, sets, floor,
        lambda share: tell("what to run next", NEXT_FROM + (1.0 - NEXT_FROM) * share),
    )  # fmt: skip


def _rival_sets(
    predictor: Predictor,
    trials: Sequence[Trial],
    selection: Selection,
    rivals: Sequence[Alike],
    floor: Floor,
) -> list[tuple[Cause, ...]]:
    """The causes that were named, and each set with an open rival in place of one, as in ``gap next``."""
    simulator, before = predictor.simulator, len(predictor.standing)
    own = (*predictor.standing, *selection.fitted.causes)
    effects = {effect.name: effect for effect in simulator.effects}
    others = [
        imitate(
            simulator,
            trials[:2],
            own,
            before + one.cause,
            Candidate(effects[one.effect], one.joints),
            floor,
        )
        for one in rivals
    ]
    return [own, *others]
