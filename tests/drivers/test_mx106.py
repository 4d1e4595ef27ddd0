"""The control table and the conversions of the MX-106(2.0)."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.mx106 import (
    REGISTER,
    REGISTERS,
    VELOCITY_UNIT_RAD_S,
    HardwareError,
    angle_to_ticks,
    hardware_error_names,
    joint_state,
    ticks_to_angle,
)
from robot.config import load_robot
from robot.rig import silent_readings

BUS = load_robot().servo_bus


@pytest.mark.parametrize(
    ("name", "address", "size", "initial"),
    [
        ("return_delay_time", 9, 1, 250),
        ("operating_mode", 11, 1, 3),
        ("homing_offset", 20, 4, 0),
        ("shutdown", 63, 1, 0x34),
        ("torque_enable", 64, 1, 0),
        ("hardware_error_status", 70, 1, None),
        ("position_p_gain", 84, 2, 850),
        ("bus_watchdog", 98, 1, 0),
        ("goal_position", 116, 4, 0),
        ("present_pwm", 124, 2, None),
        ("present_current", 126, 2, None),
        ("present_velocity", 128, 4, None),
        ("present_position", 132, 4, None),
        ("present_input_voltage", 144, 2, None),
        ("present_temperature", 146, 1, None),
        ("indirect_address_1", 168, 2, 224),
        ("indirect_data_56", 661, 1, 0),
    ],
)
def test_registers_are_where_the_manual_has_them(
    name: str, address: int, size: int, initial: int | None
) -> None:
    register = REGISTER[name]
    assert (register.address, register.size, register.initial) == (address, size, initial)


def test_registers_do_not_overlap() -> None:
    taken: dict[int, str] = {}
    for register in REGISTERS:
        for byte in range(register.address, register.address + register.size):
            assert byte not in taken, (register.name, taken.get(byte))
            taken[byte] = register.name


@given(st.sampled_from(REGISTERS), st.data())
def test_values_survive_the_bytes(register, data) -> None:  # type: ignore[no-untyped-def]
    value = data.draw(st.integers(register.minimum, register.maximum))
    assert register.decode(register.encode(value)) == value


@given(st.integers(-1_000_000, 1_000_000), st.sampled_from([1, -1]), st.integers(0, 4095))
def test_ticks_survive_the_angle(ticks: int, sign: int, zero: int) -> None:
    signs, zeros = np.array([sign]), np.array([zero])
    angle = ticks_to_angle(np.array([ticks]), signs, zeros)
    assert angle_to_ticks(angle, signs, zeros).tolist() == [ticks]


def test_the_velocity_unit_is_one_count_in_64_ms() -> None:
    assert VELOCITY_UNIT_RAD_S * 60 / (2 * np.pi) == pytest.approx(0.228882, abs=1e-6)


def test_right_hand_servos_are_mirrored_and_silence_is_nan() -> None:
    valid = np.array([True, True, True, True, True, False])
    readings = replace(
        silent_readings(7, 6),
        position_ticks=np.full(6, 2048 + 1024),
        velocity_counts=np.full(6, 100),
        current_counts=np.full(6, -10),
        voltage_counts=np.full(6, 121),
        temperature_c=np.full(6, 40),
        valid=valid,
    )
    joints = joint_state(readings, BUS)
    quarter = np.pi / 2
    assert joints.angle_rad[:5] == pytest.approx([quarter, quarter, quarter, -quarter, -quarter])
    assert joints.rate_rad_s[0] == pytest.approx(2.39691, abs=1e-4)
    assert joints.current_a[:4] == pytest.approx([-0.0336, -0.0336, -0.0336, 0.0336])
    assert joints.voltage_v[0] == pytest.approx(12.1)
    assert np.isnan([joints.angle_rad[5], joints.temperature_c[5], joints.voltage_v[5]]).all()


def test_hardware_errors_have_names() -> None:
    assert hardware_error_names(HardwareError.OVERLOAD | HardwareError.OVERHEATING) == (
        "overheating",
        "overload",
    )
    assert hardware_error_names(0) == ()
