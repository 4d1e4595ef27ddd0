"""Which column of somebody's table is which of ours, and in which unit: the TOML behind ``--columns``.

    [table]
    delimiter = ";"
    [columns]
    time_s = "Timestamp"                                  # as it is
    shaft_HL_rad = { from = "pos_1", unit = "deg", sign = -1, offset = 0.0 }
    force_HL_z_n = { from = "Fz1", scale = 0.00981 }
    [trial]                                               # as in NAME.toml, where there is none
    gait = "tripod"
    [noise]

A value becomes ``sign * scale * unit * theirs + offset``, the offset in our unit.
"""

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from model.errors import RecordError
from record.trial import trial_places
from record.trial_toml import TrialHeader, check_keys, parse_header, parse_toml, read_text

# What one of their units is in ours.
UNITS: Mapping[str, float] = MappingProxyType({
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0,
    "rad": 1.0, "deg": math.pi / 180, "turn": 2 * math.pi, "mx106_ticks": 2 * math.pi / 4096,
    "rad/s": 1.0, "deg/s": math.pi / 180, "rpm": 2 * math.pi / 60,
    "m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254,
    "N": 1.0, "kN": 1e3, "kgf": 9.80665, "lbf": 4.4482216152605,
    "Nm": 1.0, "Nmm": 1e-3, "A": 1.0, "mA": 1e-3, "V": 1.0, "mV": 1e-3, "C": 1.0,
    "1": 1.0, "%": 1e-2,
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class Source:
    """Where one of our columns comes from: ours = factor * theirs + offset.

    Attributes:
        ours: Our column.
        theirs: Theirs.
        factor: Sign, scale and unit together.
        offset: In our unit.
    """

    ours: str
    theirs: str
    factor: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class ColumnMap:
    """A column map, read.

    Attributes:
        sources: The columns it names.
        delimiter: Between fields of a CSV file.
        header: The trial's header as far as the map tells; None if it does not.
    """

    sources: tuple[Source, ...] = ()
    delimiter: str = ","
    header: TrialHeader | None = None


def read_column_map(path: Path) -> ColumnMap:
    """Read a column map.

    Raises:
        RecordError: It cannot be read, or something in it means nothing.
    """
    data = parse_toml(read_text(path), path)
    check_keys(data, ("table", "columns", "trial", "noise"), path, "")
    table = data.get("table", {})
    check_keys(table, ("delimiter",), path, "table.")
    delimiter = table.get("delimiter", ",")
    if not isinstance(delimiter, str) or len(delimiter) != 1:
        raise RecordError(f"{path}: table.delimiter must be one character, not {delimiter!r}")
    columns = data.get("columns", {})
    if not isinstance(columns, Mapping):
        raise RecordError(f"{path}: columns must be a table")
    rest = {key: data[key] for key in ("trial", "noise") if key in data}
    header = parse_header(rest, path, tuple(columns)) if rest else None
    sources = tuple(_source(ours, entry, path) for ours, entry in columns.items())
    return ColumnMap(sources, delimiter, header)


def _source(ours: str, entry: Any, path: Path) -> Source:
    if isinstance(entry, str):
        return Source(ours, entry)
    check_keys(entry, ("from", "unit", "scale", "sign", "offset"), path, f"columns.{ours}.")
    theirs, unit = entry.get("from"), entry.get("unit", "1")
    if not isinstance(theirs, str):
        raise RecordError(f'{path}: columns.{ours} needs from = "name of their column"')
    if unit not in UNITS:
        raise RecordError(f"{path}: columns.{ours}.unit {unit!r} is not one of {', '.join(UNITS)}")
    sign = entry.get("sign", 1)
    if sign not in {1, -1}:
        raise RecordError(f"{path}: columns.{ours}.sign must be 1 or -1, not {sign!r}")
    scale, offset = (_finite(entry.get(key, default), f"{path}: columns.{ours}.{key}")
                     for key, default in (("scale", 1.0), ("offset", 0.0)))  # fmt: skip
    if scale == 0:
        raise RecordError(f"{path}: columns.{ours}.scale must not be 0; it would erase the column")
    return Source(ours, theirs, sign * scale * UNITS[unit], offset)


def _finite(value: Any, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise RecordError(f"{name} must be a finite number, not {value!r}")
    return float(value)


def complete_sources(
    given: ColumnMap, joints: tuple[str, ...], theirs: tuple[str, ...], path: Path
) -> tuple[Source, ...]:
    """Return the map's sources and those columns that have our names already.

    Args:
        given: The map.
        joints: Joints of the machine.
        theirs: Columns of the table.
        path: The table, for messages.

    Raises:
        RecordError: The map names a column that is not there, or one that we do not have.
    """
    known = ("time_s", *(place.column for place in trial_places(joints)))
    for source in given.sources:
        if source.ours not in known:
            raise RecordError(
                f"columns.{source.ours} is no column of a trial{_near(source.ours, known)}"
            )
        if source.theirs not in theirs:
            raise RecordError(f"{path} has no column {source.theirs}{_near(source.theirs, theirs)}")
    mapped = {source.ours for source in given.sources}
    used = {source.theirs for source in given.sources}
    same = (name for name in theirs if name in known and name not in mapped and name not in used)
    return (*given.sources, *(Source(name, name) for name in same))


def _near(name: str, known: tuple[str, ...]) -> str:
    near = difflib.get_close_matches(name, known, n=1)
    return f"; did you mean {near[0]}?" if near else f"; there are {', '.join(known[:40])}"
