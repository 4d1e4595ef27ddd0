"""The cases of a campaign: their files, their labels, and their diagnoses.

A case is diagnosed in a process of its own. Labels are read once the seal is open.
"""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from gap.check.cases import CaseAnswer, Named, Remainder, Truth
from gap.coverage.blind_spots import blind_spots
from gap.delegate import Without
from gap.detectable import Detectable
from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.comparison.commissioning import (
    commissioned_study,
    enough_conditions,
    standing_of,
)
from gap.diagnosis.diagnose import diagnose_study
from gap.interfaces import Cause, Simulator
from model.errors import RecordError
from record.json_text import parse_json
from record.trial.header_file import read_text
from record.whole_file import write_text
from robot.console.json_output import json_text
from robot.gap_report.blind import blind_json
from robot.gap_report.causes_file import read_causes, write_causes
from robot.gap_report.trials import Runs, read_runs

CASES, REFERENCES = "cases", "references"


@dataclass(frozen=True, slots=True)
class CaseFiles:
    """Trials of one case, and healthy runs of its robot."""

    name: str
    trials: tuple[Path, ...]
    references: tuple[Path, ...]


@dataclass(frozen=True, slots=True)
class Label:
    """What was wrong in a case of a kind (control, single, pair, outside) of a robot, by its number.

    The seeds are those of the days on which its trials were walked.
    """

    kind: str
    truths: tuple[Truth, ...]
    robot: int
    seeds: tuple[int, ...]


def campaign_cases(folder: Path) -> tuple[CaseFiles, ...]:
    """Return the cases of a campaign in the order of their names, without looking at labels.

    Raises:
        RecordError: The folder holds no campaign.
    """
    references = tuple(sorted((folder / REFERENCES).glob("*.parquet")))
    folders = sorted(path for path in (folder / CASES).glob("*") if path.is_dir())
    cases = tuple(
        CaseFiles(path.name, trials, references)
        for path in folders
        if (trials := tuple(sorted(path.glob("trial_*.parquet"))))
    )
    if not cases:
        raise RecordError(
            f"{folder} holds no campaign ({CASES}/NAME/trial_*.parquet); "
            "make one with: bigant campaign make"
        )
    return cases


def parse_labels(text: str, source: str) -> dict[str, Label]:
    """Return the label of each case.

    Raises:
        RecordError: The text holds no labels.
    """
    try:
        return {name: _label(case) for name, case in parse_json(text)["cases"].items()}
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecordError(f"{source}: no labels of a campaign ({error!r})") from error


def _label(case: Mapping[str, Any]) -> Label:
    truths = tuple(
        Truth(e["name"], e["stage"], e["leg"], tuple((k, float(v)) for k, v in e["parameters"].items()))
        for e in case["effects"]
    )  # fmt: skip
    return Label(case["kind"], truths, int(case["robot"]), tuple(map(int, case["seeds"])))


def read_answer(path: Path) -> CaseAnswer:
    """Read the diagnosis of a case; any JSON that has the shape will do.

    Raises:
        RecordError: It cannot be read.
    """
    text = read_text(path)
    try:
        return answer_of(parse_json(text))
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise RecordError(
            f"{path}: no diagnosis ({error!r}); delete it to diagnose again"
        ) from error


def answer_of(diagnosis: Mapping[str, Any]) -> CaseAnswer:
    """Return what is counted of a diagnosis, as JSON has it."""
    return CaseAnswer(
        verdict=diagnosis["verdict"],
        stage=diagnosis["where"]["stage"] or "",
        named=tuple(
            Named(
                one["effect"],
                tuple(one.get("legs", ())),
                tuple((k, _number(v)) for k, v in one.get("parameters", {}).items()),
                _number(one.get("probability")),
                tuple((k, _number(v)) for k, v in one.get("errors", {}).items()),
            )
            for one in diagnosis["causes"]
        ),
        alike=tuple((a, b) for a, b in diagnosis.get("ambiguous_with", ())),
        none=_number(diagnosis.get("none_of_these")),
        shrink=_number(diagnosis["gap"].get("shrink")),
        seconds=_number(diagnosis.get("seconds")),
        simpler=tuple(
            (one["method"], tuple(cause["effect"] for cause in one["causes"]))
            for one in diagnosis.get("baselines", ())
        ),
        hidden=tuple(
            one["effect"] for one in diagnosis.get("before_judging", {}).get("cannot_be_seen", ())
        ),
        remainder=_remainder(diagnosis.get("fit")),
        referenced=diagnosis.get("floor", {}).get("source") == "references",
        detectable=tuple(map(_detectable, diagnosis.get("detectable", ()))),
    )


