"""Connecting asks and writes nothing; configuring writes only what differs."""

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.frames import Instruction, StatusError, build_status
from drivers.dynamixel.settings import ServoBusSettings
from model.errors import BusError
from tests.drivers.scripted_servos import ScriptedPort, ScriptedServos, Servo

ASKING = {Instruction.PING, Instruction.READ, Instruction.SYNC_READ}
SETTINGS = ServoBusSettings(
    names=("HL", "ML", "FR"),
    ids=np.array([1, 2, 6]),
    signs=np.array([1, 1, -1]),
    zeros=np.array([2048, 2048, 2048]),
    models=(MX_106,) * 3,
    baud_rate=1_000_000,
    watchdog_s=0.24,
    silent_limit=5,
)


def three() -> ScriptedServos:
    return ScriptedServos(Servo(1), Servo(2), Servo(6))


def bus_of(scripted: ScriptedServos) -> tuple[ServoBus, ScriptedPort]:
    port = ScriptedPort(scripted.respond)
    return ServoBus(port, SETTINGS), port


def test_everybody_introduces_himself() -> None:
    scripted = three()
    bus, port = bus_of(scripted)
    report = bus.connect()
    assert [s.leg for s in report.servos] == ["HL", "ML", "FR"]
    assert [s.servo_id for s in report.servos] == [1, 2, 6]
    assert {(s.model, s.firmware, s.voltage_v) for s in report.servos} == {(321, 44, 12.0)}
    assert report.warnings == ()
    assert bus.report is report
    assert {Instruction(f.instruction) for f in scripted.requests} <= ASKING
    assert port.is_open


def one(name: str, value: int) -> Callable[[ScriptedServos], None]:
    def change(scripted: ScriptedServos) -> None:
        scripted.servos[2].values[name] = value

    return change


def both(*changes: Callable[[ScriptedServos], None]) -> Callable[[ScriptedServos], None]:
    def change(scripted: ScriptedServos) -> None:
        for each in changes:
            each(scripted)

    return change


def silence(*ids: int) -> Callable[[ScriptedServos], None]:
    def change(scripted: ScriptedServos) -> None:
        for servo_id in ids:
            scripted.servos[servo_id].silent = True

    return change


@pytest.mark.parametrize(
    ("change", "words", "ids"),
    [
        (
            silence(1, 2, 6),
            "no servo answers on scripted at 1000000 baud: check power and cable, and whether the "
            "baud rate is right with: bigant devices --port scripted",
            (1, 2, 6),
        ),
        (
            silence(2),
            "ML (id 2) does not answer on scripted at 1000000 baud, 2 others do",
            (2,),
        ),
        (
            silence(2, 6),
            "ML (id 2), FR (id 6) do not answer on scripted at 1000000 baud, 1 other does",
            (2, 6),
        ),
        (one("model_number", 320), "ML (id 2) has protocol 1.0 firmware", (2,)),
        (
            one("model_number", 1060),
            "ML (id 2) is an XL430-W250 and the robot file says MX",
            (2,),
        ),
        (one("model_number", 9999), "ML (id 2) is model 9999, which is not known here", (2,)),
        (one("homing_offset", -100), "ML (id 2) has a homing offset of -100: set it to 0", (2,)),
        (
            one("hardware_error_status", 0x24),
            "ML (id 2) has shut down (overheating, overload): remove the cause, then switch",
            (2,),
        ),
        (
            one("status_return_level", 0),
            "ML (id 2) answers a ping and no read on scripted: its status return level may be 0",
            (2,),
        ),
    ],
)
def test_what_cannot_be_worked_with_is_named(
    change: Callable[[ScriptedServos], None], words: str, ids: tuple[int, ...]
) -> None:
    scripted = three()
    change(scripted)
    bus, port = bus_of(scripted)
    with pytest.raises(BusError, match=re.escape(words)) as caught:
        bus.connect()
    assert caught.value.ids == ids
    assert caught.value.port == port.name
    assert {Instruction(f.instruction) for f in scripted.requests} <= ASKING


