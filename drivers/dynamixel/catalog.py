"""The servos that are known here: control tables and motors of the MX(2.0) and X series, as data.

All have the registers of the MX-106(2.0) at the same addresses, but for a few that some do not have; what
differs is here. How to add one: docs/servos.md. Sources: ROBOTIS e-manual, the page of each model (table,
ranges, units, data sheet); the tables agree with the model files of the ``dynamixel_easy_sdk`` package, see
``tests/drivers/test_servo_models.py``. Where editions of the e-manual differ, the newer one is taken, as
of https://emanual.robotis.com/docs/kr/dxl/x/xh540-v270/ (current limit 1188, 2047 before) and of
https://emanual.robotis.com/docs/kr/dxl/x/xh430-v210/ (velocity limit 230, 380 before). Not sure is the
initial velocity limit of the MX-64 (https://emanual.robotis.com/docs/en/dxl/mx/mx-64-2/): docs/servos.md.
"""

import copyreg
import math
from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType

from drivers.dynamixel.base_table import MX_106_TABLE
from drivers.dynamixel.registers import (
    OperatingMode,
    Register,
    RegisterTable,
    indirect,
    kept,
    read_only,
    volatile,
)
from drivers.dynamixel.servo_model import MotorRatings, ServoModel

# Model numbers of the same servos with the old firmware, which is deaf to protocol 2.0.
PROTOCOL_1_NUMBERS = MappingProxyType({29: "MX-28", 310: "MX-64", 320: "MX-106"})
FIRST_WATCHDOG_FIRMWARE = 38  # e-manual, "Bus Watchdog"; the XL330 had it from the beginning

_LOAD = read_only("present_load", 126, 2, signed=True)  # 0.1 %, where there is no current
_PORTS = (
    *(kept(f"external_port_mode_{i}", 55 + i, 1, 3, 0, 3) for i in (1, 2, 3)),
    *(volatile(f"external_port_data_{i}", 150 + 2 * i, 2, 0, 0, 65535) for i in (1, 2, 3)),
)
_INDIRECT = tuple(one.name for one in MX_106_TABLE if one.name.startswith("indirect_"))
_NO_ACCELERATION_LIMIT = ("acceleration_limit",)
_NO_CURRENT = ("current_limit", "goal_current", "present_current")
_FEWER_MODES = frozenset({
    OperatingMode.VELOCITY, OperatingMode.POSITION, OperatingMode.EXTENDED_POSITION,
    OperatingMode.PWM,
})  # fmt: skip
# Drive modes: bit 0 reverse, bit 1 slave of two, bit 2 profiles by time, bit 3 torque on by a goal.
_ONE_JOINT, _X, _X_DUAL = (0, 0, 0x05), (0, 0, 0x0D), (0, 0, 0x0F)

Ranges = dict[str, tuple[int, int, int]]


def _speed(initial: int, highest: int = 1023) -> Ranges:
    return {"velocity_limit": (initial, 0, highest), "goal_velocity": (0, -highest, highest)}


def _current(highest: int) -> Ranges:
    limits = highest, 0, highest
    return {"current_limit": limits, "goal_current": (highest, -highest, highest)}


def _volts(lowest: int, highest: int, low_initial: int | None = None) -> Ranges:
    low = lowest if low_initial is None else low_initial
    return {
        "max_voltage_limit": (highest, lowest, highest),
        "min_voltage_limit": (low, lowest, highest),
    }


def _gain(position_p: int) -> Ranges:
    return {"position_p_gain": (position_p, 0, 16383)}


def _model(
    name: str,
    number: int,
    ratings: MotorRatings,
    ranges: Ranges,
    current_unit_a: float = math.nan,
    without: Sequence[str] = (),
    more: Sequence[Register] = (),
) -> ServoModel:
    """Return a model; without a unit of the current it has a load in its place."""
    measures = math.isfinite(current_unit_a)
    table = MX_106_TABLE.changed(
        without=(*without, *(() if measures else _NO_CURRENT)),
        ranges=ranges,
        more=(*more, *(() if measures else (_LOAD,))),
    )
    modes = frozenset(OperatingMode) if measures else _FEWER_MODES
    return ServoModel(name, number, table, current_unit_a, modes, ratings, FIRST_WATCHDOG_FIRMWARE)


