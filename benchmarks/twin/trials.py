"""The twin: a 30 s trial without the byte layer, MuJoCo's share of it, and two processes against one.

Times of this process alone are processor time, which other programs on the machine stretch little; a
campaign's is wall time, which they do.
"""

import tempfile
import time
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

from robot.campaign.run import Job, run_jobs
from robot.config.robot_file import load_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.virtual.twin_run import WalkPlan, make_twin, walk_fast

TRIALS = 8


def main() -> None:
    config = load_robot()
    twin = make_twin(config, (), 1)
    walk_fast(config, twin, WalkPlan("tripod", 0.1, 0.1, 0.0), lambda _: None)
    for gait in ("tripod", "metachronal"):
        began, wall = time.process_time(), time.perf_counter()
        walk_fast(config, twin, WalkPlan(gait, 0.1, 30.0, 0.0), lambda _: None)
        used, passed = time.process_time() - began, time.perf_counter() - wall
        print(f"30 s of {gait:12s} {used:5.2f} s of one core, {passed:5.2f} s wall")
    walls = [_campaign(count) for count in (1, 2)]
    print(f"{TRIALS} trials of 10 s: one process {walls[0]:.1f} s, two {walls[1]:.1f} s,", end=" ")
    print(f"{walls[0] / walls[1]:.2f} times as fast")


def _campaign(processes: int) -> float:
    with tempfile.TemporaryDirectory() as folder:
        jobs = [
            Job(
                DEFAULT_ROBOT_FILE,
                (),
                WalkPlan("tripod", 0.1, seconds, 0.0),
                at,
                Path(folder) / f"{at}.parquet",
            )
            for at, seconds in enumerate([0.1] * processes + [10.0] * TRIALS)
        ]
        with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as executor:
            run_jobs(jobs[:processes], executor, lambda _: None)  # imports, machine code
            began = time.perf_counter()
            run_jobs(jobs, executor, lambda _: None)
            return time.perf_counter() - began
