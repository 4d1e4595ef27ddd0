"""The live view: one screen on a terminal, plain lines anywhere else.

Nothing is written from the control thread: ``show`` only keeps the newest tick, or a line, and a thread
of its own writes it, so a slow SSH link or Ctrl-S delays the picture and not the robot.
"""

import queue
import sys
import textwrap
import threading
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import TextIO

import numpy as np

from model.values.arrays import FloatArray
from model.values.estimate import Health
from model.values.faults import StopReason
from model.values.legs import JointState
from model.values.machine_names import MachineNames
from model.values.tick import Mode, Tick
from robot.console.screen_fit import Screen
from robot.console.table import number_text
from robot.control.effect_uses import TrueForces, with_true_forces
from robot.view.narrow import narrow_lines

SCREEN_PERIOD_S = 0.25
LINE_PERIOD_NS = 1_000_000_000
MOST_LINES = 1000
CLOSE_S = 2.0  # for a terminal that takes nothing, after Ctrl-S for example
FULL_COLUMNS, LEAST_COLUMNS = 80, 20
MOST_FAULTS = 4
FAULT = "fault"
BOLD, RED, RESET = "\x1b[1m", "\x1b[31m", "\x1b[0m"


def open_view(
    names: MachineNames,
    title: str,
    help_line: str,
    stream: TextIO | None = None,
    true_forces: TrueForces | None = None,
) -> "LineView | ScreenView":
    """Return a screen when the output is a terminal, plain lines otherwise.

    Args:
        names: Names of joints and legs.
        title: First line of the screen.
        help_line: What the keys do.
        stream: Where to draw; standard output by default.
        true_forces: Takes out of readings what the robot file says that the sensors add.
    """
    out = stream if stream is not None else sys.stdout
    if not out.isatty():
        return LineView(out)
    return ScreenView(names, title, help_line, out, true_forces)


class LineView:
    """One plain line a second of run time, and one for every change of mode and new fault.

    A thread prints them; where nobody takes them, later ones are left out.
    """

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._lines: queue.Queue[str | None] = queue.Queue(MOST_LINES)
        self._thread = threading.Thread(target=self._print_forever, daemon=True)
        self._thread.start()
        self._first_ns: int | None = None
        self._next_ns = 0
        self._mode: Mode | None = None
        self._faults: set[tuple[str, str]] = set()

    def show(self, tick: Tick) -> None:
        """Print a line if there is an event or a second has passed."""
        if self._first_ns is None:
            self._first_ns = self._next_ns = tick.t_ns
        for fault in tick.faults:
            key = (fault.kind.name, fault.source)
            if key not in self._faults:
                self._faults.add(key)
                self._put(tick, f"fault {fault.kind.name} {fault.source}: {fault.detail}")
        if tick.mode is not self._mode or tick.t_ns >= self._next_ns:
            self._mode = tick.mode
            self._next_ns = tick.t_ns + LINE_PERIOD_NS
            self._put(tick, _one_line(tick))

    def _put(self, tick: Tick, text: str) -> None:
        seconds = (tick.t_ns - (self._first_ns or 0)) * 1e-9
        with suppress(queue.Full):
            self._lines.put_nowait(f"{seconds:7.2f} s  {text}")

    def _print_forever(self) -> None:
        # `| head` has what it wanted, or the terminal went away; the run goes on
        with suppress(OSError):
            while (line := self._lines.get()) is not None:
                print(line, file=self._out, flush=True)

    def close(self) -> None:
        """Print what is left, if anybody takes it."""
        with suppress(queue.Full):
            self._lines.put_nowait(None)
        self._thread.join(CLOSE_S)


class ScreenView:
    """Redraws one screen from the newest tick, in a thread."""

    def __init__(
        self,
        names: MachineNames,
        title: str,
        help_line: str,
        out: TextIO,
        true_forces: TrueForces | None = None,
    ) -> None:
        self._names = names
        self._title = title
        self._help = help_line
        self._screen = Screen(out)
        self._true_forces = true_forces
        self._newest: Tick | None = None
        self._first_ns: int | None = None
        self._late = self._missed = 0
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._draw_forever, daemon=True)
        self._thread.start()

    def show(self, tick: Tick) -> None:
        """Keep the newest tick."""
        if self._first_ns is None:
            self._first_ns = tick.t_ns
        self._late = max(self._late, tick.inputs.timing.lateness_ns)
        self._missed += tick.inputs.timing.missed
        self._newest = tick

    def _draw_forever(self) -> None:
        while not self._done.wait(SCREEN_PERIOD_S):
            self._draw()
        self._draw()

    def _draw(self) -> None:
        tick = self._newest
        if tick is None:
            return
        tick = with_true_forces(tick, self._true_forces, self._first_ns or 0)
        seconds = (tick.t_ns - (self._first_ns or 0)) * 1e-9
        columns = self._screen.columns
        draw = screen_lines if columns >= FULL_COLUMNS else narrow_lines
        lines = draw(tick, self._names, seconds, self._late, self._missed)
        faults = fault_lines(tick, columns)
        try:
            self._screen.draw(BOLD + self._title + RESET, lines, ["", *faults, "", self._help])
        except OSError:  # the terminal went away; the run goes on without a view
            self._done.set()

    def close(self) -> None:
        """Draw the last state and stop, if the terminal takes it."""
        self._done.set()
        self._thread.join(CLOSE_S)
        if not self._thread.is_alive():
            self._screen.leave()


