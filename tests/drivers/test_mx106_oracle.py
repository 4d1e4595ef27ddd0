"""The control table against two sources that know nothing of ours: ROBOTIS' model file and its e-manual.

The virtual servos read the driver's own table, so only this would see an exchanged address or a wrong unit.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from importlib.resources import files

import pytest

from drivers.dynamixel import units
from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.registers import Register

# The e-manual's page of the MX-106(2.0): address, size, name, access, initial value, range. "-" is none.
MANUAL = """
0 2 Model_Number R 321 -
2 4 Model_Information R - -
6 1 Firmware_Version R - -
7 1 ID RW 1 0 252
8 1 Baud_Rate RW 1 0 7
9 1 Return_Delay_Time RW 250 0 254
10 1 Drive_Mode RW 0 0 7
11 1 Operating_Mode RW 3 0 16
12 1 Secondary_ID RW 255 0 255
13 1 Protocol_Type RW 2 1 2
20 4 Homing_Offset RW 0 -1044479 1044479
24 4 Moving_Threshold RW 10 0 1023
31 1 Temperature_Limit RW 80 0 100
32 2 Max_Voltage_Limit RW 160 95 160
34 2 Min_Voltage_Limit RW 95 95 160
36 2 PWM_Limit RW 885 0 885
38 2 Current_Limit RW 2047 0 2047
40 4 Acceleration_Limit RW 32767 0 32767
44 4 Velocity_Limit RW 210 0 1023
48 4 Max_Position_Limit RW 4095 0 4095
52 4 Min_Position_Limit RW 0 0 4095
63 1 Shutdown RW 52 0 61
64 1 Torque_Enable RW 0 0 1
65 1 LED RW 0 0 1
68 1 Status_Return_Level RW 2 0 2
69 1 Registered_Instruction R 0 -
70 1 Hardware_Error_Status R 0 -
76 2 Velocity_I_Gain RW 1920 0 16383
78 2 Velocity_P_Gain RW 100 0 16383
80 2 Position_D_Gain RW 0 0 16383
82 2 Position_I_Gain RW 0 0 16383
84 2 Position_P_Gain RW 850 0 16383
88 2 Feedforward_2nd_Gain RW 0 0 16383
90 2 Feedforward_1st_Gain RW 0 0 16383
98 1 Bus_Watchdog RW 0 -1 127
100 2 Goal_PWM RW - -885 885
102 2 Goal_Current RW - -2047 2047
104 4 Goal_Velocity RW - -1023 1023
108 4 Profile_Acceleration RW 0 0 32767
112 4 Profile_Velocity RW 0 0 32767
116 4 Goal_Position RW - -1048575 1048575
120 2 Realtime_Tick R - -
122 1 Moving R 0 -
123 1 Moving_Status R 0 -
124 2 Present_PWM R - signed
126 2 Present_Current R - signed
128 4 Present_Velocity R - signed
132 4 Present_Position R - signed
136 4 Velocity_Trajectory R - signed
140 4 Position_Trajectory R - signed
144 2 Present_Input_Voltage R - -
146 1 Present_Temperature R - -
"""
RAM_FROM = 64


@dataclass(frozen=True)
class Driver:
    """What the driver believes of the servo."""

    registers: tuple[Register, ...] = MX_106.table.registers
    velocity_rad_s: float = units.VELOCITY_UNIT_RAD_S
    current_a: float = MX_106.current_unit_a
    voltage_v: float = units.VOLTAGE_UNIT_V
    duty_full: int = units.DUTY_FULL
    turn_ticks: int = units.TICKS_PER_TURN
    watchdog_s: float = units.WATCHDOG_UNIT_S
    return_delay_s: float = units.RETURN_DELAY_UNIT_S

    def direct(self) -> Mapping[str, Register]:
        """Its registers without the indirect ones, of which both sources list ranges only."""
        return {r.name: r for r in self.registers if not r.name.startswith("indirect_")}


def model_file() -> str:
    """ROBOTIS' model file of the MX-106(2.0), as its Python package ships it."""
    path = files("dynamixel_easy_sdk") / "control_table" / "mx_106.model"
    return path.read_text("utf-8").replace("Secondary(Shadow) ID", "Secondary ID")


