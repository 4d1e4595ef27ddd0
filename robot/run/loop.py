"""The loop: the only place that waits. Read, step, send, record, once a period.

Deadlines lie on a fixed grid. A tick that comes late by more than a period counts what it missed and
takes the next point of the grid; it never runs a burst to catch up. Torque is always switched off on exit.
"""

import gc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Protocol

from drivers.clock import Clock
from model.errors import RecordError
from model.values.faults import Fault, FaultKind, StopReason
from model.values.tick import Inputs, LoopTiming, Mode, Request, Tick
from robot.control.controller import Controller
from robot.control.safety import Allowed
from robot.control.state import ControllerState
from robot.control.state_bytes import bytes_of_state
from robot.control.stops import cause_words
from robot.run.rig import Reading

# Between two states in a log. One is as large as a second of ticks.
STATE_PERIOD_S = 30
RESTING = (Mode.IDLE, Mode.HOLD, Mode.LIMP)


class Devices(Protocol):
    """The devices of a robot: what ``exchange`` needs of a rig."""

    def read(self) -> Reading:
        """Read everything once."""

    def actuate(self, allowed: Allowed) -> tuple[Fault, ...]:
        """Send what the safety gate let through; return the faults met on the way."""


class Robot(Devices, Protocol):
    """A robot within reach: ``robot.run.rig.Rig``, or its substitute in virtual time."""

    @property
    def clock(self) -> Clock:
        """The clock that all of it lives by."""

    @property
    def torque(self) -> bool:
        """Whether torque has been switched on and not confirmed off."""

    def cut_torque(self) -> bool:
        """Switch all torque off; True if every servo confirmed it."""


class Operator(Protocol):
    """Decides what the robot should do: a script, the keyboard, a replay."""

    def request(self, tick: Tick | None, t_ns: int) -> Request:
        """Return the wish for the tick at ``t_ns``, knowing the tick before."""


class TickSink(Protocol):
    """Where ticks go: the log, in this thread or another."""

    def write(self, tick: Tick) -> None:
        """Take one tick; must not block for long."""

    @property
    def error(self) -> RecordError | None:
        """Why the log can no longer be written, None while it can."""


class StateSink(Protocol):
    """Where states go now and then, so that a replay can begin there: the log."""

    def write_state(self, t_ns: int, index: int, encode: Callable[[], bytes]) -> None:
        """Take the state after a tick, with the number of the next one; must not block for long."""


class Observer(Protocol):
    """Watches the ticks: the live view."""

    def show(self, tick: Tick) -> None:
        """Take one tick; must not block."""


@dataclass(frozen=True, slots=True)
class RunResult:
    """How a run ended.

    Attributes:
        reason: Why it ended.
        ticks: Number of ticks.
        torque_off: True if every servo confirmed that its torque is off.
        last: The last tick, None if there was none.
        detail: What made it end, in words, for a person.
        missed: Periods that never ran, because the tick before took too long.
    """

    reason: StopReason
    ticks: int
    torque_off: bool
    last: Tick | None
    detail: str
    missed: int


def run(
    robot: Robot,
    controller: Controller,
    operator: Operator,
    sink: TickSink | None = None,
    observer: Observer | None = None,
    states: StateSink | None = None,
) -> RunResult:
    """Run until the operator's wish is done or something stops the robot.

    Args:
        robot: The robot, connected.
        controller: The pure step.
        operator: Where wishes come from.
        sink: Where ticks go, if anywhere.
        observer: Who watches, if anyone.
        states: Where the controller's state goes now and then, if anywhere.
    """
    clock = robot.clock
    state_ticks = STATE_PERIOD_S * controller.rate_hz
    period_ns = controller.period_ns
    state = controller.initial()
    tick: Tick | None = None
    pending: tuple[Fault, ...] = ()
    detail = ""
    missed = all_missed = busy_ns = 0
    try:
        deadline_ns = clock.now_ns() + period_ns
        while True:
            clock.sleep_until_ns(deadline_ns)
            start_ns = clock.now_ns()
            timing = LoopTiming(deadline_ns, start_ns - deadline_ns, missed, busy_ns)
            request = operator.request(tick, start_ns)
            had_torque = robot.torque
            wanted = Inputs(None, (), request, timing, None, (*pending, *_log_fault(sink)))
            state, tick, pending = exchange(robot, controller, state, wanted, start_ns)
            switched_on = state.allowed.command.torque and not had_torque
            if sink is not None:
                sink.write(tick)
            if states is not None and state.index % state_ticks == 0:
                states.write_state(tick.t_ns, state.index, partial(bytes_of_state, state))
            if observer is not None:
                observer.show(tick)
            if not detail and tick.stop_reason is not StopReason.NONE:
                detail = cause_words(tick.stop_reason, tick.faults)
            if tick.mode in RESTING and tick.stop_reason is not StopReason.NONE:
                break
            now_ns = clock.now_ns()
            busy_ns = now_ns - start_ns
            # a dozen transactions and more: begin a new grid behind them
            if switched_on or state.allowed.recover:
                deadline_ns = now_ns
            missed = max(0, (now_ns - deadline_ns) // period_ns)
            all_missed += missed
            deadline_ns += period_ns * (1 + missed)
    finally:
        torque_off = robot.cut_torque()
    return RunResult(state.stop_reason, state.index, torque_off, tick, detail, all_missed)


@contextmanager
def no_full_collection() -> Iterator[None]:
    """Keep Python from a full garbage collection meanwhile: one costs several periods."""
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def exchange(
    devices: Devices, controller: Controller, state: ControllerState, wanted: Inputs, t_ns: int
) -> tuple[ControllerState, Tick, tuple[Fault, ...]]:
    """Read, step, send: what happens once a tick, in the loop and in a replay of recorded bytes.

    Args:
        devices: The robot.
        controller: The pure step.
        state: State after the tick before.
        wanted: What is known before the robot is read: the wish, the loop's timing, faults since then.
        t_ns: Time of the tick.

    Returns:
        The new state, the tick, and the faults met while sending, for the next tick.
    """
    reading = devices.read()
    inputs = Inputs(
        reading.servos, reading.forces, wanted.request, wanted.timing, reading.truth,
        (*reading.faults, *wanted.faults), reading.poses, reading.servo_events,
        reading.imu,
    )  # fmt: skip
    state, tick = controller.step(state, inputs, t_ns)
    return state, tick, devices.actuate(state.allowed)


def _log_fault(sink: TickSink | None) -> tuple[Fault, ...]:
    if sink is None or sink.error is None:
        return ()
    return (Fault(FaultKind.LOG_WRITE, "log", str(sink.error)),)
