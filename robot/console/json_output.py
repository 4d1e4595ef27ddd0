"""``--json``: values as JSON can hold them, printed or written."""

import dataclasses
import json
import math
from collections.abc import Iterable
from pathlib import Path

from model.errors import ConfigError
from record.json_text import read_json
from record.whole_file import check_room, write_text
from robot.console.arguments import STDOUT

FIRST_BYTES = 64


def plain(value: object) -> object:
    """Return a value for ``json.dumps``: fields of dataclasses by name, arrays as lists, NaN as null."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {one.name: plain(getattr(value, one.name)) for one in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if hasattr(value, "tolist"):  # of numpy: an array, or one number
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return str(value) if isinstance(value, Path) else value


def json_text(value: object, indent: int | None = 2) -> str:
    """Return a value as JSON; what is not known is null."""
    return json.dumps(plain(value), indent=indent, allow_nan=False)


def print_json(value: object, indent: int | None = 2) -> None:
    """Print a value as JSON."""
    print(json_text(value, indent))


def print_result(value: object, lines: Iterable[str], *, as_json: bool) -> None:
    """Print a result: as JSON for a program, or as lines for a person."""
    print(json_text(value) if as_json else "\n".join(lines))


def to_stdout(path: Path | None) -> bool:
    """Whether JSON is all that is printed."""
    return path == STDOUT


def check_json(path: Path | None) -> None:
    """Ensure that ``--json`` names a file that can be written, and not a run by mistake.

    Raises:
        ConfigError: The file is there, and is no JSON.
        RecordError: It cannot be written.
    """
    if path is None or to_stdout(path):
        return
    if path.is_file() and not _is_json(path):
        raise ConfigError(
            "--json",
            f"{path} is there and is no JSON; name another file, or put --json behind the runs",
        )
    check_room(path, "--json")


def _is_json(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            first = file.read(FIRST_BYTES).lstrip()
        if first[:1] not in {b"{", b"["}:
            return not first
        read_json(path)
    except (OSError, ValueError):
        return False
    return True


def give_json(value: object, path: Path | None, indent: int = 2) -> None:
    """Print or write a value as ``--json [FILE]`` asked for; nothing without it.

    Raises:
        RecordError: It cannot be written.
    """
    if to_stdout(path):
        print_json(value, indent)
    elif path is not None:
        write_text(path, json_text(value, indent) + "\n", "--json")
