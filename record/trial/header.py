"""The text beside a trial's table: gait, rates, noise, and which machine it was."""

import math
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

from model.errors import ConfigError, RecordError
from model.parameters import toml_table
from model.parameters.tables import CHAIN
from model.parameters.toml_table import Table
from model.values.machine_names import MachineNames
from record.chain_file import complete
from record.input_file import read_utf8
from record.toml_file import toml_text
from record.whole_file import write_text

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
        joints: Names of joints, in the order of the machine's file.
        gait: Name of the gait, as in the robot file; empty where there is none.
        frequency_hz: Cycles a second; NaN if not known.
        sample_rate_hz: Samples a second; NaN if not known.
        notes: Words.
        noise: Noise of the sensors.
        robot_file: Name of the machine's file, relative to the trial; empty if there is none.
        robot_text: What it says.
        legs: Names of legs that have several joints; empty where they are called as their joints.
        derived: What was not measured but worked out from other columns, in words.
    """

    kind: str
    joints: tuple[str, ...]
    gait: str = ""
    frequency_hz: float = math.nan
    sample_rate_hz: float = math.nan
    notes: str = ""
    noise: TrialNoise = TrialNoise()
    robot_file: str = ""
    robot_text: str = ""
    legs: tuple[str, ...] = ()
    derived: tuple[str, ...] = ()

    @property
    def names(self) -> MachineNames:
        """Names of joints and legs."""
        return MachineNames(self.joints, self.legs or self.joints)


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
        legs = trial.texts("legs") if trial.has("legs") else None
        frequency_hz = trial.maybe_number("frequency_hz")
        sample_rate_hz = trial.maybe_number("sample_rate_hz")
        derived = trial.texts("derived") if trial.has("derived") else ()
        sensors = [noise.maybe_number(field.name) for field in fields(TrialNoise)]
        for table in (trial, noise, top):
            table.done()
    if machine is None:
        machine = read_machine(path.parent / robot_file) if robot_file else ""
    robot = parse_toml(machine, path.parent / robot_file)
    return TrialHeader(
        kind=kind_of(robot, path.parent / robot_file),
        joints=check_joints(legs if legs is not None else joints_of(robot, columns), path),
        gait=gait,
        frequency_hz=frequency_hz,
        sample_rate_hz=sample_rate_hz,
        notes=notes,
        noise=TrialNoise(*sensors),
        derived=derived,
        robot_file=robot_file,
        robot_text=machine,
        legs=legs_of(robot),
    )


def read_machine(path: Path) -> str:
    """Return the text of a machine's file, with the numbers of its legs where another file has them.

    Raises:
        RecordError: It cannot be read, or the file of its legs cannot be used.
    """
    text = read_text(path)
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


def joints_of(robot: Mapping[str, Any], columns: tuple[str, ...]) -> tuple[str, ...]:
    """Return the joints that a machine's file names, or else those that the columns name."""
    legs, joints = robot.get("legs"), robot.get("joint")
    if chain := _chain_of(robot):
        return tuple(str(name) for name in chain["joints"])
    if isinstance(legs, Mapping) and isinstance(legs.get("order"), list):
        return tuple(str(name) for name in legs["order"])
    if isinstance(joints, Mapping):
        return tuple(joints)
    if robot.get("kind") == SLIDING_BODY:
        return ()
    matches = (_JOINT_OF_COLUMN.fullmatch(name) for name in columns)
    names = (next(g for g in match.groups() if g) for match in matches if match)
    return tuple(dict.fromkeys(names))


def legs_of(robot: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the legs of a machine whose joints have names of their own; none of any other."""
    legs = robot.get("legs")
    if not _chain_of(robot) or not isinstance(legs, Mapping):
        return ()
    return tuple(str(name) for name in legs.get("order", ()))


def _chain_of(robot: Mapping[str, Any]) -> Mapping[str, Any]:
    """The table [leg.chain] of a machine whose legs have several joints; empty without."""
    leg = robot.get("leg")
    chain = leg.get(CHAIN) if isinstance(leg, Mapping) else None
    return chain if isinstance(chain, Mapping) and isinstance(chain.get("joints"), list) else {}


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
    kind = kind_of(parse_toml(header.robot_text, machine), machine)
    if kind != header.kind:
        raise RecordError(
            f"{path}: the trial is of a {header.kind}, but its machine's file says {kind}; a trial's kind "
            "is that of its machine's file"
        )


def header_text(header: TrialHeader) -> str:
    """Return a header as TOML; what is not known is left out."""
    named = joints_of(toml_table.parse_toml(header.robot_text, header.robot_file), ())
    trial = {
        "robot": header.robot_file or None,
        "legs": None if header.joints == named else header.joints,
        "gait": header.gait,
        "frequency_hz": header.frequency_hz,
        "sample_rate_hz": header.sample_rate_hz,
        "notes": header.notes,
        "derived": list(header.derived) or None,
    }
    return toml_text({"trial": _known(trial), "noise": _known(asdict(header.noise)) or None})


def _known(values: Mapping[str, Any]) -> dict[str, Any]:
    """Leave out numbers that are not known; whole ones are written as 1.0, not 1."""
    numbers = {key: float(value) for key, value in values.items() if isinstance(value, int | float)}
    return {
        key: numbers.get(key, v) for key, v in values.items() if not math.isnan(numbers.get(key, 0))
    }
