"""The bus as the loop uses it: read, goals, torque; and what happens when servos misbehave."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel.bus import POLL_EVERY_READS, ServoBus
from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.frames import BROADCAST_ID, Frame, Instruction
from drivers.dynamixel.settings import ServoBusSettings
from model.errors import BusError, ConnectionLost
from model.values.arrays import FloatArray
from model.values.legs import JointCommand
from tests.drivers.scripted_servos import Replies, ScriptedPort, ScriptedServos, Servo

IDS = [1, 2, 3, 4, 5, 6]
TURN = 2 * np.pi
SETTINGS = ServoBusSettings(
    names=("HL", "ML", "FL", "HR", "MR", "FR"),
    ids=np.array(IDS),
    signs=np.array([1, 1, 1, -1, -1, -1]),
    zeros=np.full(6, 2048),
    models=(MX_106,) * 6,
    baud_rate=1_000_000,
    watchdog_s=0.24,
    silent_limit=5,
)
WATCHDOG_UNITS = 12
HARDWARE_ERROR = 70


class Rig:
    """A connected bus with its servos."""

    def __init__(self, *, armed: bool = True, **values: int) -> None:
        self.scripted = ScriptedServos(*(Servo(i, dict(values)) for i in IDS))
        self.port = ScriptedPort(self.scripted.respond)
        self.bus = ServoBus(self.port, SETTINGS)
        self.bus.connect()
        if armed:
            self.bus.configure()
        self.scripted.requests.clear()

    def servo(self, servo_id: int) -> Servo:
        return self.scripted.servos[servo_id]

    def column(self, name: str) -> list[int]:
        return [self.servo(i).values[name] for i in IDS]

    def polled(self) -> list[int]:
        """Ids whose register 70 was asked for, and forget them."""
        read = [f for f in self.scripted.requests if f.instruction == Instruction.READ]
        self.scripted.requests.clear()
        spans = [(int.from_bytes(f.parameters[:2], "little"), f.parameters[2]) for f in read]
        asked = zip(read, spans, strict=True)
        return [f.servo_id for f, (first, n) in asked if first <= HARDWARE_ERROR < first + n]


def command(angle: FloatArray | float, *, torque: bool = True) -> JointCommand:
    angles = np.broadcast_to(np.asarray(angle, dtype=np.float64), (6,))
    return JointCommand(0, angles, np.zeros(6), torque)


# Reading.


def test_a_read_is_stamped_in_its_middle() -> None:
    """Six answers of 34 bytes at 1 M take 2 ms: a stamp at their end would be as late for all of them."""
    rig = Rig(armed=False)
    clock = rig.bus.clock
    rig.bus.read()
    began_ns = clock.now_ns()
    t_ns = rig.bus.read().t_ns
    whole_ns = clock.now_ns() - began_ns
    assert whole_ns > 2_000_000
    assert t_ns - began_ns == pytest.approx(whole_ns / 2, abs=300_000)


def test_a_read_has_every_value_with_its_sign() -> None:
    rig = Rig(armed=False)
    rig.servo(5).values |= {
        "present_pwm": -885,
        "present_current": -150,
        "present_velocity": -1,
        "present_position": -1_000_003,
        "present_input_voltage": 118,
        "present_temperature": 71,
    }
    readings = rig.bus.read()
    assert readings.valid.all()
    assert readings.duty_counts[4] == -885
    assert readings.current_counts[4] == -150
    assert readings.velocity_counts[4] == -1
    assert readings.position_ticks.tolist() == [2048] * 4 + [-1_000_003, 2048]
    assert readings.voltage_counts.tolist() == [120] * 4 + [118, 120]
    assert readings.temperature_c.tolist() == [30] * 4 + [71, 30]
    assert readings.age_ns.tolist() == [0] * 6
    assert not readings.position_ticks.flags.writeable


@given(st.integers(-(1 << 31), (1 << 31) - 1), st.integers(-(1 << 31), (1 << 31) - 1))
def test_any_count_comes_through(position: int, velocity: int) -> None:
    rig = Rig(armed=False, present_position=position, present_velocity=velocity)
    readings = rig.bus.read()
    assert readings.position_ticks.tolist() == [position] * 6
    assert readings.velocity_counts.tolist() == [velocity] * 6


def test_connecting_and_reading_write_nothing() -> None:
    rig = Rig(armed=False)
    before = [dict(servo.values) for servo in rig.scripted.servos.values()]
    for _ in range(POLL_EVERY_READS):
        rig.bus.read()
    assert [dict(servo.values) for servo in rig.scripted.servos.values()] == before
    instructions = {Instruction(frame.instruction) for frame in rig.scripted.requests}
    assert instructions == {Instruction.SYNC_READ, Instruction.READ}


def test_a_silent_servo_hides_nobody_and_grows_old() -> None:
    rig = Rig(armed=False)
    never = rig.bus.read()
    rig.servo(3).silent = True
    first, second = rig.bus.read(), rig.bus.read()
    assert second.valid.tolist() == [True, True, False, True, True, True]
    assert second.position_ticks[2] == 0  # and not to be used
    assert first.age_ns[2] == first.t_ns - never.t_ns
    assert second.age_ns[2] == second.t_ns - never.t_ns
    assert second.age_ns[0] == 0
    assert rig.bus.stats.timeouts == 2


def test_a_servo_that_never_answered_has_no_age() -> None:
    rig = Rig(armed=False)
    rig.servo(6).silent = True
    readings = rig.bus.read()
    assert readings.age_ns[5] == -1
    assert readings.hardware_error[5] == -1


def test_a_silent_servo_fits_into_a_period_of_100_hz() -> None:
    rig = Rig(armed=False)
    rig.servo(3).silent = True
    began_ns = rig.port.clock.now_ns()
    for _ in range(10):
        rig.bus.read()
    assert rig.port.clock.now_ns() - began_ns < 10 * 10_000_000  # virtual


def test_return_delays_are_waited_for() -> None:
    rig = Rig(armed=False, return_delay_time=254)

    def slow(servo_id: int, frame: Frame, at_ns: int, data: bytes) -> Replies:
        turns = servo_id if frame.instruction == Instruction.SYNC_READ else 1
        return [(at_ns + turns * 508_000, data)]

    rig.scripted.edit = slow
    rig.port.latency_ms = 0.0  # or its allowance would hide that the delays are not allowed for
    assert rig.bus.read().valid.all()


# Hardware errors.


def test_register_70_is_polled_one_servo_now_and_then_in_turn() -> None:
    rig = Rig(armed=False)
    polled = []
    for _ in range(7):
        for _ in range(POLL_EVERY_READS):
            rig.bus.read()
        polled.append(rig.polled())
    assert polled == [[2], [3], [4], [5], [6], [1], [2]]


def test_an_ordinary_read_is_one_request() -> None:
    rig = Rig(armed=False)
    rig.port.sent.clear()
    rig.bus.read()
    assert rig.port.sent == [
        bytes.fromhex("FF FF FD 00 FE 0D 00 82 7C 00 17 00 01 02 03 04 05 06 78 A7")
    ]


def test_an_alert_is_polled_at_once_and_kept() -> None:
    rig = Rig(armed=False)
    assert rig.bus.read().hardware_error.tolist() == [-1] * 6
    for servo_id, error in ((4, 0x20), (6, 0x04)):
        rig.servo(servo_id).alert = True
        rig.servo(servo_id).values["hardware_error_status"] = error
    rig.polled()
    readings = rig.bus.read()
    assert rig.polled() == [4]
    assert readings.error_byte.tolist() == [0, 0, 0, 0x80, 0, 0x80]
    assert readings.hardware_error[3] == 0x20
    assert readings.valid.all()
    assert rig.bus.read().hardware_error.tolist()[3:] == [0x20, -1, 0x04]  # the second one's turn
    rig.polled()
    rig.bus.read()
    assert rig.polled() == []  # both are explained


def test_the_poll_passes_over_a_silent_servo() -> None:
    rig = Rig(armed=False)
    rig.servo(2).silent = True
    for _ in range(2 * POLL_EVERY_READS):
        rig.bus.read()
    assert rig.polled() == [3, 3], "twice, as an answer that is owed may still come"


# Late replies.


def test_an_answer_of_the_cycle_before_is_not_taken_for_new() -> None:
    rig = Rig(armed=False)
    rig.bus.read()
    rig.servo(2).values["present_position"] = 111
    hold = [20_000_000]

    def late(servo_id: int, frame: Frame, at_ns: int, data: bytes) -> Replies:
        if servo_id == 2 and frame.instruction == Instruction.SYNC_READ and hold:
            return [(at_ns + hold.pop(), data)]
        return [(at_ns, data)]

    rig.scripted.edit = late
    assert not rig.bus.read().valid[1]
    rig.servo(2).values["present_position"] = 222
    rig.port.virtual.advance(20_000_000)
    readings = rig.bus.read()
    assert readings.valid.all()
    assert readings.position_ticks[1] == 222
    assert rig.bus.stats.late_replies == 1


# Goals.


def test_goals_are_refused_until_the_bus_is_armed_and_torque_is_on() -> None:
    rig = Rig(armed=False)
    with pytest.raises(BusError, match="torque is off"):
        rig.bus.write_goals(command(0.0))
    with pytest.raises(BusError, match="arm the robot"):
        rig.bus.torque_on()
    rig.bus.configure()
    with pytest.raises(BusError, match="torque is off; call torque_on first"):
        rig.bus.write_goals(command(0.0))
    assert rig.column("torque_enable") == [0] * 6


def test_goals_go_out_in_one_sync_write_in_each_servos_own_sense() -> None:
    rig = Rig()
    rig.bus.torque_on()
    rig.port.sent.clear()
    rig.bus.write_goals(command(TURN / 4))
    assert rig.column("goal_position") == [3072] * 3 + [1024] * 3
    assert rig.port.sent == [
        bytes.fromhex(
            "FF FF FD 00 FE 25 00 83 74 00 04 00 01 00 0C 00 00 02 00 0C 00 00 03 00 0C 00 00"
            "04 00 04 00 00 05 00 04 00 00 06 00 04 00 00 9F 8A"
        )
    ]


@pytest.mark.parametrize(
    ("angle", "words"),
    [
        (np.nan, "MR has a goal angle that is not a number"),
        (np.inf, "MR has a goal angle that is not a number"),
        (257 * TURN, "MR has a goal beyond 256 turns"),
    ],
)
def test_what_is_no_goal_is_refused_and_nothing_is_sent(angle: float, words: str) -> None:
    rig = Rig()
    rig.bus.torque_on()
    rig.port.sent.clear()
    with pytest.raises(BusError, match=words) as caught:
        rig.bus.write_goals(command(np.array([0, 0, 0, 0, angle, 0])))
    assert caught.value.ids == (5,)
    assert rig.port.sent == []


def test_a_command_without_torque_has_no_goals() -> None:
    rig = Rig()
    rig.bus.torque_on()
    with pytest.raises(BusError, match="call torque_off"):
        rig.bus.write_goals(command(0.0, torque=False))


# Torque.


def test_torque_goes_on_where_the_shafts_are_and_the_watchdog_is_armed() -> None:
    rig = Rig(goal_position=0)
    for i in IDS:
        rig.servo(i).values["present_position"] = 1000 * i
    goals_at_switch_on: dict[int, int] = {}

    def watch(servo_id: int, frame: Frame, at_ns: int, data: bytes) -> Replies:
        values = rig.servo(servo_id).values
        if values["torque_enable"] and servo_id not in goals_at_switch_on:
            goals_at_switch_on[servo_id] = values["goal_position"]
        return [(at_ns, data)]

    rig.scripted.edit = watch
    rig.bus.torque_on()
    assert goals_at_switch_on == {i: 1000 * i for i in IDS}
    assert rig.column("torque_enable") == [1] * 6
    assert rig.column("bus_watchdog") == [WATCHDOG_UNITS] * 6


def test_a_tripped_watchdog_does_not_keep_torque_from_going_on() -> None:
    rig = Rig()
    rig.servo(2).values["bus_watchdog"] = -1
    rig.bus.torque_on()
    assert rig.column("bus_watchdog") == [WATCHDOG_UNITS] * 6


def test_a_silent_servo_keeps_all_torque_off() -> None:
    rig = Rig()
    rig.servo(2).silent = True
    with pytest.raises(BusError, match="ML did not answer; torque stays off") as caught:
        rig.bus.torque_on()
    assert caught.value.ids == (2,)
    assert rig.column("torque_enable") == [0] * 6


@pytest.mark.parametrize("name", ["torque_enable", "bus_watchdog"])
def test_a_servo_that_does_not_obey_switches_all_off_again(name: str) -> None:
    rig = Rig()
    rig.servo(4).deaf_to = (name,)
    with pytest.raises(BusError, match=rf"HR \(id 4\) took {name} = \d+ and has 0"):
        rig.bus.torque_on()
    assert rig.column("torque_enable") == [0] * 6
    with pytest.raises(BusError, match="torque is off"):
        rig.bus.write_goals(command(0.0))


def test_torque_off_is_one_broadcast_read_back_from_each() -> None:
    rig = Rig()
    rig.bus.torque_on()
    rig.port.sent.clear()
    assert rig.bus.torque_off()
    assert rig.port.sent[0] == bytes.fromhex("FF FF FD 00 FE 06 00 03 40 00 00 2E 16")
    assert rig.column("torque_enable") == [0] * 6
    assert rig.column("bus_watchdog") == [0] * 6
    with pytest.raises(BusError, match="torque is off"):
        rig.bus.write_goals(command(0.0))


def test_torque_off_says_honestly_that_a_servo_did_not_answer() -> None:
    rig = Rig()
    rig.bus.torque_on()
    rig.servo(5).silent = True
    assert rig.bus.torque_off() is False
    assert rig.column("torque_enable") == [0, 0, 0, 0, 1, 0]
    assert rig.servo(5).values["bus_watchdog"] == WATCHDOG_UNITS  # it will stop by itself


def test_a_watchdog_is_not_cleared_where_torque_may_still_be_on() -> None:
    rig = Rig()
    rig.bus.torque_on()
    rig.servo(5).deaf_to = ("torque_enable",)
    rig.scripted.edit = lambda i, _, at, data: [] if i == 5 else [(at, data)]
    assert rig.bus.torque_off() is False
    assert rig.servo(5).values["torque_enable"] == 1
    assert rig.servo(5).values["bus_watchdog"] == WATCHDOG_UNITS


def test_torque_off_is_told_again_to_a_servo_whose_watchdog_has_tripped() -> None:
    rig = Rig()
    rig.bus.torque_on()
    stuck = rig.servo(3)
    stuck.values["bus_watchdog"] = -1
    stuck.deaf_to = ("torque_enable",)

    def free(servo_id: int, _frame: Frame, at_ns: int, data: bytes) -> Replies:
        if stuck.values["bus_watchdog"] == 0:
            stuck.deaf_to = ()
        return [(at_ns, data)]

    rig.scripted.edit = free
    assert rig.bus.torque_off()
    assert rig.column("torque_enable") == [0] * 6


def test_torque_off_survives_a_lost_broadcast() -> None:
    rig = Rig()
    rig.bus.torque_on()
    respond = rig.port.respond
    lost = [True]

    def deaf_once(request: bytes) -> Replies:
        if request[4] == BROADCAST_ID and lost and lost.pop():
            return []
        return respond(request)

    rig.port.respond = deaf_once
    assert rig.bus.torque_off()
    assert rig.column("torque_enable") == [0] * 6


@pytest.mark.parametrize("error", [ConnectionLost("gone"), OSError(5, "Input/output error")])
@pytest.mark.parametrize("broken_writes", [1, 2, 10_000])
def test_torque_off_never_raises(error: Exception, broken_writes: int) -> None:
    rig = Rig()
    rig.bus.torque_on()
    write, left = rig.port.writePort, [error] * broken_writes

    def broken(packet: bytes) -> int:
        if left:
            raise left.pop()
        return write(packet)

    rig.port.writePort = broken  # type: ignore[method-assign]
    confirmed = rig.bus.torque_off()
    assert confirmed == (rig.column("torque_enable") == [0] * 6)
    assert confirmed == (broken_writes < 10_000)


def test_a_pulled_cable_leaves_a_read_as_an_error() -> None:
    rig = Rig(armed=False)

    def gone(_packet: bytes) -> int:
        raise ConnectionLost("gone", port="scripted")

    rig.port.writePort = gone  # type: ignore[assignment]
    with pytest.raises(ConnectionLost):
        rig.bus.read()


# Statistics.


def test_statistics_count_what_happened() -> None:
    rig = Rig(armed=False)
    before = rig.bus.stats
    for _ in range(3):
        rig.bus.read()
    after = rig.bus.stats
    assert after.reads - before.reads == 3
    assert after.requests - before.requests == 3
    assert sum(after.round_trips) == 3
    assert (after.timeouts, after.crc_errors, after.late_replies) == (0, 0, 0)
    assert before.reads == 0  # a copy, not a view


def test_close_closes_the_port() -> None:
    rig = Rig(armed=False)
    rig.bus.close()
    assert not rig.port.is_open
