"""Every fault of the servo bus, on the wire, byte for byte, from its start to its end."""

import select
import threading
from pathlib import Path

import dynamixel_sdk
import numpy as np
import pytest

from drivers.clock import MonotonicClock
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.frames import (
    BROADCAST_ID,
    FrameParser,
    Instruction,
    StatusError,
    build_instruction,
)
from drivers.dynamixel.port import BusPort
from drivers.dynamixel.requests import ServoRequests
from drivers.dynamixel.scan import broadcast_ping, id_is_shared
from model.errors import BusError, ConnectionLost
from robot.config.robot_file import load_robot
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.port import MemoryPort
from sim_hw.dynamixel.pty import PtyServoBus
from tests.sim_hw.faulty import BAUD, START_NS, FaultyBus
from tests.sim_hw.twins import plant

# so that a busy machine cannot make an answer late
PATIENCE_MS = 5000.0
PING = bytes.fromhex("FF FF FD 00 01 03 00 01 19 4E")
PONG = bytes.fromhex("FF FF FD 00 01 07 00 55 00 41 01 2D 30 C6")
# Sync read of Present Position, ids 1 to 3, and what each answers: 2048.
READ = bytes.fromhex("FF FF FD 00 FE 0A 00 82 84 00 04 00 01 02 03 2A 6C")
FIRST = bytes.fromhex("FF FF FD 00 01 08 00 55 00 00 08 00 00 1C 38")
SECOND = bytes.fromhex("FF FF FD 00 02 08 00 55 00 00 08 00 00 BC 32")
THIRD = bytes.fromhex("FF FF FD 00 03 08 00 55 00 00 08 00 00 DF B4")


def fault(kind: str, *more: str) -> str:
    """A fault that is on from second 1 to second 2."""
    lines = ["[[fault]]", f'kind = "{kind}"', "start_s = 1.0", "duration_s = 1.0", *more]
    return "\n".join(lines)


@pytest.mark.parametrize(
    ("text", "heard"),
    [
        (fault("lost_reply"), ""),
        # bit 75 is bit 3 of byte 9, the low byte of the model number
        (fault("bit_flip", "bit = 75"), "FF FF FD 00 01 07 00 55 00 49 01 2D 30 C6"),
        (fault("truncated_reply"), "FF FF FD 00 01 07 00"),
        (fault("truncated_reply", "keep_bytes = 13"), PONG[:13].hex()),
        (fault("duplicated_reply"), (PONG + PONG).hex()),
        (
            fault("foreign_reply", "foreign_id = 99"),
            "FF FF FD 00 63 07 00 55 00 00 00 00 91 64" + PONG.hex(),
        ),
        (fault("echo"), (PING + PONG).hex()),
        (fault("silent_servo", "servo = 1"), ""),
        (fault("brownout", "servo = 1"), ""),
        (fault("lost_reply", "servo = 2"), PONG.hex()),
    ],
    ids=lambda value: value.split('"')[1] if "kind" in value else "",
)
def test_a_fault_starts_and_ends_when_told(text: str, heard: str) -> None:
    bus = FaultyBus(text + "\n[servo]\nrestart_s = 0.0\n")
    assert bus.at(0.97).say(PING) == PONG
    assert bus.at(1.0).say(PING) == bytes.fromhex(heard)
    assert bus.at(1.97).say(PING) == bytes.fromhex(heard)
    assert bus.at(2.0).say(PING) == PONG


def test_a_late_reply_comes_whole_and_after_its_time() -> None:
    bus = FaultyBus(fault("late_reply", "delay_s = 0.03"))
    assert bus.at(1.0).say(PING, wait_ms=20) == b""
    assert bus.hear(20) == PONG
    # of a sync read only servo 1 is late here: the others do not wait for it
    bus = FaultyBus(fault("late_reply", "delay_s = 0.03", "servo = 1"))
    assert bus.at(1.0).say(READ) == SECOND + THIRD
    assert bus.hear(20) == FIRST


