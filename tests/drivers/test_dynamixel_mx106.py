"""The control table as data, and counts to SI in the leg's sense and back."""

import numpy as np
import pytest
from dynamixel_sdk import DXL_HIWORD, DXL_LOWORD
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel.catalog import MX_106, READ_ADDRESS, READ_LENGTH
from drivers.dynamixel.joints import angle_to_ticks, joint_state, ticks_to_angle
from drivers.dynamixel.registers import hardware_error_names
from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import (
    BAUD_CODES,
    DUTY_FULL,
    EXTENDED_POSITION_LIMIT,
    TICKS_PER_TURN,
    VELOCITY_UNIT_RAD_S,
)
from model.values.readings import ServoReadings

PLUS, MINUS = np.array([1]), np.array([-1])
ZERO = np.array([2048])
TURN = 2 * np.pi


def test_registers_do_not_overlap() -> None:
    taken = [a for r in MX_106.table for a in range(r.address, r.address + r.size)]
    assert len(taken) == len(set(taken))
    assert max(taken) == 661


@pytest.mark.parametrize(
    ("name", "address", "size", "writable", "eeprom", "initial"),
    [
        ("model_number", 0, 2, False, True, None),
        ("return_delay_time", 9, 1, True, True, 250),
        ("operating_mode", 11, 1, True, True, 3),
        ("homing_offset", 20, 4, True, True, 0),
        ("shutdown", 63, 1, True, True, 52),
        ("torque_enable", 64, 1, True, False, 0),
        ("hardware_error_status", 70, 1, False, False, None),
        ("bus_watchdog", 98, 1, True, False, 0),
        ("goal_position", 116, 4, True, False, 0),
        ("present_position", 132, 4, False, False, None),
        ("present_temperature", 146, 1, False, False, None),
        ("indirect_address_29", 578, 2, True, False, 634),
        ("indirect_data_56", 661, 1, True, False, 0),
    ],
)
def test_registers_are_where_the_manual_says(
    name: str, address: int, size: int, writable: bool, eeprom: bool, initial: int | None
) -> None:
    register = MX_106.table[name]
    assert (register.address, register.size) == (address, size)
    assert (register.writable, register.eeprom) == (writable, eeprom)
    assert register.initial == initial


def test_one_block_holds_everything_measured() -> None:
    assert (READ_ADDRESS, READ_LENGTH) == (124, 23)


def test_initial_values_are_allowed_and_survive_their_bytes() -> None:
    registers = [r for r in MX_106.table if r.initial is not None]
    assert len(registers) > 100
    for register in registers:
        assert register.initial is not None
        assert register.minimum <= register.initial <= register.maximum, register
        assert register.decode(register.encode(register.initial)) == register.initial, register


@pytest.mark.parametrize(
    ("name", "data", "value"),
    [
        ("present_velocity", "FF FF FF FF", -1),
        ("present_current", "18 FC", -1000),
        ("present_position", "FD FF FF FF", -3),
        ("present_input_voltage", "78 00", 120),
        ("bus_watchdog", "FF", -1),
        ("torque_enable", "01", 1),
    ],
)
def test_bytes_have_the_sign_that_the_register_has(name: str, data: str, value: int) -> None:
    assert MX_106.table[name].decode(bytes.fromhex(data)) == value
    assert MX_106.table[name].encode(value) == bytes.fromhex(data)


@given(st.integers(-EXTENDED_POSITION_LIMIT, EXTENDED_POSITION_LIMIT))
def test_goal_bytes_agree_with_the_sdk(ticks: int) -> None:
    words = DXL_LOWORD(ticks), DXL_HIWORD(ticks)
    expected = b"".join(word.to_bytes(2, "little") for word in words)
    assert MX_106.table["goal_position"].encode(ticks) == expected


def test_a_value_that_does_not_fit_is_refused() -> None:
    with pytest.raises(OverflowError):
        MX_106.table["torque_enable"].encode(-1)
    with pytest.raises(OverflowError):
        MX_106.table["present_position"].encode(1 << 31)


def test_the_velocity_unit_is_one_tick_in_64_ms() -> None:
    assert pytest.approx(0.229, rel=1e-3) == VELOCITY_UNIT_RAD_S * 60 / TURN  # rpm
    # the manual's acceleration unit, 214.577 rev/min^2, is this one over 64 ms
    acceleration = VELOCITY_UNIT_RAD_S / 0.064 * 3600 / TURN
    assert acceleration == pytest.approx(214.577, rel=1e-5)


