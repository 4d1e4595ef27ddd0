"""``bigant sim campaign``: the trials of a scenario file, made by many processes, and their labels."""

import hashlib
import secrets
import time
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path

from gap.worker_pool import worker_pool
from model.errors import ConfigError, RecordError
from record.trial.header_file import read_text
from record.whole_file import write_text, writing
from robot.campaign.plan import CampaignScenario, draw_cases, read_scenario
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
from robot.console.installed import how_to_install
from robot.console.json_output import print_json
from robot.console.progress import ProgressBar
from robot.requests.sim import SimCampaignRequest

CONNECT_S = 10.0  # how long a scheduler may take to answer


def make_campaign(request: SimCampaignRequest) -> ExitCode:
    """Make what is missing of a campaign.

    Raises:
        ConfigError: Options or a scenario that make no sense.
        RecordError: Labels that are there do not fit.
    """
    out = request.out
    if request.jobs < 1:
        raise ConfigError("--jobs", f"must be 1 or more, not {request.jobs}")
    if request.sealed and request.key is None:
        raise ConfigError(
            "--sealed", "needs --key FILE; keep that file away from whoever diagnoses"
        )
    if request.sealed and request.key and out.resolve() in request.key.resolve().parents:
        raise ConfigError("--key", "must lie outside the campaign's folder")
    scenario = read_scenario(request.scenario)
    began_s = time.perf_counter()
    with _executor(request) as executor, ProgressBar("trials") as bar:
        entropy, digest = _labels(request, scenario)
        jobs = campaign_jobs(scenario, entropy, out)
        before = sum(job.done for job in jobs)
        failures = run_jobs(
            jobs, executor, lambda ready: bar.show(ready / len(jobs), f"{ready} of {len(jobs)}")
        )
        dropped = drop_cases(failures) if request.sealed else 0
        level_stamps(out)
    wall_s = time.perf_counter() - began_s
    if dropped:  # which and why would tell what is wrong in them
        print(f"{dropped} cases could not be walked to the end and are left out whole")
    else:
        for failure in failures:
            print(f"{failure.out} could not be made: {failure.reason}")
    made = sum(job.done for job in jobs) - before
    if request.json:
        summary = {"trials": len(jobs), "made": made, "failed": len(failures), "wall_s": wall_s}
        print_json(summary | {"sealed_sha256": digest})
    else:
        print(f"{out}: {len(jobs)} trials, {made} made now in {wall_s:.1f} s")
        if digest:
            print(f"labels sealed, SHA-256 {digest}")
    return ExitCode.VERDICT_FAILED if failures else ExitCode.OK


def _labels(request: SimCampaignRequest, scenario: CampaignScenario) -> tuple[bytes, str]:
    """Write the labels before any trial; return what everything follows from, and the seal's hash."""
    folder = request.out
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
    entropy = hashlib.sha256(f"campaign {scenario.seed}".encode()).digest()
    labels = labels_of(draw_cases(scenario, entropy), entropy)
    if opened.exists():
        _check_same(labels, read_text(opened), folder)
    write_text(opened, labels.text)
    return entropy, ""


def _check_same(now: Labels, before: str, folder: Path) -> None:
    if now.text != before:
        raise RecordError(f"{folder} holds another scenario's campaign; choose another --out")


@contextmanager
def _executor(request: SimCampaignRequest) -> Iterator[Executor]:
    if request.dask is None:
        with worker_pool(request.jobs) as local:
            yield local
        return
    try:
        from distributed import Client  # an extra
    except ImportError as error:
        raise ConfigError(
            "--dask", f"needs Dask; install it with: {how_to_install('dask')}"
        ) from error
    try:
        client = Client(request.dask, timeout=CONNECT_S)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise ConfigError("--dask", f"nothing answers at {request.dask}: {error}") from error
    with client, client.get_executor() as cluster:  # type: ignore[no-untyped-call]
        yield cluster