def test_others_answer_when_one_is_silent_or_the_chain_breaks() -> None:
    others = FaultyBus(fault("silent_servo", "servo = 2"))
    assert others.at(1.0).say(READ) == FIRST + THIRD
    broken = FaultyBus(fault("silent_servo", "servo = 2", "chain_breaks = true"))
    assert broken.at(1.0).say(READ) == FIRST
    assert broken.at(2.0).say(READ) == FIRST + SECOND + THIRD


def test_a_silent_servo_hears_nothing() -> None:
    bus = FaultyBus(fault("silent_servo", "servo = 1"))
    led_on = bytes.fromhex("41 00 01")
    assert bus.at(1.0).ask(1, Instruction.WRITE, led_on) == []
    bus.ask(BROADCAST_ID, Instruction.WRITE, led_on)
    assert [bus.at(2.0).read("led", i) for i in (1, 2)] == [0, 1]


def test_a_bit_drawn_differs_from_reply_to_reply_and_is_one_bit() -> None:
    bus = FaultyBus(fault("bit_flip"))
    heard = [bus.at(1.0 + 0.05 * i).say(PING) for i in range(8)]
    flipped = {int.from_bytes(h, "little") ^ int.from_bytes(PONG, "little") for h in heard}
    assert all(value.bit_count() == 1 for value in flipped)
    assert len(flipped) > 3


def test_a_rate_hits_some_replies_and_a_count_ends_it() -> None:
    some = FaultyBus("seed = 3\n" + fault("lost_reply", "rate = 0.3"))
    lost = sum(some.at(1.0 + 0.005 * i).say(PING, wait_ms=1) == b"" for i in range(150))
    assert 25 < lost < 65
    twice = FaultyBus(fault("lost_reply", "count = 2"))
    assert [twice.at(1.0 + 0.1 * i).say(PING) for i in range(4)] == [b"", b"", PONG, PONG]


def test_the_same_seed_gives_the_same_bytes() -> None:
    def run(seed: int) -> bytes:
        faults = [fault(kind, "rate = 0.3") for kind in ("bit_flip", "lost_reply", "echo")]
        bus = FaultyBus("\n".join([f"seed = {seed}", *faults]))
        return b"".join(bus.at(1.0 + 0.01 * i).say(READ, wait_ms=5) for i in range(60))

    assert run(5) == run(5)
    assert run(5) != run(6)


# Servos and shafts.


def test_a_brownout_loses_ram_and_turns_and_keeps_eeprom() -> None:
    bus = FaultyBus(fault("brownout", "servo = 1"))
    bus.motors.hold = True
    bus.motors.ticks[0] = 3 * 4096 + 5.0
    bus.write("operating_mode", 4)
    bus.write("torque_enable", 1)
    bus.write("led", 1)
    assert bus.read("present_position") == 3 * 4096 + 5
    bus.at(1.5)
    bus.motors.ticks[0] += 4096  # a turn by hand while it has no power
    assert bus.at(2.2).say(PING) == b"", "it is starting"
    bus.at(2.3)
    registers = ("present_position", "torque_enable", "led", "operating_mode")
    assert [bus.read(name) for name in registers] == [5, 0, 0, 4]


def test_overheating_is_measured_and_shuts_the_servo_down_beyond_its_limit() -> None:
    bus = FaultyBus(fault("overheating", "servo = 2", "temperature_c = 85.0"))
    bus.write("torque_enable", 1, servo_id=2)
    bus.at(1.1)
    assert bus.read("present_temperature", 2) == 85
    assert bus.read("hardware_error_status", 2) == 0x04
    assert bus.ask(2, Instruction.PING)[0].error == 0x80, "the alert bit"
    assert bus.read("torque_enable", 2) == 0
    bus.at(2.1)
    assert bus.read("present_temperature", 2) == 30
    assert bus.read("hardware_error_status", 2) == 0x04, "latched until it is rebooted"


