"""The gap of a day: its runs diagnosed together against earlier ones."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from gap.diagnosis.answer.findings import Diagnosis
from model.errors import BigantError
from record.trial.trial import Trial
from robot.day.runs import DayRun
from robot.gap_report.diagnose import diagnosis_of, simulator_of
from robot.gap_report.trials import check_runs, read_trials, runs_of
from robot.gap_report.words import machine_words
from robot.requests.gap import GapDiagnoseRequest

NOT_ASKED = "not compared with earlier runs; add --reference FOLDER"


@dataclass(frozen=True, slots=True)
class DayGap:
    """How the day's runs differ from earlier ones.

    Attributes:
        words: The verdict in a sentence, or why there is none.
        diagnosis: The diagnosis; None where none was asked for, or none could be made.
        machine: Name of the machine.
        trials: Files that were compared.
        references: Files that they were compared with.
        left_out: Files of the day that were not compared, each with the reason.
    """

    words: str
    diagnosis: Diagnosis | None = None
    machine: str = ""
    trials: tuple[Path, ...] = ()
    references: tuple[Path, ...] = ()
    left_out: tuple[tuple[Path, str], ...] = ()

    @property
    def verdict(self) -> str:
        """In capitals; empty where there is no diagnosis."""
        return "" if self.diagnosis is None else self.diagnosis.headline

    def page(self) -> str:
        """Return the page of the diagnosis."""
        from robot.gap_report.page import diagnosis_page  # and with it what draws

        assert self.diagnosis is not None
        today = datetime.now(tz=UTC).astimezone().date()
        return diagnosis_page(self.diagnosis, self.machine, today, self.trials, self.references)


def gap_of_day(
    runs: Sequence[DayRun],
    references: Sequence[Path],
    jobs: int,
    progress: Callable[[str, float], None],
) -> DayGap:
    """Diagnose the runs that no fault stopped, together: one run alone says less than several.

    Args:
        runs: Of the day.
        references: Earlier runs of the same robot, assumed healthy.
        jobs: Processes.
        progress: Gets what is being done, and the share of the whole that is done.
    """
    if not references:
        return DayGap(NOT_ASKED)
    whole = [one.path for one in runs if one.summary is not None and not one.stopped_by_fault]
    trials, left_out = _readable(whole)
    left_out += [(one.path, "a fault stopped it") for one in runs if one.stopped_by_fault]
    healthy, lost = _readable(references)
    if not trials or not healthy:
        which, whose = ("no run of the day", left_out) if not trials else ("no reference", lost)
        why = "".join(reason for _, reason in whose[:1])
        return DayGap(
            f"{which} can be compared{f': {why}' if why else ''}", left_out=(*left_out, *lost)
        )
    paths, earlier = (tuple(path for path, _ in each) for each in (trials, healthy))
    everything = [trial for _, trial in (*trials, *healthy)]
    try:
        check_runs(everything, (*paths, *earlier))
        read = runs_of(everything[: len(trials)], everything[len(trials) :])
        request = GapDiagnoseRequest(trials=paths, reference=earlier, jobs=jobs)
        diagnosis = diagnosis_of(read, simulator_of(read, request), request, progress)
    except BigantError as error:
        return DayGap(f"no comparison with earlier runs: {error}", left_out=(*left_out, *lost))
    machine = machine_words(read.trials[0])
    return DayGap(diagnosis.sentence, diagnosis, machine, paths, earlier, (*left_out, *lost))


def _readable(
    paths: Sequence[Path],
) -> tuple[list[tuple[Path, Trial]], list[tuple[Path, str]]]:
    """Trials of files, and the reasons of those that hold none."""
    trials, left_out = [], []
    for path in paths:
        try:
            trials.append((path, read_trials((path,))[0]))
        except BigantError as error:
            left_out.append((path, str(error)))
    return trials, left_out
