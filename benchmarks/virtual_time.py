"""What a tick of the virtual robot costs in virtual time: through the bytes with a log, and in a campaign.

Means over the ticks of walking, of processor time; 10 ms divided by one of them is
how many times faster than real time one core is. ``python -m benchmarks.against OTHER --benchmark
virtual_time`` compares two checkouts. Results are written up in docs/performance.md.
"""

import tempfile
import time
from pathlib import Path

from robot.config.robot_file import load_robot
from robot.run.operator import Script
from robot.virtual.twin_run import WalkPlan, make_twin, walk_fast
from robot.virtual.walk import record_walk

SECONDS = 20.0


class Ticks:
    """Counts ticks of walking, and times them."""

    def __init__(self) -> None:
        self.count, self.began_s, self.ended_s = 0, 0.0, 0.0

    def __call__(self, share: float) -> None:
        self.ended_s = time.process_time()
        self.began_s = self.began_s or self.ended_s
        self.count += 1

    @property
    def mean_us(self) -> float:
        """Processor time of a tick between the first and the last."""
        return 1e6 * (self.ended_s - self.began_s) / (self.count - 1)


def main() -> None:
    """Walk both ways, and print what a tick of walking takes."""
    config = load_robot()
    drive, campaign = Ticks(), Ticks()
    with tempfile.TemporaryDirectory() as folder:
        script = Script("tripod", 0.1, duration_s=SECONDS)
        record_walk(config, Path(folder) / "walk.mcap", script, progress=drive)
    walk_fast(config, make_twin(config, (), 1), WalkPlan("tripod", 0.1, SECONDS, 0.0), campaign)
    print(f"{drive.mean_us:8.0f} us  a tick of a drive in virtual time, with its log")
    print(f"{campaign.mean_us:8.0f} us  a tick of a campaign's walk, without bytes and estimator")


if __name__ == "__main__":
    main()
