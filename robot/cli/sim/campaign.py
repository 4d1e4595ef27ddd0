"""``bigant sim campaign``: many trials of a scenario file, in parallel.

Makes DIR/references/*.parquet and DIR/cases/NAME/trial_*.parquet; nothing about these files says what is
wrong in them. Labels go to DIR/labels.json, or with --sealed, encrypted, to DIR/labels.sealed, with
hashes published beside them. A campaign that was broken off goes on where it stood when the same command
is given again. A scenario file is described in docs/twin.md.
"""

import argparse
import os
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from collections.abc import Iterator
    from concurrent.futures import Executor

    from robot.campaign.plan import Scenario

# How long a scheduler may take to answer.
CONNECT_S = 10.0


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
    """Make what is missing of a campaign.

    Raises:
        ConfigError: Options or a scenario that make no sense.
        RecordError: Labels that are there do not fit.
    """
    import json
    import time

    from model.errors import ConfigError
    from robot.campaign.plan import read_scenario
    from robot.campaign.run import campaign_jobs, drop_cases, level_stamps, run_jobs
    from robot.console.progress import ProgressBar

    if options.jobs < 1:
        raise ConfigError("--jobs", f"must be 1 or more, not {options.jobs}")
    if options.sealed and options.key is None:
        raise ConfigError(
            "--sealed", "needs --key FILE; keep that file away from whoever diagnoses"
        )
    if options.sealed and options.out.resolve() in options.key.resolve().parents:
        raise ConfigError("--key", "must lie outside the campaign's folder")
    scenario = read_scenario(options.scenario)
    begin_s = time.perf_counter()
    with _executor(options) as executor, ProgressBar("trials") as bar:
        entropy, digest = _labels(options, scenario)
        jobs = campaign_jobs(scenario, entropy, options.out)
        before = sum(job.done for job in jobs)
        failures = run_jobs(
            jobs, executor, lambda ready: bar.show(ready / len(jobs), f"{ready} of {len(jobs)}")
        )
        dropped = drop_cases(failures) if options.sealed else 0
        level_stamps(options.out)
    wall_s = time.perf_counter() - begin_s
    if dropped:  # which and why would tell what is wrong in them
        print(f"{dropped} cases could not be walked to the end and are left out whole")
    else:
        for failure in failures:
            print(f"{failure.out} could not be made: {failure.reason}")
    made = sum(job.done for job in jobs) - before
    if options.json:
        found = {"trials": len(jobs), "made": made, "failed": len(failures), "wall_s": wall_s}
        print(json.dumps(found | {"sealed_sha256": digest}, indent=2))
    else:
        print(f"{options.out}: {len(jobs)} trials, {made} made now in {wall_s:.1f} s")
        if digest:
            print(f"labels sealed, SHA-256 {digest}")
    return ExitCode.VERDICT_FAILED if failures else ExitCode.OK


def _labels(options: argparse.Namespace, scenario: "Scenario") -> tuple[bytes, str]:
    """Write the labels before any trial; return what everything follows from, and the seal's hash."""
    import hashlib
    import secrets

    from model.errors import RecordError
    from robot.campaign.plan import draw_cases
    from robot.campaign.seal import (
        ENTROPY_BYTES,
        OPEN_NAME,
        SEALED_NAME,
        labels_of,
        make_key,
        seal,
        unseal,
        write_open,
    )

    folder: Path = options.out
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise RecordError(
            f"{folder} cannot be made: {error.strerror}; choose another --out"
        ) from error
    if options.sealed:
        if (folder / OPEN_NAME).exists():
            raise RecordError(
                f"{folder} holds open labels; choose another --out for a sealed campaign"
            )
        key = make_key(options.key)
        if (folder / SEALED_NAME).exists():
            entropy = unseal(folder, key).entropy
            _same(
                labels_of(draw_cases(scenario, entropy), entropy).text,
                unseal(folder, key).text,
                folder,
            )
            return entropy, hashlib.sha256((folder / SEALED_NAME).read_bytes()).hexdigest()
        entropy = secrets.token_bytes(ENTROPY_BYTES)
        return entropy, seal(labels_of(draw_cases(scenario, entropy), entropy), folder, key)
    if (folder / SEALED_NAME).exists():
        raise RecordError(f"{folder} holds a sealed campaign; go on with --sealed --key FILE")
    entropy = hashlib.sha256(f"campaign {scenario.seed}".encode()).digest()
    labels = labels_of(draw_cases(scenario, entropy), entropy)
    if (folder / OPEN_NAME).exists():
        _same(labels.text, (folder / OPEN_NAME).read_text(encoding="utf-8"), folder)
    write_open(labels, folder)
    return entropy, ""


def _same(now: str, before: str, folder: Path) -> None:
    from model.errors import RecordError

    if now != before:
        raise RecordError(f"{folder} holds another scenario's campaign; choose another --out")


@contextmanager
def _executor(options: argparse.Namespace) -> "Iterator[Executor]":
    from gap.worker_pool import worker_pool
    from model.errors import ConfigError
    from robot.console.installed import how_to_install

    if options.dask is None:
        with worker_pool(options.jobs) as local:
            yield local
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise ConfigError(
            "--dask", f"needs Dask; install it in the clone with: {how_to_install('dask')}"
        ) from error
    try:
        client = Client(options.dask, timeout=CONNECT_S)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise ConfigError("--dask", f"nothing answers at {options.dask}: {error}") from error
    with client, client.get_executor() as cluster:  # type: ignore[no-untyped-call]
        yield cluster
