"""The nominal robot file with some values changed, by their dotted names."""

from pathlib import Path
from typing import Any

import tomlkit

from robot.config.robot_file import RobotConfig, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE

NOMINAL = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
OCTOPOD = Path("examples/octopod.toml")


def text_with(changes: dict[str, Any], text: str = NOMINAL) -> str:
    """A robot file's text with values replaced; a function is called with the old value."""
    document: Any = tomlkit.parse(text)
    for name, value in changes.items():
        *tables, key = name.split(".")
        table = document
        for one in tables:
            table = table[one]
        old = table[key].unwrap()
        table[key] = value(old) if callable(value) else value
    return tomlkit.dumps(document)


def robot_with(changes: dict[str, Any], text: str = NOMINAL) -> RobotConfig:
    """The robot of ``text_with``."""
    return parse_robot(text_with(changes, text))
