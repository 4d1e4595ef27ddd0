"""The text beside a trial's table: gait, rates, noise, and which machine it was."""

import difflib
import json
import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from model.errors import RecordError

LEGGED, SERVO_BENCH, SLIDING_BODY = "legged", "servo_bench", "sliding_body"
KINDS = (LEGGED, SERVO_BENCH, SLIDING_BODY)
_JOINT_OF_COLUMN = re.compile(
    r"(?:command_(.+)_rad|shaft_(.+?)_rad(?:_s)?|current_(.+)_a|voltage_(.+)_v|temperature_(.+)_c"
    r"|pwm_(.+)|torque_(.+)_nm|(?:foot_(.+)_[xyz]_m)|(?:force_(.+)_[xyz]_n))"
)
# Names of joints stand in the names of columns and topics.
_JOINT_NAME = re.compile(r"\w[\w.-]*")


@dataclass(frozen=True, slots=True)
class TrialNoise:
    """One standard deviation of each sensor's noise; NaN where it is not known.

    Attributes:
        force_n: Each axis of a foot's force.
        body_position_m: Each axis of the body's position.
        body_angle_rad: Each angle of the body.
        shaft_rad: Shaft angle.
        foot_position_m: Each axis of a foot's position.
    """

    force_n: float = math.nan
    body_position_m: float = math.nan
    body_angle_rad: float = math.nan
    shaft_rad: float = math.nan
    foot_position_m: float = math.nan


@dataclass(frozen=True, slots=True)
class TrialHeader:
    """Everything of a trial that is no sample.

    Attributes:
        kind: ``legged``, ``servo_bench`` or ``sliding_body``.
        joints: Names of joints or legs, in the order of the machine's file.
        gait: tripod, metachronal or other; empty where there is none.
        frequency_hz: Cycles a second; NaN if not known.
        sample_rate_hz: Samples a second; NaN if not known.
        notes: Words.
        noise: Noise of the sensors.
        robot_file: Name of the machine's file, relative to the trial; empty if there is none.
        robot_text: What it says.
    """

    kind: str
    joints: tuple[str, ...]
    gait: str
    frequency_hz: float
    sample_rate_hz: float
    notes: str
    noise: TrialNoise
    robot_file: str
    robot_text: str


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
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise RecordError(f"{path} is not valid TOML: {error}") from error


