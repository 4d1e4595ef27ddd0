"""The pre-flight list: each finding, both ways, and the list as a whole on virtual hardware."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import cast

import numpy as np
import pytest

from drivers.ati.console import Console
from drivers.ati.packets import Led, battery_led
from drivers.ati.stream import StreamCounters
from drivers.dynamixel.condition import ServoCondition
from drivers.dynamixel.registers import HardwareError
from model.errors import ConnectionLost, ForceStreamError
from model.values.arrays import FloatArray
from model.values.faults import StopReason
from model.values.readings import ForceRecord
from record.log.header import NOT_INSTALLED
from robot.bringup.preflight.computer import (
    HostSettings,
    disk_finding,
    packages_finding,
    python_finding,
)
from robot.bringup.preflight.finding import CheckVerdict, Finding, lines_of
from robot.bringup.preflight.forces import (
    Received,
    calibration_findings,
    force_findings,
    stream_findings,
)
from robot.bringup.preflight.loop import (
    LoopFigures,
    advice_of,
    loop_finding,
    run_loop,
)
from robot.bringup.preflight.servos import (
    bus_advice,
    condition_findings,
    latency_finding,
    servo_findings,
    wire_ms,
)
from robot.bringup.servo.access import open_port, servo_at
from robot.cli import main as cli
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.virtual.open import VirtualSettings, open_in_memory
from sim_hw.ati.memory import MemoryDatagramLink, MemoryTextLink
from sim_hw.ati.unit import VirtualWnet
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.bus import VirtualServoBus
from tests.drivers.test_servo_bus import Bench, make_bench
from tests.robot.light_servos import LightServos
from tests.robot.sim_serve import ForkedSim

CONFIG = load_robot()
MODELS = dict(zip(CONFIG.servo_bus.names, CONFIG.servo_bus.models, strict=True))
UNIX_OFFSET_NS = 1_700_000_000_000_000_000
PASS, WARN, FAIL, SKIP = CheckVerdict.PASS, CheckVerdict.WARN, CheckVerdict.FAIL, CheckVerdict.SKIP


def by_name(findings: list[Finding]) -> dict[str, Finding]:
    return {finding.name: finding for finding in findings}


def ready(servos: VirtualServoBus) -> None:
    for servo in servos.servos:
        servo.table.set("operating_mode", 4)


def servos(bench: Bench, *, armed: bool = False) -> dict[str, Finding]:
    findings = list(servo_findings(bench.bus, CONFIG, armed=armed))
    bench.bus.close()
    return by_name(findings)


# Servos in memory.


def test_sound_servos_pass_and_nothing_is_written() -> None:
    bench = make_bench(ready)
    found = servos(bench)
    assert {name for name, f in found.items() if f.verdict is not PASS} == {"watchdog"}
    assert found["watchdog"].verdict is SKIP
    assert "--armed" in found["watchdog"].found
    assert "0 of 600 answers lost, 0 damaged" in found["bus traffic"].found
    assert {frame[7] for frame in bench.sent} <= {0x01, 0x02, 0x82}, "ping, read, sync read only"


def test_armed_proves_the_watchdog_and_leaves_torque_off() -> None:
    bench = make_bench(ready)
    found = servos(bench, armed=True)["watchdog"]
    assert found.verdict is PASS
    assert "all 6 tripped in 0.34 s" in found.found
    assert [s.table.get("torque_enable") for s in bench.servos.servos] == [0] * 6


def test_a_watchdog_that_does_not_trip_fails() -> None:
    bench = make_bench(ready)
    bench.servos.servos[3].check = lambda t_ns, motors: None  # type: ignore[method-assign]
    found = servos(bench, armed=True)["watchdog"]
    assert found.verdict is FAIL
    assert "HR" in found.found
    assert [s.table.get("torque_enable") for s in bench.servos.servos] == [0] * 6


def test_a_silent_servo_fails_and_the_others_are_still_looked_at() -> None:
    bench = make_bench(lambda bus: bus.silence(3))
    found = servos(bench, armed=True)
    assert found["servos answer"].verdict is FAIL
    assert "1 of 6 silent: FL (id 3)" in found["servos answer"].found
    assert found["voltage"].verdict is PASS
    assert found["watchdog"].verdict is SKIP, "no torque on a robot that is not whole"
    assert [s.table.get("torque_enable") for s in bench.servos.servos] == [0] * 6


def test_nobody_there() -> None:
    bench = make_bench()
    for servo_id in range(1, 7):
        bench.servos.silence(servo_id)
    found = servos(bench)
    assert list(found) == ["port", "latency timer", "servos answer"]
    assert found["servos answer"].verdict is FAIL


def test_lost_answers_are_counted() -> None:
    bench = make_bench(ready)
    receive = bench.servos.receive
    reads = 0

    def lossy(data: bytes, t_ns: int, baud_rate: int) -> None:
        nonlocal reads
        reads += data[7] == 0x82
        bench.servos.silence(2, on=data[7] == 0x82 and reads % 10 == 0)
        receive(data, t_ns, baud_rate)

    bench.servos.receive = lossy  # type: ignore[method-assign]
    found = servos(bench)["bus traffic"]
    assert found.verdict is FAIL
    assert "10 of 600 answers lost" in found.found


def test_a_cable_pulled_in_the_middle_is_raised_for_the_command_to_say() -> None:
    bench = make_bench(ready)

    def pulled() -> None:
        raise ConnectionLost("gone", port="memory")

    bench.bus._port.clearPort = pulled
    with pytest.raises(ConnectionLost):
        list(servo_findings(bench.bus, CONFIG, armed=False))


SOUND = ServoCondition("HL", 1, 321, 45, 4, 0, 0, 0x34, False, 0, 12.0, 30.0)


@pytest.mark.parametrize(
    ("change", "name", "verdict", "said"),
    [
        (
            {"model": 311},
            "model",
            FAIL,
            "HL (id 1) is an MX-64(2.0) and the robot file says MX-106(2.0)",
        ),
        ({"firmware": 37}, "firmware", FAIL, "no watchdog"),
        ({"firmware": 42}, "firmware", WARN, "42, 45"),
        ({"operating_mode": 3}, "operating mode", WARN, "in mode 3"),
        ({"return_delay": 250}, "return delay", WARN, "waits 500 us"),
        ({"homing_offset": -7}, "homing offset", FAIL, "has -7"),
        ({"voltage_v": 9.9}, "voltage", FAIL, "9.9 V"),
        ({"voltage_v": 11.4}, "voltage", WARN, "11.4 to 12.0 V"),
        ({"temperature_c": 70.0}, "temperature", FAIL, "70 degC (HL (id 1))"),
        ({"temperature_c": 56.0}, "temperature", WARN, "56 degC"),
        ({"hardware_error": HardwareError.OVERLOAD}, "hardware errors", FAIL, "overload"),
        ({"hardware_error": HardwareError.INPUT_VOLTAGE}, "hardware errors", WARN, "voltage"),
        ({"torque": True}, "torque", FAIL, "nobody drives: HL (id 1) holds"),
    ],
)
def test_each_condition_out_of_order(
    change: dict[str, object], name: str, verdict: CheckVerdict, said: str
) -> None:
    other = replace(SOUND, leg="ML", servo_id=2)
    first = replace(SOUND, **change)  # type: ignore[arg-type]
    findings = condition_findings([first, other], CONFIG.limits, MODELS)
    finding = by_name(findings)[name]
    assert finding.verdict is verdict
    assert said in finding.found
    assert finding.advice, "it says what to do"
    assert [f.name for f in findings if f.verdict is not PASS] == [name]


def test_the_latency_timer() -> None:
    assert latency_finding(None).verdict is PASS
    assert latency_finding(1).verdict is PASS
    assert latency_finding(16).verdict is WARN
    assert "latency_timer" in latency_finding(16).advice


def test_what_makes_a_round_trip_long() -> None:
    wire = wire_ms(CONFIG.servo_bus)
    assert wire == pytest.approx(2.24), "20 + 204 bytes at 1 Mbaud"
    assert "latency timer is 16 ms" in bus_advice(16.0, wire, 16.0)
    assert "raise servo_bus.baud_rate" in bus_advice(5.0, wire, 1.0)
    assert "this computer or the adapter is late" in bus_advice(20.0, wire, None)


# The force-torque unit in memory.


class Still:
    def wrench(self, t_ns: int) -> FloatArray:
        return np.zeros((6, 6))


def forces(prepare: Callable[[VirtualWnet], None] = lambda unit: None) -> dict[str, Finding]:
    clock = VirtualClock(1_000_000_000)
    unit = VirtualWnet(Still(), (1, 2, 3, 4, 5, 6))
    prepare(unit)
    findings = force_findings(
        lambda: (MemoryDatagramLink(unit, clock), MemoryTextLink(unit, clock)),
        CONFIG.force_sensor,
        clock,
        seconds=2.0,
        unix_offset_ns=UNIX_OFFSET_NS,
    )
    found = by_name(list(findings))
    assert not unit.streaming, "told to stop, whatever was found"
    return found


def test_a_sound_unit_passes() -> None:
    found = forces()
    assert {f.verdict for f in found.values()} == {PASS}, found
    assert found["packet rate"].found == "100.0 Hz, 100 Hz wanted"
    assert found["force units"].found == "counts: 1000000 per N, 1000000 per N m"
    assert "0 of 2" in found["radio"].found


def test_raw_gage_counts_fail() -> None:
    def gages(unit: VirtualWnet) -> None:
        unit.state[1].mult = False

    found = forces(gages)
    assert found["matrix (MULT)"].verdict is FAIL
    assert "transducer 2 (ML)" in found["matrix (MULT)"].found
    assert found["force stream"].verdict is SKIP


def test_a_console_that_is_dead_is_told_once() -> None:
    class Dead:
        def query(self, command: str) -> str:
            words = "did not answer" if command == "TRANS 1" else "closed its console"
            raise ForceStreamError(f"the unit {words}")

    findings, usable = calibration_findings(cast(Console, Dead()), CONFIG.force_sensor)
    assert not usable
    (only,) = findings
    assert only.found == "the unit did not answer (so no leg could be asked)"


def test_a_transducer_without_power_fails() -> None:
    def off(unit: VirtualWnet) -> None:
        unit.state[4].powered = False

    found = forces(off)["transducers"]
    assert found.verdict is FAIL
    assert "5 (MR)" in found.found


def test_a_unit_that_is_not_there() -> None:
    def nobody() -> tuple[MemoryDatagramLink, MemoryTextLink]:
        raise ForceStreamError("no force-torque unit answers")

    clock = VirtualClock()
    (finding,) = force_findings(
        nobody, CONFIG.force_sensor, clock, seconds=1.0, unix_offset_ns=UNIX_OFFSET_NS
    )
    assert finding.verdict is FAIL
    assert "no force-torque unit answers" in finding.found


def record(i: int, **more: object) -> ForceRecord:
    """Record ``i`` of a stream at 100 Hz whose clock is right."""
    t_ns = i * 10_000_000
    ticks = round((t_ns + UNIX_OFFSET_NS) * 4096e-9) + 2_208_988_800 * 4096
    sound = ForceRecord(
        t_ns=t_ns,
        device_ticks=ticks % 2**32,
        sequence=(i + 2**32 - 5) % 2**32,
        status=np.array([0xA80, 0]),
        battery=7,
        mask=0x3F,
        counts=np.zeros((6, 6), dtype=np.int64),
        present=np.ones(6, dtype=bool),
        saturated=np.zeros(6, dtype=bool),
    )
    return replace(sound, **more)  # type: ignore[arg-type]


def judged(records: list[ForceRecord], **counts: int) -> dict[str, Finding]:
    counters = StreamCounters(records=len(records), **counts)
    return by_name(
        stream_findings(
            Received(tuple(records), counters, 2.0), CONFIG.force_sensor, UNIX_OFFSET_NS
        )
    )


def test_a_sound_stream_over_the_wrap_of_its_numbers() -> None:
    found = judged([record(i) for i in range(200)])
    assert {f.verdict for f in found.values()} == {PASS}, found
    assert found["clock offset"].found.startswith("host minus unit 0.000 s")


@pytest.mark.parametrize(
    ("counts", "verdict"), [({}, PASS), ({"missing": 1}, WARN), ({"missing": 9}, FAIL),
                            ({"malformed": 1}, FAIL)]
)  # fmt: skip
def test_losses(counts: dict[str, int], verdict: CheckVerdict) -> None:
    assert judged([record(i) for i in range(200)], **counts)["radio"].verdict is verdict


def test_another_rate_fails() -> None:
    slow = [record(2 * i, sequence=i) for i in range(100)]
    assert judged(slow)["packet rate"].found == "50.0 Hz, 100 Hz wanted"
    assert judged(slow)["packet rate"].verdict is FAIL


def test_a_clock_that_was_never_set_is_in_order_because_nothing_needs_it() -> None:
    old = [replace(record(i), device_ticks=4096 + 41 * i) for i in range(200)]
    found = judged(old)["clock offset"]
    assert (found.verdict, found.advice) == (PASS, "")
    assert "nothing needs it" in found.found


def test_records_that_come_in_bursts_are_a_warning() -> None:
    late = [record(i, t_ns=i // 20 * 200_000_000) for i in range(200)]
    assert judged(late)["clock offset"].verdict is WARN


def test_one_saturated_record_is_enough() -> None:
    records = [record(i) for i in range(200)]
    records[7] = record(7, saturated=np.arange(6) == 3)
    found = judged(records)["saturation"]
    assert found.verdict is FAIL
    assert "transducer 4 (HR)" in found.found


@pytest.mark.parametrize(
    ("words", "led", "verdict"),
    [
        ((0x00150AAA, 0x001502AA), Led.GREEN, PASS),  # blinking green, as a real unit sent it
        ((0x00150EAA, 0x001502AA), Led.ORANGE, WARN),
        ((0x001506AA, 0x001502AA), Led.RED, FAIL),
        ((0x001502AA, 0x001502AA), Led.OFF, WARN),
    ],
)
def test_the_battery_light_may_blink(
    words: tuple[int, int], led: Led, verdict: CheckVerdict
) -> None:
    assert battery_led(words[0]) is led
    records = [record(i, status=np.array([words[i % 2], 0])) for i in range(20)]
    assert judged(records)["battery light"].verdict is verdict


def test_a_stream_of_one_record_is_none() -> None:
    assert judged([record(1)])["force stream"].verdict is FAIL


# The computer.


def test_the_computer() -> None:
    assert [disk_finding(gb, "runs").verdict for gb in (0.4, 1.0, 50.0)] == [FAIL, WARN, PASS]
    pythons = [("3", "10", "1"), ("3", "11", "0"), ("3", "13", "9"), ("3", "14", "0")]
    assert [python_finding(v).verdict for v in pythons] == [WARN, PASS, PASS, WARN]
    versions = dict.fromkeys(("numpy", "mcap", "dynamixel-sdk", "pyserial", "numba"), "1.0")
    assert packages_finding(versions).verdict is PASS
    assert packages_finding(versions | {"numba": NOT_INSTALLED}).verdict is WARN
    assert packages_finding(versions | {"mcap": NOT_INSTALLED}).verdict is FAIL


# The loop.

QUIET = HostSettings(("performance",), 1.0, -10, False, "1", 5.0, 0.1, 4)
GOOD = LoopFigures(
    10.0, 1000, 0, 0, (0.05, 0.1, 0.2, 0.9), (3.0, 3.1, 3.2, 3.5), 2.0, 2.24, StopReason.COMPLETED
)
LATE = replace(GOOD, late_ms=(0.1, 2.0, 4.0, 9.0), missed=3, late_ticks=8)


def test_a_loop_in_time_needs_nothing_whatever_the_settings() -> None:
    worst = HostSettings(("powersave",), None, 0, False, "", 5.0, 0.1, 4)
    assert advice_of(GOOD, worst) == []
    assert loop_finding(GOOD, worst, 0.005).verdict is PASS


@pytest.mark.parametrize(
    ("figures", "host", "said"),
    [
        (LATE, replace(QUIET, governors=("powersave",)), "governor is powersave"),
        (LATE, replace(QUIET, load=7.5), "system load is 7.5 on 4 cores"),
        (LATE, replace(QUIET, nice=0), "nice -n -10"),
        (LATE, replace(QUIET, isolated=""), "isolcpus"),
        (LATE, QUIET, "switch interval of 5 ms"),
        (replace(GOOD, round_trip_ms=16.0), replace(QUIET, latency_timer_ms=16.0), "set it to 1"),
        (replace(GOOD, round_trip_ms=5.0), QUIET, "raise servo_bus.baud_rate"),
        (replace(GOOD, busy_ms=(7.0, 8.0, 8.5, 9.0)), QUIET, "lower loop.rate"),
    ],
)
def test_advice_follows_the_figures(figures: LoopFigures, host: HostSettings, said: str) -> None:
    assert said in "; ".join(advice_of(figures, host))
    assert loop_finding(figures, host, 0.005).verdict is WARN


def test_a_loop_that_is_late_or_stops_fails() -> None:
    late = replace(LATE, late_ms=(1.0, 5.0, 6.0, 9.0))
    assert loop_finding(late, QUIET, 0.005).verdict is FAIL
    assert loop_finding(replace(LATE, missed=11), QUIET, 0.005).verdict is FAIL
    lost = loop_finding(replace(GOOD, reason=StopReason.SERVO_LOST), QUIET, 0.005)
    assert lost.verdict is FAIL
    assert "stopped (servo lost)" in lost.found


def test_the_real_loop_runs_without_torque() -> None:
    """In virtual time nothing is ever late, and the second is over when its ticks are."""
    rig = open_in_memory(CONFIG, VirtualSettings(armed=False))
    said: list[int] = []
    figures = run_loop(rig, CONFIG, 1.0, said.append)
    rig.close()
    assert 100 <= figures.ticks <= 102
    assert figures.late_ms == (0.0, 0.0, 0.0, 0.0)
    assert (figures.missed, figures.late_ticks) == (0, 0)
    assert figures.reason is StopReason.COMPLETED
    assert figures.round_trip_ms == pytest.approx(2.54), "2.24 ms of bytes, six times 50 us of work"
    assert said[0] == 1
    assert len(said) == 2


# The command.


def test_a_finding_is_a_line_and_what_to_do() -> None:
    lines = lines_of(Finding("voltage", FAIL, "HL has 9.9 V", "charge it"))
    assert lines == ["fail  voltage          HL has 9.9 V", " " * 23 + "-> charge it"]


def test_the_watchdog_is_proven_through_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    servos = LightServos()
    try:
        words = ["check", "--hardware", servos.port, "--force-unit", "none", "--json"]
        cli.run(words)
        listened = json.loads(capsys.readouterr().out)
        cli.run([*words, "--armed"])
        armed = json.loads(capsys.readouterr().out)
        torque = torque_of_all(servos.port)
    finally:
        servos.close()
    verdicts = [{f["name"]: f["verdict"] for f in r["findings"]} for r in (listened, armed)]
    assert [v["watchdog"] for v in verdicts] == ["skip", "pass"]
    assert [v["operating mode"] for v in verdicts] == ["warn", "warn"], "nothing was written"
    assert torque == [0] * 6


@pytest.mark.soak
def test_check_of_served_devices(capsys: pytest.CaptureFixture[str]) -> None:
    """Through the pseudo-terminal and sockets.

    A busy host loses answers and misses ticks, and the list says so; what is judged in real time is
    tested in memory above.
    """
    sim = ForkedSim()
    words = ["check", "--hardware", sim.port, "--force-unit", sim.unit, "--loop", "1", "--json"]
    try:
        code = cli.run([*words, "--armed"])
        result = json.loads(capsys.readouterr().out)
        torque = torque_of_all(sim.port)
    finally:
        sim.close()
    found = {f["name"]: f for f in result["findings"]}
    assert {"disk", "packages", "port", "latency timer", "servos answer", "loop"} <= set(found)
    assert found["port"]["verdict"] == "pass"
    assert found["force unit"]["verdict"] == "pass"
    assert result["fit"] == (code == ExitCode.OK)
    assert result["fit"] == all(f["verdict"] != "fail" for f in result["findings"])
    assert ("loop" in result) != found["loop"]["found"].startswith("not run")
    assert torque == [0] * 6, "whatever went wrong on the way"


def torque_of_all(port_name: str) -> list[int]:
    config = load_robot()
    with open_port(port_name, config.servo_bus.baud_rate) as (port, packets):
        servos = [servo_at(port, packets, int(i), config) for i in config.servo_bus.ids]
        return [servo.read("torque_enable") for servo in servos]


def test_check_of_a_robot_with_a_leg_missing(capsys: pytest.CaptureFixture[str]) -> None:
    servos = LightServos(3)
    try:
        words = ["check", "--hardware", servos.port, "--force-unit", "none"]
        assert cli.run(words) == ExitCode.VERDICT_FAILED
    finally:
        servos.close()
    printed = capsys.readouterr().out
    assert "fail  servos answer    1 of 6 silent: FL (id 3)" in printed
    assert "skip  force unit" in printed
    assert printed.splitlines()[-1].endswith("1 failed, 3 skipped")


def test_check_of_a_port_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["check", "--hardware", "/dev/none", "--force-unit", "none", "--loop", "1"]
    assert cli.run(words) == ExitCode.VERDICT_FAILED
    printed = capsys.readouterr().out
    assert "fail  port             there is no port /dev/none" in printed
    assert "fail  loop             not run: there is no port" in printed


@pytest.mark.parametrize(
    "words", [["--loop", "0"], ["--loop", "x"], ["--force-unit"], ["--hardware"]]
)
def test_wrong_usage(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        cli.run(["check", *words])
    assert caught.value.code == ExitCode.USAGE
    assert "usage: bigant check" in capsys.readouterr().err


def test_a_wrong_unit_is_one_clear_line(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["check", "--hardware", "/dev/none", "--force-unit", "a:b:c"]
    assert cli.run(words) == ExitCode.USAGE
    assert "--force-unit: must be HOST" in capsys.readouterr().err
