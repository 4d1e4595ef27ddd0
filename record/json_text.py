"""JSON that we read, from files and out of logs: whatever is in it, a mistake is a ``ValueError``.

The standard library has three more ways to fail on a text that somebody damaged: lists nested too deep to
be read, or to be worked on after they were read, and half of a surrogate pair, which cannot be printed.
"""

import json
from pathlib import Path
from typing import Any

from record.input_file import read_utf8

DEEPEST = 50  # lists and tables in each other; a diagnosis has six


def parse_json(text: str) -> Any:
    """Parse JSON: every text of ours is read here.

    Raises:
        ValueError: It is no JSON, or none that a program would write.
    """
    try:
        data = json.loads(text)
    except RecursionError as error:
        raise ValueError("lists nested too deep") from error
    level = [data]
    for _ in range(DEEPEST):
        for one in level:
            _check_text(one)
        level = [inner for one in level for inner in _inside(one)]
        if not level:
            return data
    raise ValueError("lists nested too deep")


def read_json(path: Path) -> Any:
    """Read a file of JSON.

    Raises:
        OSError: It cannot be read, or is no text.
        ValueError: It is no JSON.
    """
    return parse_json(read_utf8(path))


def _inside(value: Any) -> list[Any]:
    if isinstance(value, dict):
        return [*value, *value.values()]
    return value if isinstance(value, list) else []


def _check_text(value: Any) -> None:
    if not isinstance(value, str):
        return
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise ValueError("half of a surrogate pair in a text") from error