def _remainder(fit: Mapping[str, Any] | None) -> Remainder | None:
    if fit is None:
        return None
    names = ("closed", "excess_after", "worst_after", "p_after")
    # not in earlier ones
    since = (("closed_acting", 1.0), ("left_there", 0.0), ("unwatched", 0.0), ("rough", 0.0))
    return Remainder(
        *(_number(fit.get(name)) for name in names),
        *(_number(fit.get(name, usual)) for name, usual in since),
    )


def _detectable(one: Mapping[str, Any]) -> Detectable:
    """A size; JSON has none where these runs cannot show any."""
    of = {  # without what follows of them; answers of earlier versions do not say where
        field.name: one[field.name] for field in fields(Detectable) if field.name in one
    }
    return Detectable(**{**of, "size": math.inf if of["size"] is None else of["size"]})


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else math.nan


def keep_json(value: object, path: Path) -> None:
    """Write JSON that appears when it is whole: other processes look for it.

    Raises:
        RecordError: It cannot be written.
    """
    write_text(path, json_text(value, 1) + "\n")


@dataclass(frozen=True, slots=True)
class CaseRequest:
    """A diagnosis to be made, and where its answer goes.

    ``missing`` effects are taken out of the catalogue; ``standing`` is what the references show already,
    None to find out.
    """

    trials: tuple[Path, ...]
    references: tuple[Path, ...]
    out: Path
    missing: tuple[str, ...] = ()
    standing: tuple[Cause, ...] | None = None


def answer_case(request: CaseRequest) -> None:
    """Diagnose a case and keep its answer, which appears when it is whole.

    Raises:
        BigantError: A trial cannot be read or compared.
    """
    began_s, began_cpu_s = time.perf_counter(), time.process_time()
    runs, simulator = read_case(request.trials, request.references, request.missing)
    standing = request.standing
    if standing is not None:
        there = {effect.name for effect in simulator.effects}
        standing = tuple(one for one in standing if one.effect in there)
    early = {"before_judging": blind_json(blind_spots(simulator, runs.trials))}
    study = commissioned_study(runs.trials, simulator, runs.references, standing=standing)
    diagnosis = diagnose_study(study)
    spent = {"seconds": time.perf_counter() - began_s, "cpu_s": time.process_time() - began_cpu_s}
    keep_json({**diagnosis_json(diagnosis), **early, **spent}, request.out)


def read_case(
    trials: tuple[Path, ...], references: tuple[Path, ...] = (), missing: tuple[str, ...] = ()
) -> tuple[Runs, Simulator]:
    """Return the runs of a case, and the simulator of their machine without the ``missing`` effects.

    Raises:
        BigantError: A trial cannot be read.
    """
    runs = read_runs(trials, references)
    return runs, Without(runs.simulator(), missing)


def baseline_of_case(request: CaseRequest, kept: Path) -> tuple[Cause, ...] | None:
    """``commission_case``; None where the references are too few to show a baseline.

    Raises:
        BigantError: A reference cannot be read or compared, or the file holds something else.
    """
    causes = commission_case(request, kept)
    if causes:
        return causes
    runs, _ = read_case(request.trials, request.references, request.missing)
    return causes if enough_conditions(runs.references) else None


def commission_case(request: CaseRequest, kept: Path) -> tuple[Cause, ...]:
    """Find what the references of any case of a campaign show already, and keep it for the others.

    Raises:
        BigantError: A reference cannot be read or compared, or the file holds something else.
    """
    if kept.is_file():
        try:
            return read_causes(kept)
        except (OSError, ValueError) as error:
            raise RecordError(f"{kept}: {error!r}; delete it to commission again") from error
    runs, simulator = read_case(request.trials, request.references, request.missing)
    standing = standing_of(runs.references, simulator)
    write_causes(standing, kept)
    return standing
