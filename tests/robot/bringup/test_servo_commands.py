"""The servo commands on virtual servos in memory: what they show, write, refuse and verify."""

import io
import json
import os
import tomllib
from pathlib import Path

import pytest

from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.registers import HardwareError
from robot.bringup.servo import access as servo_access
from robot.bringup.servo.watch import watch
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.console.arguments import BAUD_RATES
from robot.console.exit_codes import ExitCode
from robot.console.screen_fit import ESCAPE, HOME
from tests.robot.servo_bench import PORT, Bench

TURN = 4096


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(monkeypatch)


Capture = pytest.CaptureFixture[str]


# scan


def test_scan_lists_model_and_firmware(bench: Bench, capsys: Capture) -> None:
    bench.servo(5).table.set("firmware_version", 42)
    assert bench.devices("--json") == ExitCode.OK
    found = json.loads(capsys.readouterr().out)["servos"]
    assert [(s["baud_rate"], s["servo_id"], s["model"]) for s in found] == [
        (1_000_000, i, 321) for i in range(1, 7)
    ]
    assert [s["firmware"] for s in found] == [45, 45, 45, 45, 45, 42]
    assert sorted(int(p.baudrate) for p in bench.ports) == sorted(BAUD_RATES)


def test_a_scan_takes_less_than_two_seconds_a_baud_rate(bench: Bench) -> None:
    began_ns = bench.clock.now_ns()
    bench.devices()
    assert bench.clock.now_ns() - began_ns < 2e9 * len(BAUD_RATES)


def test_a_scan_that_finds_nobody_says_what_to_check(bench: Bench, capsys: Capture) -> None:
    assert bench.devices("--baud", "57600") == ExitCode.VERDICT_FAILED
    assert (
        "none answered (bench): check power, cable and the port's name" in capsys.readouterr().out
    )


# setup


def fresh_from_the_factory(bench: Bench, index: int) -> None:
    """Id 1, 57600 baud, return delay 250: what a new servo has; here under a free id."""
    table = bench.servo(index).table
    for name, value in (("id", 77), ("baud_rate", 1), ("return_delay_time", 250)):
        table.set(name, value)
    table.set("operating_mode", 3)


def test_setup_shows_the_difference_and_writes_nothing_without_a_yes(
    bench: Bench, capsys: Capture
) -> None:
    fresh_from_the_factory(bench, 2)
    before = bench.servo(2).table.read(0, 64)
    assert bench.command("setup") == ExitCode.VERDICT_FAILED
    printed = capsys.readouterr()
    for words in ("FL  id 77 at 57600 baud: 4 to change", "1 (57600 baud)", "3 (1000000 baud)",
                  "250 (500 us)", "3 (position)", "4 (extended position)",
                  "HL  id 1 at 1000000 baud: as wanted"):  # fmt: skip
        assert words in printed.out
    assert "add --yes" in printed.err
    assert bench.servo(2).table.read(0, 64) == before


def test_setup_makes_the_missing_servo_of_a_new_one(bench: Bench, capsys: Capture) -> None:
    fresh_from_the_factory(bench, 2)
    assert bench.command("setup", "--yes") == ExitCode.OK
    assert "1 servo(s) written and read back, answering at 1000000 baud" in capsys.readouterr().out
    assert bench.values("id") == [1, 2, 3, 4, 5, 6]
    assert bench.values("baud_rate") == [3] * 6
    assert bench.values("return_delay_time") == [0] * 6
    assert bench.values("operating_mode") == [4] * 6
    assert bench.command("setup") == ExitCode.OK, "a second time there is nothing to do"


