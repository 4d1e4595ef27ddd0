"""A TOML table read strictly: each key is taken once and checked, and none may be left over."""

import difflib
import math
import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from model.errors import ConfigError
from model.values.arrays import FloatArray, IntArray, readonly
from model.values.machine_names import PART_NAME

DEEPEST = 50  # tables in tables; a robot file has three


def parse_toml(text: str, what: str) -> dict[str, Any]:
    """Parse TOML: every text of ours is read here.

    Args:
        text: The text.
        what: What it is, for the message.

    Raises:
        ConfigError: It is no TOML, or none that a person would write.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(what, f"is not valid TOML: {error}") from error
    except RecursionError as error:
        raise ConfigError(what, "is not valid TOML: lists nested too deep") from error
    except ValueError as error:  # Python takes no integer of more than 4300 digits
        raise ConfigError(what, "is not valid TOML: an integer of too many digits") from error
    level: list[Any] = [data]
    for _ in range(DEEPEST):
        level = [inner for one in level for inner in _nested(one)]
        if not level:
            return data
    raise ConfigError(what, "is not valid TOML: tables nested too deep")


def _nested(value: Any) -> list[Any]:
    """Return the tables and lists directly in one."""
    inner = value.values() if isinstance(value, dict) else value
    return [one for one in inner if isinstance(one, dict | list)]


class Table:
    """One table of a robot file.

    Args:
        data: The parsed table.
        path: Dotted name of the table, empty for the top level; it prefixes the key in messages.
    """

    def __init__(self, data: Mapping[str, Any], path: str = "") -> None:
        self._data = data
        self._path = path
        self._taken: set[str] = set()
        self._inner: dict[str, Table] = {}

    def name(self, key: str) -> str:
        """Return the dotted name of a key of this table."""
        return f"{self._path}.{key}" if self._path else key

    def _take(self, key: str, otherwise: Any = None) -> Any:
        self._taken.add(key)
        if key in self._data:
            return self._data[key]
        if otherwise is None:
            raise ConfigError(self.name(key), f"is missing{self._near(key)}")
        return otherwise

    def _near(self, key: str) -> str:
        """Say what to do: there may be a key that is nearly this one."""
        near = difflib.get_close_matches(
            key, sorted(self._data.keys() - self._taken), n=1, cutoff=0.8
        )
        return f"; is {near[0]!r} meant to be it?" if near else "; add it"

    def flag(self, key: str, *, otherwise: bool | None = None) -> bool:
        """Return true or false; ``otherwise``, if it is given, where the key is left out."""
        value = self._take(key, otherwise)
        if not isinstance(value, bool):
            raise ConfigError(self.name(key), f"must be true or false, not {value!r}")
        return value

    def raw(self, key: str) -> Any:
        """Return a value of any kind, for the caller to check."""
        return self._take(key)

    def maybe_text(self, key: str) -> str:
        """Return a string, an empty one where the key is left out."""
        value = self._take(key, "")
        if not isinstance(value, str):
            raise ConfigError(self.name(key), f"must be a text, not {value!r}")
        return value

    def maybe_number(self, key: str) -> float:
        """Return a number, infinite ones too, or NaN where the key is left out."""
        return _real(self._take(key, math.nan), self.name(key))

    def names(self) -> tuple[str, ...]:
        """Return the keys that are there, in their order."""
        return tuple(self._data)

    def has(self, key: str) -> bool:
        """Whether a key that may be left out is there."""
        self._taken.add(key)
        return key in self._data

    def maybe_table(self, key: str) -> "Table":
        """Return a sub-table, or an empty one where the key is left out."""
        return self._as_inner(self._take(key, {}), self.name(key))

    def table(self, key: str) -> "Table":
        """Return a sub-table."""
        return self._as_inner(self._take(key), self.name(key))

    def tables(self, key: str) -> "list[Table]":
        """Return a list of tables, an empty one where the key is left out."""
        value = self._take(key, [])
        if not isinstance(value, list):
            raise ConfigError(self.name(key), f"must be a list of tables, not {value!r}")
        return [self._as_inner(one, f"{self.name(key)}[{i}]") for i, one in enumerate(value)]

    def _as_inner(self, value: Any, name: str) -> "Table":
        return self._inner.setdefault(name, as_table(value, name))

    def text(self, key: str) -> str:
        """Return a non-empty string."""
        value = self._take(key)
        if not isinstance(value, str) or not value:
            raise ConfigError(self.name(key), f"must be a non-empty text, not {value!r}")
        return value

    def word(self, key: str, known: Sequence[str]) -> str:
        """Return a string that is one of those known."""
        value = self.text(key)
        if value not in known:
            raise ConfigError(self.name(key), f"must be one of {', '.join(known)}, not {value!r}")
        return value

    def texts(self, key: str) -> tuple[str, ...]:
        """Return a list of distinct, non-empty strings."""
        value = self._take(key)
        if not isinstance(value, list) or not all(isinstance(v, str) and v for v in value):
            raise ConfigError(self.name(key), f"must be a list of texts, not {value!r}")
        if len(set(value)) != len(value):
            raise ConfigError(self.name(key), f"names must differ from each other: {value!r}")
        return tuple(value)

    def part_names(self, key: str) -> tuple[str, ...]:
        """Return a list of names of legs or joints, which stand in columns of tables and in topics too."""
        names = self.texts(key)
        for name in names:
            if not PART_NAME.fullmatch(name):
                raise ConfigError(
                    self.name(key),
                    f"{name!r} is no name of a leg or joint; use letters, digits and _",
                )
        return names

    def number(
        self,
        key: str,
        *,
        above: float = -math.inf,
        below: float = math.inf,
        minimum: float = -math.inf,
        maximum: float = math.inf,
        otherwise: float | None = None,
    ) -> float:
        """Return one finite number inside the bounds given (``above`` and ``below`` excluded).

        Where the key is left out: ``otherwise``, if it is given.
        """
        if otherwise is not None and not self.has(key):
            return otherwise
        value = _finite(self._take(key), self.name(key))
        if not (value > above and value >= minimum):
            bound = f"above {above:g}" if value <= above else f"at least {minimum:g}"
            raise ConfigError(self.name(key), f"must be {bound}, not {value:g}")
        if not (value < below and value <= maximum):
            bound = f"below {below:g}" if value >= below else f"at most {maximum:g}"
            raise ConfigError(self.name(key), f"must be {bound}, not {value:g}")
        return value

    def integer(self, key: str, *, minimum: int, maximum: int, otherwise: int | None = None) -> int:
        """Return one whole number in bounds; ``otherwise``, if it is given, where the key is left out."""
        if otherwise is not None and not self.has(key):
            return otherwise
        return _whole(self._take(key), self.name(key), minimum, maximum)

    def integers(self, key: str, count: int, *, minimum: int, maximum: int) -> IntArray:
        """Return ``count`` whole numbers, (count,) int64."""
        value = self._take(key)
        _check_length(value, count, self.name(key))
        return readonly(
            np.array(
                [_whole(v, f"{self.name(key)}[{i}]", minimum, maximum) for i, v in enumerate(value)]
            )
        )

    def numbers(self, key: str, shape: tuple[int, ...], *, above: float = -math.inf) -> FloatArray:
        """Return finite numbers of a fixed shape, each above ``above``."""
        value = self._take(key)
        flat = _flatten(value, shape, self.name(key))
        for index, item in flat:
            if not item > above:
                raise ConfigError(index, f"must be above {above:g}, not {item:g}")
        return readonly(np.array([item for _, item in flat], dtype=np.float64).reshape(shape))

    def done(self) -> None:
        """Refuse keys that nobody asked for, here and in the tables inside, with a suggestion."""
        for key in self._data:
            if key not in self._taken:
                near = difflib.get_close_matches(key, sorted(self._taken), n=1)
                hint = f"; did you mean {near[0]!r}?" if near else "; remove it"
                raise ConfigError(self.name(key), f"is not a known key{hint}")
        for inner in self._inner.values():
            inner.done()


def as_table(value: Any, name: str) -> Table:
    """Return a parsed value as a table.

    Raises:
        ConfigError: It is none.
    """
    if not isinstance(value, Mapping):
        raise ConfigError(name, f"must be a table, not {value!r}")
    return Table(value, name)


def _real(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ConfigError(name, f"must be a number, not {value!r}")
    try:
        return float(value)
    except OverflowError as error:  # TOML's integers have no end
        raise ConfigError(name, "must be a smaller number") from error


def _finite(value: Any, name: str) -> float:
    number = _real(value, name)
    if not math.isfinite(number):
        raise ConfigError(name, f"must be finite, not {value!r}")
    return number


def _whole(value: Any, name: str, minimum: int, maximum: int) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ConfigError(name, f"must be a whole number, not {value!r}")
    if not minimum <= value <= maximum:
        raise ConfigError(name, f"must be from {minimum} to {maximum}, not {value}")
    return value


def _check_length(value: Any, count: int, name: str) -> None:
    if not isinstance(value, list):
        raise ConfigError(name, f"must be a list of {count}, not {value!r}")
    if len(value) != count:
        raise ConfigError(name, f"must have {count} entries, one a leg or axis, not {len(value)}")


def _flatten(value: Any, shape: tuple[int, ...], name: str) -> list[tuple[str, float]]:
    if not shape:
        return [(name, _finite(value, name))]
    _check_length(value, shape[0], name)
    return [
        pair for i, item in enumerate(value) for pair in _flatten(item, shape[1:], f"{name}[{i}]")
    ]
