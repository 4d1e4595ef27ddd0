"""What a person sees during a run: one screen on a terminal, plain lines anywhere else."""

import io
import os
import re
import threading
from dataclasses import replace

import numpy as np
import pytest

from model.values.faults import Fault, FaultKind, StopReason
from model.values.machine_names import one_joint_a_leg
from model.values.tick import Mode, Tick
from robot.console.screen_fit import ESCAPE, HOME
from robot.view.narrow import narrow_lines
from robot.view.screen import LineView, ScreenView, fault_lines, open_view, screen_lines
from tests.record.ticks import NAMES, PERIOD_NS, make_tick

OWN = one_joint_a_leg(NAMES)


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def expected(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}" if np.isfinite(value) else "-"


def cells_of(tick: Tick, leg: int = 0) -> list[str]:
    lines = screen_lines(tick, OWN, 1.5, 2_000_000, 3)
    return next(line for line in lines if line.startswith(NAMES[leg])).split()


def test_the_screen_shows_every_leg_with_its_numbers() -> None:
    tick = make_tick(5)
    for leg, name in enumerate(NAMES):
        cells = cells_of(tick, leg)
        assert cells[0] == name
        assert cells[1] == expected(tick.joints.angle_rad[leg], 3)
        assert cells[4] == expected(tick.joints.temperature_c[leg], 0)
        assert cells[5] == expected(tick.forces.force_n[leg, 2], 1)


def test_the_screen_says_mode_phase_lateness_and_missed() -> None:
    tick = replace(make_tick(5), mode=Mode.WALK, gait_phase=2.5, stop_reason=StopReason.NONE)
    text = "\n".join(screen_lines(tick, OWN, 1.5, 2_000_000, 3))
    assert "mode WALK" in text
    assert "[##########..........]   2.50 cycles" in text
    assert "worst   2.00 ms  missed 3" in text
    assert re.search(r"predicted +-?\d", text)
    known = "\n".join(screen_lines(make_tick(6), OWN, 1.5, 0, 0))
    assert re.search(r"estimated +-?\d", known)
    assert "estimated" not in text, "there is no estimate in this tick"


def test_what_is_not_known_is_a_dash_and_never_a_zero() -> None:
    tick = make_tick(5)
    silent = replace(tick.joints, angle_rad=np.full(len(NAMES), np.nan))
    assert cells_of(replace(tick, joints=silent))[1] == "-"


def test_faults_are_listed_and_their_absence_is_said() -> None:
    tick = replace(make_tick(5), faults=())
    assert fault_lines(tick) == ["no faults"]
    fault = Fault(FaultKind.SERVO_SILENT, "HL", "no answer")
    (line,) = fault_lines(replace(tick, faults=(fault,)))
    assert "SERVO_SILENT HL: no answer" in line


def test_no_line_is_wider_than_a_terminal() -> None:
    assert max(len(line) for line in screen_lines(make_tick(5), OWN, 1.0, 0, 0)) <= 80


def test_a_phone_gets_the_same_in_40_columns() -> None:
    tick = make_tick(6)
    lines = narrow_lines(tick, OWN, 1234.5, 12_000_000, 3)
    assert max(map(len, lines)) <= 40
    assert len(lines) <= 22, "with its title and keys on a screen of 24 lines"
    text = "\n".join(lines)
    assert "1234.5 s" in text
    assert "missed 3 periods" in text
    for leg, name in enumerate(NAMES):
        cells = next(line for line in lines if line.startswith(name)).split()
        assert cells[1] == expected(tick.joints.angle_rad[leg], 2)
        assert cells[3] == expected(tick.joints.temperature_c[leg], 0)
        assert cells[4] == expected(tick.forces.force_n[leg, 2], 1)
    assert re.search(r"^estimate +-?\d", text, re.MULTILINE)
    none = replace(tick, estimate=None, stop_reason=StopReason.OPERATOR)
    assert "stopping: OPERATOR" in narrow_lines(none, OWN, 1.0, 0, 0)


