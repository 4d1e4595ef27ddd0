"""The log of a twin's walk: what any run of the robot records, and no word of what is wrong with it."""

from collections.abc import Callable
from pathlib import Path

from record.versions import software_versions
from record.writer import LogWriter
from robot.config import RobotConfig
from robot.twin_run import WalkPlan

# Virtual runs happen at this time; a real clock would make every log another one.
EPOCH_UNIX_NS = 1_700_000_000_000_000_000


def twin_log(path: Path, config: RobotConfig, plan: WalkPlan) -> Callable[[int], LogWriter]:
    """Return what opens the log once the run's first time is known.

    Args:
        path: The log.
        config: Robot file.
        plan: The walk.
    """

    def begin(start_ns: int) -> LogWriter:
        return LogWriter(
            path,
            names=config.parameters.legs.names,
            config_text=config.text,
            metadata={
                "robot": config.name,
                "hardware": "virtual",
                "time": "virtual",
                "gait": plan.gait,
                "frequency_hz": f"{plan.frequency_hz:g}",
                "steer": f"{plan.steer:g}",
                **software_versions(),
            },
            start_ns=start_ns,
            start_unix_ns=EPOCH_UNIX_NS,
        )

    return begin
