"""A TOML table read into a frozen dataclass: types and bounds come from its fields, no key is left over."""

import dataclasses
import difflib
import math
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar, get_type_hints

from model.errors import ConfigError

T = TypeVar("T")


def within(default: Any, low: float, high: float, text: str) -> Any:
    """A number (or list of numbers) with bounds, both included, and what it means."""
    return dataclasses.field(default=default, metadata={"low": low, "high": high, "text": text})


def needed(low: float, high: float, text: str) -> Any:
    """The same, of a number that the file must give."""
    return dataclasses.field(metadata={"low": low, "high": high, "text": text})


def among(*choices: str, text: str) -> Any:
    """A word out of some; the first is the default."""
    return dataclasses.field(default=choices[0], metadata={"choices": choices, "text": text})


def value(default: Any, text: str) -> Any:
    """True or false, or any text."""
    return dataclasses.field(default=default, metadata={"text": text})


def read_table(kind: type[T], table: Any, path: str, also: tuple[str, ...] = ()) -> T:
    """Return the dataclass that a table describes.

    Args:
        kind: The dataclass.
        table: The parsed table.
        path: Its dotted name, for messages.
        also: Keys that somebody else reads.

    Raises:
        ConfigError: A key is unknown, missing, of another type or out of bounds; it is named.
    """
    if not isinstance(table, Mapping):
        raise ConfigError(path, f"must be a table, not {table!r}")
    fields = {f.name: f for f in dataclasses.fields(kind)}  # type: ignore[arg-type]
    refuse_unknown(table, (*fields, *also), path)
    types = get_type_hints(kind)
    values: dict[str, Any] = {}
    for name, field in fields.items():
        where = f"{path}.{name}" if path else name
        if name in table:
            values[name] = _checked(table[name], types[name], field.metadata, where)
        elif field.default is dataclasses.MISSING:
            raise ConfigError(where, "is missing; add it to the scenario")
    return kind(**values)


def refuse_unknown(table: Mapping[str, Any], known: tuple[str, ...], path: str) -> None:
    """Raise for the first key that nobody reads, with a suggestion."""
    for key in table:
        if key not in known:
            name = f"{path}.{key}" if path else key
            raise ConfigError(name, f"is not a known key; {suggestion(key, known)}")


def suggestion(word: str, known: Sequence[str]) -> str:
    """Return the known word that was probably meant, or all of them."""
    near = difflib.get_close_matches(word, known, n=1)
    return f"did you mean {near[0]!r}?" if near else f"known are {', '.join(known)}"


def _checked(value: Any, kind: Any, bounds: Mapping[str, Any], where: str) -> Any:
    if kind is bool:
        if not isinstance(value, bool):
            raise ConfigError(where, f"must be true or false, not {value!r}")
        return value
    if kind is str:
        return _word(value, bounds, where)
    if kind == tuple[int, ...]:
        if not isinstance(value, list):
            raise ConfigError(where, f"must be a list of whole numbers, not {value!r}")
        return tuple(_number(v, int, bounds, f"{where}[{i}]") for i, v in enumerate(value))
    return _number(value, float if kind is float else int, bounds, where)


def _word(value: Any, bounds: Mapping[str, Any], where: str) -> str:
    choices = bounds.get("choices")
    if not isinstance(value, str):
        raise ConfigError(where, f"must be a text, not {value!r}")
    if choices is not None and value not in choices:
        raise ConfigError(where, f"must be one of {', '.join(choices)}, not {value!r}")
    if not value.isascii():
        raise ConfigError(where, f"must be plain ASCII, not {value!r}")
    return value


def _number(value: Any, kind: type, bounds: Mapping[str, Any], where: str) -> float | int:
    allowed = int | float if kind is float else int
    if isinstance(value, bool) or not isinstance(value, allowed):
        what = "a number" if kind is float else "a whole number"
        raise ConfigError(where, f"must be {what}, not {value!r}")
    if math.isnan(value) or not bounds["low"] <= value <= bounds["high"]:
        raise ConfigError(
            where, f"must be from {bounds['low']:g} to {bounds['high']:g}, not {value!r}"
        )
    return kind(value)  # type: ignore[no-any-return]