@pytest.mark.parametrize(
    ("columns", "shape"), [(80, "angle rad"), (79, "leg    rad"), (40, "leg    rad")]
)
def test_the_width_of_the_terminal_chooses_the_screen(
    columns: int, shape: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(os, "get_terminal_size", lambda _fd: os.terminal_size((columns, 24)))
    terminal = Terminal()
    monkeypatch.setattr(terminal, "fileno", lambda: 1)
    view = open_view(OWN, "BigANT", "Ctrl-C: stop", terminal)
    fault = Fault(FaultKind.SERVO_SILENT, "HL", "no answer in any of the last twenty-five ticks")
    view.show(replace(make_tick(6), faults=(fault,)))
    view.close()
    drawn = ESCAPE.sub("", terminal.getvalue()).replace("\r", "")
    assert shape in drawn
    assert max(map(len, drawn.splitlines())) <= columns
    assert "twenty-five ticks" in " ".join(drawn.split()), "a fault is never cut"


def test_a_terminal_gets_a_screen_and_anything_else_lines() -> None:
    assert isinstance(open_view(OWN, "", "", io.StringIO()), LineView)
    terminal = Terminal()
    screen = open_view(OWN, "BigANT virtual", "Ctrl-C: stop", terminal)
    assert isinstance(screen, ScreenView)
    screen.show(make_tick(5))
    screen.close()
    assert "BigANT virtual" in terminal.getvalue()
    assert "Ctrl-C: stop" in terminal.getvalue()


def test_plain_lines_come_once_a_second_and_on_news() -> None:
    out = io.StringIO()
    view = LineView(out)
    first = replace(make_tick(0), mode=Mode.HOLD, faults=(), stop_reason=StopReason.NONE)
    for i in range(250):
        view.show(replace(first, t_ns=first.t_ns + i * PERIOD_NS))
    view.show(replace(first, t_ns=first.t_ns + 250 * PERIOD_NS, mode=Mode.WALK))
    fault = Fault(FaultKind.SERVO_SILENT, "HL", "no answer")
    for i in range(251, 254):  # a fault is news only once
        tick = replace(first, t_ns=first.t_ns + i * PERIOD_NS, mode=Mode.WALK, faults=(fault,))
        view.show(tick)
    view.close()
    lines = out.getvalue().splitlines()
    assert len(lines) == 5
    assert not any("WALK" in line for line in lines[:3])
    assert "WALK" in lines[3]
    assert "fault SERVO_SILENT HL: no answer" in lines[4]


def test_a_terminal_that_goes_away_does_not_stop_the_run() -> None:
    class Gone(Terminal):
        def write(self, _text: str) -> int:
            raise OSError("gone")

    screen = open_view(OWN, "", "", Gone())
    screen.show(make_tick(5))
    screen.close()


@pytest.mark.parametrize("kind", [io.StringIO, Terminal])
def test_a_terminal_that_takes_nothing_does_not_hold_the_loop(
    monkeypatch: pytest.MonkeyPatch, kind: type[io.StringIO]
) -> None:
    go_on = threading.Event()  # Ctrl-Q
    ended: list[bool] = []

    class Stopped(kind):  # type: ignore[misc, valid-type]
        def write(self, _text: str) -> int:
            go_on.wait(600)
            ended.append(True)
            return 0

    monkeypatch.setattr("robot.view.screen.CLOSE_S", 0.1)
    view = open_view(OWN, "", "", Stopped())
    tick = make_tick(0)
    for i in range(3000):
        view.show(replace(tick, t_ns=i * 1_000_000_000))
    view.close()
    assert not ended, "the first write still waits: nobody waited for it"
    go_on.set()


def test_a_screen_shows_no_escapes_of_others() -> None:
    terminal = Terminal()
    screen = open_view(one_joint_a_leg(("F\x1b]0;mine\x07", *NAMES[1:])), "", "", terminal)
    screen.show(make_tick(5))
    screen.close()
    assert "\x1b]0;" not in terminal.getvalue()
    assert "F\\x1b]0;mine\\x07" in terminal.getvalue()


def test_the_screen_is_no_larger_than_the_terminal_and_does_not_scroll(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    faults = tuple(Fault(FaultKind.SERVO_SILENT, "HL", "no answer " * 12) for _ in range(4))
    tick = replace(make_tick(6), faults=faults)
    for columns, rows in ((80, 24), (60, 16), (20, 4)):
        monkeypatch.setattr(
            "robot.console.screen_fit.terminal_size",
            lambda _out, s=(columns, rows): os.terminal_size(s),
        )
        terminal = Terminal()
        screen = open_view(OWN, "BigANT virtual", "a key  " * 20, terminal)
        screen.show(tick)
        screen.close()
        drawn = terminal.getvalue().rsplit(HOME, 1)[1].removesuffix("\r\n")
        lines = [ESCAPE.sub("", line) for line in drawn.split("\r\n")]
        assert len(lines) <= rows
        assert max(map(len, lines)) <= columns
        assert lines[0] == "BigANT virtual"
        assert any("fault SERVO_SILENT" in line for line in lines)
