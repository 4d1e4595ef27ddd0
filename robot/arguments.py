"""Arguments that several commands share. Imports nothing heavy."""

import argparse
from pathlib import Path


def add_robot(parser: argparse.ArgumentParser) -> None:
    """Add ``--robot``."""
    parser.add_argument(
        "--robot",
        type=Path,
        metavar="FILE",
        default=Path(__file__).resolve().parent.parent / "config" / "bigant.toml",
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
