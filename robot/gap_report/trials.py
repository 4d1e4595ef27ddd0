"""Trials for the diagnosis, from trial tables or logs, and the simulator that their machine calls for."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from gaits.catalog import make_gaits
from gaits.limits import frequency_limit
from gap.delegate import TwoMachines
from gap.effect_file import UserEffect, read_effects
from gap.interfaces import Simulator
from gap.machines.legged.runs import LeggedProposer
from gap.machines.legged.simulator import LeggedSimulator
from gap.machines.servo_bench.simulator import servo_bench
from gap.machines.sliding_body.simulator import sliding_body
from model.effects.catalogue import EFFECTS, STAGES
from model.effects.machine import parse_machine
from model.errors import ConfigError, GapError
from model.parameters.tables import parse_table
from model.values.parameters import ChainParameters
from record.chain_file import complete
from record.log.export import export_trial
from record.log.reader import LogContents
from record.toml_file import reading
from record.trial.header import LEGGED, SERVO_BENCH
from record.trial.trial import Trial, read_trial
from robot.config.gait_file import with_gait
from robot.config.robot_file import load_robot, parse_robot

NO_GAITS = "gaits and servo limits are those of config/bigant.toml: the runs' robot file has none"


@dataclass(frozen=True, slots=True)
class Runs:
    """Runs of one machine: trials to be diagnosed, and healthy references.

    ``robot`` replaces the robot file recorded with the trials. References are runs of the robot before it
    changed: they keep the file recorded with them, whatever that of the trials is.
    """

    trials: tuple[Trial, ...]
    references: tuple[Trial, ...]
    robot: Path | None = None

    @property
    def robot_text(self) -> str:
        """Robot file of the trials.

        Raises:
            ConfigError: ``robot`` cannot be used.
            GapError: There is none.
        """
        return _recorded(self.trials) if self.robot is None else robot_text(self.robot)

    def of_robot_files(self, make: Callable[[str], Simulator]) -> Simulator:
        """Return a simulator made of the trials' robot file, and of the references' own if it differs.

        References that name no robot file have the one recorded with the trials.

        Raises:
            ConfigError: ``robot`` cannot be used.
            GapError: There is no robot file, or the two have different legs.
        """
        text = self.robot_text
        own = make(text)
        if not self.references:
            return own
        before = _recorded((*self.references, *self.trials))
        return own if before == text else TwoMachines(own, make(before), self.references)

    def simulator(self, effects: Path | None = None) -> Simulator:
        """Return the simulator of their machine; see ``simulator_for``."""
        return simulator_for((*self.trials, *self.references), effects, self.robot, self.references)


def _recorded(trials: Sequence[Trial]) -> str:
    """The first robot file that is recorded with trials."""
    text = next((one.header.robot_text for one in trials if one.header.robot_text), "")
    if not text:
        raise GapError(
            'the runs name no robot file; add robot = "FILE.toml" to [trial] in the file beside the table'
        )
    return text


def read_runs(
    trials: Sequence[Path],
    references: Sequence[Path] = (),
    robot: Path | None = None,
    joints: Sequence[str] = (),
) -> Runs:
    """Read trials with their references; see ``read_trials``.

    Raises:
        RecordError: A file cannot be read.
        GapError: They are of different machines, or one whose joints cannot be taken apart.
    """
    everything = read_trials((*trials, *references), tuple(joints))
    return Runs(everything[: len(trials)], everything[len(trials) :], robot)


def read_trials(paths: Sequence[Path], joints: tuple[str, ...] = ()) -> tuple[Trial, ...]:
    """Read trials: .parquet, .csv, NAME.toml, or a log (.mcap).

    Of a bench of servos, only ``joints``, each of which is a machine of its own; all if there are none.

    Raises:
        RecordError: A file cannot be read.
        GapError: They are of different machines, or one whose joints cannot be taken apart.
    """
    trials = tuple(_read(path) for path in paths)
    if joints:
        if trials[0].header.kind != SERVO_BENCH:
            raise GapError(
                f"--joint is for a servo_bench; the trials are of kind {trials[0].header.kind}"
            )
        trials = tuple(trial.only(joints) for trial in trials)
    check_same_machine(trials, paths)
    return trials


def check_same_machine(trials: Sequence[Trial], names: Sequence[object]) -> None:
    """Make sure that trials are of one machine; ``names`` is what they are called in the error.

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