@pytest.mark.parametrize(("overload_s", "status"), [(0.5, 0x20), (1.5, 0)])
def test_an_overload_counts_when_it_lasts(overload_s: float, status: int) -> None:
    text = f"[servo]\noverload_s = {overload_s}\n" + fault("overload", "servo = 1")
    bus = FaultyBus(text)
    bus.motors.hold = True
    bus.write("torque_enable", 1)
    for second in np.arange(1.0, 2.0, 0.01):
        bus.at(float(second))
        if second < 1.4:
            assert bus.read("present_current") == round(5.2 / 0.00336)
    bus.at(2.0)
    assert bus.read("hardware_error_status") == status
    assert bus.read("torque_enable") == (status == 0)
    assert bus.read("present_current") == 0


def test_a_stuck_shaft_stands_until_it_is_freed() -> None:
    bus = FaultyBus(fault("stuck_shaft", "servo = 1"))
    bus.write("operating_mode", 1)
    bus.write("torque_enable", 1)
    bus.write("goal_velocity", 100)
    bus.at(1.1)
    stuck = bus.read("present_position")
    assert bus.at(1.9).read("present_position") == pytest.approx(stuck, abs=1)
    assert bus.at(2.9).read("present_position") > stuck + 500


@pytest.mark.parametrize(
    "gear", ["", "servo_compliance@HL:rad_per_nm=0.002", "gear_backlash@HL:width_rad=0.02"]
)
def test_a_jammed_shaft_stalls_the_motor_of_the_plant(gear: str) -> None:
    """What is caught in a leg holds the shaft; a motor whose gear gives goes on until the gear is tight."""
    robot = plant(gear) if gear else plant()
    robot.jam_n_m[0] = 50.0
    before = robot.shaft_angle_rad.copy()
    for _ in range(300):
        robot.step(np.full(6, 1.0), np.ones(6, dtype=bool))
    turned = np.abs(robot.shaft_angle_rad - before)
    assert turned[0] < 0.02
    assert turned[1] > 0.5
    assert robot.current_a[0] > 4.2, "stalled: its current is what the servo calls overload"
    assert robot.supply_v[1] < robot.supply_v[0] + 1e-12, "one battery: all servos see the sag"
    robot.jam_n_m[0] = 0.0
    for _ in range(100):
        robot.step(np.full(6, 1.0), np.ones(6, dtype=bool))
    assert robot.shaft_angle_rad[0] - before[0] > 0.1, "freed"


# The cable and the adapter.


def test_an_unplugged_cable_raises_and_comes_back() -> None:
    bus = FaultyBus(fault("unplug"))
    assert bus.at(0.97).say(PING) == PONG
    bus.at(1.0)
    with pytest.raises(ConnectionLost, match="was the cable pulled"):
        bus.say(PING)
    assert bus.at(2.0).say(PING) == PONG


def test_servos_live_on_without_the_cable_and_their_watchdog_trips() -> None:
    bus = FaultyBus(fault("unplug"))
    bus.write("torque_enable", 1)
    bus.at(0.9)
    bus.write("bus_watchdog", 10)
    for second in np.arange(1.0, 1.3, 0.01):
        bus.at(float(second))
    assert bus.bus.servos[0].table.get("bus_watchdog") == -1


def test_our_port_in_memory_loses_the_cable_and_opens_again() -> None:
    bus = FaultyBus(fault("unplug"))
    clock = VirtualClock(START_NS)
    port = MemoryPort(bus.wire, clock, BAUD)
    assert port.openPort()
    clock.sleep_until_ns(START_NS + 1_100_000_000)
    for action in (port.clearPort, lambda: port.writePort(PING), port.openPort):
        with pytest.raises(ConnectionLost):
            action()
    clock.sleep_until_ns(START_NS + 2_100_000_000)
    assert port.openPort()
    assert [found.servo_id for found in broadcast_ping(port)] == [1, 2, 3]


