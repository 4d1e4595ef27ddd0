"""The force stream against the virtual unit, in virtual time and over real sockets."""

import select
import socket
import sys
import threading
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.ati.discovery import discover
from drivers.ati.foot_forces import ForceScales, no_forces
from drivers.ati.links import MOST_DATAGRAMS, OLDEST_NS, TcpTextLink, UdpLink, arrival_ns
from drivers.ati.packets import UnitCommand, build_command
from drivers.ati.repair import Repair, Repaired
from drivers.ati.setup import free_console
from drivers.ati.stream import ForceStream
from drivers.clock import MonotonicClock
from model.errors import ForceStreamError
from model.values.arrays import FloatArray
from model.values.faults import FaultKind
from model.values.readings import ForceRecord
from robot.config.robot_file import load_robot
from sim_hw.ati.memory import MemoryDatagramLink, MemoryTextLink
from sim_hw.ati.sockets import WnetSockets
from sim_hw.ati.unit import VirtualWnet
from sim_hw.clock import VirtualClock

SETTINGS = load_robot().force_sensor
NO_NOISE = (0.0,) * 6
SECOND = 1_000_000_000
UNKNOWN = np.full(6, np.nan)  # shaft angles


class SteadyLoad:
    """Leg k carries k + 1 newtons in every axis."""

    def __init__(self) -> None:
        self.force = np.tile(np.arange(1.0, 7.0)[:, None], (1, 6))

    def wrench(self, t_ns: int) -> FloatArray:
        return self.force


class Memory:
    def __init__(self) -> None:
        self.clock = VirtualClock(SECOND)
        self.load = SteadyLoad()
        self.unit = VirtualWnet(self.load, (1, 2, 3, 4, 5, 6), noise=NO_NOISE)
        self.link = MemoryDatagramLink(self.unit, self.clock)
        console = MemoryTextLink(self.unit, self.clock)
        self.stream = ForceStream(self.link, console, SETTINGS, self.clock)

    def wait(self, seconds: float) -> None:
        self.clock.advance(round(seconds * 1e9))


@pytest.fixture
def memory() -> Memory:
    made = Memory()
    made.stream.connect()
    made.stream.read()
    return made


def test_forces_arrive_at_the_rate_asked_for(memory: Memory) -> None:
    memory.wait(1.0)
    records = memory.stream.read()
    assert len(records) == 100
    steps = np.diff([r.device_ticks for r in records])
    assert set(steps.tolist()) == {40, 41}, "1/4096 s at 100 Hz"
    forces = ForceScales(memory.stream.calibrations, SETTINGS).forces(records[-1], UNKNOWN)
    assert forces.force_n == pytest.approx(memory.load.force[:, :3], abs=1e-6)
    assert memory.stream.take_faults() == ()


def test_a_gap_is_counted_and_a_late_record_does_not_move_the_mark(memory: Memory) -> None:
    memory.wait(0.05)
    arrived = memory.link.receive()
    order = [arrived[0], arrived[2], arrived[1], arrived[2], arrived[3], arrived[4]]
    memory.link.receive = lambda: order  # type: ignore[method-assign]
    kept = memory.stream.read()
    assert [r.sequence - kept[0].sequence for r in kept] == [0, 2, 3, 4]
    counters = memory.stream.counters
    assert (counters.missing, counters.late, counters.duplicate) == (1, 1, 1)
    assert [f.kind for f in memory.stream.take_faults()] == [FaultKind.FORCE_GAP]


def test_saturation_is_a_fault_and_no_force(memory: Memory) -> None:
    memory.load.force[2, 0] = 500.0
    memory.wait(0.01)
    record = memory.stream.read()[-1]
    forces = ForceScales(memory.stream.calibrations, SETTINGS).forces(record, UNKNOWN)
    assert np.isnan(forces.force_n[2]).all()
    assert forces.valid.tolist() == [True, True, False, True, True, True]
    faults = memory.stream.take_faults()
    assert [(f.kind, f.source) for f in faults] == [(FaultKind.FORCE_SATURATED, "FL")]


