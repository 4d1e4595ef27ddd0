"""Trials against the simulator, in units of what is expected: what search and answer work on."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from gap.diagnosis.comparison.baselines import Baseline, baselines
from gap.diagnosis.comparison.study import Study
from gap.interfaces import Drive
from gap.residuals.at_once import meanwhile
from gap.residuals.evidence import Evidence
from gap.residuals.healthy import Healthy
from gap.search.candidates import Candidate, at_hunting, candidates_of, with_vibrations
from gap.search.healthy_search import search_healthy
from gap.search.screen import Signatures, make_signatures
from gap.search.steps import Known
from model.errors import GapError


@dataclass(frozen=True, slots=True, eq=False)
class GapEvidence:
    """What is compared.

    Attributes:
        study: Trials, references and the simulator.
        evidence: What is fitted to, each stage by itself.
        end_to_end: The same from commands alone; None where runs have none.
        held: What judges, from commands alone; else each stage by itself.
        candidates: Everything that could be the cause.
        signatures: Of every candidate.
        runs: References, each in units of what the others predict; none where there are too few.
        known: The same as evidence, with what the search finds in them; None for too few.
        simpler: Returns what simpler methods answer on the same data.
    """

    study: Study
    evidence: Evidence
    end_to_end: Evidence | None
    held: Evidence
    candidates: tuple[Candidate, ...]
    signatures: Signatures
    runs: tuple[Healthy, ...]
    known: Known | None
    simpler: Callable[[], tuple[Baseline, ...]]

    @property
    def healthy(self) -> Evidence | None:
        """References as evidence; None for too few."""
        return self.known.runs if self.known else None


def compare(study: Study, progress: Callable[[float], None]) -> GapEvidence:
    """Compare trials with the simulator; progress gets the share of the candidates that were tried.

    Raises:
        GapError: Nothing can be compared.
    """
    local = study.local
    evidence = study.evidence(local) if study.references else study.loose_evidence(local)
    if not (evidence.count > 0).any():
        raise GapError("no measured channel can be compared with the simulator; check the columns")
    every = candidates_of(study.simulator, study.predictor.standing)
    candidates = with_vibrations(at_hunting(every, study.hunting), study.vibrations)
    signatures = make_signatures(evidence, candidates, (), progress)
    healthy = study.healthy_evidence(local)
    runs = study.healthy_runs(local) if healthy else ()
    held = study.whole_held(local) if healthy else None
    search = partial(search_healthy, evidence, signatures, runs)
    at_once = study.predictor.at_once
    known = Known(healthy, runs, meanwhile(search, at_once), held) if healthy else None
    return GapEvidence(
        study=study,
        evidence=evidence,
        end_to_end=study.evidence(Drive.COMMAND) if study.judging is Drive.COMMAND else None,
        held=study.held_evidence(),
        candidates=candidates,
        signatures=signatures,
        runs=runs,
        known=known,
        simpler=meanwhile(partial(baselines, evidence, signatures), at_once),
    )