def test_an_interactive_yes_is_a_yes(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    bench.servo(0).table.set("homing_offset", 100)
    monkeypatch.setattr("sys.stdin.isatty", lambda: True, raising=False)
    answers = iter(["", "n", "yes"])
    monkeypatch.setattr("builtins.input", lambda _: next(answers))
    codes = [bench.command("setup", "--baud", "1000000") for _ in range(2)]
    assert codes == [ExitCode.VERDICT_FAILED] * 2
    assert bench.values("homing_offset")[0] == 100
    assert bench.command("setup", "--baud", "1000000") == ExitCode.OK
    assert bench.values("homing_offset")[0] == 0


def test_setup_refuses_torque(bench: Bench, capsys: Capture) -> None:
    bench.servo(1).table.set("homing_offset", 100)
    bench.servo(1).write(MX_106.table["torque_enable"].address, b"\x01", 0)
    assert bench.command("setup", "--yes") == ExitCode.HARDWARE
    assert "ML (id 2) has its torque on" in capsys.readouterr().err
    assert bench.values("homing_offset")[1] == 100


def test_setup_refuses_two_servos_with_one_id(bench: Bench, capsys: Capture) -> None:
    """Both answer at once: what comes over the wire is neither's answer."""
    bench.servo(0).table.set("homing_offset", 5)
    receive = bench.bus.receive

    def both_answer(data: bytes, t_ns: int, baud_rate: int) -> None:
        if data[4] == 2:
            bench.damage_next_reply()
        receive(data, t_ns, baud_rate)

    bench.bus.receive = both_answer  # type: ignore[method-assign]
    assert bench.command("setup", "--baud", "1000000", "--yes") == ExitCode.HARDWARE
    assert "two servos on bench share id 2: connect one at a time" in capsys.readouterr().err
    assert bench.values("homing_offset")[0] == 5


def test_setup_refuses_one_id_at_two_baud_rates(bench: Bench, capsys: Capture) -> None:
    bench.servo(3).table.set("id", 2)
    bench.servo(3).table.set("baud_rate", 1)
    assert bench.command("setup", "--yes") == ExitCode.HARDWARE
    assert "two servos on bench share id 2" in capsys.readouterr().err


def test_setup_refuses_two_unknown_servos(bench: Bench, capsys: Capture) -> None:
    bench.servo(0).table.set("id", 101)
    bench.servo(1).table.set("id", 102)
    assert bench.command("setup", "--yes") == ExitCode.HARDWARE
    error = capsys.readouterr().err
    assert "knows no servo with id 101, 102: connect one at a time" in error
    assert bench.values("id") == [101, 102, 3, 4, 5, 6]


def test_setup_of_one_servo_by_hand(bench: Bench) -> None:
    words = ("--id", "6", "--new-id", "60", "--new-baud", "3000000", "--baud", "1000000", "--yes")
    assert bench.command("setup", *words) == ExitCode.OK
    assert bench.values("id") == [1, 2, 3, 4, 5, 60]
    assert bench.values("baud_rate") == [3, 3, 3, 3, 3, 5]


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (["--id", "9"], 3, "no servo with id 9"),
        (["--id", "1", "--new-id", "2"], 3, "id 2 is taken"),
        (["--new-id", "9"], 2, "--new-id: is for one servo"),
        (["--baud", "57600"], 3, "no servo answers"),
    ],
)
def test_setup_with_a_mistake(
    bench: Bench, words: list[str], code: int, said: str, capsys: Capture
) -> None:
    assert bench.command("setup", "--yes", *words) == code
    assert said in capsys.readouterr().err


def test_setup_refuses_another_model(bench: Bench, capsys: Capture) -> None:
    bench.servo(4).table.set("model_number", 311)
    assert bench.command("setup", "--yes") == ExitCode.HARDWARE
    assert (
        "(id 5) is an MX-64(2.0) and the robot file says MX-106(2.0): set model in [servo]"
        in capsys.readouterr().err
    )


# backup and restore


def test_a_backup_goes_back_register_by_register(
    bench: Bench, tmp_path: Path, capsys: Capture
) -> None:
    path = tmp_path / "servos.toml"
    bench.servo(2).table.set("position_p_gain", 640)
    assert bench.command("backup", "--out", str(path)) == ExitCode.OK
    kept = tomllib.loads(path.read_text())
    assert [s["id"] for s in kept["servo"]] == [1, 2, 3, 4, 5, 6]
    assert kept["servo"][2]["gains"]["position_p_gain"] == 640
    assert kept["servo"][0]["eeprom"]["shutdown"] == 0x34
    assert (kept["servo"][0]["model"], kept["servo"][0]["firmware"]) == (321, 45)

    saved = [servo.table.read(0, 92) for servo in bench.bus.servos]
    bench.servo(2).table.set("position_p_gain", 850)
    bench.servo(4).table.set("temperature_limit", 60)
    bench.servo(4).table.set("operating_mode", 1)
    assert bench.command("restore", str(path)) == ExitCode.VERDICT_FAILED, "no yes"
    assert bench.values("temperature_limit")[4] == 60
    shown = capsys.readouterr().out
    assert "id 5: 2 differ" in shown
    assert "id 1: as in the file" in shown
    assert bench.command("restore", str(path), "--yes") == ExitCode.OK
    assert [servo.table.read(0, 92) for servo in bench.bus.servos] == saved
    assert bench.command("restore", str(path)) == ExitCode.OK, "nothing is left to do"


