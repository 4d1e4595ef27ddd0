"""Arguments that several commands share: robot file, scenario, walk. Imports nothing heavy."""

import argparse
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

ROOT = Path(__file__).resolve().parent.parent.parent  # of the clone
Request = TypeVar("Request", bound="DataclassInstance")

# What an MX-106 can be set to, in the order in which a scan tries them.
BAUD_RATES = (57_600, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 115_200, 9_600, 4_500_000)


def parsed(options: argparse.Namespace, kind: type[Request]) -> Request:
    """Return what was asked for as a command's own frozen dataclass; the parser's values end here.

    Args:
        options: What the parser returned.
        kind: The dataclass; each of its fields is named like an option of the command.
    """
    return kind(**{field.name: getattr(options, field.name) for field in fields(kind)})


def add_robot(
    parser: argparse.ArgumentParser, words: str = "robot file (default: config/bigant.toml)"
) -> None:
    """Add ``--robot``; the nominal robot file is its default."""
    parser.add_argument(
        "--robot",
        type=Path,
        metavar="FILE",
        default=ROOT / "config" / "bigant.toml",
        help=words,
    )


def add_hardware(parser: argparse.ArgumentParser) -> None:
    """Add ``--hardware``; virtual devices are its default."""
    parser.add_argument(
        "--hardware",
        default="virtual",
        metavar="virtual|PORT",
        help="virtual (default), or the serial port of the servo bus",
    )


def add_virtual_robot(parser: argparse.ArgumentParser) -> None:
    """Add ``--virtual-robot``."""
    parser.add_argument(
        "--virtual-robot",
        type=Path,
        metavar="FILE",
        help="robot file of the virtual robot that is really there (default: the same)",
    )


def add_port(
    parser: argparse.ArgumentParser,
    *,
    required: bool = True,
    baud: str = "baud rate now (all eight)",
) -> None:
    """Add ``--port`` and ``--baud``."""
    every = "" if required else " (every USB port)"
    parser.add_argument(
        "--port",
        metavar="PORT",
        required=required,
        help=f"serial port, for example /dev/ttyUSB0{every}",
    )
    parser.add_argument("--baud", type=baud_rate, metavar="B", help=baud)


def add_discover(parser: argparse.ArgumentParser) -> None:
    """Add ``--discover``."""
    parser.add_argument(
        "--discover",
        metavar="ADDRESS[:PORT]|none",
        default="255.255.255.255",
        help="where to ask for force-torque units (default: broadcast on the local network)",
    )


def add_source(parser: argparse.ArgumentParser) -> None:
    """Add LOG, ``--live`` and ``--speed`` of a command that shows a run."""
    parser.add_argument(
        "path",
        type=Path,
        metavar="LOG",
        nargs="?",
        help="a log; with --live the one that is being written (default: the newest in runs/)",
    )
    parser.add_argument("--live", action="store_true", help="follow a running bigant drive")
    parser.add_argument(
        "--speed",
        type=between(0.01, 1000),
        default=1.0,
        metavar="X",
        help="of a recorded log (default: 1)",
    )


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Add ``--scenario``."""
    parser.add_argument(
        "--scenario",
        type=Path,
        metavar="FILE",
        help="faults of the virtual hardware, for example examples/faults_servo.toml; what it may "
        "say: bigant sim faults",
    )


def add_json(parser: argparse.ArgumentParser, what: str = "the result") -> None:
    """Add ``--json``."""
    parser.add_argument("--json", action="store_true", help=f"{what} as JSON")


def between(
    low: float, high: float, unit: str = "", *, whole: bool = False
) -> Callable[[str], Any]:
    """Return a reader of a number (a whole one, if so) from ``low`` to ``high``, both included."""
    kind, noun = (int, "a whole number ") if whole else (float, "")

    def number(text: str) -> float:
        try:
            value = kind(text)
        except ValueError:
            value = low - 1
        if not low <= value <= high:
            bounds = f"{noun}from {low:g} to {high:g} {unit}".rstrip()
            raise argparse.ArgumentTypeError(f"must be {bounds}, not {text}")
        return value

    return number


def baud_rate(text: str) -> int:
    """Read a baud rate that an MX-106 can be set to."""
    if not text.isdecimal() or int(text) not in BAUD_RATES:
        known = ", ".join(str(rate) for rate in sorted(BAUD_RATES))
        raise argparse.ArgumentTypeError(f"must be one of {known}, not {text}")
    return int(text)


def servo_id(text: str) -> int:
    """Read a Dynamixel id."""
    return int(between(0, 252, whole=True)(text))


def positive(text: str) -> float:
    """Read a positive number."""
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a positive number, not {text}")
    return value


def seed(text: str) -> int:
    """Read the seed of a random generator."""
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"must be a whole number from 0 on, not {text}")
    return int(text)


def steer(text: str) -> float:
    """Read a steering wish."""
    value = float(text)
    if not -1 <= value <= 1:
        raise argparse.ArgumentTypeError(f"must be from -1 (right) to 1 (left), not {text}")
    return value
