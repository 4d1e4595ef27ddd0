"""Runs on the virtual robot in memory, for tests."""

from collections.abc import Callable
from dataclasses import dataclass, field

from model.errors import RecordError
from model.values.faults import StopReason
from model.values.tick import Intent, Mode, Request, Tick
from robot.config.robot_file import RobotConfig, load_robot
from robot.control.controller import Controller
from robot.run.loop import RunResult, run
from robot.run.rig import Rig
from robot.virtual.open import VirtualSettings, open_in_memory

CONFIG = load_robot()


@dataclass
class Kept:
    """A sink that keeps ticks."""

    ticks: list[Tick] = field(default_factory=list)
    error: RecordError | None = None

    def write(self, tick: Tick) -> None:
        self.ticks.append(tick)


class Told:
    """An operator that does what a function of run time (seconds) and the last tick says."""

    def __init__(self, tell: Callable[[float, Tick | None], Request]) -> None:
        self._tell = tell
        self._begin_ns: int | None = None

    def request(self, tick: Tick | None, t_ns: int) -> Request:
        if self._begin_ns is None:
            self._begin_ns = t_ns
        return self._tell((t_ns - self._begin_ns) * 1e-9, tick)


def wish(
    intent: Intent,
    gait: str = "tripod",
    frequency_hz: float = 0.2,
    steer: float = 0.0,
    reason: StopReason = StopReason.NONE,
) -> Request:
    return Request(intent, gait, frequency_hz, steer, reason)


STOP = wish(Intent.STOP, reason=StopReason.OPERATOR)


def walk_then_stop(seconds: float, **more: object) -> Told:
    return Told(lambda t, _: STOP if t > seconds else wish(Intent.WALK, **more))  # type: ignore[arg-type]


def drive(
    operator: Told,
    *,
    config: RobotConfig = CONFIG,
    armed: bool = True,
    seed: int = 0,
    disturb: Callable[[Rig, Tick], None] | None = None,
    kept: Kept | None = None,
    estimate: bool = False,
) -> tuple[RunResult, list[Tick], Rig]:
    """Run to the end; ``disturb`` is called with the rig after every tick.

    Without the estimator, which is nearly half of a tick, unless a test looks at what it estimates.
    """
    rig = open_in_memory(config, VirtualSettings(seed=seed, armed=armed))
    controller = Controller(config, rig.calibrations, armed=armed, estimate=estimate)
    sink = kept if kept is not None else Kept()

    class Disturber:
        def show(self, tick: Tick) -> None:
            if disturb is not None:
                disturb(rig, tick)

    result = run(rig, controller, operator, sink, Disturber())
    return result, sink.ticks, rig


def modes_of(ticks: list[Tick]) -> list[Mode]:
    """The modes in the order in which they came, repeats left out."""
    order: list[Mode] = []
    for tick in ticks:
        if not order or order[-1] is not tick.mode:
            order.append(tick.mode)
    return order
