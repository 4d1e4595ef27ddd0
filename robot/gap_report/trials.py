"""Trials for the diagnosis, from trial tables or logs, and the simulator that their machine calls for."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from gap.interfaces import Simulator
from gap.machine_kinds import (
    MachineKind,
    Make,
    kind_named,
    kind_of_file,
    machine_kinds,
    simulator_of,
)
from gap.residuals.hold_out import HoldOut
from model.errors import GapError, RecordError
from record.log.export import export_trial
from record.log.reader import LogContents
from record.trial.header import KIND_OF_SUFFIX, LEGGED, TrialHeader, kind_of
from record.trial.header_file import machine_tables, read_machine
from record.trial.trial import Trial, read_trial
from robot.gap_report.answer import RUN_SUFFIXES, DiagnosedRuns
from robot.gap_report.each_once import check_each_once
from robot.gap_report.legged import NO_FILE, robot_text


@dataclass(frozen=True, slots=True)
class Runs:
    """Runs of one kind of machine: trials to be diagnosed, and healthy references; see ``runs_of``.

    Attributes:
        trials: Each names the machine's file that it is simulated with.
        references: They keep the file recorded with them, whatever that of the trials is.
        kind: What kind of machine they are of.
        robot: File that replaces the one recorded with the trials; None for that one.
        machine: What ``--machine`` names; empty where the machine's file says the kind.
        hold_out: Which of the trials judge; None holds out evenly.
        joints: What ``--joint`` names; empty for all joints.
    """

    trials: tuple[Trial, ...]
    references: tuple[Trial, ...]
    kind: MachineKind
    robot: Path | None = None
    machine: str = ""
    hold_out: HoldOut | None = None
    joints: tuple[str, ...] = ()

    @property
    def robot_text(self) -> str:
        """Machine's file of the trials, that of the first where they have several.

        Raises:
            GapError: There is none.
        """
        return _recorded(self.trials)

    def simulator(self, effects: Path | None = None) -> Simulator:
        """Return the simulator of their machine, each trial with its own file.

        Args:
            effects: A file of users' effects.

        Raises:
            GapError: The machine's file or the file of effects cannot be used.
        """
        return simulator_of(with_effects(self.kind, effects), (*self.trials, *self.references))

    def made_by(self, make: Make) -> Simulator:
        """Return the simulator that a function makes of each machine's file.

        Raises:
            GapError: A machine's file cannot be used, or two differ in what they may not.
        """
        return simulator_of(MachineKind(make), (*self.trials, *self.references))


def runs_of(
    trials: Sequence[Trial],
    references: Sequence[Trial] = (),
    robot: Path | None = None,
    machine: str | Make = "",
) -> Runs:
    """Return runs whose machine's files are settled.

    Args:
        trials: Trials of one machine.
        references: Healthy runs of it; one that names no machine's file has that of the trials.
        robot: Machine's file to use for the trials instead of the one recorded with them.
        machine: ``FILE.py:make``, what that would be, or an MJCF or URDF that is the machine's file of them
            all; empty for the kind that the machine's file says.

    Raises:
        ConfigError: ``robot`` cannot be used.
        GapError: There is no such kind of machine.
    """
    if callable(machine):
        kind, name = MachineKind(machine), getattr(machine, "__qualname__", repr(machine))
        return Runs(tuple(trials), tuple(references), kind, robot, name)
    model = Path(machine)
    if model.suffix in KIND_OF_SUFFIX:
        trials, references = (
            tuple(_with_machine(one, model) for one in each) for each in (trials, references)
        )
    recorded = next((one.header for one in (*trials, *references) if one.header.robot_text), None)
    trials, references = (
        tuple(_with_file_of(one, recorded) for one in each) for each in (trials, references)
    )
    if robot is not None:
        trials = tuple(_with_machine(one, robot) for one in trials)
    own = bool(machine) and model.suffix not in KIND_OF_SUFFIX
    kind = kind_of_file(machine) if own else kind_named(trials[0].header.kind)
    return Runs(tuple(trials), tuple(references), kind, robot, machine)


def _with_machine(trial: Trial, path: Path) -> Trial:
    """The trial with another machine's file."""
    if path.suffix in KIND_OF_SUFFIX:
        kind, text = KIND_OF_SUFFIX[path.suffix], read_machine(path)
    elif trial.header.kind == LEGGED:
        kind, text = LEGGED, robot_text(path)
    else:
        text = read_machine(path)
        kind = kind_of(machine_tables(text, path), path)
    header = replace(
        trial.header, kind=kind, robot_text=text, robot_file=path.name, folder=str(path.parent)
    )
    return replace(trial, header=header)


