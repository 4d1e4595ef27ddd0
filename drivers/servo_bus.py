"""The servo bus of one robot: connect, configure, read, send goals, torque on and off.

``connect`` and ``read`` never write, so they are safe on any robot; everything that writes needs
``configure`` first, which the command line calls only when armed. Torque goes on at the measured
position, with the servos' own watchdog armed, so that they stop when the host dies.
"""

from dataclasses import dataclass

import numpy as np

from drivers.clock import Clock
from drivers.dynamixel_frames import ALERT
from drivers.mx106 import (
    READ_ADDRESS,
    READ_LENGTH,
    REGISTER,
    RETURN_DELAY_UNIT_S,
    WATCHDOG_UNIT_S,
    Register,
    command_ticks,
)
from drivers.servo_packets import Answer, BusCounters, PacketHandler
from drivers.servo_port import ClockedPort
from drivers.servo_setup import BusReport, CheckedServo, configure_servos, find_servos
from drivers.settings import ServoBusSettings
from model.errors import BusError, ConnectionLost
from model.signals import IntArray, JointCommand, ServoReadings, readonly

NEVER = -1
TORQUE_OFF_TRIES = 3
# The hardware error register of one servo is read once in so many reads; an alert bit does at once.
POLL_EVERY_READS = 10


@dataclass(frozen=True, slots=True)
class _Field:
    """Where a measured register lies in the block that ``read`` fetches."""

    register: Register

    def decode(self, block: bytes) -> int:
        """Return the register's value."""
        start = self.register.address - READ_ADDRESS
        return self.register.decode(block[start : start + self.register.size])


_FIELDS = {
    name: _Field(REGISTER[name])
    for name in (
        "present_position",
        "present_velocity",
        "present_current",
        "present_pwm",
        "present_input_voltage",
        "present_temperature",
    )
}