def test_silence_is_a_fault_and_the_stream_is_started_again(memory: Memory) -> None:
    memory.unit.command(build_command(UnitCommand.STOP), memory.clock.now_ns(), 0)
    heard: list[ForceRecord] = []
    for _ in range(100):
        memory.wait(0.01)
        heard += memory.stream.read()
    assert memory.stream.counters.restarts >= 1
    assert len(heard) > 50, "a restart brings it back"
    memory.unit.transmit = False
    kinds = []
    for _ in range(100):
        memory.wait(0.01)
        memory.stream.read()
        kinds += [f.kind for f in memory.stream.take_faults()]
    assert FaultKind.FORCE_SILENT in kinds


def test_a_unit_switched_off_and_on_is_set_up_anew_beside_the_loop() -> None:
    """It has forgotten its rate and sends nothing until its console is asked: start packets fail."""
    made = Memory()
    work: list[Callable[[], None]] = []
    made.unit._sequence = 5000
    stream = ForceStream(
        made.link,
        MemoryTextLink(made.unit, made.clock),
        SETTINGS,
        made.clock,
        reopen=lambda: MemoryTextLink(made.unit, made.clock),
        background=work.append,
    )
    stream.connect()
    stream.read()
    made.unit.rate_hz, made.unit.transmit, made.unit._sequence = 125, False, 0
    for _ in range(150):
        made.wait(0.01)
        assert stream.read() == (), "reads go on, and bring nothing"
    assert len(work) == 1, "one attempt at a time, not in this thread"
    assert stream.counters.repairs == 0
    work.pop()()
    heard: list[ForceRecord] = []
    for _ in range(100):
        made.wait(0.01)
        heard += stream.read()
    assert stream.counters.repairs == 1
    assert made.unit.rate_hz == 100
    assert len(heard) > 80
    assert stream.counters.unit_restarts == 1
    assert stream.counters.missing == 0


def test_attempts_to_reconnect_come_with_pauses_that_grow_to_a_bound() -> None:
    made = Memory()
    tried: list[float] = []

    def nobody() -> MemoryTextLink:
        tried.append(made.clock.now_ns() * 1e-9)
        raise ForceStreamError("no force-torque unit answers")

    stream = ForceStream(
        made.link,
        MemoryTextLink(made.unit, made.clock),
        SETTINGS,
        made.clock,
        reopen=nobody,
        background=lambda work: work(),
    )
    stream.connect()
    made.unit.transmit = False
    for _ in range(3000):
        made.wait(0.05)
        stream.read()
    pauses = np.diff(tried)
    assert 6 <= len(tried) <= 10
    assert pauses[0] < 3
    assert (np.diff(pauses) > -0.2).all()
    assert 29 < pauses.max() < 32
    assert stream.repair_error == "no force-torque unit answers"
    assert 30 < stream.counters.restarts < 60, "start packets: every four seconds at the end"


def test_other_transducers_after_a_silence_are_not_taken() -> None:
    made = Memory()
    stream = ForceStream(
        made.link,
        MemoryTextLink(made.unit, made.clock),
        SETTINGS,
        made.clock,
        reopen=lambda: Swapped(made.unit, made.clock),
        background=lambda work: work(),
    )
    stream.connect()
    stream.read()
    made.unit.transmit = False
    for _ in range(200):
        made.wait(0.02)
        assert stream.read() == ()
    assert "other transducers" in stream.repair_error


class Swapped(MemoryTextLink):
    """A console on which every sensor has another serial number."""

    def read(self, timeout_s: float) -> bytes:
        return super().read(timeout_s).replace(b"VIRTUAL", b"OTHER")


