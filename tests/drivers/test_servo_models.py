"""Every servo known here against ROBOTIS' model files and its e-manual, which know nothing of ours."""

import math
import pickle
from functools import cache
from importlib.resources import files
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.dynamixel.catalog import (
    COMMON,
    CURRENT_OR_LOAD,
    EVERY,
    MODEL_BY_NAME,
    MODEL_BY_NUMBER,
    MX_106,
    READ_ADDRESS,
    READ_LENGTH,
    SERVO_MODELS,
)
from drivers.dynamixel.frames import Instruction, build_instruction
from drivers.dynamixel.joints import joint_state
from drivers.dynamixel.model_words import mismatch_words, model_name
from drivers.dynamixel.registers import OperatingMode, Register
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.units import DUTY_FULL, TICKS_PER_TURN, VELOCITY_UNIT_RAD_S
from drivers.wire.words import wire_words
from model.values.readings import ServoReadings
from model.values.wire import Wire, WireBytes

# The e-manual's pages: name, number, current unit [mA], current limit, velocity limit and its largest
# value, the smallest and largest voltage limit and the initial smaller one [0.1 V], temperature limit, P
# gain of the position, largest baud code, slope of the PWM or external ports besides, stall torque [N m]
# and current [A], no-load speed [rev/min], at [V]. "-" is none.
MANUAL = """
MX-106(2.0) 321 3.36 2047 210 1023 95 160 95 80 850 7 - 8.4 5.2 45 12.0
MX-64(2.0) 311 3.36 1941 435 1023 95 160 95 80 850 7 - 6.0 4.1 63 12.0
MX-28(2.0) 30 - - 230 1023 95 160 95 80 850 7 - 2.5 1.4 55 12.0
XL330-M077 1190 1.0 1750 1620 2047 31 70 35 70 400 6 slope 0.215 1.47 383 5.0
XL330-M288 1200 1.0 1750 445 2047 31 70 35 70 400 6 slope 0.52 1.47 103 5.0
XL430-W250 1060 - - 265 1023 60 140 60 72 640 7 - 1.4 1.3 57 11.1
XC430-W150 1070 - - 460 1023 60 160 60 80 460 7 - 1.6 1.4 106 12.0
XC430-W240 1080 - - 306 1023 60 160 60 80 700 7 - 1.9 1.4 70 12.0
XM430-W210 1030 2.69 1193 330 1023 95 160 95 80 800 7 - 3.0 2.3 77 12.0
XM430-W350 1020 2.69 1193 200 1023 95 160 95 80 800 7 - 4.1 2.3 46 12.0
XH430-W210 1010 2.69 648 210 1023 95 160 95 80 900 7 - 2.5 1.3 50 12.0
XH430-W350 1000 2.69 648 130 1023 95 160 95 80 900 7 - 3.4 1.3 30 12.0
XH430-V210 1050 1.34 689 230 1023 110 300 110 80 800 7 - 2.6 0.7 52 24.0
XH430-V350 1040 1.34 689 135 1023 110 300 110 80 800 7 - 3.3 0.7 31 24.0
XM540-W150 1130 2.69 2047 230 1023 95 160 95 80 800 7 ports 7.3 4.4 53 12.0
XM540-W270 1120 2.69 2047 128 1023 95 160 95 80 800 7 ports 10.6 4.4 30 12.0
XH540-W150 1110 2.69 2047 300 1023 95 160 95 80 800 7 ports 7.1 4.9 70 12.0
XH540-W270 1100 2.69 2047 167 1023 95 160 95 80 800 7 ports 9.9 4.9 39 12.0
XH540-V150 1150 2.69 1188 230 1023 110 300 110 80 800 7 ports 6.4 2.4 60 24.0
XH540-V270 1140 2.69 1188 128 1023 110 300 110 80 800 7 ports 9.2 2.4 34 24.0
"""
ROWS = {line.split()[0]: line.split()[1:] for line in MANUAL.strip().splitlines()}
each = pytest.mark.parametrize("model", SERVO_MODELS, ids=lambda model: model.name)


