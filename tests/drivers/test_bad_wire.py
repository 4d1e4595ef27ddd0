"""Torque on and off over a wire that loses requests, brings them late and destroys what overlaps."""

import heapq
from collections.abc import Callable

import numpy as np
import pytest

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.frames import BROADCAST_ID, Frame, FrameParser, Instruction
from model.errors import BusError
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.port import MemoryPort
from tests.drivers.test_servo_bus import SETTINGS
from tests.sim_hw.motors import SimpleMotors

IDS = (1, 2, 3, 4, 5, 6)
FL = 3  # id; index 2


def writes(frame: Frame, name: str) -> bool:
    """Whether a request writes a register."""
    address = MX_106.table[name].address.to_bytes(2, "little")
    return frame.instruction == Instruction.WRITE and frame.parameters[:2] == address


class Wire:
    """The virtual servos' own wire, on which chosen requests are lost or late."""

    def __init__(self, servos: VirtualServoBus) -> None:
        self.servos = servos
        self.loses: Callable[[Frame], bool] = lambda _: False
        self.delay_s: Callable[[Frame], float] = lambda _: 0.0
        self._late: list[tuple[int, bytes, int]] = []  # time, bytes, baud rate

    @property
    def collisions(self) -> int:
        return self.servos.collisions

    def poll(self, t_ns: int) -> None:
        while self._late and self._late[0][0] <= t_ns:
            late_ns, data, baud_rate = heapq.heappop(self._late)
            self.servos.receive(data, late_ns, baud_rate)
        self.servos.poll(t_ns)

    def receive(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        self.poll(t_ns)
        (frame,) = [f for f in FrameParser().feed(data) if isinstance(f, Frame)]
        if self.loses(frame):
            return
        delay_ns = round(self.delay_s(frame) * 1e9)
        if delay_ns:
            heapq.heappush(self._late, (t_ns + delay_ns, data, baud_rate))
        else:
            self.servos.receive(data, t_ns, baud_rate)

    def next_reply_ns(self) -> int | None:
        times = [self.servos.next_reply_ns(), self._late[0][0] if self._late else None]
        return min((t for t in times if t is not None), default=None)

    def replies(self, t_ns: int) -> bytes:
        self.poll(t_ns)
        return self.servos.replies(t_ns)


def configured() -> tuple[Wire, ServoBus, SimpleMotors, VirtualClock]:
    firmware = FirmwareBank(6)
    motors = SimpleMotors(firmware, 6)
    wire = Wire(VirtualServoBus(motors, firmware, IDS, SETTINGS.baud_rate))
    clock = VirtualClock(1_000_000_000)
    bus = ServoBus(MemoryPort(wire, clock, SETTINGS.baud_rate), SETTINGS)
    bus.connect()
    bus.configure()
    return wire, bus, motors, clock


@pytest.mark.parametrize("late_s", [0.0, 0.0055, 0.006, 0.0065, 0.007, 0.030])
def test_a_lost_goal_and_a_late_answer_turn_no_shaft(late_s: float) -> None:
    wire, bus, motors, clock = configured()
    wire.servos.servos[2].table.set("goal_position", 4096)  # turned by hand while torque was off
    lost = late = 0

    def loses(frame: Frame) -> bool:
        nonlocal lost
        hit = frame.servo_id == FL and writes(frame, "goal_position") and not lost
        lost += hit
        return hit

    def delay_s(frame: Frame) -> float:
        nonlocal late
        if frame.servo_id != FL or not writes(frame, "bus_watchdog"):
            return 0.0
        late += 1
        return late_s if late == 1 else 0.002

    wire.loses, wire.delay_s = loses, delay_s
    before = float(motors.motors().ticks[2])
    bus.torque_on()
    assert lost == 1, "the goal was lost once"
    for _ in range(40):
        clock.sleep_until_ns(clock.now_ns() + 10_000_000)
        bus.read()
    assert abs(float(motors.motors().ticks[2]) - before) < 2
    assert wire.servos.servos[2].table.get("goal_position") == 2048


def test_a_goal_that_is_never_kept_leaves_torque_off() -> None:
    wire, bus, _, _ = configured()
    table = wire.servos.servos[2].table
    table.set("goal_position", 4096)
    wire.loses = lambda frame: frame.servo_id == FL and writes(frame, "goal_position")
    with pytest.raises(BusError, match="goal_position"):
        bus.torque_on()
    assert [servo.table.get("torque_enable") for servo in wire.servos.servos] == [0] * 6


def test_torque_off_does_not_talk_over_answers() -> None:
    wire, bus, _, _ = configured()
    bus.torque_on()
    hits = 0

    def loses(frame: Frame) -> bool:
        nonlocal hits
        hit = frame.servo_id == BROADCAST_ID and writes(frame, "torque_enable") and not hits
        hits += hit
        return hit

    wire.loses = loses
    assert bus.torque_off()
    assert (hits, wire.collisions) == (1, 0)
    assert [servo.table.get("torque_enable") for servo in wire.servos.servos] == [0] * 6
    assert [servo.table.get("bus_watchdog") for servo in wire.servos.servos] == [0] * 6


def test_who_keeps_torque_keeps_its_watchdog() -> None:
    wire, bus, _, _ = configured()
    bus.torque_on()
    wire.loses = lambda frame: writes(frame, "torque_enable")
    assert not bus.torque_off()
    assert [s.table.get("bus_watchdog") for s in wire.servos.servos] == [bus.watchdog_units] * 6
    assert np.all([servo.table.get("torque_enable") for servo in wire.servos.servos])
    assert not wire.collisions
