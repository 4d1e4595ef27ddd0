"""Driving the virtual robot through standing poses, one leg lifted at a time, into a log."""

from collections.abc import Callable
from pathlib import Path

from gaits.limits import check_gait, frequency_limit
from gaits.standing_poses import StandingPoses
from model.errors import ModelError, RecordError
from model.values.faults import StopReason
from model.values.tick import Mode, Tick
from record.log.writer import LogWriter
from robot.cli.drive import VIRTUAL_EPOCH_UNIX_NS
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.control.modes import GaitBook
from robot.run.force_units import UNITS_KEY, units_text
from robot.run.hardware import open_in_memory
from robot.run.loop import run
from robot.run.operator import Interrupts, Script, ScriptedOperator


class _Telling:
    """A sink that also tells how far the run is."""

    def __init__(self, writer: LogWriter, progress: Callable[[float], None]) -> None:
        self._writer = writer
        self._progress = progress

    @property
    def error(self) -> RecordError | None:
        """Why the log can no longer be written."""
        return self._writer.error

    def write(self, tick: Tick) -> None:
        """Write a tick."""
        self._writer.write(tick)
        if tick.mode is Mode.WALK:
            self._progress(min(tick.gait_phase, 1.0))


def record_poses(
    config: RobotConfig,
    path: Path,
    *,
    rounds: int,
    heights: int,
    seed: int,
    progress: Callable[[float], None],
) -> None:
    """Record standing poses of the virtual robot in virtual time.

    Args:
        config: Robot file.
        path: The log.
        rounds: How often each leg is lifted.
        heights: Shaft angles at which it is held in the air, each time.
        seed: Of poses, plant and sensors.
        progress: Told the share done, 0 to 1, after each tick.

    Raises:
        GaitRefused: The servos cannot follow.
        ModelError: The robot stopped before it was done.
        RecordError: The log cannot be written.
    """
    robot = config.parameters
    gait = StandingPoses(robot.legs.count, rounds=rounds, heights=heights, seed=seed)
    check_gait(gait, gait.frequency_hz, robot.servo)
    rig = open_in_memory(config, seed=seed, armed=True, with_forces=True)
    try:
        controller = Controller(config, rig.calibrations, armed=True)
        controller.book = GaitBook(
            {gait.name: gait}, {gait.name: frequency_limit(gait, robot.servo)}
        )
        writer = LogWriter(
            path,
            names=robot.legs.names,
            config_text=config.text,
            metadata={
                "robot": config.name,
                "hardware": "virtual",
                "time": "virtual",
                "gait": gait.name,
                "frequency_hz": f"{gait.frequency_hz:g}",
                "seed": str(seed),
                UNITS_KEY: units_text(robot.legs.names, rig.calibrations),
            },
            start_ns=rig.clock.now_ns(),
            start_unix_ns=VIRTUAL_EPOCH_UNIX_NS,
        )
        try:
            script = Script(gait.name, gait.frequency_hz, steer=0.0, cycles=1.0, duration_s=None)
            sink = _Telling(writer, progress)
            result = run(rig, controller, ScriptedOperator(script, Interrupts()), sink, None)
        finally:
            writer.close()
    finally:
        rig.close()
    if writer.error is not None:
        raise writer.error
    if result.reason is not StopReason.COMPLETED:
        raise ModelError(f"the virtual robot stopped early ({result.reason.name}): {result.detail}")
