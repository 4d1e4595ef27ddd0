"""``--json [FILE]`` of the commands of the gap: alone it prints, with FILE it writes."""

import argparse
import json
from pathlib import Path

from model.errors import ConfigError, RecordError

STDOUT = Path("-")
FIRST_BYTES = 64


def add_json(parser: argparse.ArgumentParser, what: str) -> None:
    """Add the argument.

    Args:
        parser: Of the command.
        what: What is written, as in "the diagnosis".
    """
    parser.add_argument(
        "--json", type=Path, nargs="?", const=STDOUT, metavar="FILE",
        help=f"{what} as JSON into FILE; without FILE (or with -) printed, and nothing else",
    )  # fmt: skip


def to_stdout(path: Path | None) -> bool:
    """Whether JSON is all that is printed."""
    return path == STDOUT


def check_json(path: Path | None) -> None:
    """See to it that no run is overwritten that stands behind ``--json`` by mistake.

    Raises:
        ConfigError: The file is there, and is no JSON.
    """
    if path is None or to_stdout(path) or not path.is_file() or _is_json(path):
        return
    raise ConfigError(
        "--json",
        f"{path} is there and is no JSON; name another file, or put --json behind the runs",
    )


def _is_json(path: Path) -> bool:
    try:
        with path.open("rb") as file:
            first = file.read(FIRST_BYTES).lstrip()
        if first[:1] not in {b"{", b"["}:
            return not first
        json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return True


def give_json(told: object, path: Path, indent: int) -> None:
    """Print it, or write it.

    Raises:
        RecordError: It cannot be written.
    """
    text = json.dumps(told, indent=indent)
    if to_stdout(path):
        print(text)
        return
    try:
        path.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise RecordError(f"{path} cannot be written: {error.strerror}; choose another") from error
