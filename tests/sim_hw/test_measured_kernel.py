"""What all servos answer at once is what each of them answers alone, byte for byte."""

import numpy as np
import pytest

from drivers.dynamixel.catalog import COMMON, READ_ADDRESS, READ_LENGTH
from drivers.dynamixel.frames import (
    BROADCAST_ID,
    STUFFING_MARK,
    FrameParser,
    Instruction,
    StatusError,
    build_instruction,
    stuff,
)
from drivers.dynamixel.registers import OperatingMode
from drivers.dynamixel.units import BAUD_CODES
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.listeners import Listeners
from tests.sim_hw.motors import SimpleMotors

BAUD = 1_000_000
CODE = BAUD_CODES[BAUD]
IDS = (11, 12, 13, 7, 9)
SPAN = READ_ADDRESS.to_bytes(2, "little") + READ_LENGTH.to_bytes(2, "little")
ALL = SPAN + bytes(IDS)


class Bench:
    """Servos whose motors and loops are set at will."""

    def __init__(self) -> None:
        self.firmware = FirmwareBank(len(IDS))
        self.motors = SimpleMotors(self.firmware, len(IDS))
        self.motors.hold = True
        self.bus = VirtualServoBus(self.motors, self.firmware, IDS, BAUD)

    def scatter(self, seed: int) -> None:
        """Put everything that is measured somewhere."""
        some = np.random.default_rng(seed)
        motors, loops = self.motors, self.firmware.columns
        motors.ticks[:] = some.uniform(-60_000, 60_000, len(IDS))
        motors.rate[:] = some.uniform(-5, 5, len(IDS)) * some.integers(0, 2, len(IDS))
        motors.currents[:] = some.uniform(-4, 4, len(IDS))
        motors.volts[:] = some.uniform(10, 14, len(IDS))
        motors.temperature_c[:] = some.uniform(-5, 70, len(IDS))
        for name in ("trajectory", "goal_position", "trajectory_rate", "pwm", "ramp_velocity"):
            loops[name][:] = some.uniform(-800, 800, len(IDS))
        loops["profile_velocity"][:] = some.integers(0, 2, len(IDS))
        loops["profile_acceleration"][:] = some.integers(0, 2, len(IDS))
        loops["torque"][:] = some.integers(0, 2, len(IDS))
        modes = some.choice([int(mode) for mode in OperatingMode], len(IDS))
        for servo, mode in zip(self.bus.servos, modes.tolist(), strict=True):
            servo.table.set("operating_mode", mode)
            servo.table.set("drive_mode", int(some.integers(0, 2)))
            servo.table.set("homing_offset", int(some.integers(-900, 900)))
            servo.table.set("hardware_error_status", int(some.integers(0, 2)))
            loops["operating_mode"][servo._index] = mode

    def ask(self, parameters: bytes, t_ns: int) -> bytes:
        frame = build_instruction(BROADCAST_ID, Instruction.SYNC_READ, parameters)
        self.bus.receive(frame, t_ns, BAUD)
        return self.bus.replies(t_ns + 500_000_000)

    def at_once(self, parameters: bytes, t_ns: int) -> list[bytes] | None:
        read = Listeners(self.bus.servos, CODE, t_ns, {}).measured_read(parameters)
        return None if read is None else read.answers(
            self.firmware.servos, self.motors.motors(), t_ns
        )  # fmt: skip


def servo_by_servo(bench: Bench, t_ns: int, monkeypatch: pytest.MonkeyPatch) -> bytes:
    with monkeypatch.context() as patch:
        patch.setattr(Listeners, "measured_read", lambda *_: None)
        return bench.ask(ALL, t_ns)


