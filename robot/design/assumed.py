"""Keys of a robot file whose comments say that their values are assumed."""

import re
from typing import Any

ASSUMED = re.compile(r"\b(assumed|made up|guessed|estimated)\b", re.IGNORECASE)


def assumed_keys(text: str) -> tuple[str, ...]:
    """Return the dotted names of keys that are marked as assumed, in the file's order.

    A mark stands in a comment behind the value, in the comment lines right above the key, or behind the
    name of a table, which then holds for all of it and is given as ``table.*``.

    Args:
        text: A robot file that parses.
    """
    import tomlkit  # slow to import, and needed only here

    keys: list[str] = []
    _collect(tomlkit.parse(text), "", keys)
    return tuple(keys)


def _collect(table: Any, path: str, keys: list[str]) -> None:
    from tomlkit.items import Comment, Table, Whitespace

    above = ""
    for key, item in table.body:
        if isinstance(item, Whitespace):
            above = ""
        elif isinstance(item, Comment):
            above += item.trivia.comment
        elif key is not None:
            name = f"{path}{key.key}"
            mark = f"{above} {item.trivia.comment}"
            if ASSUMED.search(mark):
                keys.append(f"{name}.*" if isinstance(item, Table) else name)
            elif isinstance(item, Table):
                _collect(item.value, f"{name}.", keys)
            above = ""