def test_the_latency_timer_hands_replies_over_in_steps() -> None:
    bus = FaultyBus("[adapter]\nlatency_timer_s = 0.016")
    bus.at(0.001)  # 1.001 s: the next step of the grid is at 1.008 s
    assert bus.say(PING, wait_ms=6.8) == b""
    assert bus.hear(0.2) == PONG
    bus.at(0.025)
    several = bytes.fromhex("01 84 00 14 00 02 84 00 14 00 03 84 00 14 00")  # 20 bytes of each
    request = build_instruction(BROADCAST_ID, Instruction.BULK_READ, several)
    heard = bus.say(request, wait_ms=3)
    assert len(heard) == 62, "a full packet does not wait for the timer"
    assert len(bus.hear(16)) == 3 * 31 - 62


def test_the_driver_sees_the_latency_timer_and_waits_for_it() -> None:
    robot = load_robot().servo_bus
    bus = FaultyBus("[adapter]\nlatency_timer_s = 0.016", ids=(1, 2, 3, 4, 5, 6))
    clock = VirtualClock(START_NS)
    servos = ServoBus(MemoryPort(bus.wire, clock, BAUD, 0.016), robot)
    report = servos.connect()
    assert any("16 ms" in warning for warning in report.warnings)
    began_ns = clock.now_ns()
    for _ in range(10):
        assert servos.read().valid.all()
    assert clock.now_ns() - began_ns >= 10 * 16_000_000 * 0.9, "one step of the timer each"


# Old firmware.


def test_old_firmware_answers_protocol_1_only() -> None:
    bus = FaultyBus("[servo]\nold_firmware = [2]")
    assert bus.at(0.1).say(bytes.fromhex("FF FF 02 02 01 FA")) == bytes.fromhex("FF FF 02 02 00 FB")
    model = bus.say(bytes.fromhex("FF FF 02 04 02 00 02 F5"))
    assert model == bytes.fromhex("FF FF 02 04 00 40 01 B8"), "320"
    write = bytes.fromhex("FF FF 02 04 03 19 01 DC")
    assert bus.say(write) == bytes.fromhex("FF FF 02 02 40 BB"), "instruction error"
    assert bus.say(bytes.fromhex("FF FF 02 02 01 FB")) == b"", "wrong checksum"
    assert bus.at(0.5).say(READ) == FIRST + THIRD


def test_old_firmware_is_on_the_one_wire() -> None:
    bus = FaultyBus("[servo]\nold_firmware = [2]")
    old_ping, old_pong = bytes.fromhex("FF FF 02 02 01 FA"), bytes.fromhex("FF FF 02 02 00 FB")
    assert bus.at(0.1).say(old_ping, wait_ms=0.06) == b"", "its answer is on the wire"
    heard = bus.say(READ)
    assert (len(heard), bus.bus.collisions) == (len(old_pong), 1), "garbled, and the read unheard"
    assert heard != old_pong
    # a request that is cut off by an answer is unheard by old ones too
    assert bus.say(PING, wait_ms=0.06) == b""
    assert old_pong not in bus.say(old_ping)
    assert bus.bus.collisions == 2
    # one of each protocol is asked in one breath: they answer at the same time
    both = bus.say(PING + old_ping)
    assert len(both) == len(PONG) + len(old_pong)
    assert PONG not in both
    assert old_pong not in both
    # one behind the other: nothing is lost
    assert bus.say(PING) + bus.say(old_ping) == PONG + old_pong
    assert bus.say(READ) == FIRST + THIRD


def test_old_firmware_is_recognised_and_refused_with_advice() -> None:
    bus = FaultyBus("[servo]\nold_firmware = [2]", ids=(1, 2, 3, 4, 5, 6))
    clock = VirtualClock(START_NS)
    servos = ServoBus(MemoryPort(bus.wire, clock, BAUD), load_robot().servo_bus)
    with pytest.raises(BusError, match=r"ML \(id 2\): protocol 1.0 firmware.*Dynamixel Wizard"):
        servos.connect()


# What is assumed about the servos.


