"""Replay finds what has changed and nothing else: in outputs, in bytes, on the robot again."""

import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from drivers.ati.calibration import Calibration
from model.errors import ConfigError, RecordError
from model.values.arrays import readonly
from model.values.faults import Fault, FaultKind, ServoEvent, StopReason
from model.values.force_calibration import METHODS, ForceCalibration
from model.values.tick import Intent, Mode, Tick
from model.values.wire import Wire
from record.log.blocks.read import read_log
from record.log.reader import LogContents, read_ticks, read_wires
from robot.cli.main import run
from robot.config.robot_file import RobotConfig, parse_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode
from robot.control.controller import Controller
from robot.replay.bus import replay_bus
from robot.replay.drive import RecordedOperator, Wishes, read_wishes
from robot.replay.repeat import turned
from robot.replay.step_through import servo_events
from robot.replay.ticks import replay_log
from robot.requests.single import DriveRequest
from robot.run.header import controller_metadata
from robot.run.operator import Interrupts
from robot.run.rebuilt import rebuild_controller
from robot.virtual.open import open_in_memory
from tests.pace import brisk, usual
from tests.replay.golden import log_of, replayed, write
from tests.robot.bench_runs import bench_run
from tests.robot.bench_runs import changed as changed_file
from tests.robot.browser import without_scripts
from tests.robot.runs import wish

ROOT = Path(__file__).resolve().parents[3]
LOGS = ROOT / "tests" / "record" / "logs"
CONFIG_TEXT = DEFAULT_ROBOT_FILE.read_text(encoding="utf-8")
pytestmark = pytest.mark.usefixtures("usual_pace")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short walk at 20 Hz in virtual time with the bytes of both devices; legs move fast."""
    path = tmp_path_factory.mktemp("walk") / "walk.mcap"
    arguments = "drive --cycles 0.2 --virtual-time --rate-hz 20 --seed 4 --record-bytes --log"
    with brisk():
        assert run([*arguments.split(), str(path)]) == 0
    return path


@pytest.fixture
def walk(recorded: Path) -> Iterator[Path]:
    """The walk, and legs that move as in it."""
    with brisk():
        yield recorded


@cache
def tripod() -> tuple[list[Tick], Controller, tuple[Calibration | None, ...]]:
    """Today's ticks of the golden walk, whatever pace the test has that asks first."""
    with usual():
        return replayed(log_of("tripod"))


def changed(path: Path, change: Callable[[Tick], Tick]) -> Path:
    """The golden tripod walk with other ticks."""
    ticks, controller, calibrations = tripod()
    write(path, map(change, ticks), controller, calibrations)
    return path


def other_load(tick: Tick, *, by_n: float, at: int = 40) -> Tick:
    if tick.index != at:
        return tick
    load_n = tick.contact.support.load_n.copy()
    load_n[3] += by_n
    support = replace(tick.contact.support, load_n=readonly(load_n))
    return replace(tick, contact=replace(tick.contact, support=support))


def test_the_one_number_that_differs_is_named(tmp_path: Path) -> None:
    found = replay_log(changed(tmp_path / "a.mcap", lambda t: other_load(t, by_n=1e-6)))
    assert not found.equal
    assert found.ticks == 90
    assert found.equal_bits == 89
    assert found.first is not None
    assert (found.first.index, found.first.stage, found.first.name) == (40, "support", "load")
    assert (found.first.element, found.first.unit) == ("HR", "N")
    assert float(found.first.recorded) == pytest.approx(float(found.first.replayed) + 1e-6)
    beyond = [(f.name, f.ticks_beyond, f.largest) for f in found.fields if f.ticks_beyond]
    assert [(name, ticks) for name, ticks, _ in beyond] == [("load", 1)]
    assert beyond[0][2] == pytest.approx(1e-6)


@pytest.mark.parametrize(("scale", "equal"), [(1.0, True), (0.01, False), (0.0, False)])
def test_rounding_is_tolerated_as_far_as_asked(tmp_path: Path, scale: float, equal: bool) -> None:
    path = changed(tmp_path / "a.mcap", lambda t: other_load(t, by_n=1e-9))
    found = replay_log(path, scale=scale)
    assert found.equal is equal
    assert found.equal_bits == 89


