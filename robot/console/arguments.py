"""Arguments that several commands share: robot file, scenario, walk. Imports nothing heavy."""

import argparse
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

ROOT = Path(__file__).resolve().parent.parent.parent  # of the clone
Request = TypeVar("Request", bound="DataclassInstance")


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


def add_scenario(parser: argparse.ArgumentParser) -> None:
    """Add ``--scenario``."""
    parser.add_argument(
        "--scenario",
        type=Path,
        metavar="FILE",
        help="faults of the virtual hardware, for example examples/faults_servo.toml; what it may "
        "say: bigant sim faults",
    )


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
