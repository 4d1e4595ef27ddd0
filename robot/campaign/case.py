"""One case of a campaign: read, diagnose, keep the answer. Runs in a process of its own."""

import json
import time
from dataclasses import dataclass
from pathlib import Path

from gap.delegate import Without
from gap.diagnosis.as_json import diagnosis_json
from gap.diagnosis.commissioning import standing_of
from gap.diagnosis.diagnose import diagnose_study
from gap.diagnosis.study import make_study
from gap.interfaces import Cause, Simulator
from model.errors import RecordError
from record.trial.trial import Trial
from robot.campaign.folder import CaseFiles, keep_json
from robot.gap_report.trials import read_runs


@dataclass(frozen=True, slots=True)
class Asked:
    """A diagnosis to be made.

    Attributes:
        trials: The runs.
        references: Healthy runs.
        missing: Effects to be taken out of the catalogue.
        out: Where the answer goes.
        standing: What the references show already; None to find out.
    """

    trials: tuple[Path, ...]
    references: tuple[Path, ...]
    missing: tuple[str, ...]
    out: Path
    standing: tuple[Cause, ...] | None = None


def answer_case(asked: Asked) -> None:
    """Diagnose a case and keep its answer, which appears when it is whole.

    Raises:
        BigantError: A trial cannot be read or compared.
    """
    began_s, began_cpu_s = time.perf_counter(), time.process_time()
    trials, references, simulator = read_case(asked)
    standing = asked.standing
    if standing is not None:
        standing = tuple(one for one in standing if one.effect not in asked.missing)
    found = diagnose_study(make_study(trials, simulator, references), standing=standing)
    spent = {"seconds": time.perf_counter() - began_s, "cpu_s": time.process_time() - began_cpu_s}
    keep_json({**diagnosis_json(found), **spent}, asked.out)


def read_case(asked: Asked) -> tuple[tuple[Trial, ...], tuple[Trial, ...], Simulator]:
    """Return its trials, its references, and the simulator that their machine calls for.

    Raises:
        BigantError: A trial cannot be read.
    """
    runs = read_runs(asked.trials, asked.references)
    return runs.trials, runs.references, Without(runs.simulator(), asked.missing)


def commission_case(asked: Asked, kept: Path) -> tuple[Cause, ...]:
    """Find what the references of a campaign show already, once for all its cases.

    Args:
        asked: Any of its cases.
        kept: JSON file in which the answer is kept.

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
    _, references, simulator = read_case(asked)
    found = standing_of(references, simulator)
    keep_json(found, kept)
    return found


def neutral_values(files: CaseFiles) -> dict[tuple[str, str], float]:
    """Return the value of each (effect, parameter) at which nothing happens."""
    _, _, simulator = read_case(Asked(files.trials[:1], (), (), Path()))
    return {(e.name, p.name): p.neutral for e in simulator.effects for p in e.parameters}