def screen_lines(
    tick: Tick, names: MachineNames, seconds: float, worst_late_ns: int, missed: int
) -> list[str]:
    """Return what is measured, as lines of plain text; a pure function, so that it can be tested."""
    reason = "" if tick.stop_reason is StopReason.NONE else f"  ({tick.stop_reason.name})"
    timing = tick.inputs.timing
    lines = [
        f"mode {tick.mode.name:<7}{reason}   t {seconds:7.1f} s   {_phase_bar(tick.gait_phase)}",
        f"loop late {timing.lateness_ns * 1e-6:6.2f} ms  worst {worst_late_ns * 1e-6:6.2f} ms  "
        f"missed {missed}",
        "",
    ]
    shafts = "   angle rad   speed rad/s   current A   temp C"
    loads = "   Fz measured N   Fz model N"
    joints = tick.joints
    of_joints = (  # values, digits, width
        (joints.angle_rad, 3, 11),
        (joints.rate_rad_s, 3, 14),
        (joints.current_a, 2, 12),
        (joints.temperature_c, 0, 9),
    )
    of_legs = ((tick.forces.force_n[:, 2], 1, 16), (tick.contact.support.load_n, 1, 13))
    if names.one_joint_a_leg:
        lines += _rows("leg" + shafts + loads, names.legs, (*of_joints, *of_legs))
    else:
        lines += [*_rows("joint" + shafts, names.joints, of_joints), ""]
        lines += _rows("leg" + loads, names.legs, of_legs)
    return [*lines, "", *_velocity_lines(tick), *_pose_lines(tick)]


def _rows(
    head: str, names: tuple[str, ...], columns: Sequence[tuple[FloatArray, int, int]]
) -> Iterator[str]:
    """A heading and lines of numbers; each column with its digits and its width."""
    word, _, rest = head.partition(" ")
    width = max(3, len(word), *map(len, names))
    yield f"{word:<{width}} {rest}"
    for at, name in enumerate(names):
        cells = (number_text(values[at], digits, size) for values, digits, size in columns)
        yield f"{name:<{width}} " + "".join(cells)


def fault_lines(tick: Tick, columns: int = FULL_COLUMNS) -> list[str]:
    """Return the tick's first faults, or that there are none; a long one goes on below itself."""
    lines = []
    for fault in tick.faults[:MOST_FAULTS]:
        words = f"{FAULT} {fault.kind.name} {fault.source}: {fault.detail}"
        first, *more = textwrap.wrap(words, max(LEAST_COLUMNS, columns), subsequent_indent="  ")
        lines += [f"{RED}{FAULT}{RESET}{first.removeprefix(FAULT)}", *more]
    return lines or ["no faults"]


def _velocity_lines(tick: Tick) -> list[str]:
    predicted = _velocity_cells(tick.contact.traction.velocity_B)
    lines = ["body velocity    vx mm/s    vy mm/s   yaw rad/s", "  predicted  " + predicted]
    if tick.estimate is not None:
        lines.append("  estimated  " + _velocity_cells(tick.estimate.velocity_B))
    truth = tick.inputs.truth
    if truth is not None:
        lines.append("  true       " + _velocity_cells(truth.planar_velocity_B))
    return lines


def _velocity_cells(velocity: np.ndarray) -> str:
    vx, vy, yaw_rate = velocity
    return f"{number_text(vx * 1e3, 1, 11)}{number_text(vy * 1e3, 1, 11)}{number_text(yaw_rate, 3, 12)}"


def _pose_lines(tick: Tick) -> list[str]:
    estimate = tick.estimate
    reckoned = "dead reckoning" + _place(tick.dead_reckoning.pose)
    if estimate is None:
        return [reckoned]
    sd = np.sqrt(np.diagonal(estimate.pose_covariance))
    words = estimate.health.value + (f" ({estimate.reason})" if estimate.reason else "")
    return [
        "estimate      " + _place(estimate.pose) + f"   {words}",
        f"  one sd        {sd[0] * 1e3:10.1f} mm {sd[1] * 1e3:12.1f} mm {sd[2]:14.3f} rad",
        reckoned,
    ]


def _place(pose: np.ndarray) -> str:
    x_mm, y_mm = (number_text(value * 1e3, 1, 8) for value in pose[:2])
    return f"  x {x_mm} mm   y {y_mm} mm   yaw {number_text(pose[2], 3, 7)} rad"


def _one_line(tick: Tick) -> str:
    estimate = tick.estimate
    x = (tick.dead_reckoning if estimate is None else estimate).position_m[0] * 1e3
    velocity = tick.contact.traction.velocity_B if estimate is None else estimate.velocity_B
    predicted = velocity[0] * 1e3
    text = f"{tick.mode.name:<7}"
    if np.isfinite(tick.gait_phase):
        text += f" phase {tick.gait_phase:6.2f}"
    text += f"  x {number_text(x, 1, 7)} mm  vx {number_text(predicted, 1)} mm/s"
    truth = tick.inputs.truth
    if truth is not None:
        text += f" (true {number_text(truth.velocity_B[0] * 1e3, 1)})"
    if estimate is not None and estimate.health is not Health.OK:
        text += f"  estimate {estimate.health.value}"
    text += _hottest(tick.joints)
    if tick.stop_reason is not StopReason.NONE:
        text += f"  stopping: {tick.stop_reason.name}"
    return text


def _hottest(joints: JointState) -> str:
    if not joints.valid.any():
        return "  no servo answers"
    if not np.isfinite(joints.temperature_c).any():
        return ""
    return f"  hottest servo {np.nanmax(joints.temperature_c):.0f} C"


def _phase_bar(phase: float) -> str:
    if not np.isfinite(phase):
        return "gait  -"
    width = 20
    done = int((phase % 1.0) * width)
    return f"gait [{'#' * done}{'.' * (width - done)}] {phase:6.2f} cycles"
