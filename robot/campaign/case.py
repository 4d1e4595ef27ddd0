"""One case of a campaign: read, diagnose, keep the answer. Runs in a process of its own."""

import json
import time
from dataclasses import dataclass
from pathlib import Path

from gap.check.without import without
from gap.diagnosis.as_json import diagnosis_json
from gap.diagnosis.commissioning import standing_of
from gap.diagnosis.diagnose import diagnose_study
from gap.diagnosis.study import make_study
from gap.interfaces import Cause, Simulator
from model.errors import RecordError
from robot.campaign.folder import keep_json
from robot.gap_report.trials import Runs, read_runs


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
        standing = tuple(one for one in standing if one.effect not in request.missing)
    study = make_study(runs.trials, simulator, runs.references)
    found = diagnose_study(study, standing=standing)
    spent = {"seconds": time.perf_counter() - began_s, "cpu_s": time.process_time() - began_cpu_s}
    keep_json({**diagnosis_json(found), **spent}, request.out)


def read_case(
    trials: tuple[Path, ...], references: tuple[Path, ...] = (), missing: tuple[str, ...] = ()
) -> tuple[Runs, Simulator]:
    """Return the runs of a case, and the simulator of their machine without the ``missing`` effects.

    Raises:
        BigantError: A trial cannot be read.
    """
    runs = read_runs(trials, references)
    simulator = runs.simulator()
    known = {effect.name for effect in simulator.effects}
    return runs, without(simulator, [name for name in missing if name in known])


def commission_case(request: CaseRequest, kept: Path) -> tuple[Cause, ...]:
    """Find what the references of any case of a campaign show already, and keep it for the others.

    Raises:
        BigantError: A reference cannot be read or compared, or the file holds something else.
    """
    if kept.is_file():
        try:
            return tuple(
                Cause(one["effect"], tuple(one["joints"]), tuple(map(float, one["values"])))
                for one in json.loads(kept.read_text(encoding="utf-8"))
            )
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise RecordError(f"{kept}: {error!r}; delete it to commission again") from error
    runs, simulator = read_case(request.trials, request.references, request.missing)
    found = standing_of(runs.references, simulator)
    keep_json(found, kept)
    return found