def against_the_model_file(driver: Driver) -> list[str]:
    """Return what differs from ROBOTIS' model file."""
    head, _, table = model_file().partition("[control table]")
    rows = [line.split("\t") for line in table.splitlines()[2:]]
    theirs = {
        row[2].lower().replace(" ", "_"): (int(row[0]), int(row[1]))
        for row in rows
        if not row[2].startswith("Indirect")
    }
    ours = {name: (r.address, r.size) for name, r in driver.direct().items()}
    wrong = [name for name in theirs | ours if theirs.get(name) != ours.get(name)]
    lines = [line.split("\t") for line in head.splitlines()]
    values = {row[0]: row[1:] for row in lines if len(row) > 1}
    for name in ("Present Velocity", "Goal Velocity"):
        unit, what, sign = values[name]
        assert (what, sign) == ("rad/s", "signed")
        if not math.isclose(float(unit), driver.velocity_rad_s, rel_tol=1e-3):
            wrong.append(f"unit of {name}")
    signed = [row[0] for row in values.items() if row[1][-1] == "signed"]
    assert len(signed) == 4
    ours_signed = {name: register.signed for name, register in driver.direct().items()}
    wrong += [f"sign of {n}" for n in signed if not ours_signed[n.lower().replace(" ", "_")]]
    low, high = (int(values[f"value_of_{k}_radian_position"][0]) for k in ("min", "max"))
    if (low, high) != (0, driver.turn_ticks - 1):
        wrong.append("a turn")
    return wrong


def against_the_manual(driver: Driver) -> list[str]:
    """Return what differs from the e-manual: places, access, initial values, ranges, units."""
    wrong = []
    ours = dict(driver.direct())
    for line in MANUAL.split("\n")[1:-1]:
        address, size, name, access, initial, *limits = line.split()
        register = ours.pop(name.lower(), None)
        if register is None:
            wrong.append(name)
            continue
        bits = 8 * int(size)
        signed = limits == ["signed"] or (limits[0].startswith("-") and limits != ["-"])
        expected = replace(
            register,
            address=int(address),
            size=int(size),
            writable=access == "RW",
            eeprom=int(address) < RAM_FROM,
            signed=signed,
            minimum=int(limits[0]) if len(limits) == 2 else -(1 << bits - 1) if signed else 0,
            maximum=int(limits[1]) if len(limits) == 2 else (1 << bits - signed) - 1,
        )
        if access == "RW" and initial != "-":
            expected = replace(expected, initial=int(initial))
        if register != expected:
            wrong.append(name)
    # Its units: 0.229 rpm, 3.36 mA (2047 of them are the data sheet's 6.88 A), 0.1 V, 0.113 %, 20 ms, 2 us.
    units = {
        "velocity": (driver.velocity_rad_s, 0.229 * 2 * math.pi / 60),
        "current": (driver.current_a, 6.88 / 2047),
        "voltage": (driver.voltage_v, 16.0 / 160),
        "PWM": (1 / driver.duty_full, 0.00113),
        "position": (360 / driver.turn_ticks, 0.0879),
        "watchdog": (driver.watchdog_s, 2.54 / 127),
        "return delay": (driver.return_delay_s, 508e-6 / 254),
    }
    wrong += [n for n, (mine, unit) in units.items() if not math.isclose(mine, unit, rel_tol=1e-3)]
    return wrong + list(ours)


def test_the_table_is_that_of_both_sources() -> None:
    assert against_the_model_file(Driver()) == []
    assert against_the_manual(Driver()) == []


def exchanged(one: str, other: str) -> Driver:
    """A driver that takes one register for the other: their addresses are exchanged."""
    place = {r.name: r.address for r in MX_106.table}
    swap = {one: place[other], other: place[one]}
    return Driver(tuple(replace(r, address=swap.get(r.name, r.address)) for r in MX_106.table))


def changed(name: str, **what: object) -> Driver:
    """A driver with one register changed."""
    return Driver(
        tuple(replace(r, **what) if r.name == name else r for r in MX_106.table)  # type: ignore[arg-type]
    )


@pytest.mark.parametrize(
    ("mutant", "sources"),
    [
        (exchanged("profile_velocity", "profile_acceleration"), "both"),
        (exchanged("goal_pwm", "goal_current"), "both"),
        (exchanged("present_pwm", "present_current"), "both"),
        (exchanged("pwm_limit", "current_limit"), "both"),
        (exchanged("max_voltage_limit", "min_voltage_limit"), "both"),
        (exchanged("velocity_i_gain", "velocity_p_gain"), "both"),
        (replace(Driver(), velocity_rad_s=1.1 * units.VELOCITY_UNIT_RAD_S), "both"),
        (replace(Driver(), current_a=1.34 * MX_106.current_unit_a), "manual"),
        (replace(Driver(), voltage_v=0.12), "manual"),
        (replace(Driver(), watchdog_s=0.01), "manual"),
        (changed("present_current", signed=False), "both"),
        (changed("min_voltage_limit", minimum=0), "manual"),
        (changed("velocity_limit", maximum=32767), "manual"),
        (changed("velocity_limit", initial=360), "manual"),
        (changed("torque_enable", eeprom=True), "manual"),
        (changed("model_number", writable=True), "manual"),
        (changed("realtime_tick", size=4), "both"),
    ],
)
def test_a_wrong_table_is_seen(mutant: Driver, sources: str) -> None:
    against: Mapping[str, Callable[[Driver], list[str]]] = {
        "file": against_the_model_file,
        "manual": against_the_manual,
    }
    for source, differences in against.items():
        assert bool(differences(mutant)) is (sources in {"both", source}), source