def _mx(
    name: str, number: int, ratings: MotorRatings, ranges: Ranges, current_unit_a: float = math.nan
) -> ServoModel:
    return _model(name, number, ratings, {"drive_mode": _ONE_JOINT} | ranges, current_unit_a)


def _x430(
    name: str, number: int, ratings: MotorRatings, ranges: Ranges, current_unit_a: float = math.nan
) -> ServoModel:
    some = {"drive_mode": _X} | ranges
    return _model(name, number, ratings, some, current_unit_a, _NO_ACCELERATION_LIMIT)


def _x540(name: str, number: int, ratings: MotorRatings, ranges: Ranges) -> ServoModel:
    some = {"drive_mode": _X_DUAL} | _gain(800) | ranges
    return _model(name, number, ratings, some, _X_CURRENT_A, _NO_ACCELERATION_LIMIT, _PORTS)


def _xl330(name: str, number: int, ratings: MotorRatings, ranges: Ranges) -> ServoModel:
    """Return an XL330: 5 V, no faster than 4 Mbps, fewer indirect addresses."""
    some: Ranges = {
        "baud_rate": (1, 0, 6), "protocol_type": (2, 2, 22), "drive_mode": _X,
        "temperature_limit": (70, 0, 100), "shutdown": (0x35, 0, 0x3D),
    }  # fmt: skip
    some |= _volts(31, 70, 35) | _current(1750) | _gain(400) | ranges
    more = (kept("pwm_slope", 62, 1, 140, 1, 255), *indirect(1, 20, 168, 208, 227))
    model = _model(name, number, ratings, some, 0.001, (*_NO_ACCELERATION_LIMIT, *_INDIRECT), more)
    return replace(model, watchdog_firmware=0)


_MX_CURRENT_A, _X_CURRENT_A, _X_24_V_CURRENT_A = 0.00336, 0.00269, 0.00134
_XC430, _XM430 = _volts(60, 160), _current(1193) | _gain(800)
_24_V = _volts(110, 300)
_XH430_W, _XH430_V = _current(648) | _gain(900), _current(689) | _gain(800) | _24_V
_XL330_M077: Ranges = {
    "velocity_i_gain": (400, 0, 16383), "velocity_p_gain": (40, 0, 16383),
    "position_i_gain": (400, 0, 16383),
}  # fmt: skip
_XL330_M288: Ranges = {"velocity_i_gain": (1600, 0, 16383), "velocity_p_gain": (180, 0, 16383)}
_XL430: Ranges = _volts(60, 140) | _gain(640) | {
    "temperature_limit": (72, 0, 100), "velocity_i_gain": (1000, 0, 16383),
    "position_d_gain": (4000, 0, 16383),
}  # fmt: skip
_XC430_W150: Ranges = _XC430 | _gain(460) | {"moving_threshold": (20, 0, 1023)}
_MX_64 = _speed(435) | _current(1941)
_V = MotorRatings  # V, N m, A, rev/min