@pytest.mark.parametrize("seed", range(40))
def test_all_at_once_are_those_of_each_alone(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench()
    bench.scatter(seed)
    t_ns = 10_000_000 + 17_000_000 * seed
    made = bench.at_once(ALL, t_ns)
    assert made is not None
    assert b"".join(made) == servo_by_servo(bench, t_ns, monkeypatch)
    assert bench.ask(ALL, t_ns + 600_000_000)  # and through the bus


def test_what_looks_like_a_header_is_stuffed(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench()
    for at, ticks in enumerate((0xFDFFFF, -1 << 16, 0xFFFD, 0x7DFFFF, -3)):
        bench.motors.ticks[at] = ticks
    bench.firmware.columns["trajectory"][:] = 0xFDFFFF
    made = bench.at_once(ALL, 10_000_000)
    assert made is not None
    assert made[0].count(STUFFING_MARK) == 3  # the header and two registers
    assert b"".join(made) == servo_by_servo(bench, 10_000_000, monkeypatch)
    assert len(FrameParser().feed(b"".join(made))) == len(IDS)


def test_a_part_of_what_is_measured() -> None:
    bench = Bench()
    bench.scatter(1)
    address = READ_ADDRESS + 3
    parameters = address.to_bytes(2, "little") + (9).to_bytes(2, "little") + bytes(IDS[::-1])
    made = bench.at_once(parameters, 10_000_000)
    assert made is not None
    for data, servo_id in zip(made, IDS[::-1], strict=True):
        (servo,) = [one for one in bench.bus.servos if one.servo_id == servo_id]
        _, alone = servo.read(address, 9, 10_000_000)
        assert data[9:-2] == stuff(alone)


@pytest.mark.parametrize(
    "parameters",
    [SPAN, SPAN + bytes([11, 99]), (100).to_bytes(2, "little") + ALL[2:], ALL[:2] + b"\x90\0\x0b"],
)
def test_what_is_out_of_the_ordinary_is_not_answered_at_once(parameters: bytes) -> None:
    assert Bench().at_once(parameters, 10_000_000) is None


@pytest.mark.parametrize("value", [np.nan, 1e9, -1e9])
def test_a_number_that_fits_no_register_is_not_answered_at_once(value: float) -> None:
    bench = Bench()
    bench.motors.currents[3] = value
    assert bench.at_once(ALL, 10_000_000) is None


def test_listeners_are_looked_up_again_when_a_register_changes() -> None:
    bench = Bench()
    known = Listeners(bench.bus.servos, CODE, 0, {})
    assert known.hold(CODE)
    assert not known.hold(CODE + 1)
    bench.bus.servos[2].table.set("goal_position", 5)
    assert known.hold(CODE)
    bench.bus.servos[2].table.set("return_delay_time", 9)
    assert not known.hold(CODE)
    asleep = bench.bus.servos[1]
    asleep.restart(1_000)
    assert not Listeners(bench.bus.servos, CODE, 2_000, {}).hold(CODE)  # it wakes up


def goals_frame(goals: dict[int, int]) -> bytes:
    goal = COMMON["goal_position"]
    parts = [bytes((servo_id,)) + goal.encode(ticks) for servo_id, ticks in goals.items()]
    parameters = goal.address.to_bytes(2, "little") + (4).to_bytes(2, "little") + b"".join(parts)
    return build_instruction(BROADCAST_ID, Instruction.SYNC_WRITE, parameters)


def goals_of(bench: Bench) -> list[tuple[int, bytes | StatusError, float]]:
    goal = COMMON["goal_position"]
    return [
        (
            servo.table.values["goal_position"], servo.table.read(goal.address, 4),
            float(bench.firmware.goal_position[servo._index]),
        )
        for servo in bench.bus.servos
    ]  # fmt: skip


@pytest.mark.parametrize("seed", range(14))
def test_goals_given_at_once_are_those_given_one_by_one(
    seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    some = np.random.default_rng(seed)
    goals = dict(zip(IDS, some.integers(-9_000, 9_000, len(IDS)).tolist(), strict=True))
    given = []
    for at_once in (True, False):
        bench = Bench()
        bench.scatter(seed)
        bench.bus.servos[1].table.set("bus_watchdog", -1 if seed % 3 == 0 else 0)
        if seed % 2:
            bench.firmware.columns["torque"][:] = True
        if seed == 11:
            bench.bus.servos[2].table.set("drive_mode", 0x04)
        with monkeypatch.context() as patch:
            if not at_once:
                patch.setattr(Listeners, "goal_write", lambda *_: None)
            bench.bus.receive(goals_frame(goals), 10_000_000, BAUD)
        given.append(goals_of(bench))
    assert given[0] == given[1]
    assert any(
        ticks == goals[servo_id] for servo_id, (ticks, *_) in zip(IDS, given[0], strict=True)
    )