def test_the_units_clock_is_mapped_to_ours(memory: Memory) -> None:
    heard: list[ForceRecord] = []
    for _ in range(1500):
        memory.wait(0.01)
        heard += memory.stream.read()
    estimate = memory.stream.clock_estimate()
    assert estimate is not None
    assert abs(estimate.drift_ppm) < 30, "a tick of 244 us seen over fifteen seconds"
    assert (estimate.steps, estimate.records) == (0, 1501)
    for record in heard[-100:]:
        at_ns = memory.stream.sample_time_ns(record)
        assert at_ns is not None
        assert abs(at_ns - record.t_ns) < 400_000, "no delay: within two ticks of the stamp"


def test_age_is_that_of_each_sensor(memory: Memory) -> None:
    memory.load.force[4, 1] = 1000.0
    memory.wait(0.5)
    memory.stream.read()
    age = memory.stream.age_ns()
    assert age[4] >= 500_000_000
    assert (age[[0, 1, 2, 3, 5]] <= 10_000_000).all()
    assert memory.stream.counters.saturated == 50


def test_stop_is_said_more_than_once() -> None:
    made = Memory()
    sent: list[bytes] = []
    made.link.send = lambda data: sent.append(data)  # type: ignore[method-assign]
    made.stream.stop()
    assert sent == [bytes.fromhex("00 06 00 02 7d 48")] * 3


def test_malformed_datagrams_are_counted(memory: Memory) -> None:
    memory.link.receive = lambda: [(0, b"nonsense")]  # type: ignore[method-assign]
    assert memory.stream.read() == ()
    assert memory.stream.counters.malformed == 1


def test_a_device_that_starts_anew_is_not_a_loss_of_millions(memory: Memory) -> None:
    memory.unit._sequence = 4_000_000_000
    memory.wait(0.05)
    assert len(memory.stream.read()) == 4, "the second one is believed"
    counters = memory.stream.counters
    assert (counters.missing, counters.late, counters.unit_restarts) == (0, 1, 1)


def test_raw_gage_counts_are_refused() -> None:
    made = Memory()
    made.unit.state[3].mult = False
    with pytest.raises(ForceStreamError, match=r"transducer 4 \(HR\) sends raw gage counts"):
        made.stream.connect()


def test_a_unit_that_sends_nothing_is_said() -> None:
    made = Memory()
    made.link.send = lambda data: None  # type: ignore[method-assign]
    with pytest.raises(ForceStreamError, match="takes commands and sends no data"):
        made.stream.connect()


def test_legs_without_transducer_are_nan() -> None:
    made = Memory()
    settings = replace(SETTINGS, transducers=np.array([1, 0, 3, 4, 5, 6]))
    console = MemoryTextLink(made.unit, made.clock)
    stream = ForceStream(made.link, console, settings, made.clock)
    stream.connect()
    made.wait(0.01)
    forces = ForceScales(stream.calibrations, settings).forces(stream.read()[-1], UNKNOWN)
    assert forces.valid.tolist() == [True, False, True, True, True, True]


def test_bias_and_rotation() -> None:
    made = Memory()
    made.stream.connect()
    made.wait(0.02)
    settings = replace(SETTINGS, yaw_rad=np.full(6, np.pi / 2), bias_n=np.full((6, 3), 0.5))
    forces = ForceScales(made.stream.calibrations, settings).forces(made.stream.read()[-1], UNKNOWN)
    assert forces.force_n[1] == pytest.approx([-1.5, 1.5, 1.5])
    nothing = no_forces(len(settings.names))
    assert nothing.t_ns == -1
    assert not nothing.valid.any()


# Real sockets on loopback.


class Loopback:
    def __init__(self) -> None:
        self.unit = VirtualWnet(SteadyLoad(), (1, 2, 3, 4, 5, 6), noise=NO_NOISE)
        self.sockets = WnetSockets(self.unit)
        self.settings = replace(
            SETTINGS,
            address="127.0.0.1",
            udp_port=self.sockets.udp_port,
            console_port=self.sockets.console_port,
            local_port=0,
        )
        self._done = threading.Event()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        clock = MonotonicClock()
        while not self._done.is_set():
            select.select(self.sockets.filenos(), [], [], 0.002)
            self.sockets.service(clock.now_ns())

    def close(self) -> None:
        self._done.set()
        self._thread.join()
        self.sockets.close()