def test_a_servo_with_the_old_firmware_is_asked_in_the_old_protocol() -> None:
    """Bytes of the protocol 1.0 manual: FF FF, id, length, instruction, checksum."""
    old = {
        bytes.fromhex("FF FF 02 02 01 FA"): bytes.fromhex("FF FF 02 02 00 FB"),
        bytes.fromhex("FF FF 02 04 02 00 02 F5"): bytes.fromhex("FF FF 02 04 00 40 01 B8"),
    }
    scripted = three()
    scripted.servos[2].silent = True
    bus, port = bus_of(scripted)
    respond = port.respond
    port.respond = lambda data: [(1000, old[data])] if data in old else respond(data)
    with pytest.raises(BusError, match=r"ML \(id 2\): protocol 1.0 firmware.*Dynamixel Wizard"):
        bus.connect()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (one("return_delay_time", 250), "ML wait 500 us before they answer"),
        (one("firmware_version", 37), "ML (id 2) has firmware 37, which has no bus watchdog"),
        (
            one("hardware_error_status", 0x01),  # not among the causes of a shutdown
            "ML (id 2) reports input voltage",
        ),
    ],
)
def test_what_should_be_put_right_is_a_warning(
    change: Callable[[ScriptedServos], None], words: str
) -> None:
    scripted = three()
    change(scripted)
    (warning,) = bus_of(scripted)[0].connect().warnings
    assert words in warning


def test_2_us_of_return_delay_are_no_reason_to_complain() -> None:
    scripted = three()
    one("return_delay_time", 1)(scripted)
    assert bus_of(scripted)[0].connect().warnings == ()


@pytest.mark.parametrize(("timer_ms", "count"), [(16.0, 1), (1.0, 0), (None, 0)])
def test_a_slow_latency_timer_is_a_warning(timer_ms: float | None, count: int) -> None:
    bus, port = bus_of(three())
    port.latency_timer_ms = timer_ms
    warnings = bus.connect().warnings
    assert len(warnings) == count
    assert all("set its latency_timer to 1" in warning for warning in warnings)


class _Shut(ScriptedPort):
    def openPort(self) -> bool:  # noqa: N802
        return False


def test_a_port_that_does_not_open_in_the_way_of_the_sdk() -> None:
    port = _Shut(lambda _: [])
    with pytest.raises(BusError, match="scripted cannot be opened at 1000000 baud"):
        ServoBus(port, SETTINGS).connect()


# Configuring.


def written(scripted: ScriptedServos, servo_id: int) -> list[tuple[str, int]]:
    by_address = {r.address: r for r in MX_106.table}
    found = []
    for frame in scripted.requests:
        if frame.instruction == Instruction.WRITE and frame.servo_id == servo_id:
            register = by_address[int.from_bytes(frame.parameters[:2], "little")]
            found.append((register.name, register.decode(frame.parameters[2:])))
    return found


def test_what_is_right_is_not_written_to_eeprom() -> None:
    scripted = three()
    bus, _ = bus_of(scripted)
    bus.connect()
    bus.configure()
    assert written(scripted, 1) == [
        ("torque_enable", 0),
        ("bus_watchdog", 0),
        ("profile_velocity", 0),
        ("profile_acceleration", 0),
    ]


def test_a_servo_in_any_other_state_is_brought_into_ours() -> None:
    scripted = three()
    scripted.servos[6].values |= {
        "torque_enable": 1,
        "bus_watchdog": -1,
        "operating_mode": 1,
        "status_return_level": 1,
        "profile_velocity": 30,
        "present_position": 201 * 4096 + 17,
    }
    bus, _ = bus_of(scripted)
    bus.connect()
    bus.configure()
    values = scripted.servos[6].values
    expected = {
        "torque_enable": 0,
        "bus_watchdog": 0,
        "operating_mode": 4,
        "status_return_level": 2,
        "profile_velocity": 0,
        "present_position": 17,
    }
    assert {name: values[name] for name in expected} == expected
    assert [f.servo_id for f in scripted.requests if f.instruction == Instruction.CLEAR] == [6]


