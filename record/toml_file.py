"""TOML that we write, in one place: quoting and the spelling of numbers are tomlkit's."""

from collections.abc import Mapping, Sequence
from typing import Any

import tomlkit


def toml_text(table: Mapping[str, Any], head: Sequence[str] = ()) -> str:
    """Return a table as TOML.

    Args:
        table: Keys and values: text, numbers, lists, tables, lists of tables. A list of lists is written
            one row a line. A key whose value is None is left out.
        head: Comment lines above it, each without its ``#``.
    """
    document = tomlkit.document()
    for line in head:
        document.add(tomlkit.comment(line))
    for key, value in _known(table).items():
        document.add(key, tomlkit.item(value))
    return tomlkit.dumps(document)


def _known(value: Any) -> Any:  # anything that TOML can hold
    """Leave out what is None, in nested tables too."""
    if isinstance(value, Mapping):
        return {key: _known(one) for key, one in value.items() if one is not None}
    if not isinstance(value, list | tuple):
        return value
    if value and all(isinstance(row, list | tuple) for row in value):
        rows = tomlkit.array().multiline(multiline=True)
        rows.extend(map(list, value))
        return rows
    return [_known(one) for one in value]