def test_reserved_gaps() -> None:
    gap = bytes.fromhex("0E 00 02 00")  # registers 14 and 15
    assert FaultyBus("").ask(1, Instruction.READ, gap)[0].parameters == b"\0\0"
    strict = FaultyBus('[servo]\nreserved = "error"').ask(1, Instruction.READ, gap)[0]
    assert (strict.error, strict.parameters) == (StatusError.ACCESS, b"")


def test_a_wrong_crc_is_answered_only_if_that_is_assumed() -> None:
    wrong = PING[:-1] + b"\x4f"
    assert FaultyBus("").say(wrong) == b""
    answer = FaultyBus("[servo]\nanswers_bad_crc = true").say(wrong)
    assert answer[:9] == bytes.fromhex("FF FF FD 00 01 04 00 55 03")


@pytest.mark.parametrize(("hears", "left"), [("all", 5), ("own", -1)])
def test_whom_the_watchdog_hears(hears: str, left: int) -> None:
    bus = FaultyBus(f'[servo]\nwatchdog_hears = "{hears}"')
    bus.write("torque_enable", 1)
    bus.write("bus_watchdog", 5)
    for _ in range(8):
        bus.ask(2, Instruction.PING)  # 20 ms each
    assert bus.bus.servos[0].table.get("bus_watchdog") == left


def test_a_goal_kept_or_here_at_torque_on() -> None:
    for assumed, goal in (("kept", 3000), ("here", 2048)):
        bus = FaultyBus(f'[servo]\ngoal_at_torque_on = "{assumed}"')
        bus.write("goal_position", 3000)
        bus.write("torque_enable", 1)
        assert bus.read("goal_position") == goal


def test_gains_reset_or_kept_at_a_mode_change() -> None:
    for assumed, gain in (("reset", 850), ("kept", 400)):
        bus = FaultyBus(f'[servo]\ngains_at_mode_change = "{assumed}"')
        bus.write("position_p_gain", 400)
        bus.write("operating_mode", 4)
        assert bus.read("position_p_gain") == gain


def test_servos_that_share_an_id_talk_at_once() -> None:
    bus = FaultyBus("[servo]\nshares_id = [2]")
    assert bus.say(PING) == PONG, "the same bytes at the same time"
    bus.motors.ticks[1] = 2100
    read = (MX_106.table["present_position"].address.to_bytes(2, "little")) + b"\4\0"
    assert bus.ask(1, Instruction.READ, read) == []
    assert bus.ask(2, Instruction.PING) == []
    assert bus.write("led", 1) == 0
    assert [servo.table.get("led") for servo in bus.bus.servos] == [1, 1, 0], "both obey"
    read_all = build_instruction(BROADCAST_ID, Instruction.SYNC_READ, bytes.fromhex("840004000103"))
    assert bus.say(read_all)[len(FIRST) :] == THIRD, "who shares no id is understood"


def test_a_shared_id_is_detected() -> None:
    bus = FaultyBus("[servo]\nshares_id = [2]")
    port = MemoryPort(bus.wire, VirtualClock(bus.t_ns), BAUD)
    requests = ServoRequests(port)
    assert not id_is_shared(requests, 3)
    bus.motors.ticks[1] = 2100
    assert id_is_shared(requests, 1)


# Requests, and the one wire.


@pytest.mark.parametrize(
    "text",
    [
        fault("lost_request"),
        fault("damaged_request"),
        fault("damaged_request", "bit = 75"),
        fault("truncated_request"),
        fault("truncated_request", "keep_bytes = 9"),
        fault("late_request", "delay_s = 0.5"),
    ],
)
def test_a_request_that_is_not_sound_does_nothing(text: str) -> None:
    bus = FaultyBus(text)
    led = build_instruction(1, Instruction.WRITE, bytes.fromhex("410001"))
    for second, obeyed in ((0.9, True), (1.0, False), (2.0, True)):
        assert bool(bus.at(second).say(led)) is obeyed
        assert bus.bus.servos[0].table.get("led") == obeyed
        bus.bus.servos[0].table.set("led", 0)
        bus.hear(1.6)  # a pause ends what was cut short


