"""Virtual devices with a scenario on their wires, in memory, for tests."""

from drivers.dynamixel_frames import Frame, FrameParser, build_instruction
from drivers.mx106 import REGISTER
from sim_hw.interfaces import MotorWorld, ServoWire
from sim_hw.scenario import parse_scenario
from sim_hw.scenario_time import ScenarioTime
from sim_hw.servo_firmware import FirmwareBank
from sim_hw.servo_mishaps import DisturbedMotors, Jammable, ServoMishaps
from sim_hw.servos import VirtualServoBus
from sim_hw.virtual_robot import faulty_wire
from tests.sim_hw.motors import SimpleMotors

BAUD = 1_000_000
MS = 1_000_000
START_NS = 1_000_000_000


def scenario_on(
    text: str, motors: Jammable, firmware: FirmwareBank, ids: tuple[int, ...], baud: int
) -> tuple[VirtualServoBus, ServoWire]:
    """Return servos, and the wire to them with a scenario on it."""
    scenario = parse_scenario(text, ids)
    seen = DisturbedMotors(motors, firmware)
    world: MotorWorld = seen
    bus = VirtualServoBus(world, firmware, ids, baud, assumed=scenario.servo)
    time = ScenarioTime(scenario.course.begins)
    mishaps = ServoMishaps(bus, seen, motors, scenario.faults, time)
    return bus, faulty_wire(bus, mishaps, scenario, time, baud)


class FaultyBus:
    """Raw bytes to servos with a scenario; it begins with the first ``at``, at second 0."""

    def __init__(self, text: str, ids: tuple[int, ...] = (1, 2, 3)) -> None:
        firmware = FirmwareBank(len(ids))
        self.motors = SimpleMotors(firmware, len(ids))
        self.bus, self.wire = scenario_on(text, self.motors, firmware, ids, BAUD)
        self.t_ns = START_NS
        self.wire.poll(self.t_ns)

    def at(self, second: float) -> "FaultyBus":
        """Let time pass until so many seconds after the scenario's beginning."""
        self.t_ns = START_NS + round(second * 1e9)
        self.wire.poll(self.t_ns)
        return self

    def say(self, frame: bytes, wait_ms: float = 20.0) -> bytes:
        """Send bytes now, return what comes back until so much later."""
        self.t_ns += round(10e9 * len(frame) / BAUD)
        self.wire.receive(frame, self.t_ns, BAUD)
        return self.hear(wait_ms)

    def hear(self, wait_ms: float) -> bytes:
        """Return what comes in a time."""
        self.t_ns += round(wait_ms * MS)
        self.wire.poll(self.t_ns)
        return self.wire.replies(self.t_ns)

    def ask(self, servo_id: int, instruction: int, parameters: bytes = b"") -> list[Frame]:
        """Send an instruction, return the sound answers."""
        heard = FrameParser().feed(self.say(build_instruction(servo_id, instruction, parameters)))
        return [frame for frame in heard if isinstance(frame, Frame)]

    def write(self, name: str, value: int, servo_id: int = 1) -> int:
        """Write a register, return the error number."""
        register = REGISTER[name]
        data = register.address.to_bytes(2, "little") + register.encode(value)
        return self.ask(servo_id, 0x03, data)[0].error or 0

    def read(self, name: str, servo_id: int = 1) -> int:
        """Read a register."""
        register = REGISTER[name]
        data = register.address.to_bytes(2, "little") + register.size.to_bytes(2, "little")
        return register.decode(self.ask(servo_id, 0x02, data)[0].parameters)