class ServoBus:
    """All servos of a robot on one port.

    Args:
        port: Port, not yet open.
        settings: Ids and mounting of the servos.
        clock: The clock of the port.
    """

    def __init__(self, port: ClockedPort, settings: ServoBusSettings, clock: Clock) -> None:
        self.settings = settings
        self.report = BusReport((), ())
        self._port = port
        self._clock = clock
        self._packets = PacketHandler()
        self._ids = [int(i) for i in settings.ids]
        self._configured = False
        self._torque_on = False
        self._seen_ns: IntArray = np.full(len(self._ids), NEVER, dtype=np.int64)
        self._hardware_error: IntArray = np.full(len(self._ids), NEVER, dtype=np.int64)
        self._reads = 0

    @property
    def counters(self) -> BusCounters:
        """Counts of requests, timeouts, damaged and late answers."""
        return self._packets.counters

    def connect(self) -> BusReport:
        """Open the port and find every servo. Writes nothing.

        Raises:
            BusError: The port cannot be opened, or a servo is missing, of another kind or unusable.
        """
        self._port.openPort()
        self.report = find_servos(self._port, self._packets, self.settings)
        return self.report

    def configure(self) -> None:
        """Bring the servos into extended position mode, torque off, watchdog clear.

        Raises:
            BusError: A servo does not take a setting.
        """
        configure_servos(self._port, self._packets, self.settings)
        self._configured = True

    # Reading.

    def read(self) -> ServoReadings:
        """Read every servo once. A silent one costs one timeout and hides no other.

        Raises:
            ConnectionLost: The port is gone.
        """
        answers = self._packets.sync_read(
            self._port, self._ids, READ_ADDRESS, READ_LENGTH, self._return_delay_ms()
        )
        now_ns = self._clock.now_ns()
        valid = np.array([answer.data is not None for answer in answers])
        self._seen_ns = np.where(valid, now_ns, self._seen_ns)
        self._poll_hardware_error(answers)
        age_ns = np.where(self._seen_ns == NEVER, NEVER, now_ns - self._seen_ns)
        columns = {name: _column(answers, field) for name, field in _FIELDS.items()}
        return ServoReadings(
            t_ns=now_ns,
            position_ticks=columns["present_position"],
            velocity_counts=columns["present_velocity"],
            current_counts=columns["present_current"],
            duty_counts=columns["present_pwm"],
            voltage_counts=columns["present_input_voltage"],
            temperature_c=columns["present_temperature"],
            error_byte=readonly(np.array([answer.error for answer in answers])),
            hardware_error=readonly(self._hardware_error.copy()),
            valid=readonly(valid),
            age_ns=readonly(age_ns),
        )

    def _return_delay_ms(self) -> float:
        delays = [servo.return_delay for servo in self.report.servos]
        return max(delays, default=250) * RETURN_DELAY_UNIT_S * 1e3

    def _poll_hardware_error(self, answers: list[Answer]) -> None:
        """Read register 70 where an alert bit is set, and of each servo in turn now and then.

        A sync read carries the alert bit only, and only our own receive loop keeps even that.
        """
        alerted = [i for i, answer in enumerate(answers) if answer.error & ALERT]
        self._reads += 1
        turn, rest = divmod(self._reads, POLL_EVERY_READS)
        index = turn % len(self._ids)
        due = rest == 0 and answers[index].data is not None
        wanted = alerted[:1] or ([index] if due else [])
        for chosen in wanted:
            register = REGISTER["hardware_error_status"]
            answer = self._packets.read(
                self._port, self._ids[chosen], register.address, register.size
            )
            if answer.data is not None:
                self._hardware_error[chosen] = register.decode(answer.data)

    # Writing.

    def torque_on(self) -> None:
        """Switch torque on where the shafts stand, with the watchdog armed.

        Raises:
            BusError: Not configured, or a servo does not do it; torque is off again then.
            ConnectionLost: The port is gone.
        """
        self._need_configured()
        readings = self.read()
        if not readings.valid.all():
            raise BusError(
                f"{self._names(~readings.valid)} did not answer; torque stays off",
                port=self._port.name,
            )
        try:
            for servo, ticks in zip(self._servos(), readings.position_ticks, strict=True):
                servo.write("goal_position", int(ticks))
                servo.write("torque_enable", 1)
            self._torque_on = True
            for servo in self._servos():
                servo.write("bus_watchdog", self._watchdog_units())
        except BusError:
            self.torque_off()
            raise

    def write_goals(self, command: JointCommand) -> None:
        """Send goal positions to all servos in one sync write.

        Raises:
            BusError: Torque is off, or an angle is not a number.
            ConnectionLost: The port is gone.
        """
        if not self._torque_on:
            raise BusError("torque is off; call torque_on first", port=self._port.name)
        if not np.isfinite(command.angle_rad).all():
            raise BusError("a goal angle is not a number", port=self._port.name)
        goal = REGISTER["goal_position"]
        ticks = command_ticks(command, self.settings)
        items = [
            (servo_id, goal.encode(int(t))) for servo_id, t in zip(self._ids, ticks, strict=True)
        ]
        self._packets.sync_write(self._port, goal.address, items)

    def torque_off(self) -> bool:
        """Switch all torque off and read it back.

        Returns:
            True only if every servo says that its torque is off. Never raises: it is on every way
            out, also when the bus is half broken.
        """
        self._torque_on = False
        off, enable = REGISTER["torque_enable"].encode(0), REGISTER["torque_enable"]
        watchdog = REGISTER["bus_watchdog"]
        left = list(self._ids)
        for _ in range(TORQUE_OFF_TRIES):
            try:
                # a tripped watchdog would leave the servo deaf to later goals: clear it as well
                self._packets.tell_all(self._port, enable.address, off)
                self._packets.tell_all(self._port, watchdog.address, watchdog.encode(0))
                left = [i for i in left if not self._torque_is_off(i)]
            except ConnectionLost:
                return False
            if not left:
                return True
        return False

    def _torque_is_off(self, servo_id: int) -> bool:
        answer = self._packets.read(self._port, servo_id, REGISTER["torque_enable"].address, 1)
        return answer.data == b"\x00"

    def _need_configured(self) -> None:
        if not self._configured:
            raise BusError(
                "the servos are only being listened to; arm the robot to move it (--armed)",
                port=self._port.name,
            )

    def _watchdog_units(self) -> int:
        return round(self.settings.watchdog_s / WATCHDOG_UNIT_S)

    def _servos(self) -> list[CheckedServo]:
        return [
            CheckedServo(self._port, self._packets, leg, servo_id)
            for leg, servo_id in zip(self.settings.names, self._ids, strict=True)
        ]

    def _names(self, where: np.ndarray) -> str:
        return ", ".join(n for n, here in zip(self.settings.names, where, strict=True) if here)

    def close(self) -> None:
        """Close the port."""
        self._port.closePort()


def _column(answers: list[Answer], field: _Field) -> IntArray:
    values = [0 if a.data is None else field.decode(a.data) for a in answers]
    column: IntArray = readonly(np.array(values, dtype=np.int64))
    return column
