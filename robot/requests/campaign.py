"""Requests of ``bigant campaign``: how often a diagnosis is right, on faults that it is not told of."""

import os
from pathlib import Path

from robot.console.arguments import argument, as_json, flag, json_file, needed, option, request

CORES = min(os.cpu_count() or 1, 4)


@request("campaign.make:make_campaign")
class CampaignMakeRequest:
    """``bigant campaign make``: many trials of a scenario file, in parallel.

    Makes DIR/references/*.parquet and DIR/cases/NAME/trial_*.parquet; nothing in these files reveals the
    faults. Labels go to DIR/labels.json, or with --sealed, encrypted, to DIR/labels.sealed, with hashes
    published next to them. An interrupted campaign continues when the same command is given again. With
    --reality the robots are built as `bigant sim realities` lists, and each reality has its campaign in
    DIR/NAME; effects that it cannot have are skipped and listed. A scenario file is described in
    docs/twin.md.
    """

    scenario: Path = argument("FILE", "scenario file, TOML")
    out: Path = needed(metavar="DIR")
    reality: str | None = option(
        "how the robots are built, or all for one campaign of each", "NAME|all"
    )
    jobs: int = option("processes (default: one a core)", "N", default=os.cpu_count() or 1)
    dask: str | None = option(
        "scheduler of a Dask cluster that sees DIR as well", "tcp://HOST:PORT"
    )
    sealed: bool = flag("encrypt the labels")
    key: Path | None = option("key of the sealed labels; made if it is not there", "FILE")
    json: bool = as_json("what was done as JSON")


@request("campaign.seal:open_seal", writes=True)
class CampaignUnsealRequest:
    """``bigant campaign unseal``: open the labels of a sealed campaign, for scoring.

    Checks the published hashes, then prints the labels or writes them to --out (.toml or .json).
    """

    folder: Path = argument("DIR")
    key: Path = needed(metavar="FILE")
    out: Path | None = option(".toml or .json (default: print TOML)", "FILE")
    json: bool = as_json("print JSON")


@request("campaign.check:check_campaign", writes=True)
class CampaignScoreRequest:
    """``bigant campaign score``: diagnose a blind campaign, then open the seal and count.

    The true causes of a blind campaign are hidden. Each case is diagnosed with the campaign's healthy
    runs, and its answer is stored in --out before any label is read; stored answers are reused. Then the
    labels are opened (labels.json, or the sealed ones with --key), and every figure of the protocol is
    printed with its target, and which causes were confused. With --removed N, the first N single-effect
    cases are diagnosed once more with their true effect taken out of the catalogue. It also measures how
    visible each effect is, and how much of the gap its true values would explain: against the campaign's
    controls, or with --scenario against walks of the twin without the effects. With --realities, CAMPAIGN
    is a folder with one campaign for each reality (bigant campaign make --reality all): it prints a row of
    figures for each reality, and names the worst; the constants of the probabilities are fitted on all
    realities but one and tested on that one. Exit code 1: some target is not met.
    """

    campaign: Path = argument("CAMPAIGN", "folder of bigant campaign make")
    key: Path | None = option("key of the sealed labels", "FILE")
    scenario: Path | None = option(
        "its scenario file: the twin walks each case again to measure what is visible", "FILE"
    )
    out: Path | None = option(
        "where answers are kept (default: answers in CAMPAIGN, those without references apart)",
        "DIR",
    )
    removed: int = option(
        "single-effect cases to diagnose again without their effect in the catalogue",
        "N",
        default=0,
    )
    no_references: bool = flag("diagnose without the healthy runs")
    realities: bool = flag("CAMPAIGN has one campaign for each reality: score each separately")
    dask: str | None = option(
        "scheduler of a Dask cluster that sees CAMPAIGN as well", "tcp://HOST:PORT"
    )
    jobs: int = option("cases at a time (default: one a core, up to 4)", "N", default=CORES)
    json: Path | None = json_file("figures and cases")
    markdown: Path | None = option("figures as tables for a page", "FILE")