def test_a_number_against_none_is_a_difference(tmp_path: Path) -> None:
    path = changed(tmp_path / "a.mcap", lambda t: other_load(t, by_n=np.nan))
    found = replay_log(path, scale=1e9)
    assert found.first is not None
    assert found.first.recorded == "absent"


def test_a_decision_has_no_tolerance(tmp_path: Path) -> None:
    path = changed(
        tmp_path / "a.mcap", lambda t: replace(t, mode=Mode.SLOW) if t.index == 70 else t
    )
    found = replay_log(path, scale=1e9)
    assert found.first is not None
    assert (found.first.recorded, found.first.replayed) == ("SLOW", "WALK")


def test_timing_is_not_compared_but_a_gap_ends_the_replay(tmp_path: Path) -> None:
    ticks, controller, calibrations = tripod()
    write(tmp_path / "gap.mcap", [*ticks[:30], *ticks[40:]], controller, calibrations)
    found = replay_log(tmp_path / "gap.mcap")
    assert found.equal
    assert found.ticks == 30
    assert found.notes == (
        "ticks 30 to 39 are missing from the log: only what is before them is replayed",
    )
    write(tmp_path / "late.mcap", ticks[5:], controller, calibrations)
    with pytest.raises(RecordError, match="does not begin with tick 0"):
        replay_log(tmp_path / "late.mcap")


def test_a_run_with_recoveries_replays_from_its_faults_alone(tmp_path: Path) -> None:
    """A log keeps the faults; which servo went down and came back is read from them."""
    brownout = '[[fault]]\nkind = "brownout"\nservo = 4\nstart_s = 2.2\nduration_s = 0.1\n'
    more = "[safety.recovery]\nmost = 2\nafter_restart = true\n[estimator]\nenabled = false\n"
    config = changed_file(more=more)
    path = tmp_path / "recovered.mcap"
    with brisk():
        done = bench_run(brownout, config=config, seconds=5.4)
        calibrations = open_in_memory(config).calibrations
        write(path, done.ticks, Controller(config, calibrations, armed=True), calibrations)
        result = replay_log(path, scale=0.0)
    assert done.first(FaultKind.SERVO_RECOVERED)[0] < 5.0
    assert result.equal
    assert result.equal_bits == result.ticks == len(done.ticks)
    both = [
        Fault(FaultKind.SERVO_DOWN, "HR", ""),
        Fault(FaultKind.SERVO_RECOVERED, "HR", ""),
        Fault(FaultKind.LATE, "loop", ""),
    ]
    names = config.servo_bus.names
    assert servo_events(both, names) == (
        ServoEvent(3, FaultKind.SERVO_RECOVERED),
        ServoEvent(3, FaultKind.SERVO_DOWN),
    ), "it came back before the servos were read"


def test_another_robot_file_shows_what_it_changes() -> None:
    heavy = parse_robot(CONFIG_TEXT.replace("mass = 6.5 ", "mass = 6.6 "))
    found = replay_log(log_of("tripod"), config=heavy)
    stages = {field.stage for field in found.fields if field.ticks_beyond}
    assert stages == {"support", "traction", "dead reckoning", "estimate"}
    assert replay_log(log_of("tripod"), config=parse_robot(CONFIG_TEXT)).equal


@pytest.mark.parametrize("layout", [2, 3])
def test_a_log_of_a_layout_before_is_replayed_in_full(layout: int) -> None:
    """2 had other names for dead reckoning and estimate, 3 no IMU; every output of today is compared.

    The estimator has learned since; all else says the same.
    """
    found = replay_log(LOGS / f"format_{layout}.mcap")
    assert {field.stage for field in found.fields if field.ticks_beyond} == {"estimate"}
    assert found.complete
    assert found.ticks == 62
    assert found.notes == ()


def test_recorded_bytes_go_through_the_drivers(walk: Path) -> None:
    found = replay_bus(walk)
    assert found.equal
    assert found.wire is None
    assert found.ticks == len(list(read_ticks(walk)))
    pieces = read_wires(walk, LogContents())
    assert found.requests == sum(piece.sent for piece in pieces)
    assert {piece.wire for piece in pieces} == set(Wire)
    assert all(field.largest == 0 for field in found.fields)