def test_a_late_request_is_obeyed_late() -> None:
    bus = FaultyBus(fault("late_request", "delay_s = 0.03"))
    assert bus.at(1.0).say(PING, wait_ms=29.0) == b""
    assert bus.hear(2.0) == PONG


def test_requests_of_one_id_are_hit_and_broadcasts_only_without_an_id() -> None:
    bus = FaultyBus(fault("lost_request", "servo = 1")).at(1.0)
    assert bus.ask(1, Instruction.PING) == []
    assert len(bus.ask(2, Instruction.PING)) == 1
    assert bus.say(READ) == FIRST + SECOND + THIRD
    assert FaultyBus(fault("lost_request")).at(1.0).say(READ) == b""


def test_a_request_over_a_reply_destroys_both() -> None:
    bus = FaultyBus("")
    wire_ms = 1e3 * 10 * len(PING) / BAUD
    assert bus.say(PING, wait_ms=0.06) == b"", "its answer is on the wire"
    heard = bus.say(READ)
    assert (len(heard), bus.bus.collisions) == (len(PONG), 1), "garbled, and the read unheard"
    assert FrameParser().feed(heard) == []
    assert bus.say(PING, wait_ms=0.05 + wire_ms + 0.05) == PONG
    assert bus.say(READ) == FIRST + SECOND + THIRD


def test_two_requests_in_one_breath_collide_where_the_first_is_answered() -> None:
    bus = FaultyBus("")
    heard = bus.say(PING + READ)
    assert (len(heard), FrameParser().feed(heard)) == (len(PONG), [])
    led = build_instruction(BROADCAST_ID, Instruction.WRITE, bytes.fromhex("410001"))
    assert bus.say(led + PING) == PONG, "nobody answers a broadcast"


def test_the_answer_to_a_late_request_meets_the_next_one() -> None:
    bus = FaultyBus(fault("late_request", "delay_s = 0.0001", "count = 1")).at(1.0)
    bus.say(PING, wait_ms=0.1)
    heard = bus.say(PING)
    assert len(heard) == len(PONG) != heard.count(PONG) * len(PONG)
    assert bus.bus.collisions == 1
    assert bus.say(PING) == PONG


# The healthy servo, where it had gaps.


def moved(bus: FaultyBus, goal: int) -> tuple[list[float], list[int], list[int]]:
    """Ticks, Moving and Moving Status after a goal, 20 ms apart for 3 s; reading takes no time."""
    bus.write("goal_position", goal)
    servo, ticks, moving, status = bus.bus.servos[0], [], [], []
    at = servo.table.model.table["moving"].address
    for _ in range(150):
        bus.hear(20.0)
        servo.read(at, 2, bus.t_ns)
        ticks.append(float(bus.motors.motors().ticks[0]))
        moving.append(servo.table.get("moving"))
        status.append(servo.table.get("moving_status"))
    return ticks, moving, status


@pytest.mark.parametrize(("ramp_ms", "kind"), [(0, 0x12), (500, 0x32)])
def test_a_time_based_profile_takes_its_time(ramp_ms: int, kind: int) -> None:
    bus = FaultyBus("")
    bus.write("drive_mode", 4)
    bus.write("operating_mode", 4)
    bus.write("torque_enable", 1)
    for goal in (3000, 2500):
        bus.write("profile_velocity", 2000)
        bus.write("profile_acceleration", ramp_ms)
        before = float(bus.motors.motors().ticks[0])
        ticks, _, status = moved(bus, goal)
        assert status[10] == kind
        assert sum(code != 1 for code in status) * 0.02 == pytest.approx(2.0, abs=0.1)
        assert ticks[49] == pytest.approx((before + goal) / 2, abs=25), "half of it after 1 s"
        assert ticks[-1] == pytest.approx(goal, abs=3)


