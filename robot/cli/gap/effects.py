"""``bigant gap effects``: the catalogue of what a simulator may lack.

Each effect with its stage, what it can touch, its numbers with units and bounds, its physics and what a
person would do about it. With --effects FILE.py a user's own effects are listed behind them, which also
checks the file (it is run as Python: open only files that you trust).
"""

import argparse
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("--effects", type=Path, metavar="FILE.py", help="effects of your own")
    parser.add_argument("--stage", metavar="STAGE", help="only those of one stage")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """List the catalogue."""
    from robot.gap_report.effects import EffectsRequest, list_effects

    return list_effects(parsed(options, EffectsRequest))
