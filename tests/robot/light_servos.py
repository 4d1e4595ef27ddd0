"""Virtual servos without a plant behind a pseudo-terminal, in a process of their own.

As ``bigant sim serve`` does it, for tests of commands: nearly no arithmetic, so that a busy host still
answers in time.
"""

import select
import subprocess
import sys
from pathlib import Path

from drivers.clock import MonotonicClock
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.pty import PtyServoBus
from tests.sim_hw.motors import SimpleMotors

ROOT = Path(__file__).resolve().parents[2]
IDS = (1, 2, 3, 4, 5, 6)


class LightServos:
    """The process; ``port`` is its device name.

    Args:
        absent: Ids of servos that do not answer.
    """

    def __init__(self, *absent: int) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "tests.robot.light_servos", *(str(i) for i in absent)],
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
        )
        assert self.process.stdout is not None
        self.port = self.process.stdout.readline().strip()

    def close(self) -> None:
        self.process.terminate()
        self.process.wait(20)
        assert self.process.stdout is not None
        self.process.stdout.close()


def serve() -> None:
    """Serve until terminated."""
    firmware, clock = FirmwareBank(len(IDS)), MonotonicClock()
    bus = VirtualServoBus(SimpleMotors(firmware, len(IDS)), firmware, IDS, 1_000_000)
    for servo_id in sys.argv[1:]:
        bus.silence(int(servo_id))
    pty = PtyServoBus(bus)
    print(pty.device_name, flush=True)
    while True:
        due_ns = pty.next_due_ns()
        wait_s = 0.01 if due_ns is None else max(0.0, (due_ns - clock.now_ns()) * 1e-9)
        select.select(pty.filenos(), [], [], wait_s)
        pty.service(clock.now_ns())


if __name__ == "__main__":
    serve()