def test_a_velocity_ramp_takes_its_time() -> None:
    bus = FaultyBus("")
    bus.write("drive_mode", 4)
    bus.write("operating_mode", 1)
    bus.write("torque_enable", 1)
    bus.write("profile_acceleration", 1000)
    bus.write("goal_velocity", 100)
    bus.hear(480.0)
    assert bus.read("velocity_trajectory") == pytest.approx(50, abs=2)
    bus.hear(600.0)
    assert bus.read("velocity_trajectory") == 100


def test_moving_is_1_as_long_as_a_slow_profile_lasts() -> None:
    bus = FaultyBus("")
    bus.write("operating_mode", 4)
    bus.write("torque_enable", 1)
    bus.write("profile_velocity", 5)  # below the moving threshold
    _, moving, status = moved(bus, 2080)
    assert moving[5:10] == [1] * 5
    assert moving[-1] == 0
    assert [m == 1 for m in moving[5:]] == [code != 1 for code in status[5:]]


def test_protocol_1_is_deaf_to_protocol_2() -> None:
    bus = FaultyBus("")
    assert bus.write("protocol_type", 1) == 0
    assert bus.ask(1, Instruction.PING) == []
    assert len(bus.ask(2, Instruction.PING)) == 1


def test_drive_mode_reverse_turns_every_signed_register() -> None:
    bus = FaultyBus("")
    bus.write("operating_mode", 4)
    bus.write("drive_mode", 1)
    assert bus.read("present_position") == -2048
    bus.write("torque_enable", 1)
    bus.write("goal_position", -1000)
    bus.at(2.0)
    assert bus.read("present_position") == pytest.approx(-1000, abs=3)
    assert bus.motors.ticks[0] == pytest.approx(1000, abs=3)


def test_a_homing_offset_moves_goal_and_position_alike() -> None:
    bus = FaultyBus("")
    bus.write("operating_mode", 4)
    bus.write("homing_offset", 100)
    assert bus.read("present_position") == 2148
    bus.write("torque_enable", 1)
    bus.write("goal_position", 2148)
    bus.at(1.0)
    assert bus.motors.ticks[0] == pytest.approx(2048, abs=1)


def test_velocity_mode_ramps_with_its_profile_acceleration() -> None:
    bus = FaultyBus("")
    bus.write("operating_mode", 1)
    bus.write("profile_acceleration", 8)  # 100 counts in 64 ms x 100 / 8 = 0.8 s
    bus.write("torque_enable", 1)
    bus.write("goal_velocity", 100)
    began_s = (bus.t_ns - START_NS) * 1e-9
    assert bus.at(began_s + 0.4).read("velocity_trajectory") == pytest.approx(50, abs=4)
    assert bus.at(began_s + 0.9).read("velocity_trajectory") == 100


def test_a_mode_change_resets_gains_profile_and_ceilings() -> None:
    bus = FaultyBus("")
    changed = {"position_p_gain": 400, "velocity_p_gain": 7, "profile_velocity": 9, "goal_pwm": 50}
    for name, value in changed.items():
        bus.write(name, value)
    bus.write("operating_mode", 4)
    assert [bus.read(name) for name in changed] == [850, 100, 0, 885]


def test_sync_and_bulk_writes_reach_the_secondary_id() -> None:
    bus = FaultyBus("")
    bus.write("secondary_id", 1, servo_id=2)
    bus.ask(BROADCAST_ID, Instruction.SYNC_WRITE, bytes.fromhex("41 00 01 00 01 01"))
    assert [bus.read("led", i) for i in (1, 2, 3)] == [1, 1, 0]
    bus.ask(BROADCAST_ID, Instruction.BULK_WRITE, bytes.fromhex("01 41 00 01 00 00"))
    assert [bus.read("led", i) for i in (1, 2)] == [0, 0]
    bus.ask(BROADCAST_ID, Instruction.SYNC_WRITE, bytes.fromhex("09 00 01 00 01 07"))
    assert [bus.read("return_delay_time", i) for i in (1, 2)] == [7, 0], "RAM only"