@cache
def vendor_file(name: str) -> str:
    """A model file of ROBOTIS, as its Python package ships it."""
    folder = files("dynamixel_easy_sdk") / "control_table"
    text = (folder / name).read_text("utf-8").replace("\r", "")
    return text.replace("Secondary(Shadow) ID", "Secondary ID")


def vendor_name(model: ServoModel) -> str:
    """Name of a model's file, by the vendor's own list of numbers."""
    rows = [line.split("\t") for line in vendor_file("dynamixel.model").splitlines()[1:]]
    return {int(row[0]): row[1] for row in rows if len(row) == 2}[model.number]


def vendor_table(text: str) -> dict[str, tuple[int, int]]:
    """Address and size of the registers in a model file, by our names."""
    lines = text.partition("[control table]")[2].splitlines()[2:]
    rows = [line.split("\t") for line in lines if line.strip()]
    return {row[2].strip().lower().replace(" ", "_"): (int(row[0]), int(row[1])) for row in rows}


@each
def test_a_table_is_that_of_the_vendor(model: ServoModel) -> None:
    name = vendor_name(model)
    assert name.removesuffix(".model") == model.name.lower().removesuffix("(2.0)").replace("-", "_")
    theirs = vendor_table(vendor_file(name))
    ours = {one.name: (one.address, one.size) for one in model.table}
    direct = {n: place for n, place in theirs.items() if not n.startswith("indirect")}
    assert {n: place for n, place in ours.items() if not n.startswith("indirect")} == direct
    if model.name.startswith("XL330"):  # manual and file of firmware 52 agree
        theirs = vendor_table(vendor_file(name.replace(".model", "_fw52.model")))
    for one in ("indirect_address_1", "indirect_data_1"):
        assert ours[one] == theirs[one]


@each
def test_units_and_signs_are_those_of_the_vendor(model: ServoModel) -> None:
    head = vendor_file(vendor_name(model)).partition("[control table]")[0]
    values = {row[0]: row[1:] for row in (line.split("\t") for line in head.splitlines()) if row}
    low, high = (int(values[f"value_of_{k}_radian_position"][0]) for k in ("min", "max"))
    assert (low, high) == (0, TICKS_PER_TURN - 1)
    for name in ("Present Velocity", "Goal Velocity"):
        unit, what, sign = values[name]
        assert (what, sign) == ("rad/s", "signed")
        assert math.isclose(float(unit), VELOCITY_UNIT_RAD_S, rel_tol=1e-3)
    assert ("Present Current" in values) is model.measures_current
    for name in (row for row in values if values[row] and values[row][-1] == "signed"):
        assert model.table[name.lower().replace(" ", "_")].signed, name


@each
def test_limits_and_motor_are_those_of_the_manual(model: ServoModel) -> None:
    row = ROWS[model.name]
    table, ratings = model.table, model.ratings
    assert model.number == int(row[0])
    if row[1] == "-":
        assert math.isnan(model.current_unit_a)
        assert not {"current_limit", "goal_current", "present_current"} & set(table.by_name)
        assert table["present_load"].address == 126
    else:
        assert model.current_unit_a * 1e3 == pytest.approx(float(row[1]))
        limit = int(row[2])
        assert (table["current_limit"].initial, table["current_limit"].maximum) == (limit, limit)
        assert table["goal_current"].minimum == -limit
    speed = table["velocity_limit"]
    assert (speed.initial, speed.maximum) == (int(row[3]), int(row[4]))
    assert (table["goal_velocity"].minimum, table["goal_velocity"].maximum) == (
        -speed.maximum,
        speed.maximum,
    )
    low, high = table["min_voltage_limit"], table["max_voltage_limit"]
    assert [low.minimum, high.maximum, low.initial] == [int(v) for v in row[5:8]]
    assert (low.maximum, high.minimum, high.initial) == (high.maximum, low.minimum, high.maximum)
    assert table["temperature_limit"].initial == int(row[8])
    assert table["position_p_gain"].initial == int(row[9])
    assert table["baud_rate"].maximum == int(row[10])
    assert ("pwm_slope" in table) is (row[11] == "slope")
    assert ("external_port_mode_3" in table) is (row[11] == "ports")
    figures = ratings.stall_torque_n_m, ratings.stall_current_a, ratings.no_load_rpm
    assert [*figures, ratings.voltage_v] == [float(v) for v in row[12:]]


