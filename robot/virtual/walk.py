"""Walks of the nominal virtual robot in virtual time: as a recording or a log; standing poses."""

from contextlib import closing
from pathlib import Path

from gaits.limits import check_gait
from gaits.standing_poses import StandingPoses
from model.errors import RecordError
from model.values.machine_names import one_joint_a_leg
from model.values.tick import Tick
from record.log.recording import Recording, build_recording
from robot.config.gait_file import with_gait
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.header import controller_metadata, virtual_header, whole_log
from robot.run.operator import Script
from robot.virtual.open import VirtualSettings, open_in_memory
from robot.virtual.rehearsal import Progress, rehearse, silent


class TickList:
    """A sink that keeps every tick."""

    error: RecordError | None = None

    def __init__(self) -> None:
        self.ticks: list[Tick] = []

    def write(self, tick: Tick) -> None:
        """Keep a tick."""
        self.ticks.append(tick)


def walk_in_memory(
    config: RobotConfig, gait: str, *, cycles: float, seed: int = 0, progress: Progress = silent
) -> Recording:
    """Let the virtual robot walk straight ahead in virtual time.

    Args:
        config: Robot file.
        gait: Name of the gait, or a Python file that gives one; walked at its own frequency.
        cycles: Cycles to walk.
        seed: Seed of the plant and its sensors; the same seed gives the same walk.
        progress: Called with the share done, 0 to 1, after each tick.

    Raises:
        ConfigError: The robot has no such gait.
        ModelError: The robot stopped before it was done.
    """
    config, name = with_gait(config, gait)
    sink = TickList()
    with closing(open_in_memory(config, VirtualSettings(seed=seed))) as rig:
        start_ns = rig.clock.now_ns()
        controller = Controller(config, rig.calibrations, armed=True)
        script = Script(name, controller.book.gaits[name].frequency_hz, cycles=cycles)
        rehearse(rig, controller, script, progress, sink)
    header = virtual_header(config, script, seed)
    return build_recording(
        sink.ticks,
        machine=one_joint_a_leg(config.parameters.legs.names),
        start_ns=start_ns,
        config_text=config.text,
        metadata={**header.metadata(), **controller_metadata(controller, rig.calibrations)},
        damage="",
    )


def record_walk(
    config: RobotConfig, path: Path, script: Script, *, seed: int = 0, progress: Progress = silent
) -> None:
    """Record a walk of the virtual robot in virtual time, as ``bigant drive --virtual-time`` walks.

    Args:
        config: Robot file.
        path: The log.
        script: What to walk.
        seed: Of plant and sensors.
        progress: Called with the share done, 0 to 1, after each tick.

    Raises:
        ModelError: The robot stopped before it was done.
        RecordError: The log cannot be written.
    """
    with closing(open_in_memory(config, VirtualSettings(seed=seed))) as rig:
        controller = Controller(config, rig.calibrations, armed=True)
        with whole_log(path, virtual_header(config, script, seed), rig, controller) as log:
            rehearse(rig, controller, script, progress, log)


def record_poses(
    config: RobotConfig,
    path: Path,
    *,
    rounds: int,
    heights: int,
    seed: int,
    progress: Progress = silent,
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
