"""The robot file of a reality: the lab's own file with the reality's numbers in it."""

from collections.abc import Mapping
from typing import Any

import tomlkit

from model.errors import ConfigError
from robot.config.robot_file import RobotConfig, parse_robot
from sim_hw.realities.reality import Numbers, Reality, Times

DIGITS = 9


def robot_in(reality: Reality, config: RobotConfig) -> RobotConfig:
    """Return the robot that a lab of this reality has, its file rewritten; the same one if it is no other.

    Raises:
        ConfigError: The robot file lacks a key that the reality changes, or cannot be used with it.
    """
    if not reality.robot:
        return config
    document = tomlkit.parse(config.text)
    for key, numbers in reality.robot:
        _change(document, key, numbers, reality.name)
    document["name"] = f"{config.name} ({reality.name})"
    return parse_robot(tomlkit.dumps(document))


def _change(document: Mapping[str, Any], key: str, numbers: Numbers, name: str) -> None:
    table, _, last = key.partition(".")
    owner = document.get(table, {})
    if last not in owner:
        raise ConfigError(
            key, f"is not in the robot file; the reality {name} is of robots that have it"
        )
    new = _scaled(owner[last], numbers.factor) if isinstance(numbers, Times) else _plain(numbers)
    if isinstance(new, list) and len(new) != len(owner[last]):
        raise ConfigError(
            key, f"has {len(owner[last])} entries; the reality {name} is of robots with {len(new)}"
        )
    owner[last] = new


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, list):
        return [_scaled(one, factor) for one in value]
    return round(float(value) * factor, DIGITS)


def _plain(numbers: Any) -> Any:
    return [_plain(one) for one in numbers] if isinstance(numbers, tuple) else numbers
