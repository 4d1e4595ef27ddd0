"""One run of a virtual robot in virtual time: done as scripted, or an error that says why it stopped."""

from collections.abc import Callable

from model.errors import ModelError, RecordError
from model.values.faults import StopReason
from model.values.tick import Intent, Mode, Tick
from robot.control.controller import Controller
from robot.control.stops import STOPS, cause_words
from robot.run.loop import Robot, TickSink, run
from robot.run.operator import Interrupts, Script, ScriptedOperator

# The robot stands up and takes its start pose in this time, or never.
START_LIMIT_S = 60.0
Progress = Callable[[float], None]


def silent(share: float) -> None:
    """Take the progress, and show nothing."""


def rehearse(
    robot: Robot,
    controller: Controller,
    script: Script,
    progress: Progress = silent,
    *sinks: TickSink,
) -> None:
    """Let a virtual robot do what a script says.

    Args:
        robot: The robot under its virtual clock, armed.
        controller: Its controller.
        script: What to do.
        progress: Called with the share done, 0 to 1, after each tick of walking.
        sinks: Where every tick goes, in this order.

    Raises:
        ModelError: The robot stopped before it was done.
        RecordError: A sink can no longer be written.
    """
    watched = _Watched(script, progress, sinks)
    result = run(robot, controller, ScriptedOperator(script, Interrupts()), watched)
    done = StopReason.COMPLETED if script.end is Intent.STOP else StopReason.EMERGENCY
    if result.reason is not done:
        raise _stopped(script, result.reason, result.detail)


def _stopped(script: Script, reason: StopReason, detail: str) -> ModelError:
    return ModelError(
        f"{script.gait} cannot be walked: the robot would have stopped ({reason.name}): "
        f"{detail or STOPS[reason].words}; choose a lower frequency or smaller effects"
    )


class _Watched:
    """Hands every tick on, tells how far the run is, and ends it at a stop that nobody wished."""

    error: RecordError | None = None

    def __init__(self, script: Script, progress: Progress, sinks: tuple[TickSink, ...]) -> None:
        self._script = script
        self._progress = progress
        self._sinks = sinks
        self._first_ns: int | None = None
        self._walk: Tick | None = None

    def write(self, tick: Tick) -> None:
        for sink in self._sinks:
            sink.write(tick)
            if sink.error is not None:
                raise sink.error
        walking = tick.inputs.request.intent is Intent.WALK
        if walking and tick.stop_reason is not StopReason.NONE:
            detail = cause_words(tick.stop_reason, tick.faults)
            raise _stopped(self._script, tick.stop_reason, detail)
        self._first_ns = tick.t_ns if self._first_ns is None else self._first_ns
        if tick.mode is Mode.WALK:
            self._walk = tick if self._walk is None else self._walk
            self._progress(min(1.0, self._share(self._walk, tick)))
        elif self._walk is None and tick.t_ns - self._first_ns > START_LIMIT_S * 1e9:
            raise ModelError(f"the robot did not come to walk within {START_LIMIT_S:g} s")

    def _share(self, first: Tick, tick: Tick) -> float:
        """Share of the walk that is done."""
        script = self._script
        if script.duration_s is not None:
            return (tick.t_ns - first.t_ns) * 1e-9 / script.duration_s
        return (tick.gait_phase - first.gait_phase) / script.cycles if script.cycles else 0.0
