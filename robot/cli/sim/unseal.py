"""``bigant sim unseal``: open the labels of a sealed campaign, for scoring.

Checks the published hashes, then prints the labels or writes them to --out (.toml or .json).
"""

import argparse
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("folder", type=Path, metavar="DIR")
    parser.add_argument("--key", type=Path, required=True, metavar="FILE")
    parser.add_argument(
        "--out", type=Path, metavar="FILE", help=".toml or .json (default: print TOML)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Open the seal."""
    from robot.campaign.seal import UnsealRequest, open_seal

    return open_seal(parsed(options, UnsealRequest))
