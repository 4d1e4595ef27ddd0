"""Which column of somebody's table is which of ours, and in which unit: the TOML behind ``--map``.

    [table]
    delimiter = ";"
    [columns]
    time_s = "Timestamp"                                  # as it is
    shaft_HL_rad = { from = "pos_1", unit = "deg", sign = -1, offset = 0.0 }
    force_HL_z_n = { from = "Fz1", scale = 0.00981 }
    [trial]                                               # as in NAME.toml, where there is none
    gait = "tripod"
    [noise]

A value becomes ``sign * scale * unit * theirs + offset``, the offset in our unit. ``docs/log.md`` has all
keys; maps of public data sets lie in ``record/maps``.
"""

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from model.errors import ConfigError, RecordError
from record.trial.cut import Cut, parse_cut
from record.trial.header import TrialHeader, check_keys, parse_header, parse_toml, read_text
from record.trial.trial import trial_places

MAPS = Path(__file__).resolve().parent.parent / "maps"
MAP_FILE = "map.toml"
STAMPS = "iso8601"
# What one of their units is in ours.
UNITS: Mapping[str, float] = MappingProxyType({
    "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0,
    "rad": 1.0, "deg": math.pi / 180, "turn": 2 * math.pi, "mx106_ticks": 2 * math.pi / 4096,
    "ticks_4096": 2 * math.pi / 4096,
    "rad/s": 1.0, "deg/s": math.pi / 180, "rpm": 2 * math.pi / 60,
    "m": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254,
    "N": 1.0, "kN": 1e3, "kgf": 9.80665, "lbf": 4.4482216152605,
    "Nm": 1.0, "Nmm": 1e-3, "A": 1.0, "mA": 1e-3, "V": 1.0, "mV": 1e-3, "C": 1.0,
    "1": 1.0, "%": 1e-2, STAMPS: 1.0,
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class Source:
    """Where one of our columns comes from: ours = factor * theirs + offset.

    Attributes:
        ours: Our column; where several sources name it, it is their sum.
        theirs: Theirs.
        factor: Sign, scale and unit together.
        offset: In our unit.
        sign_bit: Number of the bit that says minus (the others are the size); negative for none.
        signed_bits: Width of a number whose negative values wrap (two's complement); 0 for none.
        rest: With ``beyond``: where theirs rests.
        beyond: What counts is only whether theirs is farther than this from its rest, and on which side
            (-1, 0, 1); NaN for the value itself.
        stamps: Whether theirs are dates with times (ISO 8601).
    """

    ours: str
    theirs: str
    factor: float = 1.0
    offset: float = 0.0
    sign_bit: int = -1
    signed_bits: int = 0
    rest: float = 0.0
    beyond: float = math.nan
    stamps: bool = False


@dataclass(frozen=True, slots=True)
class About:
    """Where a data set comes from.

    Attributes:
        what: What was measured.
        source: Who published it, and which version.
        licence: Under which licence.
    """

    what: str = ""
    source: str = ""
    licence: str = ""


NO_CUT, NOWHERE = Cut(), About()


@dataclass(frozen=True, slots=True)
class ColumnMap:
    """A column map, read.

    Attributes:
        sources: The columns it names.
        delimiter: Between fields of a CSV file.
        header: The trial's header as far as the map tells; None if it does not.
        period_s: Time between rows where no column tells the time; NaN otherwise.
        each_array: Whether every array of a .npz file is a table of its own.
        cut: Which rows make the trial.
        about: Where the data come from.
    """

    sources: tuple[Source, ...] = ()
    delimiter: str = ","
    header: TrialHeader | None = None
    period_s: float = math.nan
    each_array: bool = False
    cut: Cut = NO_CUT
    about: About = NOWHERE


def map_names() -> tuple[str, ...]:
    """Names of the maps that come with the program."""
    return tuple(sorted(path.parent.name for path in MAPS.glob(f"*/{MAP_FILE}")))


def find_map(name: str) -> Path:
    """Return the file of a map.

    Args:
        name: A file, or the name of a map that comes with the program.

    Raises:
        ConfigError: There is neither.
    """
    if name in map_names():
        return MAPS / name / MAP_FILE
    path = Path(name)
    if path.suffix != ".toml":
        known = map_names()
        near = difflib.get_close_matches(name, known, n=1)
        hint = f"did you mean {near[0]}?" if near else "give a map's name or its FILE.toml."
        raise ConfigError(
            "--map", f"there is no map {name!r}; {hint} Named maps: {', '.join(known)}"
        )
    return path


def read_column_map(path: Path) -> ColumnMap:
    """Read a column map.

    Raises:
        RecordError: It cannot be read, or something in it means nothing.
    """
    data = parse_toml(read_text(path), path)
    check_keys(data, ("about", "table", "columns", "trial", "noise", "cut"), path, "")
    about = data.get("about", {})
    check_keys(about, ("what", "source", "licence"), path, "about.")
    table = data.get("table", {})
    check_keys(table, ("delimiter", "period_s", "each_array"), path, "table.")
    delimiter = table.get("delimiter", ",")
    if not isinstance(delimiter, str) or len(delimiter) != 1:
        raise RecordError(f"{path}: table.delimiter must be one character, not {delimiter!r}")
    period_s = math.nan
    if "period_s" in table:
        period_s = _finite(table["period_s"], f"{path}: table.period_s")
        if not period_s > 0:
            raise RecordError(f"{path}: table.period_s must be above 0, not {period_s:g}")
    each = table.get("each_array", False)
    if not isinstance(each, bool):
        raise RecordError(f"{path}: table.each_array must be true or false, not {each!r}")
    columns = data.get("columns", {})
    if not isinstance(columns, Mapping):
        raise RecordError(f"{path}: columns must be a table")
    rest = {key: data[key] for key in ("trial", "noise") if key in data}
    header = parse_header(rest, path, tuple(columns)) if rest else None
    sources = tuple(
        _source(ours, one, path)
        for ours, entry in columns.items()
        for one in (entry if isinstance(entry, list) else [entry])
    )
    return ColumnMap(
        sources,
        delimiter,
        header,
        period_s,
        each,
        parse_cut(data.get("cut", {}), path),
        About(**{key: str(value) for key, value in about.items()}),
    )


def _source(ours: str, entry: Any, path: Path) -> Source:
    if isinstance(entry, str):
        return Source(ours, entry)
    place = f"{path}: columns.{ours}"
    known = ("from", "unit", "scale", "sign", "offset", "sign_bit", "signed_bits", "rest", "beyond")
    check_keys(entry, known, path, f"columns.{ours}.")
    theirs, unit = entry.get("from"), entry.get("unit", "1")
    if not isinstance(theirs, str):
        raise RecordError(f'{place} needs from = "name of their column"')
    if unit not in UNITS:
        raise RecordError(f"{place}.unit {unit!r} is not one of {', '.join(UNITS)}")
    if unit == STAMPS and ours != "time_s":
        raise RecordError(f"{place}.unit {STAMPS} is for time_s only")
    sign = entry.get("sign", 1)
    if sign not in {1, -1}:
        raise RecordError(f"{place}.sign must be 1 or -1, not {sign!r}")
    scale, offset, rest = (_finite(entry.get(key, default), f"{place}.{key}")
                     for key, default in (("scale", 1.0), ("offset", 0.0), ("rest", 0.0)))  # fmt: skip
    if scale == 0:
        raise RecordError(f"{place}.scale must not be 0; it would erase the column")
    bit = entry.get("sign_bit", -1)
    if isinstance(bit, bool) or not isinstance(bit, int) or not -1 <= bit <= 31:
        raise RecordError(f"{place}.sign_bit must be a bit's number, 0 to 31, not {bit!r}")
    wide = entry.get("signed_bits", 0)
    if isinstance(wide, bool) or not isinstance(wide, int) or not 0 <= wide <= 32:
        raise RecordError(f"{place}.signed_bits must be a width, 1 to 32, not {wide!r}")
    beyond = _finite(entry["beyond"], f"{place}.beyond") if "beyond" in entry else math.nan
    factor = sign * scale * UNITS[unit]
    return Source(ours, theirs, factor, offset, bit, wide, rest, beyond, unit == STAMPS)


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
