"""Whole trajectories: running sums against a linear pass, and frames on one and two processes."""

import time
from itertools import accumulate

import numpy as np

from benchmarks.model.processes import ModelProcesses, SharedFrames
from benchmarks.timing import keep, keep_model, repeat, spread
from model.motion.se2 import compose, products
from model.quasistatic.frames import FrictionLaw
from model.systems.disk import disk, random_disk_poses

STEPS = 10_000
FRAMES = 300_000
ROUNDS = 15


def _trajectory() -> None:
    steps = np.random.default_rng(0).normal(scale=1e-3, size=(STEPS, 3))
    linear = repeat(lambda: list(accumulate(steps, compose)), 9)
    sums = repeat(lambda: products(steps), 31)
    worst = np.abs(products(steps)[1:] - np.array(list(accumulate(steps, compose)))).max()
    print(f"trajectory of {STEPS} steps: linear pass {linear}")
    print(f"                             sums        {sums}   {linear.median / sums.median:.0f} x")
    print(f"                             largest difference {worst:.1e}")
    keep_model(sums=sums, product=linear)


def main() -> None:
    """Print the table and keep it for the figure."""
    _trajectory()
    system = disk(6)
    some = random_disk_poses(2000, 6, np.random.default_rng(0))
    repeats = FRAMES // 2000
    room = SharedFrames(FRAMES, 6)
    room.feet.position_m[:] = np.tile(some.position_m, (repeats, 1, 1))
    room.feet.velocity_m_s[:] = np.tile(some.velocity_m_s, (repeats, 1, 1))
    counts = (1, 2)
    overheads = {}
    for law in FrictionLaw:
        times: dict[int, list[float]] = {count: [] for count in counts}
        with ModelProcesses(1) as one, ModelProcesses(2) as two:
            for turn in range(ROUNDS + 1):
                for pool in (one, two):  # in turn, so that both see the same machine
                    began = time.perf_counter_ns()
                    pool.solve(room, system.contact, system.weight_n, law=law)
                    if turn:
                        times[pool.count].append((time.perf_counter_ns() - began) / 1e3)
        base = spread(times[1]).median
        print(f"{law.value}: {FRAMES} frames, time x processes / time on one")
        rows = []
        for count in counts:
            overhead = spread([t * count / base for t in times[count]])
            print(
                f"  {count} processes: {spread(times[count]).median / 1e3:8.1f} ms, overhead "
                f"{overhead.median:.2f} (quartiles {overhead.q25:.2f}, {overhead.q75:.2f})"
            )
            rows.append(overhead)
        overheads[law] = {
            key: [round(getattr(row, key), 4) for row in rows] for key in ("median", "q25", "q75")
        }
    room.close()
    keep(
        processes=list(counts),
        overhead=overheads[FrictionLaw.VISCOUS],
        overhead_coulomb=overheads[FrictionLaw.COULOMB],
    )


if __name__ == "__main__":
    main()
