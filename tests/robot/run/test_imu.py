"""An IMU in a run: robot file, mounting, the virtual one through its lines, faults that stop nothing."""

import itertools
import time
from dataclasses import replace
from math import isnan, nan
from pathlib import Path

import numpy as np
import pytest
import serial
from scipy.spatial.transform import Rotation

from drivers.lines.imu import parse_imu
from model.errors import ConfigError
from model.values.arrays import FloatArray
from model.values.faults import FaultKind, StopReason
from model.values.readings import ImuRecord
from model.values.tick import Intent, Tick
from record.log.reader import read_ticks
from robot.cli import main as cli
from robot.config.imu import ImuConfig
from robot.config.robot_file import load_robot, parse_robot
from robot.console.exit_codes import ExitCode
from robot.control.controller import Controller
from robot.control.imu import MountedImu
from robot.replay.ticks import replay_log
from robot.run.hardware import imu_place
from robot.run.loop import run
from robot.virtual.open import VirtualSettings, open_in_memory
from sim_hw.assumed import ImuAssumed
from sim_hw.faults.scenario import parse_scenario
from tests.robot.runs import Kept, Told, wish
from tests.robot.sim_serve import ForkedSim

TEXT = load_robot().text
WITH_IMU = TEXT + '\n[imu]\nport = "/dev/ttyIMU"\n'


