"""What in the unit changes its data and is in no record: read, judged, set right."""

import numpy as np
import pytest

from drivers.ati.console import Console
from drivers.ati.unit_state import UnitState, read_unit_state, set_rate
from model.errors import ForceStreamError
from robot.config.robot_file import load_robot
from sim_hw.ati.console import ConsoleSession
from sim_hw.ati.memory import MemoryTextLink
from sim_hw.ati.unit import VirtualWnet
from sim_hw.clock import VirtualClock
from tests.drivers.test_ati_console import Scripted
from tests.drivers.test_ati_stream import Memory

SETTINGS = load_robot().force_sensor
# Bodies as a real unit with firmware 2.1.27 prints them, shortened.
ANSWERS = {
    "RATE": "Packet rate =  125 Hz\r\nADC    rate = 4000 Hz\r\nOversample  =   32\r\n",
    "XPWR": "Tr Auto   Now\r\n-- ----   ---\r\n 1 ON     ON\r\n 6 OFF    OFF\r\n"
    "Analog power = ON in AUTO mode\r\n",
    "FILTER": "Tr Filter  Taps\r\n-- ------  ----\r\n 1 MEAN      8\r\n 6 IIR     500\r\n",
    "BIAS": "Tr Ch Pwr   Bias\r\n 1  1  ON  ON\r\n 6  1  OFF  OFF\r\n",
    "VERSIONS": "Component   Version\r\n---------   -------\r\n"
    "Firmware    2.1.27 - Feb 18 2016 12:00:59\r\nCPLD 0      04\r\n",
}


class Printed(Scripted):
    """A console that answers each command as printed."""

    def write(self, data: bytes) -> None:
        word = data.decode().strip()
        self._ready = [f"{word}\r\n{ANSWERS[word]}>".encode()] if word else []


def state() -> UnitState:
    clock = VirtualClock()
    return read_unit_state(Console(Printed(clock), clock))


def test_what_a_real_unit_prints() -> None:
    assert state() == UnitState(
        rate_hz=125,
        oversampling=32,
        filters=((1, "MEAN", 8), (6, "IIR", 500)),
        biased=(1,),
        unpowered=(6,),
        firmware="2.1.27 - Feb 18 2016 12:00:59",
    )


def test_what_changes_forces_is_said() -> None:
    bias, iir, power = state().warnings(SETTINGS)
    assert "device bias is on for transducer 1" in bias
    assert "transducer 6 has the filter IIR 500" in iir
    assert "transducer 6 has no power" in power


def test_the_usual_state_says_nothing() -> None:
    clock = VirtualClock()
    unit = Memory().unit
    usual = read_unit_state(Console(MemoryTextLink(unit, clock), clock))
    assert usual.warnings(SETTINGS) == ()
    assert "MEAN 8" in usual.text


def test_a_rate_that_is_not_taken_is_an_error() -> None:
    clock = VirtualClock()
    ANSWERS["RATE 100 32"] = ANSWERS["RATE"]
    with pytest.raises(ForceStreamError, match="does not take rate 100 x 32"):
        set_rate(Console(Printed(clock), clock), 100, 32)


def test_a_filter_that_somebody_left_delays_forces(memory: Memory) -> None:
    session = ConsoleSession(memory.unit)
    session.give(b"FILTER 1 IIR 3200\r\n", 0)
    stream = memory.stream
    assert stream.unit_state is not None
    assert any("IIR" in line for line in read(memory).warnings(SETTINGS))


def read(memory: Memory) -> UnitState:
    return read_unit_state(Console(MemoryTextLink(memory.unit, memory.clock), memory.clock))


@pytest.fixture
def memory() -> Memory:
    made = Memory()
    made.stream.connect()
    return made


def test_device_bias_can_be_switched_off_again(memory: Memory) -> None:
    memory.stream.set_device_bias(on=True)
    assert read(memory).biased == (1, 2, 3, 4, 5, 6)
    memory.stream.set_device_bias(on=False)
    assert read(memory).biased == ()
    assert isinstance(memory.unit, VirtualWnet)
    assert np.all([s.bias is None for s in memory.unit.state])
