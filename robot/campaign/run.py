"""The trials of a campaign: which files, and their making by many processes, here or elsewhere.

Every file has the same size and the same time stamp, whatever is wrong in it, and appears when it is
complete: what is there need not be made again.
"""

import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor, Future, as_completed
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from model.errors import BigantError
from record.trial.header_file import header_text
from record.trial.table_writer import write_even_table
from record.trial.trial import Trial
from record.whole_file import whole_file
from robot.campaign.plan import CampaignScenario, draw_cases, reference_seeds
from robot.config.robot_file import load_robot
from robot.virtual.reality_robot import robot_in
from robot.virtual.twin_run import WalkPlan, make_twin, walk_fast
from sim_hw.realities.catalogue import USUAL
from sim_hw.realities.reality import Reality
from sim_hw.twin.effects import TwinEffect

# All files of a campaign say that they were made then.
STAMP_UNIX_S = 1_700_000_000


@dataclass(frozen=True, slots=True)
class Job:
    """One trial to be made: a robot file, what is wrong, the walk, the seed of day and noise, the file.

    ``reality`` is how the robot is built, and ``begin_within_s`` when at the latest its recording begins.
    """

    robot: Path
    effects: tuple[TwinEffect, ...]
    plan: WalkPlan
    seed: int
    out: Path
    reality: Reality = USUAL
    begin_within_s: float = 0.0

    @property
    def begin_s(self) -> float:
        """When the recording begins, drawn."""
        return float(np.random.default_rng([self.seed, 0x62]).uniform(0.0, self.begin_within_s))

    @property
    def done(self) -> bool:
        """Whether it has been made."""
        return self.out.is_file()


@dataclass(frozen=True, slots=True)
class Failure:
    """A trial that could not be made: where, and why."""

    out: Path
    reason: str


def campaign_jobs(scenario: CampaignScenario, entropy: bytes, folder: Path) -> tuple[Job, ...]:
    """Return every trial of a campaign, references first, in an order that says nothing."""
    jobs, begin = [], scenario.begin_within_s
    for robot_at, robot in enumerate(scenario.robots):
        for at, seed in enumerate(reference_seeds(scenario, entropy)):
            name = f"references/robot_{robot_at + 1}_{at + 1}.parquet"
            plan = scenario.references[at]
            out = folder / name
            jobs.append(Job(robot, (), plan, seed + robot_at, out, scenario.reality, begin))
    for case in draw_cases(scenario, entropy):
        for at, (plan, seed) in enumerate(zip(scenario.plans, case.seeds, strict=True)):
            out = folder / "cases" / case.name / f"trial_{at + 1}.parquet"
            robot = scenario.robots[case.robot]
            jobs.append(Job(robot, case.effects, plan, seed, out, scenario.reality, begin))
    return tuple(jobs)


def run_job(job: Job) -> Failure | None:
    """Make one trial; what goes wrong comes back as a value."""
    try:
        config = robot_in(job.reality, load_robot(job.robot))
        twin = make_twin(config, job.effects, job.seed, job.reality)
        plan = replace(job.plan, seconds=job.plan.seconds + job.begin_s)
        trial = walk_fast(config, twin, plan, lambda _: None)
        _write(_last(trial, job.plan.seconds), job.out)
    except (BigantError, OSError) as error:
        return Failure(job.out, str(error))
    return None


def _last(trial: Trial, seconds: float) -> Trial:
    """Return the end of a trial, as many rows whenever it begins."""
    rows = round(seconds * trial.header.sample_rate_hz)
    return trial.rows(np.arange(len(trial.time_s)) >= len(trial.time_s) - rows)


def _write(trial: Trial, out: Path) -> None:
    """Write a trial so that nothing about its file depends on what is in it."""
    out.parent.mkdir(parents=True, exist_ok=True)
    header = trial.header
    for path, text in (
        (out.parent / header.robot_file, header.robot_text),
        (out.with_suffix(".toml"), header_text(header)),
    ):
        with _stamped(path) as part:
            part.write_bytes(text.encode())
    with _stamped(out) as part:
        write_even_table(part, trial.columns())


@contextmanager
def _stamped(path: Path) -> Iterator[Path]:
    """Yield the name to write to; the file appears whole, with the time stamp of all of them."""
    with whole_file(path) as part:
        yield part
        os.utime(part, (STAMP_UNIX_S, STAMP_UNIX_S))


def run_jobs(
    jobs: Sequence[Job], executor: Executor, tell: Callable[[int], None]
) -> tuple[Failure, ...]:
    """Make the trials that are not there yet; ``tell`` is told how many there are, now and then.

    The processes of the executor, here or elsewhere, must see the same folders.
    """
    todo = [job for job in jobs if not job.done]
    ready = len(jobs) - len(todo)
    waiting: list[Future[Failure | None]] = [executor.submit(run_job, job) for job in todo]
    failures = []
    try:
        for future in as_completed(waiting):
            if (failure := future.result()) is not None:
                failures.append(failure)
            ready += 1
            tell(ready)
    except BaseException:
        for future in waiting:
            future.cancel()
        raise
    return tuple(sorted(failures, key=lambda failure: failure.out))


def drop_cases(failures: Sequence[Failure]) -> int:
    """Remove every case with a failed trial: an incomplete one gives itself away. Return how many."""
    folders = {failure.out.parent for failure in failures}
    for folder in folders:
        shutil.rmtree(folder, ignore_errors=True)
    return len(folders)


def level_stamps(folder: Path) -> None:
    """Give all folders of a campaign one time stamp."""
    for path in sorted(folder.rglob("*"), reverse=True):
        if path.is_dir():
            os.utime(path, (STAMP_UNIX_S, STAMP_UNIX_S))
