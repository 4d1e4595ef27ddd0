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
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType

import numpy as np

from model.errors import ConfigError, RecordError
from model.parameters.toml_table import Table, as_table
from model.values.arrays import FloatArray
from model.values.machine_names import MachineNames
from record.trial.body_pose import ORIENTATIONS, BodyColumns, BodyFrame, read_body
from record.trial.clock_alignment import FileClock, read_clock
from record.trial.cut import Cut, read_cut
from record.trial.header import TrialHeader
from record.trial.header_file import errors_of, parse_toml, read_text
from record.trial.header_form import TABLES, HeaderForm
from record.trial.imu_tilt import IMU_QUATERNION
from record.trial.ros_bag import BagMap, read_bag_map
from record.trial.table_check import TableFinding
from record.trial.table_file import DataTable, TableColumn
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


NO_CUT, NOWHERE, OURS, CHOSEN = Cut(), About(), BodyFrame(), BagMap()


@dataclass(frozen=True, slots=True)
class ColumnMap:
    """A column map, read.

    Attributes:
        sources: The columns it names.
        delimiter: Between fields of a CSV file.
        header: The trial's header as far as the map tells; None if it does not.
        form: The same where it differs from run to run; None where it does not.
        period_s: Time between rows where no column tells the time; NaN otherwise.
        each_array: Whether every array of a .npz file is a table of its own.
        cut: Which rows make the trial.
        about: Where the data come from.
        body: The axes of a tracking system and its marker on the body.
        bag: Which topics of a ROS 2 bag are what.
        files: Other files of the same run, with clocks of their own.
    """

    sources: tuple[Source, ...] = ()
    delimiter: str = ","
    header: TrialHeader | None = None
    form: HeaderForm | None = None
    period_s: float = math.nan
    each_array: bool = False
    cut: Cut = NO_CUT
    about: About = NOWHERE
    body: BodyFrame = OURS
    bag: BagMap = CHOSEN
    files: "tuple[OtherFile, ...]" = ()


@dataclass(frozen=True, slots=True)
class OtherFile:
    """Another file of a run.

    Attributes:
        name: What the map calls it.
        path: Beside the run's table; ``{name}`` in it is that table's name.
        columns: Which of its columns is which.
        clock: How its clock lies to that of the run's table.
    """

    name: str
    path: str
    columns: ColumnMap
    clock: FileClock


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
    with errors_of(path):
        top = Table(data)
        about, files = top.maybe_table("about"), top.maybe_table("file")
        given = replace(
            _one_table(top),
            cut=read_cut(top.maybe_table("cut")),
            about=About(*(about.maybe_text(field.name) for field in fields(About))),
            bag=read_bag_map(top.maybe_table("bag")),
            files=tuple(_other_file(files, name) for name in files.names()),
        )
        header = {key: data[key] for key in TABLES if top.has(key)}
        for one in (about, files, top):
            one.done()
    if not header:
        return given
    form = HeaderForm(header, path, top.maybe_table("columns").names())
    if form.of_each_run:
        return replace(given, form=form)
    return replace(given, header=form.header_of("", {}))


def _one_table(top: Table) -> ColumnMap:
    """Read what a map says of one table: [table], [columns] and [body]."""
    table, columns = top.maybe_table("table"), top.maybe_table("columns")
    delimiter = table.text("delimiter") if table.has("delimiter") else ","
    if len(delimiter) != 1:
        raise ConfigError(table.name("delimiter"), f"must be one character, not {delimiter!r}")
    frame, poses = read_body(top.maybe_table("body"))
    given = ColumnMap(
        sources=(
            *(one for ours in columns.names() for one in _sources(columns, ours)),
            *_of_body(poses, columns),
        ),
        delimiter=delimiter,
        period_s=table.number("period_s", above=0, otherwise=math.nan),
        each_array=table.flag("each_array", otherwise=False),
        body=frame,
    )
    table.done()
    return given


def _other_file(files: Table, name: str) -> OtherFile:
    table = files.table(name)
    file = OtherFile(
        name, table.text("path"), _one_table(table), read_clock(table.maybe_table("clock"))
    )
    table.done()
    return file


def _of_body(poses: BodyColumns, columns: Table) -> Iterator[Source]:
    """Return the columns that [body] names."""
    for ours, (theirs, unit) in poses.items():
        if columns.has(ours):
            raise ConfigError(columns.name(ours), "is named in [body] too; leave one of them out")
        yield Source(ours, theirs, factor=_factor(unit, "body.unit"))


