"""``bigant check --computer``: every judgement both ways, and the command as a program reads it."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from drivers.dynamixel.scan import SerialPort
from robot.bringup.preflight import doctor
from robot.bringup.preflight.computer import (
    HostSettings,
    Machine,
    cache_finding,
    group_finding,
    host_settings_findings,
    machine_facts,
    machine_findings,
    priority_finding,
    renderer_finding,
)
from robot.bringup.preflight.finding import CheckVerdict, Finding
from robot.cli import main as cli
from robot.console.exit_codes import ExitCode

STUDENT = Machine(
    root=False,
    groups=("student",),
    port_group="dialout",
    rtprio=0,
    nice_floor=20,
    memlock_bytes=8 << 20,
    preempt_rt=False,
    renderers=(),
    gl_choice="",
    display=False,
)


def test_who_may_open_ports() -> None:
    outside = group_finding(STUDENT)
    assert outside.verdict is CheckVerdict.WARN
    assert "usermod -aG dialout" in outside.advice
    assert group_finding(replace(STUDENT, groups=("dialout",))).verdict is CheckVerdict.PASS
    assert group_finding(replace(STUDENT, root=True)).verdict is CheckVerdict.PASS
    assert group_finding(replace(STUDENT, port_group="")).verdict is CheckVerdict.SKIP


def test_who_may_take_priority() -> None:
    assert priority_finding(STUDENT).verdict is CheckVerdict.WARN
    assert "rtprio" in priority_finding(STUDENT).advice
    assert priority_finding(replace(STUDENT, rtprio=50)).verdict is CheckVerdict.PASS
    assert priority_finding(replace(STUDENT, root=True)).verdict is CheckVerdict.PASS


def test_drawing_without_a_display() -> None:
    assert renderer_finding(STUDENT).verdict is CheckVerdict.SKIP
    assert renderer_finding(replace(STUDENT, renderers=("EGL",))).verdict is CheckVerdict.PASS
    asked = renderer_finding(replace(STUDENT, renderers=("EGL",), gl_choice="egl"))
    assert "MUJOCO_GL=egl" in asked.found


def test_settings_that_a_loop_feels() -> None:
    def verdicts(governors: tuple[str, ...], load: float) -> list[CheckVerdict]:
        host = HostSettings(governors, None, 0, False, "", 5.0, load, 2)
        return [f.verdict for f in host_settings_findings(host)]

    ok, warn, skip = CheckVerdict.PASS, CheckVerdict.WARN, CheckVerdict.SKIP
    assert verdicts(("performance",), 1.0) == [ok, ok, ok]
    assert verdicts(("performance", "powersave"), 3.0) == [warn, ok, warn]
    assert verdicts((), 2.0) == [skip, ok, ok]


def test_a_port_that_may_not_be_opened_fails_and_a_slow_timer_warns(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    device = tmp_path / "ttyUSB0"
    device.write_text("", encoding="utf-8")
    timer = tmp_path / "sys" / "ttyUSB0" / "latency_timer"
    timer.parent.mkdir(parents=True)
    timer.write_text("16\n", encoding="utf-8")
    monkeypatch.setattr("drivers.dynamixel.port.USB_SERIAL_DEVICES", tmp_path / "sys")
    ports = (SerialPort(str(device), "0403:6014", "USB <-> Serial Converter"),)

    def look() -> dict[str, Finding]:
        return {f.name.removeprefix(str(device)): f for f in doctor.port_findings(ports)}

    assert look()[""].verdict is CheckVerdict.PASS
    assert look()[" timer"].verdict is CheckVerdict.WARN
    assert look()[" timer"].found == "16 ms"
    timer.write_text("1\n", encoding="utf-8")
    assert look()[" timer"].verdict is CheckVerdict.PASS
    monkeypatch.setattr("os.access", lambda *_: False)
    assert look()[""].verdict is CheckVerdict.FAIL
    plain = SerialPort(str(device), "", "no USB")
    assert [f.verdict for f in doctor.port_findings((plain,))] == [CheckVerdict.SKIP]


def test_a_cache_that_cannot_be_written_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert cache_finding(tmp_path).verdict is CheckVerdict.PASS
    monkeypatch.setattr("os.access", lambda *_: False)
    assert cache_finding(tmp_path).verdict is CheckVerdict.WARN
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "mine"))
    assert str(tmp_path / "mine") in cache_finding().found


def test_this_computer_can_be_looked_at() -> None:
    names = [finding.name for finding in machine_findings(machine_facts())]
    assert names == ["serial group", "priority", "locked memory", "kernel", "OpenGL"]


def test_the_command_lists_everything_and_json_says_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    code = cli.run(["check", "--computer", "--json"])
    result = json.loads(capsys.readouterr().out)
    verdicts = {f["name"]: f["verdict"] for f in result["findings"]}
    assert set(verdicts.values()) <= {"pass", "warn", "fail", "skip"}
    assert {"disk", "Python", "packages", "governor", "compiler cache", "OpenGL"} <= set(verdicts)
    assert result["fit"] == ("fail" not in verdicts.values())
    assert code == (ExitCode.OK if result["fit"] else ExitCode.VERDICT_FAILED)
    for finding in result["findings"]:
        assert finding["found"], finding
        assert finding["advice"] or finding["verdict"] in {"pass", "skip"}, finding
    assert cli.run(["check", "--computer"]) == code
    printed = capsys.readouterr().out
    assert all(name in printed for name in verdicts)