def test_a_write_of_the_id_is_answered_from_the_old_one() -> None:
    bus = FaultyBus("")
    assert [f.servo_id for f in bus.ask(3, Instruction.WRITE, bytes.fromhex("07 00 09"))] == [3]
    assert [f.servo_id for f in bus.ask(9, Instruction.PING)] == [9]


@pytest.mark.parametrize(("how", "kept"), [(0x01, (3, 1)), (0x02, (3, 3)), (0xFF, (1, 1))])
def test_factory_reset_keeps_what_it_is_told_to(how: int, kept: tuple[int, int]) -> None:
    bus = FaultyBus("")
    bus.write("temperature_limit", 60, servo_id=3)
    bus.ask(3, Instruction.FACTORY_RESET, bytes([how]))
    table = bus.bus.servos[2].table
    assert (table.get("id"), table.get("baud_rate")) == kept
    assert table.get("temperature_limit") == 80


def test_a_value_out_of_range_does_not_slip_in_through_indirect_data() -> None:
    bus = FaultyBus("")
    bus.write("indirect_address_1", MX_106.table["torque_enable"].address)
    assert bus.write("indirect_data_1", 2) == StatusError.DATA_RANGE
    assert bus.write("indirect_data_1", 1) == 0
    assert bus.read("torque_enable") == 1


@pytest.mark.parametrize("instruction", [0x02, 0x06, 0x08, 0x10, 0x20, 0x8A, 0x9A])
def test_broadcasts_that_nobody_answers(instruction: int) -> None:
    assert FaultyBus("").ask(BROADCAST_ID, instruction, bytes.fromhex("84 00 04 00 01")) == []


def test_the_input_voltage_error_leaves_torque_on() -> None:
    bus = FaultyBus("")
    bus.write("torque_enable", 1)
    bus.motors.volts[0] = 9.0
    bus.at(0.5)
    assert bus.read("hardware_error_status") == 0x01
    assert bus.read("torque_enable") == 1, "not in the default Shutdown mask"


# Over a pseudo-terminal, in real time.


def write_often(port: BusPort) -> None:
    for _ in range(100_000):
        port.writePort(PING)


def test_the_cable_of_a_pseudo_terminal_comes_back_under_its_name(tmp_path: Path) -> None:
    """The time of the wire is ours; the port is real, and so is the SDK."""
    bus = FaultyBus(fault("unplug"))
    pty = PtyServoBus(bus.wire, tmp_path / "servo_bus")
    times_ns = [START_NS]
    done = threading.Event()

    def serve() -> None:
        while not done.is_set():
            select.select(pty.filenos(), [], [], 0.0005)
            times_ns[0] += 500_000
            pty.service(times_ns[0])

    thread = threading.Thread(target=serve, daemon=True)

    def ping() -> tuple[int, int, int]:
        port = dynamixel_sdk.PortHandler(str(tmp_path / "servo_bus"))
        port.setPacketTimeout = lambda _: port.setPacketTimeoutMillis(PATIENCE_MS)
        assert port.openPort()
        assert port.setBaudRate(BAUD)
        try:
            found: tuple[int, int, int] = dynamixel_sdk.PacketHandler(2.0).ping(port, 2)
        finally:
            port.closePort()
        return found

    try:
        thread.start()
        assert ping() == (321, 0, 0)
        port = BusPort(pty.device_name, BAUD, MonotonicClock())
        port.openPort()
        times_ns[0] = START_NS + 1_000_000_000
        with pytest.raises(ConnectionLost):
            write_often(port)
        port.closePort()
        with pytest.raises(BusError, match="there is no port"):
            port.openPort()
        times_ns[0] = START_NS + 2_000_000_000
        assert any((tmp_path / "servo_bus").exists() for _ in range(1_000_000))
        assert ping() == (321, 0, 0)
    finally:
        done.set()
        thread.join()
        pty.close()
    assert not (tmp_path / "servo_bus").is_symlink()