FAULTY = """
begins = "torque"
[adapter]
latency_timer_s = 0.001
[[fault]]
kind = "bit_flip"
start_s = 0.5
rate = 0.02
[[fault]]
kind = "silent_servo"
servo = 3
start_s = 1.0
duration_s = 0.06
"""


def test_damaged_and_missing_replies_are_replayed_too(tmp_path: Path) -> None:
    scenario, path = tmp_path / "faulty.toml", tmp_path / "faulty.mcap"
    scenario.write_text(FAULTY, encoding="utf-8")
    arguments = "drive --cycles 0.1 --virtual-time --rate-hz 20 --record-bytes --scenario"
    with brisk():
        run([*arguments.split(), str(scenario), "--log", str(path)])
        found = replay_bus(path)
    faulty = [tick for tick in read_ticks(path) if not tick.joints.valid.all()]
    assert len(faulty) > 3
    assert found.wire is None
    assert found.first is None


def test_the_first_other_request_is_shown_with_its_register(walk: Path) -> None:
    other = parse_robot(CONFIG_TEXT.replace("watchdog = 0.24 ", "watchdog = 0.30 "))
    found = replay_bus(walk, config=other)
    assert not found.equal
    assert found.wire is not None
    # write to servo 1, register 98 (bus watchdog), 12 and 15 times 20 ms; then the CRC
    assert found.wire.recorded_hex == "ff ff fd 00 01 06 00 03 62 00 0c 5e e4"
    assert found.wire.sent_hex == "ff ff fd 00 01 06 00 03 62 00 0f 54 e4"
    assert found.wire.differs == "write to id 1: bus_watchdog 12 recorded, 15 now"