def read_text(path: Path) -> str:
    """Return a file's text.

    Raises:
        RecordError: It cannot be read, or is no text.
    """
    try:
        return path.read_bytes().decode("utf-8")  # as it is, line ends too
    except OSError as error:
        raise RecordError(f"{path} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise RecordError(f"{path} is not UTF-8 text") from error


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
    check_keys(data, ("trial", "noise"), path, "")
    trial, noise = data.get("trial", {}), data.get("noise", {})
    known = ("robot", "legs", "gait", "frequency_hz", "sample_rate_hz", "notes")
    check_keys(trial, known, path, "trial.")
    sensors = tuple(field.name for field in fields(TrialNoise))
    check_keys(noise, sensors, path, "noise.")
    robot_file = _words(trial, "robot", path)
    if machine is None:
        machine = read_text(path.parent / robot_file) if robot_file else ""
    robot = parse_toml(machine, path.parent / robot_file)
    return TrialHeader(
        kind=kind_of(robot, path.parent / robot_file),
        joints=check_joints(
            _listed(trial, path) if "legs" in trial else joints_of(robot, columns), path
        ),
        gait=_words(trial, "gait", path),
        frequency_hz=_number(trial, "frequency_hz", path),
        sample_rate_hz=_number(trial, "sample_rate_hz", path),
        notes=_words(trial, "notes", path),
        noise=TrialNoise(**{name: _number(noise, name, path) for name in sensors}),
        robot_file=robot_file,
        robot_text=machine,
    )


def check_keys(table: Any, known: tuple[str, ...], path: Path, prefix: str) -> None:
    """Refuse keys that mean nothing.

    Raises:
        RecordError: There is one, or this is no table.
    """
    if not isinstance(table, Mapping):
        raise RecordError(f"{path}: {prefix.rstrip('.')} must be a table")
    for key in table:
        if key not in known:
            near = difflib.get_close_matches(key, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}"
            raise RecordError(f"{path}: {prefix}{key} is not a known key; {hint}")


def _words(table: Mapping[str, Any], key: str, path: Path) -> str:
    value = table.get(key, "")
    if not isinstance(value, str):
        raise RecordError(f"{path}: {key} must be a text, not {value!r}")
    return value


def _listed(table: Mapping[str, Any], path: Path) -> tuple[str, ...]:
    value = table["legs"]
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        raise RecordError(f"{path}: legs must be a list of names, not {value!r}")
    return tuple(value)


def check_joints(joints: tuple[str, ...], path: Path) -> tuple[str, ...]:
    """Return names of joints that are fit to stand in names of columns.

    Raises:
        RecordError: One is no name, or two are the same.
    """
    for name in joints:
        if not _JOINT_NAME.fullmatch(name):
            raise RecordError(
                f"{path}: {name!r} is no name of a leg or joint; use letters, digits and _"
            )
    if len(set(joints)) != len(joints):
        raise RecordError(f"{path}: legs must differ from each other, not {', '.join(joints)}")
    return joints


def kind_of(robot: Mapping[str, Any], path: Path) -> str:
    """Return the kind of machine that its file says; a hexapod's says none.

    Raises:
        RecordError: There is no such kind.
    """
    kind = robot.get("kind", LEGGED)
    if kind not in KINDS:
        raise RecordError(f"{path}: kind must be one of {', '.join(KINDS)}, not {kind!r}")
    return str(kind)


def _number(table: Mapping[str, Any], key: str, path: Path) -> float:
    value = table.get(key, math.nan)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise RecordError(f"{path}: {key} must be a number, not {value!r}")
    return float(value)


def joints_of(robot: Mapping[str, Any], columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return the joints that a machine's file names, or else those that the columns name."""
    legs, joints = robot.get("legs"), robot.get("joint")
    if isinstance(legs, Mapping) and isinstance(legs.get("order"), list):
        return tuple(str(name) for name in legs["order"])
    if isinstance(joints, Mapping):
        return tuple(joints)
    if robot.get("kind") == SLIDING_BODY:
        return ()
    matches = (_JOINT_OF_COLUMN.fullmatch(name) for name in columns)
    found = (next(g for g in match.groups() if g) for match in matches if match)
    return tuple(dict.fromkeys(found))


def write_header(header: TrialHeader, path: Path) -> None:
    """Write NAME.toml, and the machine's file if it is not there yet.

    Raises:
        RecordError: It contradicts itself, a file cannot be written, or another machine's file of that name
            is there.
    """
    _check_header(header, path)
    try:
        if header.robot_file:
            machine = path.parent / header.robot_file
            if not machine.exists():
                machine.write_text(header.robot_text, encoding="utf-8", newline="")
            elif machine.read_bytes() != header.robot_text.encode():
                raise RecordError(
                    f"{machine} is another machine's file than this trial's; write to another folder"
                )
        path.write_text(header_text(header), encoding="utf-8", newline="")
    except OSError as error:
        raise RecordError(
            f"{path} cannot be written: {error.strerror}; choose another --out"
        ) from error


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
    kind = kind_of(parse_toml(header.robot_text, machine), machine)
    if kind != header.kind:
        raise RecordError(
            f"{path}: the trial is of a {header.kind}, but its machine's file says {kind}; a trial's kind "
            "is that of its machine's file"
        )


def header_text(header: TrialHeader) -> str:
    """Return a header as TOML."""
    lines = ["[trial]"]
    if header.robot_file:
        lines.append(f"robot = {_toml_text(header.robot_file)}")
    if header.joints != joints_of(tomllib.loads(header.robot_text), ()):
        lines.append(f"legs = [{', '.join(map(_toml_text, header.joints))}]")
    lines.append(f"gait = {_toml_text(header.gait)}")
    for name in ("frequency_hz", "sample_rate_hz"):
        lines += _toml_number(name, getattr(header, name))
    lines.append(f"notes = {_toml_text(header.notes)}")
    noise = [
        line
        for field in fields(TrialNoise)
        for line in _toml_number(field.name, getattr(header.noise, field.name))
    ]
    return "\n".join(lines + (["[noise]", *noise] if noise else [])) + "\n"


def _toml_text(text: str) -> str:
    """JSON's escapes are TOML's too, but for the delete character."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _toml_number(key: str, value: float) -> list[str]:
    return [] if math.isnan(value) else [f"{key} = {float(value)!r}"]