def test_a_backup_is_never_overwritten(bench: Bench, tmp_path: Path, capsys: Capture) -> None:
    path = tmp_path / "servos.toml"
    path.write_text("somebody's own")
    words = ("backup", "--out", str(path), "--baud", "1000000")
    assert bench.command(*words) == ExitCode.USAGE
    assert "exists; choose another name" in capsys.readouterr().err
    assert path.read_text() == "somebody's own"


@pytest.mark.parametrize(
    ("change", "code", "said"),
    [
        ("missing", 3, "id 6 of the backup does not answer"),
        ("model", 3, "id 1 is MX-64(2.0) and the backup is of MX-106(2.0)"),
        ("torque", 3, "has its torque on"),
    ],
)
def test_restore_refuses_before_anything_is_written(
    bench: Bench, tmp_path: Path, change: str, code: int, said: str, capsys: Capture
) -> None:
    path = tmp_path / "servos.toml"
    assert bench.command("backup", "--out", str(path), "--baud", "1000000") == ExitCode.OK
    bench.servo(1).table.set("temperature_limit", 60)
    if change == "missing":
        bench.bus.silence(6)
    elif change == "model":
        bench.servo(0).table.set("model_number", 311)
    else:
        bench.servo(4).write(MX_106.table["torque_enable"].address, b"\x01", 0)
    assert bench.command("restore", str(path), "--baud", "1000000", "--yes") == code
    assert said in capsys.readouterr().err
    assert bench.values("temperature_limit")[1] == 60


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('kind = "bigant servo backup"', 'kind = "recipe"', "is no servo backup"),
        ("shutdown = 52", "shutdown = 520", "shutdown"),
        ("shutdown = 52\n", "", "shutdown"),
        ("[servo.eeprom]\nid = 1\n", "[servo.eeprom]\nid = 9\n", "has two different ids"),
        ("version = 1", "version = [", "is not valid TOML"),
    ],
)
def test_a_backup_with_a_mistake_is_refused(
    bench: Bench, tmp_path: Path, old: str, new: str, said: str, capsys: Capture
) -> None:
    path = tmp_path / "servos.toml"
    bench.command("backup", "--out", str(path), "--baud", "1000000")
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    assert cli.run(["servo", "restore", str(path), "--port", PORT, "--yes"]) == ExitCode.USAGE
    assert said in capsys.readouterr().err


# zero


def test_zero_gives_the_line_of_the_robot_file(
    bench: Bench, tmp_path: Path, capsys: Capture
) -> None:
    bench.motors.ticks[:] = [2048, 2000.4, -100, 3 * TURN + 7, 4095, 1]
    path = tmp_path / "zeros.toml"
    assert bench.command("zero", "--write", str(path)) == ExitCode.OK
    line = "servo_zero = [2048, 2000, 3996, 7, 4095, 1]"
    assert line in capsys.readouterr().out.splitlines()
    kept = tomllib.loads(path.read_text())
    assert line in path.read_text()
    assert [(s["leg"], s["id"], s["model"], s["zero_ticks"]) for s in kept["servo"]][2] == (
        "FL",
        3,
        321,
        3996,
    )
    assert cli.run(["servo", "zero", "--port", PORT, "--write", str(path)]) == ExitCode.USAGE
    assert "exists" in capsys.readouterr().err


def test_zero_writes_a_robot_file_that_has_them(
    bench: Bench, tmp_path: Path, capsys: Capture
) -> None:
    bench.motors.ticks[:] = [2048, 2000.4, -100, 3 * TURN + 7, 4095, 1]
    path = tmp_path / "lab.toml"
    assert bench.command("zero", "--robot-out", str(path)) == ExitCode.OK
    assert f"robot file with these zeros: {path}" in capsys.readouterr().out
    before, after = load_robot(), load_robot(path)
    assert after.servo_bus.zeros.tolist() == [2048, 2000, 3996, 7, 4095, 1]
    changed = [
        line
        for line, other in zip(before.text.splitlines(), after.text.splitlines(), strict=True)
        if line != other
    ]
    assert len(changed) == 1  # comments and all else as they were
    words = ["servo", "zero", "--port", PORT, "--robot-out", str(path)]
    assert cli.run(words) == ExitCode.USAGE
    assert "exists; choose another name" in capsys.readouterr().err