def test_a_robot_file_has_none_unless_it_says_so() -> None:
    assert not parse_robot(TEXT).imu.any
    config = parse_robot(TEXT + "\n[imu]\nudp_port = 5006\nmounting = [0, 0, 1.5]\n").imu
    assert config.any
    assert config.mounting == (0.0, 0.0, 1.5)
    assert parse_robot(WITH_IMU).imu == ImuConfig(port="/dev/ttyIMU")


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("udp_prot = 5006", "did you mean 'udp_port'"),
        ("udp_port = 70000", "from 0 to 65535"),
        ('udp_port = 5006\nport = "/dev/x"', "exclude each other"),
        ("mounting = [0, 0]", "must have 3 entries"),
        ("mounting = [0, 0, 90.0]", "must be in rad"),
        ("mounting = [1.57, 0, 0]", "upright or upside down"),
        ("stale_after = 0", "above 0"),
        ("baud_rate = 0", "from 1200"),
    ],
)
def test_a_wrong_table_is_refused(lines: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        parse_robot(f"{TEXT}\n[imu]\n{lines}\n")


def test_a_place_on_the_command_line_is_a_udp_port_or_a_serial_port() -> None:
    config = ImuConfig(port="/dev/ttyIMU", mounting=(0.0, 0.0, 1.0))
    assert imu_place("5006", config) == replace(config, udp_port=5006, port="")
    assert imu_place("/dev/ttyUSB1", config) == replace(config, port="/dev/ttyUSB1")
    with pytest.raises(ConfigError, match="1 to 65535"):
        imu_place("70000", config)


@pytest.mark.parametrize(
    "mounting", [(0.0, 0.0, 0.0), (0.0, 0.0, 2.0), (np.pi, 0.0, 0.5), (0.2, -0.1, -1.0)]
)
def test_readings_are_turned_into_the_body_s(mounting: tuple[float, float, float]) -> None:
    """What scipy's rotations say an IMU mounted like this reads gives the body's own angles again."""
    imu = MountedImu(ImuConfig(mounting=mounting))
    mount = Rotation.from_euler("ZYX", mounting[::-1])
    for yaw, pitch, roll in itertools.product((0.0, 2.5), (-0.1, 0.2), (0.0, 0.15)):
        body = Rotation.from_euler("ZYX", (yaw, pitch, roll))
        _, seen_pitch, seen_roll = (body * mount).as_euler("ZYX")
        rate = float(mount.inv().apply([0.0, 0.0, 0.3])[2])
        record = ImuRecord(7, rate, float(seen_roll), float(seen_pitch))
        found = imu.of_body((ImuRecord(6, nan, nan, nan), record), 7)
        assert found[1:] == pytest.approx((roll, pitch), abs=1e-9)
        assert found[0] == pytest.approx(0.3 * mount.as_matrix()[2, 2] ** 2, abs=1e-9)
    assert isnan(imu.of_body((ImuRecord(7, 0.1, nan, nan),), 7)[1])
    assert not isnan(imu.of_body((ImuRecord(7, 0.1, nan, nan),), 7)[0])


def test_an_old_reading_is_not_used() -> None:
    imu = MountedImu(ImuConfig(stale_after=0.2))
    reading = ImuRecord(1_000_000_000, 0.1, 0.0, 0.0)
    assert imu.of_body((reading,), 1_200_000_000)[0] == 0.1
    assert np.isnan(imu.of_body((reading,), 1_200_000_001)).all()
    assert np.isnan(imu.of_body((), 0)).all()


def standing(imu: ImuAssumed, *, text: str = TEXT, seconds: float = 3.0) -> list[Tick]:
    """A run in virtual time that gets up; with the virtual IMU over its lines."""
    config = parse_robot(text)
    rig = open_in_memory(config, VirtualSettings(seed=1, imu=imu))
    controller = Controller(config, rig.calibrations, armed=True, rate_hz=50)
    kept = Kept()
    end = wish(Intent.CUT, reason=StopReason.EMERGENCY)
    result = run(
        rig, controller, Told(lambda t, _: wish(Intent.STAND) if t < seconds else end), kept
    )
    rig.close()
    assert result.reason is StopReason.EMERGENCY, "an IMU never stops the robot"
    return kept.ticks


def kinds(ticks: list[Tick]) -> set[FaultKind]:
    return {fault.kind for tick in ticks for fault in tick.faults}


def test_the_virtual_imu_reaches_the_estimator_and_its_bias_is_known() -> None:
    ticks = standing(ImuAssumed(yaw_rate_bias_rad_s=0.02))
    assert all(tick.inputs.imu for tick in ticks[1:])
    ages = [tick.imu_age_s for tick in ticks[1:]]
    assert max(ages) < 0.02
    last = ticks[-1].estimate
    assert last is not None
    assert abs(last.gyro_bias_rad_s - 0.02) < 3 * last.gyro_bias_sd < 0.002
    assert not kinds(ticks) & {FaultKind.IMU_BAD, FaultKind.IMU_STALE}
    assert isnan(standing(ImuAssumed(silent_after_s=0.0), seconds=0.5)[-1].imu_age_s)


def test_an_imu_mounted_upside_down_tells_the_same() -> None:
    table = "\n[imu]\nudp_port = 5006\nmounting = [3.14159265358979, 0.0, 1.0]\n"
    quiet = ImuAssumed(yaw_rate_noise_rad_s=0.0, tilt_noise_rad=0.0, yaw_rate_bias_rad_s=0.0)
    upright = standing(quiet, seconds=1.0)
    turned = standing(quiet, text=TEXT + table, seconds=1.0)
    mounted = MountedImu(parse_robot(TEXT + table).imu)
    for one, other in zip(upright[1:], turned[1:], strict=True):
        assert abs(abs(other.inputs.imu[-1].roll_rad) - np.pi) < 0.2
        newest = one.inputs.imu[-1]
        expected = (newest.yaw_rate_rad_s, newest.roll_rad, newest.pitch_rad)
        assert mounted.of_body(other.inputs.imu, other.t_ns) == pytest.approx(expected, abs=1e-6)


@pytest.fixture(scope="module")
def undisturbed() -> FloatArray:
    """Where a robot with a sound IMU ends, (2,) [m]."""
    last = standing(ImuAssumed(), seconds=2.0)[-1].estimate
    assert last is not None
    return last.position_m


@pytest.mark.parametrize(
    ("imu", "kind"),
    [
        (ImuAssumed(silent_after_s=0.5, silent_for_s=1.0), FaultKind.IMU_STALE),
        pytest.param(ImuAssumed(silent_after_s=0.0), FaultKind.IMU_STALE, marks=pytest.mark.soak),
        (ImuAssumed(delay_s=0.5), FaultKind.IMU_STALE),
        (ImuAssumed(stuck_after_s=0.8), FaultKind.IMU_BAD),
        (ImuAssumed(damage=0.2), FaultKind.IMU_BAD),
    ],
)
def test_trouble_is_a_fault_and_nothing_else(
    imu: ImuAssumed, kind: FaultKind, undisturbed: FloatArray
) -> None:
    ticks = standing(imu, seconds=2.0)
    assert kind in kinds(ticks)
    last = ticks[-1].estimate
    assert last is not None
    assert last.position_m == pytest.approx(undisturbed, abs=2e-3)


def test_lost_lines_and_a_late_stream_within_the_limit_are_no_fault() -> None:
    ticks = standing(ImuAssumed(loss=0.5, delay_s=0.05), seconds=2.0)
    assert not kinds(ticks) & {FaultKind.IMU_BAD, FaultKind.IMU_STALE}
    ages = np.array([tick.imu_age_s for tick in ticks])
    assert np.nanmin(ages) >= 0.04
    assert 0.1 < np.isnan(ages).mean() < 0.4, "two readings a tick, each lost by half"


def test_a_scenario_may_hold_an_imu() -> None:
    scenario = parse_scenario("[imu]\nyaw_rate_bias_rad_s = 0.01\nstuck_after_s = 3.0\n", [1])
    assert scenario.imu == ImuAssumed(yaw_rate_bias_rad_s=0.01, stuck_after_s=3.0)
    assert parse_scenario("", [1]).imu is None
    with pytest.raises(ConfigError, match=r"imu.noise.*known"):
        parse_scenario("[imu]\nnoise = 1\n", [1])


def drive(*words: str) -> int:
    return cli.run(["drive", "--readonly", "--duration", "2", "--rate-hz", "50", *words])


def test_drive_in_virtual_time_gives_the_same_log_with_an_imu_every_time(tmp_path: Path) -> None:
    robot, scenario = tmp_path / "robot.toml", tmp_path / "scenario.toml"
    robot.write_text(WITH_IMU, encoding="utf-8")
    scenario.write_text("[imu]\nyaw_rate_bias_rad_s = 0.01\nloss = 0.1\n", encoding="utf-8")
    logs = [tmp_path / f"{name}.mcap" for name in ("one", "two", "none")]
    words = ["--robot", str(robot), "--scenario", str(scenario), "--virtual-time", "--log"]
    assert [drive(*words, str(log)) for log in logs[:2]] == [ExitCode.OK] * 2
    assert logs[0].read_bytes() == logs[1].read_bytes()
    assert drive(*words, str(logs[2]), "--imu", "none", "--duration", "0.3") == ExitCode.OK
    assert not any(tick.inputs.imu for tick in read_ticks(logs[2]))
    heard = [tick for tick in read_ticks(logs[0]) if tick.inputs.imu]
    assert len(heard) > 80
    replayed = replay_log(logs[0], scale=0.0)
    assert replayed.equal
    assert replayed.equal_bits == replayed.ticks


@pytest.mark.soak
def test_drive_in_real_time_hears_the_virtual_imu_on_its_pseudo_terminal(tmp_path: Path) -> None:
    robot, log = tmp_path / "robot.toml", tmp_path / "log.mcap"
    robot.write_text(WITH_IMU, encoding="utf-8")
    assert drive("--robot", str(robot), "--log", str(log)) == ExitCode.OK
    ticks = list(read_ticks(log))
    heard = [tick for tick in ticks if tick.inputs.imu]
    assert len(heard) > len(ticks) / 2
    assert abs(np.median([tick.imu_age_s for tick in heard])) < 0.2
    rates = [one.yaw_rate_rad_s for tick in heard for one in tick.inputs.imu]
    assert np.mean(rates) == pytest.approx(ImuAssumed().yaw_rate_bias_rad_s, abs=0.002)


def test_served_devices_have_an_imu_too(tmp_path: Path) -> None:
    robot = tmp_path / "robot.toml"
    robot.write_text(WITH_IMU, encoding="utf-8")
    sim = ForkedSim("--robot", str(robot))
    try:
        assert sim.imu
        with serial.Serial(sim.imu, 115_200, timeout=20.0) as port:
            port.readline()  # may be torn
            reading = parse_imu(port.readline().decode(), 0, 0)
        assert abs(reading.t_ns * 1e-9 - time.time()) < 30
        assert abs(reading.roll_rad) < 0.1
    finally:
        sim.close()


def test_what_cannot_be_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert drive("--virtual-time", "--imu", "5006", "--log", "none") == ExitCode.USAGE
    assert "--imu" in capsys.readouterr().err
