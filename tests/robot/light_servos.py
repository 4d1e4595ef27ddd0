"""Virtual servos without a plant behind a pseudo-terminal, in a copy of the process of the tests.

As ``bigant sim serve`` does it, for tests of commands: nearly no arithmetic, so that a busy host still
answers in time.
"""

import os
import select

from drivers.clock import MonotonicClock
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.pty import PtyServoBus
from tests.robot.sim_serve import forked
from tests.sim_hw.motors import SimpleMotors

IDS = (1, 2, 3, 4, 5, 6)


class LightServos:
    """The process; ``port`` is its device name.

    Args:
        absent: Ids of servos that do not answer.
    """

    def __init__(self, *absent: int) -> None:
        self.process, reading = forked(serve, absent)
        with reading as said:
            self.port = said.readline().strip()

    def close(self) -> None:
        self.process.terminate()
        self.process.join(20)


def serve(writing: int, absent: tuple[int, ...]) -> None:
    """Serve until terminated."""
    firmware, clock = FirmwareBank(len(IDS)), MonotonicClock()
    bus = VirtualServoBus(SimpleMotors(firmware, len(IDS)), firmware, IDS, 1_000_000)
    for servo_id in absent:
        bus.silence(servo_id)
    pty = PtyServoBus(bus)
    with os.fdopen(writing, "w") as said:
        print(pty.device_name, file=said)
    while True:
        due_ns = pty.next_due_ns()
        wait_s = 0.01 if due_ns is None else max(0.0, (due_ns - clock.now_ns()) * 1e-9)
        select.select(pty.filenos(), [], [], wait_s)
        pty.service(clock.now_ns())