MX_106 = _model("MX-106(2.0)", 321, _V(12.0, 8.4, 5.2, 45), {}, _MX_CURRENT_A)
# In the order in which they are listed.
SERVO_MODELS: tuple[ServoModel, ...] = (
    MX_106,
    _mx("MX-64(2.0)", 311, _V(12.0, 6.0, 4.1, 63), _MX_64, _MX_CURRENT_A),
    _mx("MX-28(2.0)", 30, _V(12.0, 2.5, 1.4, 55), _speed(230)),
    _xl330("XL330-M077", 1190, _V(5.0, 0.215, 1.47, 383), _speed(1620, 2047) | _XL330_M077),
    _xl330("XL330-M288", 1200, _V(5.0, 0.52, 1.47, 103), _speed(445, 2047) | _XL330_M288),
    _x430("XL430-W250", 1060, _V(11.1, 1.4, 1.3, 57), _speed(265) | _XL430),
    _x430("XC430-W150", 1070, _V(12.0, 1.6, 1.4, 106), _speed(460) | _XC430_W150),
    _x430("XC430-W240", 1080, _V(12.0, 1.9, 1.4, 70), _speed(306) | _XC430 | _gain(700)),
    _x430("XM430-W210", 1030, _V(12.0, 3.0, 2.3, 77), _speed(330) | _XM430, _X_CURRENT_A),
    _x430("XM430-W350", 1020, _V(12.0, 4.1, 2.3, 46), _speed(200) | _XM430, _X_CURRENT_A),
    _x430("XH430-W210", 1010, _V(12.0, 2.5, 1.3, 50), _speed(210) | _XH430_W, _X_CURRENT_A),
    _x430("XH430-W350", 1000, _V(12.0, 3.4, 1.3, 30), _speed(130) | _XH430_W, _X_CURRENT_A),
    _x430("XH430-V210", 1050, _V(24.0, 2.6, 0.7, 52), _speed(230) | _XH430_V, _X_24_V_CURRENT_A),
    _x430("XH430-V350", 1040, _V(24.0, 3.3, 0.7, 31), _speed(135) | _XH430_V, _X_24_V_CURRENT_A),
    _x540("XM540-W150", 1130, _V(12.0, 7.3, 4.4, 53), _speed(230)),
    _x540("XM540-W270", 1120, _V(12.0, 10.6, 4.4, 30), _speed(128)),
    _x540("XH540-W150", 1110, _V(12.0, 7.1, 4.9, 70), _speed(300)),
    _x540("XH540-W270", 1100, _V(12.0, 9.9, 4.9, 39), _speed(167)),
    _x540("XH540-V150", 1150, _V(24.0, 6.4, 2.4, 60), _speed(230) | _current(1188) | _24_V),
    _x540("XH540-V270", 1140, _V(24.0, 9.2, 2.4, 34), _speed(128) | _current(1188) | _24_V),
)
MODEL_BY_NAME = MappingProxyType({one.name: one for one in SERVO_MODELS})
MODEL_BY_NUMBER = MappingProxyType({one.number: one for one in SERVO_MODELS})


def _places(table: RegisterTable) -> set[tuple[str, int, int, bool]]:
    return {(one.name, one.address, one.size, one.signed) for one in table}


_SHARED = set.intersection(*(_places(one.table) for one in SERVO_MODELS))
# What every one of them has at the same place; ranges and initial values are those of the MX-106.
COMMON = RegisterTable.of([
    one for one in MX_106.table if (one.name, one.address, one.size, one.signed) in _SHARED
])  # fmt: skip
# What the loop reads of every servo at once: everything measured, PWM to temperature. Two bytes of it are
# a current, or a load where there is none.
READ_ADDRESS = COMMON["present_pwm"].address
READ_LENGTH = COMMON["present_temperature"].end - READ_ADDRESS
CURRENT_OR_LOAD = MX_106.table["present_current"]


def model_named(name: str) -> ServoModel:
    """Return the model of a name that is known."""
    return MODEL_BY_NAME[name]


# Another process, such as that of the virtual devices, takes a model from its own catalogue.
copyreg.pickle(ServoModel, lambda model: (model_named, (model.name,)))


def _every() -> RegisterTable:
    items = list(MX_106.table)
    taken = {address for one in items for address in range(one.address, one.end)}
    for model in SERVO_MODELS:
        for one in model.table:
            bytes_of_it = range(one.address, one.end)
            if taken.isdisjoint(bytes_of_it):
                items.append(one)
                taken.update(bytes_of_it)
    return RegisterTable.of(sorted(items, key=lambda one: one.address))


# To name what goes over a wire, where nobody says whose it is: the MX-106's registers, and what other
# models have besides.
EVERY = _every()
