"""What a 100 Hz cycle costs: on the wire in virtual time, and in this computer's processor.

``python -m benchmarks cycle``. A cycle is one sync read of six servos, one sync write, and the force unit's
datagrams. The wire-time limit is the bytes of request, answers and goals at ten bits each, without a gap
and without an adapter. A real servo takes about 50 us to begin its answer even with a return delay of 0;
no driver can change that, so cycles are given with it (as the virtual servos assume) and without.

The processor's time is that of the drivers alone (``time.thread_time``), with the devices' own share taken
off: they are asked on the other side of the port and timed there.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from drivers.ati.packets import build_record
from drivers.ati.stream import ForceStream
from drivers.clock import Clock, MonotonicClock
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import READ_LENGTH
from drivers.dynamixel.frames import STATUS_BYTES
from drivers.dynamixel.port import BITS_PER_BYTE, ClockedPort
from model.values.arrays import readonly
from model.values.legs import JointCommand
from model.values.readings import ForceRecord
from robot.config.robot_file import RobotConfig, load_robot
from sim_hw.assumed import ServoAssumed
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel.bus import VirtualServoBus
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.port import MemoryPort
from sim_hw.host.bench_world import BenchWorld

BAUDS = (1_000_000, 3_000_000)
PERIOD_NS = 10_000_000
INSTRUCTION_BYTES = 10  # header, id, length, instruction, CRC
SPAN_BYTES = 4  # address and length
GOAL_BYTES = 4


SERVO_US = 1e6 * ServoAssumed().processing_s


def wire_limit_us(count: int, baud: int) -> float:
    """Return the time of a cycle's bytes [us]."""
    request = INSTRUCTION_BYTES + SPAN_BYTES + count
    answers = count * (STATUS_BYTES + READ_LENGTH)
    goals = INSTRUCTION_BYTES + SPAN_BYTES + count * (1 + GOAL_BYTES)
    return (request + answers + goals) * BITS_PER_BYTE * 1e6 / baud


@dataclass(frozen=True, slots=True)
class Cycle:
    """A cycle on the wire.

    Attributes:
        baud: Baud rate.
        limit_us: Wire-time limit.
        median_us: Median of the cycles, virtual time.
        longest_us: Longest one; once in ten cycles one register more is asked for.
        servos_us: What all servos together take to begin their answers.
    """

    baud: int
    limit_us: float
    median_us: float
    longest_us: float
    servos_us: float

    @property
    def over(self) -> float:
        """How much longer than the bytes alone the median is, as a share."""
        return self.median_us / self.limit_us - 1

    @property
    def over_servos(self) -> float:
        """How much longer than the bytes and the servos' own time the median is, as a share."""
        return self.median_us / (self.limit_us + self.servos_us) - 1


def armed_bus(
    config: RobotConfig,
    baud: int,
    port: Callable[[VirtualServoBus, VirtualClock, int], Any],
    servo_us: float = SERVO_US,
) -> tuple[ServoBus, VirtualClock]:
    """Return a bus with torque on, its servos without a return delay."""
    settings = replace(config.servo_bus, baud_rate=baud)
    firmware, clock = FirmwareBank(len(settings.ids)), VirtualClock(start_ns=1_000_000_000)
    world = BenchWorld(firmware, settings.zeros, weight_n=60.0)
    assumed = ServoAssumed(processing_s=servo_us * 1e-6)
    ids = tuple(int(i) for i in settings.ids)
    servos = VirtualServoBus(world, firmware, ids, baud, assumed=assumed)
    for servo in servos.servos:
        servo.table.set("return_delay_time", 0)
    bus = ServoBus(port(servos, clock, baud), settings)
    bus.connect()
    bus.configure()
    bus.torque_on()
    return bus, clock


def command(clock: Clock, count: int) -> JointCommand:
    """Return a command to stand."""
    zeros = readonly(np.zeros(count))
    return JointCommand(clock.now_ns(), zeros, zeros, torque=True)


def measure_cycle(baud: int, cycles: int = 100, servo_us: float = SERVO_US) -> Cycle:
    """Run cycles in virtual time."""
    config = load_robot()
    bus, clock = armed_bus(config, baud, MemoryPort, servo_us)
    count, took_us = len(config.servo_bus.ids), []
    for _ in range(cycles):
        began_ns = clock.now_ns()
        bus.read()
        bus.write_goals(command(clock, count))
        took_us.append((clock.now_ns() - began_ns) * 1e-3)
        clock.sleep_until_ns(began_ns + PERIOD_NS)
    return Cycle(
        baud, wire_limit_us(count, baud), statistics.median(took_us), max(took_us), count * servo_us
    )