def test_zero_is_the_median_of_several(bench: Bench, monkeypatch: pytest.MonkeyPatch,
                                       capsys: Capture) -> None:  # fmt: skip
    jitter = iter([0, 3, -1, 0, 1, -3, 0, 0, 1, -1] * 100)
    measure = bench.motors.advance_to

    def shaky(t_ns: int) -> None:
        measure(t_ns)
        bench.motors.ticks[0] = 1000 + next(jitter)

    monkeypatch.setattr(bench.motors, "advance_to", shaky)
    assert bench.command("zero", "--json") == ExitCode.OK
    first = json.loads(capsys.readouterr().out)["servos"][0]
    assert first["zero_ticks"] == 1000
    assert 0 < first["spread_ticks"] <= 6


def test_zero_reads_again_where_an_answer_is_lost(bench: Bench, capsys: Capture) -> None:
    receive = bench.bus.receive
    reads = 0

    def lossy(data: bytes, t_ns: int, baud_rate: int) -> None:
        nonlocal reads
        reads += data[7] == 0x82
        bench.bus.silence(4, on=data[7] == 0x82 and reads % every == 0)
        receive(data, t_ns, baud_rate)

    bench.bus.receive = lossy  # type: ignore[method-assign]
    every = 3
    assert bench.command("zero") == ExitCode.OK
    every = 1
    assert bench.command("zero") == ExitCode.HARDWARE
    assert "HR did not answer often enough: check its cable" in capsys.readouterr().err


def test_zero_refuses_a_shaft_that_moves(bench: Bench, monkeypatch: pytest.MonkeyPatch,
                                         capsys: Capture) -> None:  # fmt: skip
    def turning(t_ns: int) -> None:
        bench.motors.ticks[3] = t_ns / 1e7

    monkeypatch.setattr(bench.motors, "advance_to", turning)
    assert bench.command("zero") == ExitCode.HARDWARE
    assert "HR moves: hold the shaft still" in capsys.readouterr().err


# watch


def test_watch_shows_every_servo_and_what_the_wire_did(bench: Bench, capsys: Capture) -> None:
    bench.motors.ticks[1] = 2048 + 1024
    bench.motors.temperature_c[4] = 66
    assert bench.command("watch", "--seconds", "2.2") == ExitCode.OK
    printed = capsys.readouterr().out
    tables = [line for line in printed.splitlines() if line.startswith("leg ")]
    assert len(tables) == 4, "at 0, 1, 2 s and at the end"
    assert "\x1b" not in printed
    second = next(line for line in printed.splitlines() if line.startswith("ML "))
    assert second.split()[:4] == ["ML", "2", "3072", "1.571"]
    assert " 66 " in next(line for line in printed.splitlines() if line.startswith("MR "))
    assert "CRC 0  late 0  foreign 0" in printed


def test_watch_decodes_errors_and_survives_a_silent_servo(bench: Bench, capsys: Capture) -> None:
    bench.servo(0).table.set("hardware_error_status", HardwareError.OVERLOAD)
    bench.bus.silence(6)
    assert bench.command("watch", "--seconds", "1", "--json") == ExitCode.HARDWARE
    printed = capsys.readouterr()
    result = json.loads(printed.out)
    assert result["servos"][0]["errors"] == "overload"
    assert result["servos"][5]["valid"] is False
    assert result["servos"][5]["angle_rad"] is None
    assert result["servos"][5]["errors"] == "silent"
    assert result["stats"]["timeouts"] > 0
    assert "FR (id 6) does not answer" in printed.err


def test_watch_counts_damage_and_draws_both_histograms(bench: Bench, capsys: Capture) -> None:
    reads = 0
    receive = bench.bus.receive

    def now_and_then(data: bytes, t_ns: int, baud_rate: int) -> None:
        nonlocal reads
        reads += 1
        if reads in {150, 160}:
            bench.damage_next_reply()
        receive(data, t_ns, baud_rate)

    bench.bus.receive = now_and_then  # type: ignore[method-assign]
    bench.command("watch", "--seconds", "3")
    printed = capsys.readouterr().out
    assert "CRC 2 " in printed.splitlines()[-1]
    assert "#" in printed.split("round trip of complete reads")[1].split("jitter")[0]
    assert "#" in printed.split("jitter")[1]


