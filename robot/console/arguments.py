"""A command's options, declared once: fields of a frozen dataclass, of which its parser is made.

Imports nothing heavy: help has to answer at once.
"""

import argparse
import math
from collections.abc import Callable
from dataclasses import MISSING, Field, dataclass, field, fields
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, Any, TypeVar, dataclass_transform, get_args

from robot.console.shipped import shipped

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

DEFAULT_ROBOT_FILE = shipped("config/bigant.toml")
STDOUT = Path("-")
EITHER = "either"  # the group of options that exclude each other
WORK = "bigant_work"  # of a request's class: the function that does what is asked for
WRITES = "bigant_writes"  # and whether it writes files
Kind = TypeVar("Kind")
Request = TypeVar("Request", bound="DataclassInstance")

# What servos can be set to, in the order in which a scan tries them.
BAUD_RATES = (57_600, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 115_200, 9_600, 4_500_000)


@dataclass_transform(frozen_default=True, kw_only_default=True)
def request(work: str, *, writes: bool = False) -> Callable[[type[Kind]], type[Kind]]:
    """Make a class the request of a command: a frozen dataclass of its options.

    Its fields are made by ``option`` and the functions below it; the paragraphs of its docstring after the
    first are the command's help.

    Args:
        work: ``module:function`` below ``robot``; the function takes the request and returns an exit code.
        writes: Whether it writes files where earlier ones may be: it then has ``--overwrite``, too.
    """

    def made(kind: type[Kind]) -> type[Kind]:
        kind = dataclass(frozen=True, slots=True, kw_only=True)(kind)
        setattr(kind, WORK, work)
        setattr(kind, WRITES, writes)
        return kind

    return made


def option(
    text: str | None = None,
    metavar: str | None = None,
    *,
    default: Any = None,
    flags: tuple[str, ...] = (),
    group: str = "",
    by_place: bool = False,
    **words: Any,
) -> Any:
    """An option named like its field; a value is read as the field's type says.

    Args:
        text: Its help.
        metavar: What its value is called in the help.
        default: Its value where it is left out; ``MISSING`` for an option that is needed.
        flags: Its names, if they are not the field's.
        group: Heading in the help below which it stands, or ``EITHER``.
        by_place: Whether it is known by its place and has no name.
        words: For ``argparse``.
    """
    words = {"help": text, **({"metavar": metavar} if metavar else {}), **words}
    kept = {"flags": flags, "group": group, "by_place": by_place, "words": words}
    return field(default=default, metadata=kept)


def needed(text: str | None = None, metavar: str | None = None, **words: Any) -> Any:
    """An option that must be given."""
    return option(text, metavar, default=MISSING, required=True, **words)


def several(text: str, metavar: str, **words: Any) -> Any:
    """An option that may be given several times; its values are a tuple."""
    return option(text, metavar, default=(), action="append", **words)


def flag(text: str, **words: Any) -> Any:
    """An option without a value."""
    return option(text, default=False, action="store_true", **words)


def argument(metavar: str, text: str | None = None, *, default: Any = MISSING, **words: Any) -> Any:
    """An argument that is known by its place; with ``default`` it may be left out."""
    return option(text, metavar, default=default, by_place=True, **words)


def robot_file(text: str = "robot file (default: config/bigant.toml)") -> Any:
    """``--robot``; the nominal robot file is its default."""
    return option(text, "FILE", default=DEFAULT_ROBOT_FILE)


def gait_choice() -> Any:
    """``--gait``: which names there are is known when the robot file has been read."""
    text = "gait of the robot file (default: its first), or a Python file that gives one"
    return option(text, "NAME|FILE.py")


def servo_port() -> Any:
    """``--port`` of the servo bus."""
    return needed("serial port, for example /dev/ttyUSB0", "PORT")


def baud_now(text: str = "baud rate now (all eight)") -> Any:
    """``--baud``."""
    return option(text, "B", type=baud_rate)


def hardware_port(**words: Any) -> Any:
    """``--hardware``, virtual by default."""
    text = "virtual (default), or the serial port of the servo bus"
    return option(text, "virtual|PORT", default="virtual", **words)


def virtual_robot() -> Any:
    """``--virtual-robot``."""
    text = "robot file of the actual virtual robot (default: the same)"
    return option(text, "FILE")


def random_seed(
    text: str | None = "seed of virtual noise", metavar: str | None = "N", **words: Any
) -> Any:
    """``--seed`` of a random generator."""
    return option(text, metavar, default=0, type=between(0, whole=True), **words)


