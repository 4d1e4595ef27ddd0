"""The runs that a robot file's robot can make, for ``gap.experiments.next_run``."""

from pathlib import Path

from gaits.catalog import make_gait
from gaits.limits import frequency_limit
from gaits.names import GAIT_NAMES
from gap.machines.legged.runs import LeggedProposer
from model.effects.machine import parse_machine
from model.errors import ConfigError, GapError
from robot.config.robot_file import RobotConfig, load_robot, parse_robot

NOTE = "gaits and servo limits are those of config/bigant.toml: the runs' robot file has none to drive by"


def proposer_of(text: str, file: Path | None) -> tuple[LeggedProposer, str]:
    """Return the runs of a robot, and a note in words if something had to be assumed.

    Args:
        text: Its robot file.
        file: Where that is, for command lines; None for the default one.

    Raises:
        GapError: The file has other legs than the gaits that must stand in for its own.
    """
    machine = parse_machine(text)
    config, note = _config(text)
    own = config.parameters
    if own.legs.names != machine.legs.names:
        raise GapError(
            f"the robot file of the runs has no gaits, and those of {', '.join(own.legs.names)} do not "
            "fit its legs; add [gait] and [servo] to it"
        )
    gaits = {name: make_gait(name, own) for name in GAIT_NAMES}
    proposer = LeggedProposer(
        legs=machine.legs.names,
        gaits=gaits,
        limits_hz={name: frequency_limit(gait, own.servo) for name, gait in gaits.items()},
        mass_kg=machine.mass_kg,
        robot_text=text,
        robot_option="" if file is None else f" --robot {file}",
    )
    return proposer, note


def _config(text: str) -> tuple[RobotConfig, str]:
    try:
        return parse_robot(text), ""
    except ConfigError:
        return load_robot(), NOTE