class Terminal(io.StringIO):
    """A small terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.parametrize(("columns", "rows"), [(80, 24), (60, 12)])
def test_the_screen_of_watch_fits_its_terminal(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, columns: int, rows: int
) -> None:
    size = os.terminal_size((columns, rows))
    monkeypatch.setattr("robot.console.screen_fit.terminal_size", lambda _: size)
    bus, terminal = servo_access.bus_of(PORT, None, load_robot()), Terminal()
    bus.connect()
    watch(bus, terminal, seconds=0.5, rate_hz=50, stopped=lambda: False)
    bus.close()
    drawn = terminal.getvalue().rsplit(HOME, 1)[1].removesuffix("\r\n")
    lines = [ESCAPE.sub("", line) for line in drawn.split("\r\n")]
    assert len(lines) <= rows
    assert max(map(len, lines)) <= columns
    assert lines[1].startswith("leg  id   ticks")
    assert [line[:2] for line in lines[2:8]] == ["HL", "ML", "FL", "HR", "MR", "FR"]
    assert "noise bytes 0" in drawn
    assert lines[-1] == "Ctrl-C ends"


# reboot


def test_reboot_keeps_the_cause_and_says_what_was_lost(bench: Bench, capsys: Capture) -> None:
    bench.motors.ticks[2] = 2048 + 3 * TURN
    bench.servo(2).table.set("hardware_error_status", HardwareError.OVERLOAD)
    assert bench.command("reboot", "--id", "3", "--json") == ExitCode.OK
    (result,) = json.loads(capsys.readouterr().out)
    assert result["cause_names"] == ["overload"]
    assert result["turns_lost"] == 3
    assert (result["ticks_before"], result["ticks_after"]) == (2048 + 3 * TURN, 2048)
    assert result["error_after"] == 0
    assert bench.values("torque_enable")[2] == 0


def test_reboot_of_all_in_words(bench: Bench, capsys: Capture) -> None:
    bench.motors.ticks[5] = 100 - 2 * TURN
    assert bench.command("reboot", "--id", "all") == ExitCode.OK
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 6
    assert "FR (id 6): was no hardware error; -2 turns lost" in lines[5]
    assert "torque off" in lines[5]


def test_reboot_of_a_servo_that_holds_needs_a_yes(bench: Bench, capsys: Capture) -> None:
    bench.servo(0).write(MX_106.table["torque_enable"].address, b"\x01", 0)
    assert bench.command("reboot", "--id", "1") == ExitCode.VERDICT_FAILED
    assert "torque is on: HL (id 1)" in capsys.readouterr().err
    assert bench.values("torque_enable")[0] == 1
    assert bench.command("reboot", "--id", "1", "--yes") == ExitCode.OK
    assert bench.values("torque_enable")[0] == 0


def test_an_error_whose_cause_persists_fails_the_reboot(bench: Bench, capsys: Capture) -> None:
    bench.motors.temperature_c[0] = 90
    assert bench.command("reboot", "--id", "1") == ExitCode.VERDICT_FAILED
    assert "STILL REPORTS overheating: remove the cause" in capsys.readouterr().out


# wrong usage


@pytest.mark.parametrize(
    "words",
    [
        ["setup", "--port", PORT, "--id", "253"],
        ["reboot", "--port", PORT, "--id", "some"],
        ["reboot", "--port", PORT],
        ["watch", "--port", PORT, "--seconds", "0"],
        ["watch", "--port", PORT, "--rate-hz", "9999"],
        ["zero"],
        [],
    ],
)
def test_wrong_usage(words: list[str], capsys: Capture) -> None:
    with pytest.raises(SystemExit) as caught:
        cli.run(["servo", *words])
    assert caught.value.code == ExitCode.USAGE
    assert "usage: bigant servo" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["setup"],
        ["backup", "--out", "never.toml"],
        ["zero"],
        ["watch"],
        ["reboot", "--id", "all"],
    ],
)
def test_a_port_that_is_not_there(words: list[str], capsys: Capture) -> None:
    assert cli.run(["servo", *words, "--port", "/dev/none"]) == ExitCode.HARDWARE
    error = capsys.readouterr().err
    assert "there is no port /dev/none" in error
    assert len(error.splitlines()) == 1
    assert not Path("never.toml").exists()
