"""A walk of the virtual robot in memory, as a recording: no devices, no files, no waiting."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from model.errors import ModelError, RecordError
from model.values.faults import StopReason
from model.values.tick import Mode, Tick
from record.log.recording import Recording, build_recording
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.hardware import open_in_memory
from robot.run.loop import run
from robot.run.operator import Interrupts, Script, ScriptedOperator

Progress = Callable[[float], None]


class _Keeper:
    """A sink that keeps every tick and tells how far the walk is."""

    error: RecordError | None = None

    def __init__(self, cycles: float, progress: Progress) -> None:
        self.ticks: list[Tick] = []
        self._cycles = cycles
        self._progress = progress
        self._start: float | None = None

    def write(self, tick: Tick) -> None:
        """Keep a tick."""
        self.ticks.append(tick)
        if tick.mode is Mode.WALK:
            self._start = tick.gait_phase if self._start is None else self._start
            self._progress(min((tick.gait_phase - self._start) / self._cycles, 1.0))


def walk_in_memory(
    config: RobotConfig, gait: str, *, cycles: float, seed: int, progress: Progress
) -> Recording:
    """Let the virtual robot walk straight ahead in virtual time.

    Args:
        config: Robot file.
        gait: Name of the gait; walked at the frequency that the robot file gives it.
        cycles: Cycles to walk.
        seed: Seed of the plant and its sensors; the same seed gives the same walk.
        progress: Told the share done, 0 to 1, after each tick.

    Raises:
        ModelError: The robot stopped before it was done.
    """
    rig = open_in_memory(config, seed=seed, armed=True, with_forces=True)
    start_ns = rig.clock.now_ns()
    controller = Controller(config, rig.calibrations, armed=True)
    frequency_hz = controller.book.gaits[gait].frequency_hz
    script = Script(gait, frequency_hz, steer=0.0, cycles=cycles, duration_s=None)
    keeper = _Keeper(cycles, progress)
    result = run(rig, controller, ScriptedOperator(script, Interrupts()), keeper, None)
    if result.reason is not StopReason.COMPLETED:
        raise ModelError(
            f"the virtual {gait} walk stopped early ({result.reason.name}): {result.detail}"
        )
    metadata: Mapping[str, str] = MappingProxyType({
        "robot": config.name,
        "hardware": "virtual",
        "gait": gait,
        "frequency_hz": f"{frequency_hz:g}",
        "seed": str(seed),
    })  # fmt: skip
    return build_recording(
        keeper.ticks,
        names=config.parameters.legs.names,
        start_ns=start_ns,
        config_text=config.text,
        metadata=metadata,
        damage="",
    )
