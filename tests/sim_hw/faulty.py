"""Virtual devices with a scenario on their wires, in memory, for tests."""

import numpy as np

from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.frames import Frame, FrameParser, build_instruction
from model.values.arrays import FloatArray
from sim_hw.ati.unit import VirtualWnet
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.faults.mishaps import DisturbedMotors, ServoMishaps
from sim_hw.faults.scenario import parse_scenario
from sim_hw.faults.time import ScenarioTime
from sim_hw.faults.wnet import FaultyWnet
from sim_hw.host.virtual_robot import faulty_wire
from sim_hw.interfaces import MotorWorld, ServoWire
from tests.sim_hw.motors import SimpleMotors

BAUD = 1_000_000
MS = 1_000_000
START_NS = 1_000_000_000


def scenario_on(
    text: str, motors: MotorWorld, firmware: FirmwareBank, ids: tuple[int, ...], baud: int
) -> tuple[VirtualServoBus, ServoWire]:
    """Return servos, and the wire to them with a scenario on it."""
    scenario = parse_scenario(text, ids)
    seen = DisturbedMotors(motors, firmware)
    world: MotorWorld = seen
    bus = VirtualServoBus(world, firmware, ids, baud, assumed=scenario.servo)
    time = ScenarioTime(scenario.course.begins)
    mishaps = ServoMishaps(bus, seen, scenario.faults, time)
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
        register = MX_106.table[name]
        data = register.address.to_bytes(2, "little") + register.encode(value)
        return self.ask(servo_id, 0x03, data)[0].error or 0

    def read(self, name: str, servo_id: int = 1) -> int:
        """Read a register."""
        register = MX_106.table[name]
        data = register.address.to_bytes(2, "little") + register.size.to_bytes(2, "little")
        return register.decode(self.ask(servo_id, 0x02, data)[0].parameters)


class Still:
    """Transducers that feel nothing."""

    def wrench(self, t_ns: int) -> FloatArray:
        del t_ns
        return np.zeros((6, 6))


# 2024-03-01 12:00:00 UTC, so that the stamp of second 0 is c41c0000.
UNIX_OFFSET_NS = 1_709_294_400_000_000_000
START = bytes.fromhex("000a 00 01 00000000 7346")
STOP = bytes.fromhex("0006 00 02 7d48")
HOST_PORT = 49152


class FaultyUnit:
    """A noiseless, unloaded force-torque unit with a scenario; 125 records a second from second 0."""

    def __init__(self, text: str, transducers: tuple[int, ...] = (1, 0, 0, 0, 0, 0)) -> None:
        scenario = parse_scenario(text, ())
        self.unit = VirtualWnet(
            Still(),
            transducers,
            noise=(0.0,) * 6,
            unix_offset_ns=UNIX_OFFSET_NS,
            assumed=scenario.force_unit,
        )
        time = ScenarioTime(scenario.course.begins)
        self.wire = FaultyWnet(self.unit, scenario.faults, time, scenario.course.seed)

    def start(self, second: float = 0.0, host_port: int = HOST_PORT) -> "FaultyUnit":
        """Tell it to send without end."""
        self.wire.command(START, round(second * 1e9), host_port)
        return self

    def heard(self, second: float) -> list[bytes]:
        """Return the datagrams that have arrived since the last call."""
        return [data for _, data in self.wire.poll(round(second * 1e9))]


def sound_record(sequence: int, *, status: str = "00010a82 00000000 07 01") -> bytes:
    """What a sound unit with transducer 1 alone sends as its n-th record, at n x 8 ms."""
    ticks = 0xC41C0000 + sequence * 8 * 4096 // 1000
    return bytes.fromhex(f"{ticks:08x} {sequence:08x} {status}" + 24 * "00")