class TimedPort(MemoryPort):
    """A memory port that takes the devices' own time off."""

    def __init__(self, *words: Any) -> None:
        super().__init__(*words)
        self.devices_ns = 0

    def _timed(self, call: Callable[..., Any], *words: Any) -> Any:
        began_ns = time.thread_time_ns()
        try:
            return call(*words)
        finally:
            self.devices_ns += time.thread_time_ns() - began_ns

    def writePort(self, packet: bytes) -> int:  # noqa: N802 - the SDK's names
        """Send."""
        return int(self._timed(super().writePort, packet))

    def readPort(self, length: int) -> bytes:  # noqa: N802
        """Receive."""
        return bytes(self._timed(super().readPort, length))

    def clearPort(self) -> None:  # noqa: N802
        """Drop what has arrived."""
        self._timed(super().clearPort)

    def getBytesAvailable(self) -> int:  # noqa: N802
        """Return how many bytes have arrived."""
        return int(self._timed(super().getBytesAvailable))


class _Datagrams:
    """A link that brings one record of six transducers a cycle."""

    def __init__(self) -> None:
        self._sequence = 0

    def send(self, data: bytes) -> None:
        pass

    def receive(self) -> list[tuple[int, bytes]]:
        self._sequence += 1
        record = ForceRecord(
            t_ns=0,
            device_ticks=41 * self._sequence,
            sequence=self._sequence,
            status=np.array([0x2A82, 0]),
            battery=7,
            mask=0b111111,
            counts=np.full((6, 6), 123_456),
            present=np.ones(6, dtype=bool),
            saturated=np.zeros(6, dtype=bool),
        )
        return [(self._sequence * PERIOD_NS, build_record(record))]

    def close(self) -> None:
        pass


class _Console:
    def write(self, data: bytes) -> None:
        pass

    def read(self, timeout_s: float) -> bytes:
        del timeout_s
        return b""

    def close(self) -> None:
        pass


def driver_cpu_ms(cycles: int = 500) -> list[float]:
    """Return the drivers' processor time of each cycle [ms]."""
    config = load_robot()
    ports: list[TimedPort] = []

    def port(servos: VirtualServoBus, clock: VirtualClock, baud: int) -> ClockedPort:
        ports.append(TimedPort(servos, clock, baud))
        return ports[-1]

    bus, clock = armed_bus(config, BAUDS[0], port)
    count, datagrams = len(config.servo_bus.ids), _Datagrams()
    stream = ForceStream(datagrams, _Console(), config.force_sensor, MonotonicClock())
    took_ms = []
    for _ in range(cycles):
        wished = command(clock, count)
        arrived = datagrams.receive()
        datagrams_now = _Ready(arrived)
        stream._datagrams = datagrams_now
        devices_ns, began_ns = ports[0].devices_ns, time.thread_time_ns()
        bus.read()
        bus.write_goals(wished)
        stream.read()
        stream.take_faults()
        spent_ns = time.thread_time_ns() - began_ns - (ports[0].devices_ns - devices_ns)
        took_ms.append(spent_ns * 1e-6)
        clock.advance(PERIOD_NS)
    return took_ms


class _Ready(_Datagrams):
    def __init__(self, arrived: list[tuple[int, bytes]]) -> None:
        super().__init__()
        self._arrived = arrived

    def receive(self) -> list[tuple[int, bytes]]:
        arrived, self._arrived = self._arrived, []
        return arrived


def main() -> None:
    """Run and print both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cycles", type=int, default=500)
    options, _ = parser.parse_known_args()
    for baud in BAUDS:
        for servo_us in (SERVO_US, 0.0):
            cycle = measure_cycle(baud, options.cycles, servo_us)
            print(
                f"{baud / 1e6:g} M baud, servos answer after {servo_us:.0f} us: cycle "
                f"{cycle.median_us:.0f} us (longest {cycle.longest_us:.0f}), bytes alone "
                f"{cycle.limit_us:.0f} us ({100 * cycle.over:+.1f} %), with the servos' own time "
                f"{cycle.limit_us + cycle.servos_us:.0f} us ({100 * cycle.over_servos:+.1f} %)"
            )
    took_ms = driver_cpu_ms(options.cycles)
    low, median, high = np.percentile(took_ms, [25, 50, 75])
    print(f"drivers' processor time a cycle: {median:.3f} ms (quartiles {low:.3f}, {high:.3f})")


if __name__ == "__main__":
    main()
