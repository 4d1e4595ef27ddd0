"""The virtual robot read and commanded without bytes, at the times at which the bytes would have come.

It begins through the bytes: connecting, switching torque on, and the first reads and writes, whose wire
times are learned from the virtual clock. From then on the registers are taken as they are, rounded as
their counts are. So a run is the same as through the bus, at a fraction of the cost.
"""

from dataclasses import replace

import numpy as np

from drivers.dynamixel.joints import angle_to_ticks
from drivers.dynamixel.port import BITS_PER_BYTE
from drivers.dynamixel.units import VELOCITY_UNIT_RAD_S, VOLTAGE_UNIT_V
from model.values.arrays import IntArray, readonly
from model.values.faults import Fault
from model.values.readings import ServoReadings
from robot.config.robot_file import RobotConfig
from robot.control.safety import Allowed
from robot.run.rig import Reading, Rig
from sim_hw.clock import VirtualClock
from sim_hw.host.virtual_robot import VirtualRobot

# The pattern of reads repeats: every tenth asks one servo for its errors as well.
PATTERN = 10
CURRENT = 2  # row of the readings of the motors
# A sync read without its ids, in bytes.
SYNC_READ_BYTES = 14


class DirectRobot:
    """A rig whose bus is bypassed once its times are known; implements ``robot.run.loop.Robot``.

    Args:
        config: Robot file.
        rig: Open, armed, with forces.
        robot: What is behind it.
    """

    def __init__(self, config: RobotConfig, rig: Rig, robot: VirtualRobot) -> None:
        if not isinstance(rig.clock, VirtualClock):
            raise TypeError(
                "only a virtual clock can be advanced by the time that bytes would take"
            )
        self.clock = rig.clock
        self.world = robot.world
        self._rig, self._robot = rig, robot
        self._bus = config.servo_bus
        self._unmeasured = np.flatnonzero(~self._bus.measures_current)
        current_unit_a = np.where(self._bus.measures_current, self._bus.current_unit_a, 1.0)
        one = np.ones(len(current_unit_a))
        units = one, VELOCITY_UNIT_RAD_S * one, current_unit_a, VOLTAGE_UNIT_V * one, one
        self._units = np.array(units)  # in the order of the readings of the motors
        wire_s = (SYNC_READ_BYTES + len(self._bus.ids)) * BITS_PER_BYTE / self._bus.baud_rate
        self._ask_ns = round(wire_s * 1e9)
        self._reads: list[int] = []
        self._writes: list[int] = []
        self._plain = readonly(np.zeros(len(self._bus.ids), dtype=np.int64))
        self._valid = readonly(np.ones(len(self._bus.ids), dtype=bool))

    @property
    def torque(self) -> bool:
        """Whether torque is on."""
        return self._rig.torque

    @property
    def direct(self) -> bool:
        """Whether wire times are known: reads repeat their pattern, writes take what they took."""
        reads, writes = self._reads, self._writes
        return (
            len(reads) >= 2 * PATTERN
            and reads[-PATTERN:] == reads[-2 * PATTERN : -PATTERN]
            and len(writes) > 1
            and writes[-1] == writes[-2]
        )

    def read(self) -> Reading:
        """Read the servos, and the forces and readings of the IMU that have come since; no truth."""
        start_ns = self.clock.now_ns()
        if not self.direct:
            # forces come through the link, which parses what the unit sent
            reading = self._rig.read()
            self._reads.append(self.clock.now_ns() - start_ns)
            return replace(reading, truth=None)
        world = self.world
        world.advance_to(start_ns + self._ask_ns)
        counts = self._counts()
        self._reads.append(self._reads[-PATTERN])
        self.clock.advance(self._reads[-1])
        world.advance_to(self.clock.now_ns())
        position, velocity, current, voltage, temperature = counts
        readings = ServoReadings(
            t_ns=self.clock.now_ns(),
            position_ticks=position,
            velocity_counts=velocity,
            current_counts=current,
            duty_counts=self._plain,
            voltage_counts=voltage,
            temperature_c=temperature,
            error_byte=self._plain,
            hardware_error=self._plain,
            valid=self._valid,
            age_ns=self._plain,
        )
        forces = tuple(self._robot.wnet.due(self.clock.now_ns()))
        imu, faults = self._rig.read_imu()
        return Reading(readings, forces, faults=faults, imu=imu)

    def _counts(self) -> tuple[IntArray, ...]:
        counts = np.rint(np.array(self.world.motors()) / self._units)
        counts[CURRENT, self._unmeasured] = 0.0
        return tuple(counts.astype(np.int64))

    def actuate(self, allowed: Allowed) -> tuple[Fault, ...]:
        """Send what the safety gate let through."""
        start_ns, command = self.clock.now_ns(), allowed.command
        if not (self.direct and command.torque):
            had_torque = self._rig.torque
            faults = self._rig.actuate(allowed)
            if had_torque and command.torque:
                self._writes.append(self.clock.now_ns() - start_ns)
            return faults
        self.clock.advance(self._writes[-1])
        self.world.advance_to(self.clock.now_ns())
        ticks = angle_to_ticks(command.angle_rad, self._bus.signs, self._bus.zeros)
        self._robot.firmware.goal_position[:] = ticks
        return ()

    def cut_torque(self) -> bool:
        """Switch all torque off, through the bus."""
        return self._rig.cut_torque()