def test_turns_within_range_are_left_alone() -> None:
    scripted = three()
    scripted.servos[1].values["present_position"] = -200 * 4096
    bus, _ = bus_of(scripted)
    bus.connect()
    bus.configure()
    assert scripted.servos[1].values["present_position"] == -200 * 4096


def test_a_value_that_is_taken_and_not_kept_is_found_out() -> None:
    scripted = three()
    scripted.servos[2].values["operating_mode"] = 3
    scripted.servos[2].deaf_to = ("operating_mode",)
    bus, _ = bus_of(scripted)
    bus.connect()
    with pytest.raises(BusError, match=r"ML \(id 2\) took operating_mode = 4 and has 3") as caught:
        bus.configure()
    assert caught.value.register == "operating_mode"


def test_an_error_of_the_servo_is_in_the_message() -> None:
    scripted = three()
    bus, _ = bus_of(scripted)
    bus.connect()
    scripted.servos[6].refuses["profile_velocity"] = StatusError.DATA_LIMIT
    words = re.escape("FR (id 6) did not take profile_velocity = 0: error: data limit")
    with pytest.raises(BusError, match=words):
        bus.configure()


def test_an_answer_lost_on_the_way_is_asked_for_again() -> None:
    scripted = three()
    bus, _ = bus_of(scripted)
    bus.connect()
    lost = [True]

    def edit(_id: int, frame, at: int, data: bytes):  # type: ignore[no-untyped-def]
        if frame.instruction == Instruction.WRITE and lost and lost.pop():
            return []
        return [(at, data)]

    scripted.edit = edit
    bus.configure()
    assert lost == []
    assert written(scripted, 1)[:2] == [("torque_enable", 0)] * 2


@pytest.mark.parametrize("instruction", [Instruction.READ, Instruction.WRITE])
def test_a_request_that_was_damaged_on_the_way_is_sent_again(instruction: Instruction) -> None:
    """A servo may say so, with a CRC error and nothing done: that is no refusal."""
    scripted = three()
    bus, _ = bus_of(scripted)
    bus.connect()
    damaged = [instruction]

    def edit(servo_id: int, frame, at: int, data: bytes):  # type: ignore[no-untyped-def]
        if damaged and frame.instruction == damaged[0]:
            damaged.pop()
            return [(at, build_status(servo_id, StatusError.CRC, b""))]
        return [(at, data)]

    scripted.edit = edit
    bus.configure()
    assert damaged == []


def test_a_refusal_is_not_asked_again() -> None:
    scripted = three()
    scripted.servos[2].refuses["torque_enable"] = StatusError.ACCESS
    bus, _ = bus_of(scripted)
    bus.connect()
    with pytest.raises(BusError, match="did not take torque_enable = 0: error: access"):
        bus.configure()
    assert written(scripted, 2).count(("torque_enable", 0)) == 1


def test_a_baud_rate_in_the_settings_is_in_the_advice() -> None:
    scripted = three()
    silence(1, 2, 6)(scripted)
    port = ScriptedPort(scripted.respond, 57_600)
    bus = ServoBus(port, replace(SETTINGS, baud_rate=57_600))
    with pytest.raises(BusError, match="at 57600 baud"):
        bus.connect()


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("drive_mode", 1, "turns backwards"),
        ("drive_mode", 4, "takes profiles for times"),
        ("secondary_id", 6, "also obeys id 6"),
    ],
)
def test_a_servo_that_would_not_do_as_told_is_refused(name: str, value: int, words: str) -> None:
    scripted = three()
    one(name, value)(scripted)
    bus, _ = bus_of(scripted)
    with pytest.raises(BusError, match=words):
        bus.connect()


def test_limits_that_hold_a_servo_back_are_a_warning() -> None:
    scripted = three()
    both(one("pwm_limit", 500), one("shutdown", 0))(scripted)
    bus, _ = bus_of(scripted)
    first, second = bus.connect().warnings
    assert "pwm_limit 500" in first
    assert "shutdown 0" in second
