"""An answer that comes late, in the middle of a later request, never passes for the answer to that one."""

from collections import Counter
from typing import Any

import numpy as np
import pytest

from benchmarks.faults.witness import MarkedBench, fits
from drivers.dynamixel.bus import LONGEST_LEAD, ServoBus
from drivers.dynamixel.catalog import COMMON, MX_106
from drivers.dynamixel.requests import ServoRequests
from robot.config.robot_file import load_robot
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.port import MemoryPort
from sim_hw.faults.scenario import parse_scenario
from sim_hw.host.virtual_robot import put_devices

CONFIG = load_robot()
LATE = '[[fault]]\nkind = "late_reply"\nrate = 0.1\n[[fault]]\nkind = "lost_reply"\nrate = 0.1\n'
SYNC_READ = 0x82


class Bench:
    """Servos whose currents tell the time, with late and lost replies, and a bus that only reads."""

    def __init__(self, faults: str) -> None:
        self.clock = VirtualClock(start_ns=1_000_000_000)
        firmware = FirmwareBank(6)
        self.world = MarkedBench(firmware, CONFIG.servo_bus.zeros, 60.0, 1)
        scenario = parse_scenario(f'begins = "power"\n{faults}', range(1, 7))
        robot = put_devices(
            self.world, firmware, CONFIG.servo_bus, CONFIG.force_sensor, 1, scenario
        )
        port = MemoryPort(robot.servo_wire, self.clock, 1_000_000)
        self.sent: list[bytes] = []
        port.tap = lambda way, data, _t: self.sent.append(data) if way == "tx" else None
        self.bus = ServoBus(port, CONFIG.servo_bus)
        self.bus.open()
        for _ in range(2):  # the pattern begins with the first step
            self.world.advance_to(self.clock.now_ns())
            self.clock.advance(20_000_000)

    def wrong(self, reads: int) -> tuple[int, int]:
        """Read so often; return how many readings were valid and how many of them wrong."""
        valid = wrong = 0
        for _ in range(reads):
            began_ns = self.clock.now_ns()
            found = self.bus.read()
            end_ns = self.clock.now_ns()
            steps = [s for s in self.world.past if began_ns - 5_000_000 <= s[0] <= end_ns]
            for leg in np.flatnonzero(found.valid).tolist():
                valid += 1
                here = int(found.position_ticks[leg])
                amps = float(found.current_counts[leg]) * MX_106.current_unit_a
                wrong += not any(fits(here, amps, step, leg) for step in steps)
            self.clock.sleep_until_ns(began_ns + 10_000_000)
        return valid, wrong


def test_nothing_late_is_taken_for_new() -> None:
    valid, wrong = Bench(LATE).wrong(400)
    assert valid > 1500
    assert wrong == 0


def test_the_same_without_the_precaution_is_wrong(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ServoRequests, "owed", lambda _self: False)
    _, wrong = Bench(LATE).wrong(400)
    assert wrong > 10


def test_the_requests_byte_for_byte() -> None:
    bench = Bench('[[fault]]\nkind = "lost_reply"\ncount = 1\n')
    bench.wrong(4)
    reads = [frame for frame in bench.sent if frame[7] == SYNC_READ]
    assert [frame[8:12].hex(" ") for frame in reads] == [
        "7c 00 17 00",  # 23 bytes from 124
        "7b 00 18 00",  # an answer is owed: one byte more, from one earlier
        "7a 00 19 00",
        "79 00 1a 00",
    ]
    bench.clock.advance(600_000_000)
    bench.sent.clear()
    bench.wrong(1)
    assert bench.sent[0][8:12].hex(" ") == "7c 00 17 00", "nothing is owed any more"
    assert 124 - LONGEST_LEAD == 116, "goal position: no gap of the table in between"


def test_one_byte_is_read_until_two_answers_agree() -> None:
    from drivers.dynamixel.packets import ServoAnswer

    class Scripted(ServoRequests):
        def __init__(self, *values: int) -> None:
            super().__init__(port)
            self.left = list(values)

        def owed(self) -> bool:
            return True

        def read(self, servo_id: int, address: int, length: int) -> ServoAnswer:
            assert (servo_id, address, length) == (3, 98, 1)
            return ServoAnswer(bytes([self.left.pop(0)]), 0, 0)

    port: Any = None
    asked = Scripted(1, 0, 0, 9)
    assert asked.read_byte(3, 98).data == b"\x00", "the first was another question's answer"
    assert asked.left == [9]
    assert Scripted(1, 2, 3, 4, 5).read_byte(3, 98).data is None


def test_torque_that_is_on_never_passes_for_a_low_voltage() -> None:
    """Many answers 30 ms late: two about the torque came in the place of two about errors."""
    late = (
        '[[fault]]\nkind = "late_reply"\nrate = 0.5\n[[fault]]\nkind = "lost_reply"\nrate = 0.1\n'
    )
    bench = Bench(late)
    packets = bench.bus.servos()[2].packets
    torque = COMMON["torque_enable"].address
    while packets.read_byte(3, torque).data != b"\x01":
        packets.write(3, torque, b"\x01")
    errors: Counter[bytes] = Counter()
    for _ in range(500):
        packets.read_byte(3, torque)
        answer = packets.read_byte(3, COMMON["hardware_error_status"].address)
        if answer.data is not None:
            errors[answer.data] += 1
    assert errors.keys() == {b"\x00"}
    assert errors.total() > 50


def test_registers_of_one_byte_byte_for_byte() -> None:
    bench = Bench("")
    packets = bench.bus.servos()[2].packets
    packets.read_byte(3, 70)
    packets.note_missing()
    packets.read_byte(3, 70)
    packets.read_byte(3, 64)
    packets.read_byte(3, 98)
    assert [frame[4:12].hex(" ") for frame in bench.sent] == [
        "03 07 00 02 46 00 01 00",
        *["03 07 00 02 44 00 03 00"] * 2,  # 68 to 70, until two agree
        *["03 07 00 02 3f 00 02 00"] * 2,  # 63 and 64
        *["03 07 00 02 62 00 01 00"] * 2,
    ]