def test_end_to_end_over_sockets(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("drivers.ati.setup.RESET_PAUSE_S", 0.05)
    loopback = Loopback()
    clock = MonotonicClock()
    settings = loopback.settings
    stale = TcpTextLink("127.0.0.1", settings.console_port)  # a dead program holds the console
    try:
        datagrams = UdpLink("127.0.0.1", settings.udp_port, 0, clock)
        free_console(datagrams, clock)
        console = TcpTextLink("127.0.0.1", settings.console_port)
        stream = ForceStream(datagrams, console, settings, clock)
        stream.connect()
        records = stream.read()
        forces = ForceScales(stream.calibrations, settings).forces(records[-1], UNKNOWN)
        assert forces.force_n[5] == pytest.approx([6, 6, 6], abs=1e-6)
        stream.stop()
        stream.close()
        found = discover("127.0.0.1", loopback.sockets.discovery_port)
        assert [u.address for u in found] == ["127.0.0.1"]
    finally:
        stale.close()
        loopback.close()


@pytest.mark.skipif(sys.platform != "linux", reason="the stamp of arrival is Linux'")
def test_a_datagram_is_stamped_when_it_arrives_and_a_flood_comes_in_portions() -> None:
    clock = MonotonicClock()
    unit = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    unit.bind(("127.0.0.1", 0))
    link = UdpLink("127.0.0.1", unit.getsockname()[1], 0, clock)
    try:
        port = link._socket.getsockname()[1]
        for _ in range(100):  # Linux begins to stamp a while after it was asked to
            before_ns = clock.now_ns()
            unit.sendto(b"x", ("127.0.0.1", port))
            sent_ns = clock.now_ns()
            clock.sleep_until_ns(sent_ns + 50_000_000)
            ((t_ns, data),) = link.receive()
            assert data == b"x"
            assert before_ns - 1_000_000 < t_ns
            if t_ns < sent_ns + 40_000_000:
                break
        else:
            pytest.fail("no datagram has the time of its arrival")
        for i in range(MOST_DATAGRAMS + 4):
            unit.sendto(bytes([i % 256]), ("127.0.0.1", port))
        first, rest = link.receive(), link.receive()
        assert (len(first), len(rest)) == (MOST_DATAGRAMS, 4)
        times = [t for t, _ in [*first, *rest]]
        assert times == sorted(times)
    finally:
        unit.close()
        link.close()


@pytest.mark.parametrize("stamp_ns", [None, 1_000_078, 1_000_077 - OLDEST_NS - 1])
def test_without_a_stamp_that_makes_sense_the_time_of_reading_counts(stamp_ns: int | None) -> None:
    assert arrival_ns(stamp_ns, now_ns=77, unix_less_ours_ns=1_000_000) == 77
    assert arrival_ns(1_000_007, now_ns=77, unix_less_ours_ns=1_000_000) == 7


def test_nobody_there_is_said() -> None:
    loopback = Loopback()
    port = loopback.sockets.console_port
    loopback.close()
    with pytest.raises(ForceStreamError, match=r"no force-torque unit answers at 127\.0\.0\.1"):
        TcpTextLink("127.0.0.1", port, timeout_s=1.0)


def test_an_attempt_that_fails_in_any_way_is_not_the_last() -> None:
    def attempt() -> Repaired:
        raise KeyError("T")

    repair = Repair(attempt, lambda work: work())
    for second in range(0, 100, 5):
        repair.begin(second * 10**9)
        assert repair.take(second * 10**9) is None
    assert repair.attempts > 3
    assert repair.last_error == "KeyError: 'T'"
