"""``--gait NAME|FILE.py``: a gait of the robot file, or one that a Python file gives.

The file is run as Python: name only files that you trust. What it must have is in ``gaits.plugin``.
"""

from dataclasses import replace
from pathlib import Path

from gaits.catalog import default_gait, gait_names, make_gait
from model.errors import ConfigError
from model.values.parameters import PluginParameters
from record.toml_file import reading
from robot.config.gaits import GAIT_NAME
from robot.config.robot_file import RobotConfig

SUFFIX = ".py"


def with_gait(config: RobotConfig, named: str | None) -> tuple[RobotConfig, str]:
    """Return a robot that has a gait, and the gait's name.

    Args:
        config: Robot file.
        named: Name of one of its gaits, or a Python file to add; None for the robot's first gait.

    Raises:
        ConfigError: There is no such gait, or the file gives none.
    """
    if named is None:
        return config, default_gait(config.parameters)
    if not named.endswith(SUFFIX):
        make_gait(named, config.parameters)
        return config, named
    plugin = read_gait_file(Path(named))
    return with_plugin(config, plugin), plugin.name


def with_plugin(config: RobotConfig, plugin: PluginParameters) -> RobotConfig:
    """Return a robot that has the gait of a Python file as well, after its own.

    Raises:
        ConfigError: It has another of that name, or the file gives no gait.
    """
    robot = config.parameters
    if plugin in robot.gaits:
        return config
    if plugin.name in gait_names(robot):
        raise ConfigError(
            plugin.file, f"the robot has a gait {plugin.name!r} already; rename the file"
        )
    more = replace(robot, gaits=(*robot.gaits, plugin))
    make_gait(plugin.name, more)  # refuses what is no gait
    return replace(config, parameters=more)


def read_gait_file(path: Path) -> PluginParameters:
    """Read a gait file; its gait is named like it. Nothing is run.

    Raises:
        ConfigError: It cannot be read, or its name is none of a gait.
    """
    if not GAIT_NAME.fullmatch(path.stem):
        raise ConfigError(
            str(path), "must be named by letters, digits, _ and -, as its gait is named like it"
        )
    with reading(path, "the gait file") as text:
        return PluginParameters(path.stem, str(path), text)