@each
def test_a_table_is_sound(model: ServoModel) -> None:
    taken = [a for one in model.table for a in range(one.address, one.end)]
    assert len(taken) == len(set(taken))
    for one in model.table:
        if one.initial is not None:
            assert one.minimum <= one.initial <= one.maximum, one.name
            assert one.decode(one.encode(one.initial)) == one.initial
        assert one.eeprom is (one.address < 64)
    kept = [r for run in model.table.kept_runs for r in model.table.between(*run)]
    assert {r.name for r in kept} == {r.name for r in model.table if r.eeprom}
    for first, last in (*model.table.kept_runs, *model.table.gain_runs):
        run = model.table.between(first, last)
        assert all(a.end == b.address for a, b in pairwise(run)), "no gap"
    assert OperatingMode.EXTENDED_POSITION in model.modes
    assert (OperatingMode.CURRENT in model.modes) is model.measures_current


def test_every_model_of_the_list_is_here_once() -> None:
    assert list(ROWS) == [model.name for model in SERVO_MODELS] == list(MODEL_BY_NAME)
    assert len(MODEL_BY_NUMBER) == len(SERVO_MODELS)


def test_what_the_loop_reads_is_in_every_model() -> None:
    """One sync read of 23 bytes fits them all, two of which are a current or a load."""
    assert (READ_ADDRESS, READ_LENGTH) == (124, 23)
    read = [one for one in MX_106.table if 120 <= one.address < READ_ADDRESS + READ_LENGTH]
    for model in SERVO_MODELS:
        for one in read:
            name = one.name if one.name in model.table else "present_load"
            place = model.table[name]
            assert (place.address, place.size, place.signed) == (one.address, one.size, one.signed)
    assert CURRENT_OR_LOAD.address == 126
    needed = "goal_position torque_enable bus_watchdog hardware_error_status shutdown homing_offset"
    assert set(needed.split()) <= set(COMMON.by_name)


def bus_settings(*models: ServoModel) -> ServoBusSettings:
    count = len(models)
    return ServoBusSettings(
        names=tuple(f"L{i}" for i in range(count)),
        ids=np.arange(1, count + 1),
        signs=np.array([1, -1] * count)[:count],
        zeros=np.full(count, 2048),
        models=models,
        baud_rate=1_000_000,
        watchdog_s=0.24,
        silent_limit=5,
    )


def same_readings(count: int, current: int, velocity: int = 0) -> ServoReadings:
    one = np.ones(count, dtype=np.int64)
    return ServoReadings(
        1, one * 2048, one * velocity, one * current, one * 0, one * 50, one * 30, one * 0, one * 0,
        np.ones(count, dtype=bool), one * 0,
    )  # fmt: skip


# 23 bytes from 124 as an XL330 sends them: PWM -443, current -120 mA, velocity -17, position 3072,
# trajectories, 5.0 V, 31 degC.
XL330_BLOCK = "45 FE 88 FF EF FF FF FF 00 0C 00 00 00 00 00 00 00 0C 00 00 32 00 1F"


def test_bytes_of_an_xl330() -> None:
    data, model = bytes.fromhex(XL330_BLOCK), MODEL_BY_NAME["XL330-M288"]
    assert len(data) == READ_LENGTH

    def value(name: str) -> int:
        one: Register = model.table[name]
        return one.decode(data[one.address - READ_ADDRESS : one.end - READ_ADDRESS])

    assert value("present_pwm") == -443
    assert value("present_current") * model.current_unit_a == pytest.approx(-0.120)
    assert value("present_velocity") * VELOCITY_UNIT_RAD_S * 30 / math.pi == pytest.approx(
        -3.89, 1e-3
    )
    assert value("present_position") == 3072
    assert value("present_input_voltage") == 50
    assert value("present_temperature") == 31


