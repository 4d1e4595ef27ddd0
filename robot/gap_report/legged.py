"""The legged robot as a kind of machine: its robot files, users' effects, and the runs it can make."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from gaits.catalog import make_gaits
from gaits.limits import frequency_limit
from gap.effect_file import UserEffect, read_effects
from gap.interfaces import Proposal, Simulator
from gap.machine_kinds import MachineKind
from gap.machines.legged.runs import LeggedProposer
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.catalogue import EFFECTS, STAGES
from model.effects.machine import parse_machine
from model.errors import ConfigError, GapError
from model.parameters.tables import parse_table
from model.values.parameters import ChainParameters
from record.chain_file import complete
from record.toml_file import reading
from record.trial.trial import Trial
from robot.config.gait_file import with_gait
from robot.config.robot_file import load_robot, parse_robot
from robot.console.shipped import ROBOT_FILE_PAGE

NO_FILE = (
    'the runs name no robot file; add robot = "FILE.toml" to [trial] in the file beside the table'
)
NO_GAITS = "gaits and servo limits are those of config/bigant.toml: the runs' robot file has none"


def make_legged(trials: Sequence[Trial], added: tuple[UserEffect, ...] = ()) -> Simulator:
    """Return the chain of the robot that trials name, with effects of a user's own.

    Raises:
        GapError: They name no robot file, or it cannot be used.
    """
    if not trials[0].header.robot_text:
        raise GapError(NO_FILE)
    return LeggedSimulator(parse_machine(trials[0].header.robot_text), added)


def propose_walks(trials: Sequence[Trial]) -> Sequence[Proposal]:
    """Return the walks that the robot of trials can make; see ``proposer_of``."""
    return proposer_of(trials[0].header.robot_text, None)[0].proposals()


def _with_effects(path: Path) -> MachineKind:
    return replace(LEGGED_ROBOT, make=partial(make_legged, added=users_effects(path)))


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
    with reading(path, "the robot file", ROBOT_FILE_PAGE) as own:
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


LEGGED_ROBOT = MachineKind(make_legged, propose=propose_walks, with_effects=_with_effects)
