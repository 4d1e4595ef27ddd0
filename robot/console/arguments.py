"""Arguments that several commands share: robot file, scenario, walk. Imports nothing heavy."""

import argparse
from pathlib import Path

GAITS = ("tripod", "metachronal")


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Add ``--robot``."""
    parser.add_argument(
        "--robot",
        type=Path,
        metavar="FILE",
        default=Path(__file__).resolve().parent.parent.parent / "config" / "bigant.toml",
        help="robot file (default: config/bigant.toml)",
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
