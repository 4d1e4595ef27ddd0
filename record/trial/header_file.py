"""The text beside a trial's table, NAME.toml, and the machine's file that it names: read and written."""

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

from model.errors import ConfigError, RecordError
from model.parameters import toml_table
from model.parameters.toml_table import Table, as_table
from record.chain_file import complete
from record.input_file import read_utf8
from record.toml_file import toml_text
from record.trial.header import (
    KIND_OF_SUFFIX,
    LEGGED,
    Condition,
    TrialHeader,
    TrialNoise,
    check_joints,
    joints_of,
    kind_of,
    legs_named,
    legs_of,
    without_legs,
)
from record.whole_file import write_text


def read_header(path: Path, columns: tuple[str, ...]) -> TrialHeader:
    """Read NAME.toml and the machine's file that it names.

    Args:
        path: NAME.toml.
        columns: Columns of the table; they name the joints where no machine's file does.

    Raises:
        RecordError: It cannot be read, a key is not known, or a value is of the wrong kind.
    """
    text = read_text(path)
    return parse_header(parse_toml(text, path), path, columns)


def parse_toml(text: str, path: Path) -> Mapping[str, Any]:
    """Parse TOML.

    Raises:
        RecordError: It is none.
    """
    try:
        return toml_table.parse_toml(text, str(path))
    except ConfigError as error:
        raise RecordError(f"{path} {error.reason}") from error


def read_text(path: Path) -> str:
    """Return a file's text.

    Raises:
        RecordError: It cannot be read, or is no text.
    """
    try:
        return read_utf8(path)
    except OSError as error:
        raise RecordError(f"{path} cannot be read: {error.strerror}") from error


def parse_header(
    data: Mapping[str, Any], path: Path, columns: tuple[str, ...], machine: str | None = None
) -> TrialHeader:
    """Make a header of the tables [trial] and [noise].

    Args:
        data: The parsed TOML.
        path: Where it was; for messages, and to find the machine's file.
        columns: Columns of the table.
        machine: The machine's file; read from the disk without it.

    Raises:
        RecordError: A key is not known, or a value is of the wrong kind.
    """
    with errors_of(path):
        top = Table(data)
        trial, noise = top.maybe_table("trial"), top.maybe_table("noise")
        robot_file, gait, notes = (trial.maybe_text(key) for key in ("robot", "gait", "notes"))
        given = {key: trial.texts(key) for key in ("joints", "legs") if trial.has(key)}
        frequency_hz = trial.maybe_number("frequency_hz")
        sample_rate_hz = trial.maybe_number("sample_rate_hz")
        derived = trial.texts("derived") if trial.has("derived") else ()
        sensors = [noise.maybe_number(field.name) for field in fields(TrialNoise)]
        conditions = _conditions(top.maybe_table("conditions"))
        constants = _constants(top.maybe_table("constants"))
        # what is in it is for its machine to check
        drive = _drive(top.raw("drive")) if top.has("drive") else ""
        for table in (trial, noise):
            table.done()
        top.done()
    if machine is None:
        machine = read_machine(path.parent / robot_file) if robot_file else ""
    robot = machine_tables(machine, path.parent / robot_file)
    kind = kind_of(robot, path.parent / robot_file)
    of_joints = columns if kind == LEGGED else without_legs(columns)
    # in older files ``legs`` alone names the joints
    joints = given.get("joints", given.get("legs", joints_of(robot, of_joints)))
    legs = given["legs"] if len(given) == 2 else legs_of(robot)
    return TrialHeader(
        kind=kind,
        joints=check_joints(joints, path),
        gait=gait,
        frequency_hz=frequency_hz,
        sample_rate_hz=sample_rate_hz,
        notes=notes,
        noise=TrialNoise(*sensors),
        derived=derived,
        robot_file=robot_file,
        robot_text=machine,
        legs=check_joints(legs if legs or kind == LEGGED else legs_named(columns), path),
        conditions=conditions,
        constants=constants,
        drive=drive,
        folder=str(path.parent.resolve()),
    )


def _drive(value: Any) -> str:
    return toml_text(value) if as_table(value, "drive").names() else ""


def _conditions(table: Table) -> tuple[tuple[str, Condition], ...]:
    pairs = []
    for key in table.names():
        value = table.raw(key)
        if isinstance(value, bool) or not isinstance(value, str | int | float):
            raise ConfigError(table.name(key), f"must be a text or a number, not {value!r}")
        pairs.append((key, value if isinstance(value, str) else float(value)))
    return tuple(pairs)


