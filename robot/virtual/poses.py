"""Driving the virtual robot through standing poses, one leg lifted at a time, into a log."""

from contextlib import closing
from pathlib import Path

from gaits.limits import check_gait
from gaits.standing_poses import StandingPoses
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.header import virtual_header, whole_log
from robot.run.operator import Script
from robot.virtual.open import VirtualSettings, open_in_memory
from robot.virtual.rehearsal import Progress, rehearse


def record_poses(
    config: RobotConfig, path: Path, *, rounds: int, heights: int, seed: int, progress: Progress
) -> None:
    """Record standing poses of the virtual robot in virtual time.

    Args:
        config: Robot file.
        path: The log.
        rounds: How often each leg is lifted.
        heights: Shaft angles at which it is held in the air, each time.
        seed: Of poses, plant and sensors.
        progress: Called with the share done, 0 to 1, after each tick.

    Raises:
        GaitRefused: The servos cannot follow.
        ModelError: The robot stopped before it was done.
        RecordError: The log cannot be written.
    """
    robot = config.parameters
    gait = StandingPoses(robot.legs.count, rounds=rounds, heights=heights, seed=seed)
    check_gait(gait, gait.frequency_hz, robot.servo)
    script = Script(gait.name, gait.frequency_hz, cycles=1.0)
    with closing(open_in_memory(config, VirtualSettings(seed=seed))) as rig:
        controller = Controller(config, rig.calibrations, armed=True, gaits=(gait,))
        with whole_log(path, virtual_header(config, script, seed), rig, controller) as log:
            rehearse(rig, controller, script, progress, log)
