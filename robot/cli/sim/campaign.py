"""``bigant sim campaign``: many trials of a scenario file, in parallel.

Makes DIR/references/*.parquet and DIR/cases/NAME/trial_*.parquet; nothing about these files says what is
wrong in them. Labels go to DIR/labels.json, or with --sealed, encrypted, to DIR/labels.sealed, with
hashes published beside them. A campaign that was broken off goes on where it stood when the same command
is given again. A scenario file is described in docs/twin.md.
"""

import argparse
import os
from pathlib import Path

from robot.console.arguments import parsed
from robot.console.exit_codes import ExitCode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("scenario", type=Path, metavar="FILE", help="scenario file, TOML")
    parser.add_argument("--out", type=Path, required=True, metavar="DIR")
    parser.add_argument(
        "--jobs",
        type=int,
        default=os.cpu_count() or 1,
        metavar="N",
        help="processes (default: one a core)",
    )
    parser.add_argument(
        "--dask",
        metavar="tcp://HOST:PORT",
        help="scheduler of a Dask cluster that sees DIR as well",
    )
    parser.add_argument("--sealed", action="store_true", help="encrypt the labels")
    parser.add_argument(
        "--key", type=Path, metavar="FILE", help="key of the sealed labels; made if it is not there"
    )
    parser.add_argument("--json", action="store_true", help="what was done as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Make what is missing of a campaign."""
    from robot.campaign.make import CampaignRequest, make_campaign

    return make_campaign(parsed(options, CampaignRequest))