def _constants(table: Table) -> tuple[tuple[str, tuple[float, ...]], ...]:
    pairs = []
    for key in table.names():
        value = table.raw(key)
        many = value if isinstance(value, list) else [value]
        numbers = [
            one for one in many if isinstance(one, int | float) and not isinstance(one, bool)
        ]
        if not numbers or len(numbers) != len(many):
            raise ConfigError(table.name(key), f"must be a number, or one a joint, not {value!r}")
        pairs.append((key, tuple(map(float, numbers))))
    return tuple(pairs)


def machine_tables(text: str, path: Path) -> Mapping[str, Any]:
    """Parse a machine's file; of one that is no TOML of ours, only its kind is known.

    Raises:
        RecordError: It is no TOML.
    """
    if path.suffix in KIND_OF_SUFFIX:
        return {"kind": KIND_OF_SUFFIX[path.suffix]}
    return parse_toml(text, path)


def read_machine(path: Path) -> str:
    """Return the text of a machine's file, with the numbers of its legs where another file has them.

    Raises:
        RecordError: It cannot be read, or the file of its legs cannot be used.
    """
    text = read_text(path)
    if path.suffix in KIND_OF_SUFFIX:
        return text
    with errors_of(path):
        return complete(text, path.parent)


@contextmanager
def errors_of(path: Path) -> Iterator[None]:
    """Turn a mistake in a key into the error of a file that was measured, which names the file.

    Raises:
        RecordError: A key has a value of the wrong kind, or is not known.
    """
    try:
        yield
    except ConfigError as error:
        raise RecordError(f"{path}: {error}") from error


def write_header(header: TrialHeader, path: Path) -> None:
    """Write NAME.toml, and the machine's file if it is not there yet.

    Raises:
        RecordError: It contradicts itself, a file cannot be written, or another machine's file of that name
            is there.
    """
    _check_header(header, path)
    if header.robot_file:
        machine = path.parent / header.robot_file
        if not machine.exists():
            write_text(machine, header.robot_text)
        elif header.robot_text not in {read_text(machine), read_machine(machine)}:
            raise RecordError(
                f"{machine} is another machine's file than this trial's; write to another folder"
            )
    write_text(path, header_text(header))


def _check_header(header: TrialHeader, path: Path) -> None:
    """Refuse what would not read back as it is."""
    check_joints(header.joints, path)
    machine = path.parent / header.robot_file
    if header.robot_text and not header.robot_file:
        raise RecordError(f"{path}: the machine's text needs a name for its file (robot_file)")
    if header.robot_file and machine.resolve() == path.resolve():
        raise RecordError(
            f"{path} would be the machine's file too; choose another name for the trial"
        )
    kind = kind_of(machine_tables(header.robot_text, machine), machine)
    if kind != header.kind:
        raise RecordError(
            f"{path}: the trial is of a {header.kind}, but its machine's file says {kind}; a trial's kind "
            "is that of its machine's file"
        )


def header_text(header: TrialHeader) -> str:
    """Return a header as TOML; what is not known is left out."""
    robot = machine_tables(header.robot_text, Path(header.robot_file))
    named = joints_of(robot, ())
    apart = bool(header.legs) and header.legs != legs_of(robot)
    trial = {
        "robot": header.robot_file or None,
        "joints": header.joints if apart else None,
        "legs": header.legs if apart else None if header.joints == named else header.joints,
        "gait": header.gait,
        "frequency_hz": header.frequency_hz,
        "sample_rate_hz": header.sample_rate_hz,
        "notes": header.notes,
        "derived": list(header.derived) or None,
    }
    tables = {
        "trial": _known(trial),
        "conditions": dict(header.conditions) or None,
        "constants": {key: _one_or_list(values) for key, values in header.constants} or None,
        "drive": toml_table.parse_toml(header.drive, "drive") or None,
        "noise": _known(asdict(header.noise)) or None,
    }
    return toml_text(tables)


def _one_or_list(values: tuple[float, ...]) -> float | list[float]:
    return values[0] if len(values) == 1 else list(values)


def _known(values: Mapping[str, Any]) -> dict[str, Any]:
    """Leave out numbers that are not known; whole ones are written as 1.0, not 1."""
    numbers = {key: float(value) for key, value in values.items() if isinstance(value, int | float)}
    return {
        key: numbers.get(key, v) for key, v in values.items() if not math.isnan(numbers.get(key, 0))
    }