def discovery() -> Any:
    """``--discover`` force-torque units."""
    text = "where to search for force-torque units (default: broadcast on the local network)"
    return option(text, "ADDRESS[:PORT]|none", default="255.255.255.255")


def scenario_file() -> Any:
    """``--scenario``."""
    example = "for example examples/faults_servo.toml; bigant sim faults lists what it can hold"
    return option(f"faults of the virtual hardware, {example}", "FILE")


def as_json(text: str = "the result as JSON") -> Any:
    """``--json``: print JSON."""
    return flag(text)


def json_file(what: str) -> Any:
    """``--json [FILE]``: alone it prints, with FILE it writes."""
    text = f"{what} as JSON into FILE; without FILE (or with -) printed, and nothing else"
    return option(text, "FILE", nargs="?", const=STDOUT)


def add_arguments(parser: argparse.ArgumentParser, kind: "type[DataclassInstance]") -> None:
    """Add the options that the fields of a request are."""
    groups: dict[str, argparse._ArgumentGroup] = {}
    for one in fields(kind):
        title, words = one.metadata["group"], dict(one.metadata["words"])
        if title == EITHER and title not in groups:
            groups[title] = parser.add_mutually_exclusive_group()
        elif title and title not in groups:
            groups[title] = parser.add_argument_group(title)
        if words.get("action") != "store_true":
            words.setdefault("type", _type_of_one(one))
        if one.default is not MISSING:
            # argparse appends to lists
            many = words.get("action") == "append" or words.get("nargs") == "+"
            words["default"] = list(one.default) if many else one.default
        if one.metadata["by_place"]:
            parser.add_argument(one.name, **words)
            continue
        flags = one.metadata["flags"] or (f"--{one.name.replace('_', '-')}",)
        groups.get(title, parser).add_argument(*flags, dest=one.name, **words)


def _type_of_one(one: "Field[Any]") -> Any:
    """Return the type of one value of a field: inside ``X | None`` and ``tuple[X, ...]``."""
    inner = [kind for kind in get_args(one.type) if kind not in {NoneType, Ellipsis}]
    kind = inner[0] if inner else one.type
    return path_of if kind is Path else kind


def parsed(options: argparse.Namespace, kind: type[Request]) -> Request:
    """Return what was asked for as a command's own request; the parser's values end here."""
    values = {one.name: getattr(options, one.name) for one in fields(kind)}
    return kind(**{n: tuple(v) if isinstance(v, list) else v for n, v in values.items()})


def between(
    low: float, high: float = math.inf, unit: str = "", *, whole: bool = False
) -> Callable[[str], Any]:
    """Return a reader of a finite number (a whole one, if so) from ``low`` to ``high``, both included."""
    kind, noun = (int, "a whole number ") if whole else (float, "")

    def number(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = math.nan
        if not (low <= value <= high and value < math.inf):
            bounds = f"from {low:g} to {high:g} {unit}" if high < math.inf else f"{low:g} or more"
            raise argparse.ArgumentTypeError(f"must be {noun}{bounds.rstrip()}, not {text}")
        return value

    return number


def baud_rate(text: str) -> int:
    """Read a baud rate that a servo can be set to."""
    if not text.isdecimal() or int(text) not in BAUD_RATES:
        known = ", ".join(str(rate) for rate in sorted(BAUD_RATES))
        raise argparse.ArgumentTypeError(f"must be one of {known}, not {text}")
    return int(text)


SERVO_ID = between(0, 252, whole=True)


def id_or_all(text: str) -> int | None:
    """Read a Dynamixel id; None for ``all``."""
    return None if text == "all" else int(SERVO_ID(text))


def file_name(text: str) -> str:
    """Read the name of a file, which need not be there."""
    if "\0" in text:
        raise argparse.ArgumentTypeError("must be a name without NUL bytes")
    return text


def path_of(text: str) -> Path:
    """Read the name of a file as a path; completion offers files for it."""
    return Path(file_name(text))


def positive(text: str) -> float:
    """Read a positive number."""
    value = float(text)
    if not 0 < value < math.inf:
        raise argparse.ArgumentTypeError(f"must be a positive number, not {text}")
    return value


def names(text: str) -> tuple[str, ...]:
    """Read names with commas between them."""
    return tuple(name for part in text.split(",") if (name := part.strip()))
