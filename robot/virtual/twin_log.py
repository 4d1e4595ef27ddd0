"""The log of a twin's walk: what any run of the robot records, and no word of what is wrong with it."""

from collections.abc import Callable
from pathlib import Path

from record.log.versions import software_versions
from record.log.writer import LogWriter
from robot.cli.drive import VIRTUAL_EPOCH_UNIX_NS, software
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.force_units import UNITS_KEY, units_text
from robot.run.header import controller_metadata
from robot.run.rig import Rig
from robot.virtual.twin_run import WalkPlan

BeginLog = Callable[[Rig, Controller], LogWriter]


def twin_log(path: Path, config: RobotConfig, plan: WalkPlan) -> BeginLog:
    """Return what opens the log once robot and controller are there.

    Args:
        path: The log.
        config: Robot file.
        plan: The walk.
    """

    def begin(rig: Rig, controller: Controller) -> LogWriter:
        names = config.parameters.legs.names
        return LogWriter(
            path,
            names=names,
            config_text=config.text,
            metadata={
                "robot": config.name,
                "hardware": "virtual",
                "time": "virtual",
                "gait": plan.gait,
                "frequency_hz": f"{plan.frequency_hz:g}",
                "steer": f"{plan.steer:g}",
                **controller_metadata(controller, rig.calibrations),
                UNITS_KEY: units_text(names, rig.calibrations),
                "software": software(),
                **software_versions(),
            },
            start_ns=rig.clock.now_ns(),
            start_unix_ns=VIRTUAL_EPOCH_UNIX_NS,
        )

    return begin
