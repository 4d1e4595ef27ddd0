"""A walk of the virtual robot in memory, as a recording: no devices, no files, no waiting."""

from contextlib import closing

from model.errors import RecordError
from model.values.tick import Tick
from record.log.recording import Recording, build_recording
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.header import controller_metadata, virtual_header
from robot.run.operator import Script
from robot.virtual.open import VirtualSettings, open_in_memory
from robot.virtual.rehearsal import Progress, rehearse


class TickList:
    """A sink that keeps every tick."""

    error: RecordError | None = None

    def __init__(self) -> None:
        self.ticks: list[Tick] = []

    def write(self, tick: Tick) -> None:
        """Keep a tick."""
        self.ticks.append(tick)


def walk_in_memory(
    config: RobotConfig, gait: str, *, cycles: float, seed: int, progress: Progress
) -> Recording:
    """Let the virtual robot walk straight ahead in virtual time.

    Args:
        config: Robot file.
        gait: Name of the gait; walked at the frequency that the robot file gives it.
        cycles: Cycles to walk.
        seed: Seed of the plant and its sensors; the same seed gives the same walk.
        progress: Called with the share done, 0 to 1, after each tick.

    Raises:
        ModelError: The robot stopped before it was done.
    """
    sink = TickList()
    with closing(open_in_memory(config, VirtualSettings(seed=seed))) as rig:
        start_ns = rig.clock.now_ns()
        controller = Controller(config, rig.calibrations, armed=True)
        script = Script(gait, controller.book.gaits[gait].frequency_hz, cycles=cycles)
        rehearse(rig, controller, script, progress, sink)
    header = virtual_header(config, script, seed)
    return build_recording(
        sink.ticks,
        names=config.parameters.legs.names,
        start_ns=start_ns,
        config_text=config.text,
        metadata={**header.metadata(), **controller_metadata(controller, rig.calibrations)},
        damage="",
    )