def _read(path: Path) -> Trial:
    if path.suffix != ".mcap":
        return read_trial(path)
    with TemporaryDirectory() as folder:
        out = Path(folder) / "trial.parquet"
        export_trial(path, out, LogContents())
        return read_trial(out)


def simulator_for(
    trials: Sequence[Trial],
    effects: Path | None,
    robot: Path | None = None,
    references: Sequence[Trial] = (),
) -> Simulator:
    """Return the simulator of the machine that the trials name.

    Args:
        trials: Trials of one machine, the references among them.
        effects: A file of users' effects; only the legged simulator takes one.
        robot: Robot file to use for the trials instead of the one recorded with them.
        references: Those of the trials that keep the robot file recorded with them.

    Raises:
        GapError: The machine's file or the file of effects cannot be used.
    """
    kind = trials[0].header.kind
    if kind == LEGGED:
        added = users_effects(effects)
        runs = Runs(tuple(trials), tuple(references), robot)
        return runs.of_robot_files(lambda text: LeggedSimulator(parse_machine(text), added))
    for option, given in (("--effects", effects), ("--robot", robot)):
        if given is not None:
            raise GapError(f"{option} is for legged robots; the trials are of kind {kind}")
    if kind == SERVO_BENCH:
        return servo_bench(trials)
    return sliding_body(trials)


def users_effects(path: Path | None) -> tuple[UserEffect, ...]:
    """Read a file of users' effects for legged robots; none without a file.

    Raises:
        GapError: It cannot be used.
    """
    if path is None:
        return ()
    return read_effects(path, STAGES, tuple(EFFECTS))


def robot_text(path: Path) -> str:
    """Return the text of a robot file, which need not be complete enough to drive.

    Raises:
        ConfigError: It cannot be read; or it is a whole robot file, and something in it is wrong.
    """
    with reading(path, "the robot file") as own:
        text = complete(own, path.parent)
        try:
            if parse_table(text).has("servo"):
                parse_robot(text)  # a typing mistake must not pass for a default
            else:
                parse_machine(text)
        except GapError as error:
            raise ConfigError("machine", str(error)) from error
        return text


def proposer_of(
    text: str, file: Path | None, gait: str | None = None
) -> tuple[LeggedProposer, str]:
    """Return the runs that a robot can make by its file's text, and a note if something was assumed.

    Args:
        text: The robot file's text.
        file: What command lines name it; None stands for the default one.
        gait: A Python file with a gait that is to be proposed as well.

    Raises:
        ConfigError: The gait cannot be used.
        GapError: The robot is not driven, or has other legs than the gaits that must stand in for its own.
    """
    machine = parse_machine(text)
    if isinstance(machine.leg, ChainParameters):
        words = "are not driven from here, so that there is no run to propose"
        raise GapError(f"legs of several joints {words}; make one of your own and diagnose again")
    note = ""
    try:
        config = parse_robot(text)
    except ConfigError:
        config, note = load_robot(), NO_GAITS
    if not config.parameters.gaits:
        config, note = load_robot(), NO_GAITS
    own = config.parameters
    if own.legs.names != machine.legs.names:
        raise GapError(
            f"the robot file of the runs has no gaits, and those of {', '.join(own.legs.names)} do not "
            "fit its legs; add [gait] and [servo] to it"
        )
    names: dict[str, str] = {}
    if gait is not None:
        config, name = with_gait(config, gait)
        own, names = config.parameters, {name: gait}
    gaits = {one.name: one for one in make_gaits(own)}
    proposer = LeggedProposer(
        legs=machine.legs.names,
        gaits=gaits,
        limits_hz={name: frequency_limit(one, own.servo) for name, one in gaits.items()},
        mass_kg=machine.mass_kg,
        robot_text=text,
        robot_option="" if file is None else f" --robot {file}",
        gait_files=names,
    )
    return proposer, note