def _with_file_of(trial: Trial, header: TrialHeader | None) -> Trial:
    """The trial with the machine's file of another one where it names none."""
    if trial.header.robot_text or header is None:
        return trial
    own = replace(
        trial.header,
        robot_text=header.robot_text,
        robot_file=header.robot_file,
        folder=header.folder,
    )
    return replace(trial, header=own)


def with_effects(kind: MachineKind, effects: Path | None) -> MachineKind:
    """Return a kind of machine with the effects of a user's file.

    Raises:
        GapError: It takes none, or the file cannot be used.
    """
    if effects is None:
        return kind
    if kind.with_effects is None:
        raise GapError(
            f"--effects is for {_taking_effects()}; the trials are of kind {kind.name}: write the effect "
            "into a machine of your own (--machine FILE.py:make)"
        )
    return kind.with_effects(effects)


def _taking_effects() -> str:
    return ", ".join(name for name in machine_kinds() if kind_named(name).with_effects is not None)


def _recorded(trials: Sequence[Trial]) -> str:
    """The first robot file that is recorded with trials."""
    text = next((one.header.robot_text for one in trials if one.header.robot_text), "")
    if not text:
        raise GapError(NO_FILE)
    return text


def read_runs(
    trials: Sequence[Path],
    references: Sequence[Path] = (),
    robot: Path | None = None,
    joints: Sequence[str] = (),
    machine: str = "",
) -> Runs:
    """Read trials with their references; see ``read_trials`` and ``runs_of``.

    Raises:
        RecordError: A file cannot be read.
        GapError: They are of different machines, one recording is there twice, or joints cannot be taken
            apart.
    """
    everything = read_trials((*trials, *references), tuple(joints))
    runs = runs_of(everything[: len(trials)], everything[len(trials) :], robot, machine)
    return replace(runs, joints=tuple(joints))


def runs_of_diagnosis(of: DiagnosedRuns, robot: Path | None = None) -> Runs:
    """Read the runs of a diagnosis, with the same joints and the same held out.

    Args:
        of: Which they are.
        robot: Machine's file to use for the trials; None for the one of the diagnosis.

    Raises:
        GapError: They are not where they were.
        RecordError: A file cannot be read.
    """
    if not of.trials:
        raise GapError(
            f"the runs of {of.path} are not where they were, and they say what machine it is; put them "
            "back, or diagnose again"
        )
    runs = read_runs(of.trials, of.references, robot or of.robot, of.joints, of.machine)
    return replace(runs, hold_out=of.hold_out)


def read_trials(paths: Sequence[Path], joints: tuple[str, ...] = ()) -> tuple[Trial, ...]:
    """Read trials: .parquet, .csv, NAME.toml, or a log (.mcap).

    Of a bench of servos, only ``joints``, each of which is a machine of its own; all if there are none.

    Raises:
        RecordError: A file cannot be read.
        GapError: They are of different machines, one recording is there twice, or joints cannot be taken
            apart.
    """
    trials = tuple(_read(path) for path in paths)
    if joints:
        if trials[0].header.kind == LEGGED:
            raise GapError("--joint is for benches of servos; these runs are of a legged robot")
        trials = tuple(trial.only(joints) for trial in trials)
    check_runs(trials, paths)
    return trials


def check_runs(trials: Sequence[Trial], names: Sequence[object]) -> None:
    """Make sure that trials are of one machine, and each there once; ``names`` are for the error.

    Raises:
        GapError: They are not.
    """
    for name, trial in zip(names, trials, strict=True):
        first = trials[0].header
        if (trial.header.kind, trial.header.joints) != (first.kind, first.joints):
            raise GapError(
                f"{name} is of another machine than {names[0]}: {trial.header.kind} with "
                f"{', '.join(trial.header.joints) or 'no joints'}; diagnose one machine at a time"
            )
    check_each_once(trials, names)


def _read(path: Path) -> Trial:
    if path.suffix not in RUN_SUFFIXES:
        kinds = ", ".join(RUN_SUFFIXES)
        raise RecordError(f"{path} is no run: runs end in {kinds}")
    if path.suffix != ".mcap":
        return read_trial(path)
    with TemporaryDirectory() as folder:
        out = Path(folder) / "trial.parquet"
        export_trial(path, out, LogContents())
        return read_trial(out)


def simulator_for(trials: Sequence[Trial], effects: Path | None = None) -> Simulator:
    """Return the simulator of the machine that trials name.

    Args:
        trials: Trials of one kind of machine, each with its machine's file.
        effects: A file of users' effects.

    Raises:
        GapError: The machine's file or the file of effects cannot be used.
    """
    return runs_of(trials).simulator(effects)
