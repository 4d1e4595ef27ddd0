"""``bigant campaign make``: the trials of a scenario file, made by many processes, and their labels."""

import hashlib
import secrets
import sys
import time
from concurrent.futures import Executor
from pathlib import Path

from model.errors import ConfigError, RecordError
from record.trial.header_file import read_text
from record.whole_file import write_text, writing
from robot.campaign.executor import campaign_executor
from robot.campaign.plan import (
    REALITY_NAME,
    CampaignScenario,
    draw_cases,
    read_scenario,
    reality_text,
)
from robot.campaign.run import campaign_jobs, drop_cases, level_stamps, run_jobs
from robot.campaign.seal import (
    ENTROPY_BYTES,
    OPEN_NAME,
    SEALED_NAME,
    Labels,
    labels_of,
    make_key,
    seal,
    unseal,
)
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.progress import ProgressBar
from robot.requests.campaign import CampaignMakeRequest
from sim_hw.realities.catalogue import REALITIES, find_reality

ALL = "all"


def make_campaign(request: CampaignMakeRequest) -> ExitCode:
    """Make what is missing of a campaign, or of one campaign a reality.

    Raises:
        ConfigError: Options or a scenario that make no sense.
        RecordError: Labels that are there do not fit.
    """
    if request.jobs < 1:
        raise ConfigError("--jobs", f"must be 1 or more, not {request.jobs}")
    if request.sealed and request.key is None:
        raise ConfigError(
            "--sealed", "needs --key FILE; keep that file away from whoever diagnoses"
        )
    if request.sealed and request.key and request.out.resolve() in request.key.resolve().parents:
        raise ConfigError("--key", "must lie outside the campaign's folder")
    plans = _plans(request)
    with campaign_executor(request.jobs, request.dask) as executor:
        made = [_make_one(request, *plan, executor) for plan in plans]
    if request.json:
        print_json({"realities": made} if request.reality is not None else made[0])
    return ExitCode.VERDICT_FAILED if any(one["failed"] for one in made) else ExitCode.OK


def _plans(request: CampaignMakeRequest) -> list[tuple[CampaignScenario, Path]]:
    """Scenarios and their folders: one, or one a reality."""
    if request.reality is None:
        return [(read_scenario(request.scenario), request.out)]
    chosen = REALITIES if request.reality == ALL else (find_reality(request.reality),)
    return [(read_scenario(request.scenario, one), request.out / one.name) for one in chosen]


def _make_one(
    request: CampaignMakeRequest, scenario: CampaignScenario, out: Path, executor: Executor
) -> dict[str, object]:
    """Make one campaign; return what was done."""
    began_s, words = time.perf_counter(), sys.stderr if request.json else sys.stdout
    with ProgressBar("trials") as bar:
        entropy, digest = _labels(request, scenario, out)
        if request.reality is not None:
            write_text(out / REALITY_NAME, reality_text(scenario))
        jobs = campaign_jobs(scenario, entropy, out)
        before = sum(job.done for job in jobs)
        failures = run_jobs(
            jobs, executor, lambda ready: bar.show(ready / len(jobs), f"{ready} of {len(jobs)}")
        )
        dropped = drop_cases(failures) if request.sealed else 0
        level_stamps(out)
    wall_s = time.perf_counter() - began_s
    made = sum(job.done for job in jobs) - before
    named = {} if request.reality is None else {"reality": scenario.reality.name}
    for name, why in scenario.skipped:
        print(f"{out}: {name} skipped, {why}", file=words)
    if dropped:  # which and why would tell what is wrong in them
        print(f"{dropped} cases could not finish the walk and are left out", file=words)
    else:
        for failure in failures:
            print(f"{failure.out} could not be made: {failure.reason}", file=words)
    if not request.json:
        print(f"{out}: {len(jobs)} trials, {made} made now in {wall_s:.1f} s")
        if digest:
            print(f"labels sealed, SHA-256 {digest}")
    skipped = dict(scenario.skipped)
    return {
        **named,
        "trials": len(jobs),
        "made": made,
        "failed": len(failures),
        "wall_s": wall_s,
        "sealed_sha256": digest,
        **({"skipped": skipped} if named else {}),
    }


def _labels(
    request: CampaignMakeRequest, scenario: CampaignScenario, folder: Path
) -> tuple[bytes, str]:
    """Write the labels before any trial; return what everything follows from, and the seal's hash."""
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
    opened, sealed = folder / OPEN_NAME, folder / SEALED_NAME
    if request.key is not None and request.sealed:
        if opened.exists():
            raise RecordError(
                f"{folder} holds open labels; choose another --out for a sealed campaign"
            )
        key = make_key(request.key)
        if sealed.exists():
            there = unseal(folder, key)
            drawn = labels_of(draw_cases(scenario, there.entropy), there.entropy)
            _check_same(drawn, there.text, folder)
            return there.entropy, hashlib.sha256(sealed.read_bytes()).hexdigest()
        entropy = secrets.token_bytes(ENTROPY_BYTES)
        return entropy, seal(labels_of(draw_cases(scenario, entropy), entropy), folder, key)
    if sealed.exists():
        raise RecordError(f"{folder} holds a sealed campaign; go on with --sealed --key FILE")
    words = f"campaign {scenario.seed}"
    if request.reality is not None:  # each has cases and days of its own
        words += f" {scenario.reality.name}"
    entropy = hashlib.sha256(words.encode()).digest()
    labels = labels_of(draw_cases(scenario, entropy), entropy)
    if opened.exists():
        _check_same(labels, read_text(opened), folder)
    write_text(opened, labels.text)
    return entropy, ""


def _check_same(now: Labels, before: str, folder: Path) -> None:
    if now.text != before:
        raise RecordError(f"{folder} holds another scenario's campaign; choose another --out")
