"""Operators: who decides what the robot should do, tick by tick.

``ScriptedOperator`` walks a number of cycles or seconds, then stops. ``KeyboardOperator`` is in
``robot.run.teleop``. ``Interrupts`` turns Ctrl-C into a stop on all feet, and a second one into a cut.
"""

import signal
from dataclasses import dataclass
from types import FrameType, TracebackType
from typing import Self

from model.values.faults import StopReason
from model.values.tick import Intent, Mode, Request, Tick


class Interrupts:
    """Counts Ctrl-C, SIGTERM and a hang-up while active; handlers are put back afterwards.

    Until ``begin`` a signal ends the program as usual: nothing counts it while devices are being opened.
    """

    SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)

    def __init__(self) -> None:
        self.count = 0
        self._begun = False
        self._before: list[tuple[signal.Signals, object]] = []

    def _count(self, number: int, frame: FrameType | None) -> None:
        self.count += 1
        if not self._begun:
            before = dict(self._before).get(signal.Signals(number))
            if callable(before):
                before(number, frame)
            raise KeyboardInterrupt

    def begin(self) -> None:
        """From now on somebody looks at ``count`` or ``override``."""
        self._begun = True

    def __enter__(self) -> Self:
        for number in self.SIGNALS:
            self._before.append((number, signal.signal(number, self._count)))
        return self

    def __exit__(
        self,
        _kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        for number, handler in self._before:
            signal.signal(number, handler)  # type: ignore[arg-type]
        self._before.clear()

    def override(self, wish: Request) -> Request:
        """Return the wish, or a stop (one interrupt) or a cut (two) in its place."""
        if self.count == 0:
            return wish
        intent, reason = (
            (Intent.STOP, StopReason.OPERATOR)
            if self.count == 1
            else (Intent.CUT, StopReason.EMERGENCY)
        )
        return Request(intent, wish.gait, wish.frequency_hz, wish.steer, reason)


@dataclass(frozen=True, slots=True)
class Script:
    """What a scripted run is to do.

    Attributes:
        gait: Gait to walk.
        frequency_hz: Cycles a second.
        steer: -1 (right) to 1 (left).
        cycles: Cycles to walk, or None.
        duration_s: Seconds to walk (or to listen), or None; with both None it goes on until stopped.
        listen: True never asks for torque.
        end: STOP comes to rest on all feet when it is done, CUT cuts torque there and then.
    """

    gait: str
    frequency_hz: float
    steer: float = 0.0
    cycles: float | None = None
    duration_s: float | None = None
    listen: bool = False
    end: Intent = Intent.STOP


def listening(duration_s: float | None) -> Script:
    """Return a script that only listens, for so long, or until stopped."""
    return Script(gait="", frequency_hz=0.0, duration_s=duration_s, listen=True)


class ScriptedOperator:
    """Walks a script to its end."""

    def __init__(self, script: Script, interrupts: Interrupts) -> None:
        self._script = script
        self._interrupts = interrupts
        self._start_phase: float | None = None
        self._start_ns: int | None = None
        self._done = False

    def request(self, tick: Tick | None, t_ns: int) -> Request:
        """Return the wish for the tick at ``t_ns``."""
        script = self._script
        intent = Intent.LISTEN if script.listen else Intent.WALK
        reason = StopReason.NONE
        self._done = self._done or self._finished(tick, t_ns)
        if self._done:
            intent, reason = script.end, StopReason.COMPLETED
        wish = Request(intent, script.gait, script.frequency_hz, script.steer, reason)
        return self._interrupts.override(wish)

    def _finished(self, tick: Tick | None, t_ns: int) -> bool:
        script = self._script
        walking = tick is not None and tick.mode is Mode.WALK
        if self._start_ns is None and (walking or script.listen):
            self._start_ns = t_ns
        if self._start_phase is None and walking and tick is not None:
            self._start_phase = tick.gait_phase
        if script.duration_s is not None and self._start_ns is not None:
            return t_ns - self._start_ns >= script.duration_s * 1e9
        if script.cycles is not None and self._start_phase is not None and tick is not None:
            return tick.gait_phase - self._start_phase >= script.cycles
        return False
