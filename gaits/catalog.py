"""Which gaits a robot has."""

from difflib import get_close_matches

from gaits.buehler import BuehlerClock
from gaits.cubic import CubicClock
from gaits.gait import Gait
from gaits.plugin import PluginGait
from model.errors import ConfigError
from model.values.parameters import BuehlerParameters, PluginParameters, RobotParameters


def gait_names(robot: RobotParameters) -> tuple[str, ...]:
    """Return the names of a robot's gaits, in the order of its file."""
    return tuple(gait.name for gait in robot.gaits)


def make_gait(name: str, robot: RobotParameters) -> Gait:
    """Build a gait by name.

    Raises:
        ConfigError: The robot has no such gait, or its parameters make none.
    """
    for gait in robot.gaits:
        if gait.name == name:
            if isinstance(gait, PluginParameters):
                return PluginGait(gait, robot.legs)
            if isinstance(gait, BuehlerParameters):
                return BuehlerClock(gait, robot.legs)
            return CubicClock(gait, robot.legs)
    raise no_such_gait(name, gait_names(robot))


def make_gaits(robot: RobotParameters) -> tuple[Gait, ...]:
    """Build all gaits of a robot, in the order of its file.

    Raises:
        ConfigError: The parameters of one make none.
    """
    return tuple(make_gait(name, robot) for name in gait_names(robot))


def no_such_gait(name: str, names: tuple[str, ...]) -> ConfigError:
    """Return the error for a gait that a robot does not have."""
    if not names:
        return ConfigError("gait", f"{name!r}: the robot file has no gait; add a table [gait.NAME]")
    near = get_close_matches(name, names, n=1)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    return ConfigError(
        "gait", f"{name!r} is no gait of this robot, which has {', '.join(names)}{hint}"
    )


def default_gait(robot: RobotParameters) -> str:
    """Return the gait that a robot walks unless another is named: the first of its file.

    Raises:
        ConfigError: It has none.
    """
    if not robot.gaits:
        raise ConfigError("gait", "the robot file has no gait; add a table [gait.NAME]")
    return robot.gaits[0].name
