"""The diagnosis in a notebook: what ``bigant gap diagnose`` prints, as values."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import TypeAlias

from bigant.logs import Log, path_of
from gap.diagnosis.answer.findings import Diagnosis
from gap.diagnosis.answer.named_cause import NamedCause
from gap.diagnosis.diagnose import silent
from gap.machine_kinds import Make
from record.trial.trial import Trial
from record.whole_file import write_text
from robot.console.json_output import json_text
from robot.gap_report.diagnose import diagnosis_of, diagnosis_result, simulator_of
from robot.gap_report.split import with_hold_out
from robot.gap_report.summary import summary_lines
from robot.gap_report.trials import Runs, check_runs, read_trials, runs_of
from robot.gap_report.words import machine_words
from robot.requests.gap import GapDiagnoseRequest

Run: TypeAlias = Log | Trial | str | Path
Machine: TypeAlias = str | Path | Make
ROBOT_FILE = ".toml"


@dataclass(frozen=True, eq=False, repr=False)
class GapReport:
    """A diagnosis, and what it was made from.

    Attributes:
        diagnosis: Everything that was found.
        runs: Trials and references.
        files: Files of the trials and then of the references; ``run 1`` for one that is in memory.
    """

    diagnosis: Diagnosis
    runs: Runs
    files: tuple[Path, ...]

    @property
    def verdict(self) -> str:
        """``no_gap``, ``explained``, ``ambiguous`` or ``unexplained``."""
        return self.diagnosis.verdict.value

    @property
    def sentence(self) -> str:
        """The verdict in one sentence."""
        return self.diagnosis.sentence

    @property
    def causes(self) -> tuple[NamedCause, ...]:
        """The causes, the largest first: effect, legs, values with errors, probability, remedy."""
        return self.diagnosis.causes

    @property
    def probabilities(self) -> Mapping[str, float]:
        """Probability of each cause by its name and place; ``none``: the catalogue has no name for it."""
        named = {_place(one): one.probability for one in self.causes}
        return {**named, "none": self.diagnosis.none}

    @property
    def parameters(self) -> Mapping[str, Mapping[str, tuple[float, float]]]:
        """Value and standard error of each parameter of each cause."""
        return {
            _place(one): {value.name: (value.value, value.error) for value in one.values}
            for one in self.causes
        }

    def save(self, out: str | Path) -> None:
        """Write the page (.html) or the JSON (.json) that the command writes.

        Raises:
            ValueError: It is another kind of file.
            RecordError: It cannot be written.
        """
        path, trials = Path(out), len(self.runs.trials)
        if path.suffix == ".json":
            result = diagnosis_result(self.diagnosis, self.files, self.runs)
            write_text(path, json_text(result) + "\n")
        elif path.suffix == ".html":
            from robot.gap_report.page import diagnosis_page  # and with it matplotlib

            machine, today = machine_words(self.runs.trials[0]), datetime.now(tz=UTC).date()
            files = self.files[:trials], self.files[trials:]
            write_text(path, diagnosis_page(self.diagnosis, machine, today, *files))
        else:
            raise ValueError(f"a diagnosis is written as .html or .json, not {path}")

    def __repr__(self) -> str:
        """Return what the command prints."""
        return "\n".join(summary_lines(self.diagnosis, self.files))


def _place(cause: NamedCause) -> str:
    return " ".join([cause.effect, *cause.joints])


def diagnose(
    runs: Run | Sequence[Run],
    references: Run | Sequence[Run] = (),
    *,
    machine: Machine | None = None,
    hold_out: str | Sequence[str] = (),
    effects: str | Path | None = None,
    jobs: int | str = 1,
    progress: Callable[[str, float], None] = silent,
) -> GapReport:
    """Diagnose where the simulator differs from measured runs, why, and how much of it is explained.

    Args:
        runs: Logs, trials or their files, of one machine.
        references: Runs of the same machine assumed healthy; the question is then what is new.
        machine: What the runs are compared with, in place of what is recorded with them: a robot file for
            the runs (the references keep theirs), an MJCF or URDF or ``FILE.py:make`` for all, or a
            function that makes a ``gap.interfaces.Simulator`` of a list of trials.
        hold_out: Runs that judge and are not fitted to: ``trial=NAME``, ``KEY=VALUE`` of their conditions,
            or ``last-third`` of every run. Without it they are chosen evenly.
        effects: A Python file of effects of your own.
        jobs: Processes. Above 1 a script needs ``if __name__ == "__main__":``, and a machine made by a
            function one that can be imported. Or the scheduler of a Dask cluster, ``tcp://HOST:PORT``.
        progress: Gets what is being done, and the share of the whole that is done, 0 to 1.

    Raises:
        RecordError: A run cannot be read.
        GapError: They are of different machines, or cannot be compared with a simulator.
        ConfigError: No cluster answers.
    """
    own, healthy = _listed(runs), _listed(references)
    everything = [_trial(one) for one in (*own, *healthy)]
    files = tuple(
        Path(f"run {number}") if isinstance(one, Trial) else path_of(one)
        for number, one in enumerate((*own, *healthy), start=1)
    )
    check_runs(everything, files)
    count = len(own)
    robot, other = _replacement(machine)
    read = runs_of(everything[:count], everything[count:], robot, other)
    read = with_hold_out(read, files[:count], _texts(hold_out))
    request = GapDiagnoseRequest(
        trials=files[:count],
        reference=files[count:],
        robot=read.robot,
        effects=None if effects is None else Path(effects),
        jobs=1 if isinstance(jobs, str) else jobs,
        dask=jobs if isinstance(jobs, str) else None,
    )
    simulator = simulator_of(read, request)
    return GapReport(diagnosis_of(read, simulator, request, progress), read, files)


def _replacement(machine: Machine | None) -> tuple[Path | None, str | Make]:
    """The robot file that replaces the one of the runs, and the machine that replaces that of all."""
    if machine is None:
        return None, ""
    if callable(machine):
        return None, machine
    text = str(machine)
    return (Path(text), "") if text.endswith(ROBOT_FILE) else (None, text)


def _texts(chosen: str | Sequence[str]) -> tuple[str, ...]:
    return (chosen,) if isinstance(chosen, str) else tuple(chosen)


def _listed(runs: Run | Sequence[Run]) -> tuple[Run, ...]:
    return (runs,) if isinstance(runs, Log | Trial | str | Path) else tuple(runs)


def _trial(run: Run) -> Trial:
    return run if isinstance(run, Trial) else read_trials((path_of(run),))[0]
