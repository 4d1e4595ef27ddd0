"""Causes with their values in a JSON file: baseline model errors that are kept for other diagnoses."""

from collections.abc import Sequence
from pathlib import Path

from gap.interfaces import Cause
from record.json_text import read_json
from record.whole_file import write_text
from robot.console.json_output import json_text


def read_causes(path: Path) -> tuple[Cause, ...]:
    """Read causes.

    Raises:
        OSError: The file cannot be read.
        ValueError: It holds something else.
    """
    try:
        return tuple(
            Cause(str(one["effect"]), tuple(one["joints"]), tuple(map(float, one["values"])))
            for one in read_json(path)
        )
    except (KeyError, TypeError) as error:
        raise ValueError(f"no causes ({error!r})") from error


def write_causes(causes: Sequence[Cause], path: Path) -> None:
    """Write causes into a file that appears when it is whole.

    Raises:
        RecordError: It cannot be written.
    """
    write_text(path, json_text(list(causes), 1) + "\n")
