"""TOML files: read with their name in every error message, written with tomlkit's quoting and numbers."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from model.errors import ConfigError
from record.input_file import read_utf8


@contextmanager
def reading(path: Path, what: str, page: str = "") -> Iterator[str]:
    """Yield the text of a file; a mistake that the block finds in it is named with the file.

    Args:
        path: The file.
        what: What it is, as in "the robot file".
        page: Page of docs/ that describes such files; a mistake in a file that it names keeps its own.

    Raises:
        ConfigError: It cannot be read, or the block refuses what it says.
    """
    try:
        text = read_utf8(path).replace("\r\n", "\n")
    except OSError as error:
        raise ConfigError(str(path), f"{what} cannot be read: {error.strerror}", page) from error
    try:
        yield text
    except ConfigError as error:
        raise ConfigError(f"{path}: {error.key}", error.reason, error.page or page) from error


def toml_text(table: Mapping[str, Any], head: Sequence[str] = ()) -> str:
    """Return a table as TOML.

    Args:
        table: Keys and values: text, numbers, lists, tables, lists of tables. A list of lists is written
            one row a line. A key whose value is None is left out.
        head: Comment lines above it, each without its ``#``.
    """
    import tomlkit  # which most commands, all of which read TOML, never need

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
        import tomlkit

        rows = tomlkit.array().multiline(multiline=True)
        rows.extend(map(list, value))
        return rows
    return [_known(one) for one in value]