@pytest.mark.soak
def test_the_same_wishes_on_the_same_robot_give_the_same_run(
    walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    new = tmp_path / "again.mcap"
    arguments = ["replay", str(walk), "--drive", "--virtual-time", "--seed", "4", "--json"]
    assert run([*arguments, "--log", str(new)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [leg["name"] for leg in found["legs"]] == ["HL", "ML", "FL", "HR", "MR", "FR"]
    for leg in found["legs"]:
        assert [leg["sent_rad"], leg["angle_rad"], *leg["force_n"]] == [0.0] * 5
    assert found["old_way"] == found["new_way"]
    page = Path(found["pictures"][0]).read_text()
    assert without_scripts(page).count("<svg") == 2
    np.testing.assert_array_equal(read_log(walk).angle_rad, read_log(new).angle_rad)


@pytest.mark.soak
def test_another_seed_is_another_measurement(
    walk: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["replay", str(walk), "--drive", "--virtual-time", "--seed", "5", "--json"]
    assert run([*arguments, "--log", str(tmp_path / "b.mcap")]) == 0
    legs = json.loads(capsys.readouterr().out)["legs"]
    assert all(0.01 < leg["force_n"][2] < 0.2 for leg in legs), "noise of the sensors, in newtons"


def test_real_hardware_has_to_be_armed(walk: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["replay", str(walk), "--drive", "--hardware", "/dev/nonexistent"]) == 2
    assert "--armed" in capsys.readouterr().err


def test_real_servos_take_their_limits_from_here_and_not_from_the_log(
    walk: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    foreign = tmp_path / "foreign.toml"
    text = DEFAULT_ROBOT_FILE.read_text().replace("watchdog = 0.24 ", "watchdog = 0.20 ")
    foreign.write_text(text.replace("late_ticks = 20 ", "late_ticks = 900 "))
    log = tmp_path / "foreign.mcap"
    drive = ["drive", "--virtual-time", "--cycles", "0.05", "--robot", str(foreign)]
    with brisk():
        assert run([*drive, "--log", str(log), "--force-unit", "none", "--rate-hz", "50"]) == 0
    asked: list[tuple[RobotConfig, int | None]] = []

    def seen(request: DriveRequest, config: RobotConfig, *_: object) -> ExitCode:
        asked.append((config, request.rate_hz))
        raise ConfigError("the test", "has seen enough")

    monkeypatch.setattr("robot.replay.drive.drive_as", seen)
    again = ["replay", str(log), "--drive", "--hardware", "/dev/ttyUSB9", "--armed"]
    assert run(again) == 2
    ((config, rate_hz),) = asked
    assert (config.loop.late_ticks, config.servo_bus.watchdog_s, rate_hz) == (20, 0.24, 100)
    said = capsys.readouterr().err
    assert "loop.late_ticks is 20" in said
    assert "was 900 in the run" in said


def test_recorded_wishes_come_at_their_times_and_ctrl_c_comes_first(walk: Path) -> None:
    read = read_wishes(walk, LogContents())
    assert [r.intent for r in read.requests] == [Intent.WALK, Intent.STOP]
    wishes = Wishes((0, 10), (wish(Intent.STAND), wish(Intent.WALK)), end_ns=20)
    interrupts = Interrupts()
    operator = RecordedOperator(wishes, interrupts)
    told = [operator.request(None, 1000 + t_ns) for t_ns in (0, 9, 10, 20, 21)]
    assert [t.intent for t in told] == [
        Intent.STAND, Intent.STAND, Intent.WALK, Intent.WALK, Intent.STOP,
    ]  # fmt: skip
    assert told[-1].reason is StopReason.COMPLETED
    interrupts.count = 2
    assert operator.request(None, 1010).intent is Intent.CUT


def test_whole_turns_of_a_servo_are_no_difference() -> None:
    np.testing.assert_allclose(turned(np.array([2 * np.pi + 0.1, -0.2])), [0.1, -0.2], atol=1e-12)


def test_the_command_says_it_and_its_exit_code_too(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(["replay", str(log_of("faults"))]) == 0
    assert "equal: 90 ticks, 8.9 s" in capsys.readouterr().out
    path = changed(tmp_path / "a.mcap", lambda t: other_load(t, by_n=1.0))
    assert run(["replay", str(path)]) == 1
    said = capsys.readouterr().out
    assert "first difference: 4.016 s (tick 40), support, load of HR: recorded" in said
    assert run(["replay", str(path), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["first"]["element"] == "HR"
    assert run(["replay", str(tmp_path / "none.mcap")]) == 4
    assert run(["replay", str(log_of("faults")), "--bus"]) == 4
    assert "--record-bytes" in capsys.readouterr().err
    assert run(["replay", str(log_of("faults")), "--armed"]) == 2


USERS_TEST = """
def test_our_run(assert_replays):
    assert_replays("ours.mcap")

def test_the_changed_one(assert_replays):
    assert_replays("changed.mcap")
"""


def test_a_lab_adds_its_log_in_three_lines(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")  # others' plugins take time
    (tmp_path / "ours.mcap").write_bytes(log_of("tripod").read_bytes())
    changed(tmp_path / "changed.mcap", lambda t: other_load(t, by_n=1.0))
    (tmp_path / "test_ours.py").write_text(USERS_TEST)
    words = ["-q", "-p", "robot.replay.pytest_plugin", "-p", "no:cacheprovider"]
    pytest.main([*words, "--rootdir", str(tmp_path), str(tmp_path)])
    printed = capsys.readouterr().out
    assert "1 failed, 1 passed" in printed
    assert "changed.mcap does not replay equal" in printed
    assert "first difference: 4.016 s (tick 40), support, load of HR" in printed


def test_the_log_s_own_calibration_of_the_sensors_comes_back() -> None:
    names = ("HL", "ML", "FL", "HR", "MR", "FR")
    rng = np.random.default_rng(1)
    in_use = ForceCalibration(
        legs=names,
        serials=("FT1", "", "", "", "", ""),
        unloaded=readonly(rng.normal(size=(6, 6, 3))),
        correction=readonly(rng.normal(size=(6, 6, 6))),
        standard_error=readonly(np.full((6, 6), np.nan)),
        method=METHODS[0],
        date="2026-01-01",
        logs=("a.mcap",),
    )
    plain = parse_robot(CONFIG_TEXT)
    config = replace(plain, force_sensor=replace(plain.force_sensor, calibration=in_use))
    controller = Controller(config, (None,) * 6, armed=True, rate_hz=50)
    metadata = controller_metadata(controller, (None,) * 6)
    rebuilt = rebuild_controller(LogContents(config_text=CONFIG_TEXT, metadata=metadata))
    found = rebuilt.controller.config.force_sensor.calibration
    assert found is not None
    np.testing.assert_array_equal(found.unloaded, in_use.unloaded)
    np.testing.assert_array_equal(found.correction, in_use.correction)
    assert rebuilt.controller.rate_hz == 50
    assert rebuilt.run.notes == ()