def test_baud_codes_are_the_eight_of_the_manual() -> None:
    assert [BAUD_CODES[b] for b in (9_600, 57_600, 1_000_000, 4_500_000)] == [0, 1, 3, 7]
    assert sorted(BAUD_CODES.values()) == list(range(8))


def test_hardware_errors_have_names_even_when_the_manual_gives_none() -> None:
    assert hardware_error_names(0) == ()
    assert hardware_error_names(0x21) == ("input voltage", "overload")
    assert hardware_error_names(0x42) == ("bit 0x02", "bit 0x40")


def test_a_quarter_turn_in_the_leg_sense() -> None:
    ticks = np.array([2048 + 1024])
    assert ticks_to_angle(ticks, PLUS, ZERO) == pytest.approx(TURN / 4)
    assert ticks_to_angle(ticks, MINUS, ZERO) == pytest.approx(-TURN / 4)


@given(
    ticks=st.integers(-EXTENDED_POSITION_LIMIT, EXTENDED_POSITION_LIMIT),
    sign=st.sampled_from([PLUS, MINUS]),
    zero=st.integers(0, TICKS_PER_TURN - 1),
)
def test_ticks_to_angle_and_back(ticks: int, sign: np.ndarray, zero: int) -> None:
    angle = ticks_to_angle(np.array([ticks]), sign, np.array([zero]))
    assert angle_to_ticks(angle, sign, np.array([zero])) == ticks


@given(st.floats(-1600, 1600), st.sampled_from([PLUS, MINUS]))
def test_rounding_costs_at_most_half_a_tick(angle: float, sign: np.ndarray) -> None:
    back = ticks_to_angle(angle_to_ticks(np.array([angle]), sign, ZERO), sign, ZERO)
    assert abs(back[0] - angle) <= TURN / TICKS_PER_TURN / 2 + 1e-9


@pytest.mark.parametrize("angle", [np.nan, np.inf])
def test_what_is_no_number_has_no_position(angle: float) -> None:
    with pytest.raises(ValueError, match="not a number"):
        angle_to_ticks(np.array([angle]), PLUS, ZERO)


def settings() -> ServoBusSettings:
    return ServoBusSettings(
        names=("HL", "HR"),
        ids=np.array([1, 2]),
        signs=np.array([1, -1]),
        zeros=np.array([2048, 2048]),
        models=(MX_106,) * 2,
        baud_rate=1_000_000,
        watchdog_s=0.1,
        silent_limit=5,
    )


def readings(valid: list[bool]) -> ServoReadings:
    both = np.array([1, 1], dtype=np.int64)
    return ServoReadings(
        t_ns=7,
        position_ticks=both * 3072,
        velocity_counts=both * -100,
        current_counts=both * 50,
        duty_counts=both * DUTY_FULL,
        voltage_counts=both * 121,
        temperature_c=both * 40,
        error_byte=both * 0,
        hardware_error=both * 0,
        valid=np.array(valid),
        age_ns=both * 0,
    )


def test_a_joint_state_is_in_the_leg_sense() -> None:
    state = joint_state(readings([True, True]), settings())
    np.testing.assert_allclose(state.angle_rad, [TURN / 4, -TURN / 4])
    np.testing.assert_allclose(state.rate_rad_s, np.array([-100, 100]) * VELOCITY_UNIT_RAD_S)
    np.testing.assert_allclose(state.current_a, np.array([50, -50]) * MX_106.current_unit_a)
    np.testing.assert_allclose(state.duty, [1, -1])
    np.testing.assert_allclose(state.voltage_v, [12.1, 12.1])
    np.testing.assert_allclose(state.temperature_c, [40, 40])
    assert state.t_ns == 7


def test_a_silent_servo_has_no_numbers() -> None:
    state = joint_state(readings([True, False]), settings())
    for column in (
        state.angle_rad,
        state.rate_rad_s,
        state.current_a,
        state.duty,
        state.voltage_v,
        state.temperature_c,
    ):
        assert np.isfinite(column[0])
        assert np.isnan(column[1])
        assert not column.flags.writeable
