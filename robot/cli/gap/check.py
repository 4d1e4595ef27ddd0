"""``bigant gap check``: diagnose a campaign whose causes are withheld, then open the seal and count.

Each case is diagnosed with the campaign's healthy runs and its answer kept in --out, before any label is
looked at; cases answered already are not asked again. Then the labels are opened (labels.json, or the
sealed ones with --key), and every figure of the protocol is printed with its bar, and the confusions. With
--removed N, the first N single-effect cases are diagnosed once more with their true effect taken out of
the catalogue. How visible each effect is, and what its true values would close, are measured: against the
campaign's controls, or with --scenario against walks of the twin without the effects. Exit code 1: some
bar is not met.
"""

import argparse
import os
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode
from robot.console.json_output import add_json


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument(
        "campaign", type=Path, metavar="CAMPAIGN", help="folder of bigant sim campaign"
    )
    parser.add_argument("--key", type=Path, metavar="FILE", help="key of the sealed labels")
    parser.add_argument("--scenario", type=Path, metavar="FILE",
        help="its scenario file: the twin walks each case again to measure what is visible")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="DIR",
        help="where answers are kept (default: CAMPAIGN/answers)")  # fmt: skip
    parser.add_argument("--removed", type=int, default=0, metavar="N",
        help="single-effect cases to diagnose again without their effect in the catalogue")  # fmt: skip
    parser.add_argument("--no-references", action="store_true", help="do without the healthy runs")
    parser.add_argument("--jobs", type=int, default=min(os.cpu_count() or 1, 4), metavar="N",
        help="cases at a time (default: one a core, up to 4)")  # fmt: skip
    add_json(parser, "figures and cases")
    parser.add_argument(
        "--markdown", type=Path, metavar="FILE", help="figures as tables for a page"
    )


def run(options: argparse.Namespace) -> ExitCode:
    """Diagnose, open the seal, count."""
    from robot.campaign.check import CheckRequest, check_campaign

    return check_campaign(parsed(options, CheckRequest))
