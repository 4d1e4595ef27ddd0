"""A trial's header as a map writes it: some of it comes from each run's name, or from arrays of its log.

[trial]
robot = "arm_{p_gain}.toml"                   # what {p_gain} is comes from the name
[conditions]
from_name = "kp{p_gain}_{trajectory}"         # kp100_sin_sin.parquet: p_gain 100, trajectory "sin_sin"
floor = "carpet"                              # of all runs
[constants]
kp = { from = "p_gain", scale = 0.0058 }      # a condition, or an array of a .npz with one number a joint
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from model.errors import ConfigError
from model.parameters.toml_table import Table, as_table
from model.values.arrays import FloatArray
from record.trial.header import Condition, TrialHeader
from record.trial.header_file import errors_of, parse_header

FROM_NAME = "from_name"
TABLES = ("trial", "noise", "conditions", "constants", "drive")
_FIELD = re.compile(r"\{(\w+)\}")
Arrays = Mapping[str, FloatArray]


@dataclass(frozen=True, slots=True)
class HeaderForm:
    """What a map says of the headers of its runs.

    Attributes:
        data: Its tables of ``TABLES``, parsed.
        path: The map.
        columns: Our columns that it names.
    """

    data: Mapping[str, Any]
    path: Path
    columns: tuple[str, ...]

    def header_of(self, name: str, arrays: Arrays) -> TrialHeader:
        """Return the header of one run.

        Args:
            name: The run's file without its suffix.
            arrays: What its file has besides samples, by name.

        Raises:
            RecordError: The name is not of the form, or what a constant comes from is not there.
        """
        with errors_of(self.path):
            conditions = dict(self._table("conditions"))
            words = _named(conditions.pop(FROM_NAME, ""), name)
            conditions = {key: _value(text) for key, text in words.items()} | conditions
            trial = dict(self._table("trial"))
            if isinstance(trial.get("robot"), str):
                trial["robot"] = _FIELD.sub(
                    lambda field: words.get(field[1], field[0]), trial["robot"]
                )
            constants = {
                key: _constant(one, f"constants.{key}", conditions, arrays)
                for key, one in self._table("constants").items()
            }
        own = {"trial": trial, "conditions": conditions, "constants": constants}
        return parse_header({**self.data, **own}, self.path, self.columns)

    @property
    def of_each_run(self) -> bool:
        """Whether the runs' headers differ by more than their machine's file can say."""
        sources = any(isinstance(one, Mapping) for one in self._table("constants").values())
        return sources or FROM_NAME in self._table("conditions")

    def from_arrays(self, arrays: Arrays) -> tuple[str, ...]:
        """Return the constants that come from arrays of a log, in the order of the array."""
        sources = self._table("constants").items()
        return tuple(
            key for key, one in sources if isinstance(one, Mapping) and one.get("from") in arrays
        )

    def _table(self, name: str) -> Mapping[str, Any]:
        value = self.data.get(name, {})
        as_table(value, name)
        own: Mapping[str, Any] = value
        return own


def _named(form: object, name: str) -> dict[str, str]:
    """Return the part of a name for each field of a form."""
    if not isinstance(form, str):
        raise ConfigError(f"conditions.{FROM_NAME}", f"must be a text, not {form!r}")
    if not form:
        return {}
    parts = _FIELD.split(form)  # text, field, text, field, ..., text
    fields = parts[1::2]
    if not fields or len(set(fields)) != len(fields):
        raise ConfigError(
            f"conditions.{FROM_NAME}", f'{form!r} needs names in braces, each once: "run_{{speed}}"'
        )
    # a field takes as little as it can, the last one all the rest
    pattern = "".join(
        re.escape(part) if at % 2 == 0 else f"(?P<{part}>.+?)" for at, part in enumerate(parts)
    )
    match = re.fullmatch(pattern, name)
    if match is None:
        raise ConfigError(
            f"conditions.{FROM_NAME}",
            f"{name!r} is not of the form {form!r}; rename the file, or leave from_name out",
        )
    return match.groupdict()


def _value(text: str) -> Condition:
    try:
        return float(text)
    except ValueError:
        return text


def _constant(
    given: object, name: str, conditions: Mapping[str, Condition], arrays: Arrays
) -> object:
    """A constant as the header has it: a number or a list."""
    if not isinstance(given, Mapping):
        return given
    table = Table(given, name)
    source, scale = table.text("from"), table.number("scale", otherwise=1.0)
    table.done()
    if source in arrays:
        return [scale * float(one) for one in arrays[source]]
    value = conditions.get(source)
    if value is None:
        known = ", ".join((*conditions, *arrays)) or "none"
        raise ConfigError(
            f"{name}.from", f"{source!r} is no condition and no array; there are {known}"
        )
    if isinstance(value, str):
        raise ConfigError(
            f"{name}.from", f"the condition {source} is {value!r}, which is no number"
        )
    return scale * value