@given(
    counts=st.integers(-2047, 2047),
    velocity=st.integers(-2047, 2047),
    models=st.lists(st.sampled_from(SERVO_MODELS), min_size=1, max_size=8),
)
def test_counts_become_amperes_of_each_servo_by_its_own_unit(
    counts: int, velocity: int, models: list[ServoModel]
) -> None:
    state = joint_state(same_readings(len(models), counts, velocity), bus_settings(*models))
    for k, model in enumerate(models):
        sign = 1 if k % 2 == 0 else -1
        unit_ma = ROWS[model.name][1]
        if unit_ma == "-":
            assert math.isnan(state.current_a[k])
        else:
            assert state.current_a[k] == pytest.approx(sign * counts * float(unit_ma) * 1e-3)
        rpm = state.rate_rad_s[k] * 60 / (2 * math.pi)
        assert rpm == pytest.approx(sign * velocity * 0.229, rel=1e-3)
    assert state.valid.all(), "a current that is not measured makes no servo silent"


def test_a_model_number_in_words() -> None:
    assert model_name(1060) == "XL430-W250"
    assert model_name(320) == "MX-106 with protocol 1.0 firmware"
    assert model_name(9999) == "model 9999"
    assert mismatch_words(MX_106, 321) == ""
    assert "put the MX-28(2.0) firmware on it" in mismatch_words(MX_106, 29)
    assert mismatch_words(MX_106, 1020) == (
        "is an XM430-W350 and the robot file says MX-106(2.0): set model in [servo] of the robot file, "
        "unless the id is that of another leg"
    )
    unknown = mismatch_words(MX_106, 9999)
    assert unknown.startswith(
        "is model 9999, which is not known here; check that the id is not that of another"
    )
    assert all(model.name in unknown for model in SERVO_MODELS)
    assert unknown.endswith("how to add one: docs/servos.md")
    assert DUTY_FULL == 885


def test_a_model_in_another_process_is_the_same_model() -> None:
    for model in MODEL_BY_NAME.values():
        assert pickle.loads(pickle.dumps(model)) is model


def test_the_page_lists_every_model_with_its_figures() -> None:
    page = (Path(__file__).resolve().parents[2] / "docs" / "servos.md").read_text("utf-8")
    rows = [line.split(" | ") for line in page.splitlines() if line.startswith(("| MX", "| X"))]
    assert [row[0].removeprefix("| ") for row in rows] == list(MODEL_BY_NAME)
    for row in rows:
        model = MODEL_BY_NAME[row[0].removeprefix("| ")]
        assert int(row[1]) == model.number
        assert row[2] == f"{model.lowest_voltage_v:g} to {model.highest_voltage_v:g} V"
        milliamperes = model.current_unit_a * 1e3
        measured = f"{milliamperes:g} mA, to {model.highest_current_a:.2f} A"
        assert row[3] == (measured if model.measures_current else "none (a load)")
        motor = model.ratings
        figures = (
            f"{motor.stall_torque_n_m:g} N m, {motor.stall_current_a:g} A, {motor.no_load_rpm:g}"
        )
        assert row[4].startswith(f"{figures} rpm at {motor.voltage_v:g} V")


def test_traffic_is_named_by_the_registers_of_all_models() -> None:
    assert set(MX_106.table) <= set(EVERY)
    assert {"pwm_slope", "external_port_mode_2", "external_port_data_3"} <= set(EVERY.by_name)
    taken = [address for one in EVERY for address in range(one.address, one.end)]
    assert len(taken) == len(set(taken))
    write = build_instruction(3, Instruction.WRITE, bytes.fromhex("66 00 2C 01 3E 00"))
    read = build_instruction(3, Instruction.READ, bytes.fromhex("3E 00 01 00"))
    lines = [
        words.line
        for data in (write, read)
        for words in wire_words(WireBytes(0, Wire.SERVO_BUS, True, data))
    ]
    assert lines[0].startswith("write to id 3: goal_current = 300")
    assert lines[1] == "read pwm_slope of id 3"
