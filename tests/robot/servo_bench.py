"""Virtual servos on a bench for the servo commands: in memory, under a virtual clock, no plant."""

from collections.abc import Sequence

import pytest

from drivers.dynamixel.port import ClockedPort
from drivers.dynamixel.servo_model import ServoModel
from model.errors import BusError
from robot.bringup.servo import access as servo_access
from robot.cli import main as cli
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.port import MemoryPort
from sim_hw.dynamixel.servo import VirtualServo
from tests.sim_hw.motors import SimpleMotors

PORT = "bench"
BAUD = 1_000_000


class Bench:
    """Servos on the port ``bench``; every servo command finds them there."""

    def __init__(
        self,
        monkeypatch: pytest.MonkeyPatch,
        ids: tuple[int, ...] = (1, 2, 3, 4, 5, 6),
        models: Sequence[ServoModel] = (),
    ) -> None:
        firmware = FirmwareBank(len(ids))
        self.clock = VirtualClock(start_ns=1_000_000_000)
        self.motors = SimpleMotors(firmware, len(ids))
        self.bus = VirtualServoBus(self.motors, firmware, ids, BAUD, models=models)
        self.ports: list[ClockedPort] = []
        for servo in self.bus.servos:
            servo.table.set("operating_mode", 4)
        self._damage = 0
        self._sound = self.bus.replies
        monkeypatch.setattr(self.bus, "replies", self._replies)
        monkeypatch.setattr(servo_access, "new_port", self._new_port)

    def _new_port(self, name: str, baud: int) -> ClockedPort:
        if name != PORT:
            raise BusError(f"there is no port {name}", port=name)
        self.ports.append(MemoryPort(self.bus, self.clock, baud))
        return self.ports[-1]

    def damage_next_reply(self) -> None:
        """Flip one bit of the next reply."""
        self._damage += 1

    def _replies(self, t_ns: int) -> bytes:
        data = self._sound(t_ns)
        if self._damage and data:
            self._damage -= 1
            return data[:-3] + bytes([data[-3] ^ 0x10]) + data[-2:]
        return data

    def servo(self, index: int) -> VirtualServo:
        """Return a servo by its place."""
        return self.bus.servos[index]

    def values(self, name: str) -> list[int]:
        """Return one register of every servo, straight from its memory."""
        return [servo.table.get(name) for servo in self.bus.servos]

    def command(self, *words: str) -> int:
        """Run ``bigant servo`` on the bench; every port it opened must be closed afterwards."""
        return self._run("servo", *words)

    def devices(self, *words: str) -> int:
        """Run ``bigant devices`` on the bench, in the same way; no force-torque unit is searched for."""
        return self._run("devices", "--discover", "none", *words)

    def _run(self, *words: str) -> int:
        self.ports = []
        code = cli.run([*words, "--port", PORT])
        assert self.ports
        assert not any(port.is_open for port in self.ports)
        return code