def _factor(unit: str, name: str) -> float:
    if unit not in UNITS:
        raise ConfigError(name, f"{unit!r} is not one of {', '.join(UNITS)}")
    return UNITS[unit]


def _sources(columns: Table, ours: str) -> Iterator[Source]:
    entry = columns.raw(ours)
    for one in entry if isinstance(entry, list) else [entry]:
        if isinstance(one, str):
            yield Source(ours, one)
        else:
            yield _source(ours, as_table(one, columns.name(ours)))


def _source(ours: str, table: Table) -> Source:
    theirs, unit = table.text("from"), table.maybe_text("unit") or "1"
    factor = _factor(unit, table.name("unit"))
    if unit == STAMPS and ours != "time_s":
        raise ConfigError(table.name("unit"), f"{STAMPS} is for time_s only")
    sign, scale = table.number("sign", otherwise=1.0), table.number("scale", otherwise=1.0)
    if sign not in {1, -1}:
        raise ConfigError(table.name("sign"), f"must be 1 or -1, not {sign:g}")
    if scale == 0:
        raise ConfigError(table.name("scale"), "must not be 0; it would erase the column")
    source = Source(
        ours,
        theirs,
        factor=sign * scale * factor,
        offset=table.number("offset", otherwise=0.0),
        sign_bit=table.integer("sign_bit", minimum=0, maximum=31, otherwise=-1),
        signed_bits=table.integer("signed_bits", minimum=1, maximum=32, otherwise=0),
        rest=table.number("rest", otherwise=0.0),
        beyond=table.number("beyond", otherwise=math.nan),
        stamps=unit == STAMPS,
    )
    table.done()
    return source


def complete_sources(
    given: ColumnMap, machine: MachineNames, theirs: tuple[str, ...], path: Path
) -> tuple[Source, ...]:
    """Return the map's sources and those columns that have our names already.

    Args:
        given: The map.
        machine: Joints and legs of the machine.
        theirs: Columns of the table.
        path: The table, for messages.

    Raises:
        RecordError: The map names a column that is not there, or one that we do not have.
    """
    known = (
        "time_s",
        *ORIENTATIONS,
        *IMU_QUATERNION,
        *(place.column for place in trial_places(machine)),
    )
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


def summed(table: DataTable, sources: list[Source], findings: list[TableFinding]) -> TableColumn:
    """Return one of our columns: the sum of what the map names for it.

    Args:
        table: Theirs.
        sources: What the map names for this column, at least one.
        findings: What is no number is added here.
    """
    values = np.zeros(table.rows)
    for one in sources:
        values += _values(table, one, findings)
    return TableColumn(sources[0].ours, values)


def _values(table: DataTable, source: Source, findings: list[TableFinding]) -> FloatArray:
    """Return a column in our unit; what is no number in it becomes NaN and is listed."""
    given = next(c for c in table.columns if c.name == source.theirs).values
    if given.dtype.kind == "O":
        values = _parse(TableColumn(source.theirs, given), findings, stamps=source.stamps)
    else:
        values = given.astype(np.float64)
    if source.sign_bit >= 0:
        level = 2.0**source.sign_bit
        values = np.where(values >= level, level - values, values)
    if source.signed_bits > 0:
        level = 2.0**source.signed_bits
        values = np.where(values >= 0.5 * level, values - level, values)
    if np.isfinite(source.beyond):
        away = values - source.rest
        side = np.where(np.abs(away) > source.beyond, np.sign(away), 0.0)
        values = np.where(np.isfinite(away), side, np.nan)
    elif source.stamps:
        known = values[np.isfinite(values)]
        values = values - (known[0] if len(known) else 0.0)
    return np.asarray(values * source.factor + source.offset)


def _parse(column: TableColumn, findings: list[TableFinding], *, stamps: bool) -> FloatArray:
    values = np.full(len(column.values), np.nan)
    bad: list[int] = []
    for row, text in enumerate(column.values):
        try:
            if text:
                values[row] = _seconds(text) if stamps else float(text)
        except ValueError:
            bad.append(row)
    if bad:
        shown = ", ".join(f"row {row + 1} {column.values[row]!r}" for row in bad[:5])
        more = f" and {len(bad) - 5} more" if len(bad) > 5 else ""
        findings.append(TableFinding("unreadable", column.name, len(bad), bad[0] + 1,
                                f"no numbers, taken as missing: {shown}{more}"))  # fmt: skip
    return values


def _seconds(stamp: str) -> float:
    """Return UNIX seconds of a date with time; without a zone it is UTC."""
    when = datetime.fromisoformat(stamp)
    return (when if when.tzinfo else when.replace(tzinfo=UTC)).timestamp()
