"""The servo bus of one robot: connect, configure, read, send goals, torque on and off.

``connect`` and ``read`` never write, so they are safe on any robot; everything that moves needs
``configure`` first, which the command line calls only when armed. Torque goes on at the measured
position, with the servos' own watchdog armed, so that they stop when the host dies.
"""

import contextlib
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from math import isfinite, pi

import numpy as np
from dynamixel_sdk import COMM_SUCCESS

from drivers.clock import Clock
from drivers.dynamixel.answers_kernel import loop_reader
from drivers.dynamixel.catalog import COMMON, READ_ADDRESS, READ_LENGTH
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.frames import ALERT
from drivers.dynamixel.joints import nearest_ticks
from drivers.dynamixel.loop_registers import loop_columns
from drivers.dynamixel.packets import ServoAnswer
from drivers.dynamixel.port import ClockedPort
from drivers.dynamixel.requests import ServoRequests
from drivers.dynamixel.settings import ServoBusSettings
from drivers.dynamixel.setup import (
    BusReport,
    configure_servos,
    find_servos,
    hold_here,
)
from drivers.dynamixel.stats import BusStats
from drivers.dynamixel.units import (
    EXTENDED_POSITION_LIMIT,
    RETURN_DELAY_UNIT_S,
    TICKS_PER_TURN,
    WATCHDOG_UNIT_S,
)
from model.errors import BusError
from model.values.arrays import BoolArray, IntArray, readonly
from model.values.legs import JointCommand
from model.values.readings import ServoReadings

NEVER = -1
GOAL = COMMON["goal_position"]
TORQUE_OFF_TRIES = 3
# One lost answer is no reason to refuse; a servo that misses so many is not to be relied on.
TORQUE_ON_READS = 5
# While an answer is owed, reads begin up to so many bytes early (goal position and what is between are
# neighbours), each with another length than those before: an old answer cannot pass for a new one.
LONGEST_LEAD = 8
# Twice what a servo's goal can reach: still a number of ticks, and refused as one.
BEYOND_ALL_TURNS_RAD = 2 * EXTENDED_POSITION_LIMIT / TICKS_PER_TURN * 2 * pi
# Register 70 of one servo is read once in so many reads; a new alert is looked into at once.
POLL_EVERY_READS = 10


class ServoBus:
    """All servos of a robot on one port. One thread at a time.

    Args:
        port: Port, not yet open.
        settings: Ids and mounting of the servos.
    """

    def __init__(self, port: ClockedPort, settings: ServoBusSettings) -> None:
        self.settings = settings
        self.report = BusReport((), ())
        self._return_delay_ms = _longest_return_delay_ms(self.report)
        self._port = port
        self._packets = ServoRequests(port)
        self._ids: list[int] = settings.ids.tolist()
        self._signs: list[int] = settings.signs.tolist()
        self._zeros: list[int] = settings.zeros.tolist()
        self._configured = False
        self._torque_on = False
        self._seen_ns = [NEVER] * len(self._ids)
        self._hardware_error = [NEVER] * len(self._ids)
        # A servo that restarts forgets its turns; positions are given and taken as if it had not.
        self._lost_ticks = [0] * len(self._ids)
        self._goal_ticks: list[int] = []  # as sent last, in the servos' own count
        self._reads = 0
        self._lead = 0
        self._read_at_once: Callable[[bytes], IntArray | None] | None = None

    @property
    def stats(self) -> BusStats:
        """Counts of requests, timeouts, damaged and late answers, and round trips."""
        return self._packets.counters.snapshot()

    @property
    def latency_ms(self) -> float:
        """How long the port's adapter may hold back an answer."""
        return self._port.latency_ms

    @property
    def torque_wanted(self) -> bool:
        """Whether torque has been switched on and not off again; a servo may have lost it."""
        return self._torque_on

    @property
    def clock(self) -> Clock:
        """The clock of the port."""
        return self._port.clock

    @property
    def latency_timer_ms(self) -> float | None:
        """How long the adapter holds a short answer back, None where the system does not say."""
        return self._port.latency_timer_ms

    def open(self) -> None:
        """Open the port; nothing happens if it is open.

        Raises:
            BusError: It cannot be opened.
        """
        if not self._port.openPort():
            raise BusError(
                f"{self._port.name} cannot be opened at {self.settings.baud_rate} baud; choose "
                "another port or baud_rate",
                port=self._port.name,
            )

    def connect(self) -> BusReport:
        """Open the port and find every servo. Writes nothing.

        Returns:
            Who answered, and what should be corrected.

        Raises:
            BusError: The port cannot be opened, or a servo is missing, of another kind or unusable.
        """
        self.open()
        self.report = find_servos(self._port, self.servos(), self.settings)
        self._return_delay_ms = _longest_return_delay_ms(self.report)
        return self.report

    def configure(self) -> None:
        """Bring the servos into extended position mode, torque off, watchdog clear.

        Raises:
            BusError: A servo does not take a setting.
        """
        configure_servos(self.servos())
        self._configured = True

    def prepare(self) -> None:
        """Load or make the machine code that takes usual answers apart at once, for a loop.

        Without it ``read`` gives the same, and takes longer: a few reads need no compiler.
        """
        self._read_at_once = loop_reader(self._ids)

    def close(self) -> None:
        """Close the port."""
        self._port.closePort()

    # Reading.

    def read(self) -> ServoReadings:
        """Read every servo once. A silent one costs one timeout and hides no other.

        The readings are stamped with the middle between request and last answer: when in that time a
        servo looks at its shaft is not documented, so the stamp is wrong by half of it at most.

        Returns:
            Raw readings, (N,) each; see ``ServoReadings`` for what is missing.

        Raises:
            ConnectionLost: The port is gone.
        """
        answers = self._sync_read()
        t_ns = (self._packets.sent_ns + self._port.clock.now_ns()) // 2
        count = len(self._ids)
        if isinstance(answers, list):
            valid = [data is not None for data, _, _ in answers]
            errors = [error for _, error, _ in answers]
            silent = [code != COMM_SUCCESS for _, _, code in answers]
            columns = loop_columns(answers)
        else:
            valid, errors, silent = [True] * count, answers[0].tolist(), [False] * count
            columns = answers[1:]
        if all(valid):
            self._seen_ns, age_ns = [t_ns] * count, [0] * count
        else:
            seen = zip(valid, self._seen_ns, strict=True)
            self._seen_ns = [t_ns if here else before for here, before in seen]
            age_ns = [NEVER if seen_ns == NEVER else t_ns - seen_ns for seen_ns in self._seen_ns]
        self._poll_hardware_error(silent, errors)
        duty, current, velocity, position, voltage, temperature = columns
        flags = *valid, *errors, *self._hardware_error, *age_ns
        known, error_byte, hardware_error, age = _flags_as_arrays(flags, count)
        return ServoReadings(
            t_ns=t_ns,
            position_ticks=self._unshifted(position, valid),
            velocity_counts=velocity,
            current_counts=current,
            duty_counts=duty,
            voltage_counts=voltage,
            temperature_c=temperature,
            error_byte=error_byte,
            hardware_error=hardware_error,
            valid=known,
            age_ns=age,
        )

    def _sync_read(self) -> list[ServoAnswer] | IntArray:
        """Read the registers of the loop, so that no answer still owed can be taken for a new one.

        Returns:
            All answers, or what ``loop_reader`` has read.
        """
        self._lead = self._lead % LONGEST_LEAD + 1 if self._packets.owed() else 0
        lead, delay_ms = self._lead, self._return_delay_ms
        if not lead and self._read_at_once is not None:
            return self._packets.sync_read_as(
                self._ids, READ_ADDRESS, READ_LENGTH, delay_ms, self._read_at_once
            )
        answers = self._packets.sync_read(
            self._ids, READ_ADDRESS - lead, READ_LENGTH + lead, delay_ms
        )
        if not lead:
            return answers
        return [a if a.data is None else a._replace(data=a.data[lead:]) for a in answers]

    def _unshifted(self, ticks: IntArray, valid: Sequence[bool]) -> IntArray:
        if not any(self._lost_ticks):
            return ticks
        shifted: IntArray = readonly(np.where(valid, ticks - np.array(self._lost_ticks), 0))
        return shifted

    def note_restart(self, index: int, lost_ticks: int) -> None:
        """Take note that a servo has restarted and is sound.

        Args:
            index: Leg index.
            lost_ticks: Its position now less the one that ``read`` would have given before [ticks].
        """
        self._lost_ticks[index] = lost_ticks
        self._hardware_error[index] = 0

    def _poll_hardware_error(self, silent: Sequence[bool], errors: Sequence[int]) -> None:
        """Read register 70 of one servo: at once where an alert is new, now and then in turn.

        A sync read carries the alert bit only, and only our own receive loop keeps even that.
        """
        unexplained: list[int] = []
        if any(errors):
            unexplained = [
                index
                for index, error in enumerate(errors)
                if error & ALERT and self._hardware_error[index] <= 0
            ]
        self._reads += 1
        turn, rest = divmod(self._reads, POLL_EVERY_READS)
        if not unexplained and rest:
            return
        index = unexplained[0] if unexplained else turn % len(self._ids)
        if silent[index]:
            return  # it is silent just now, and would cost a second timeout
        register = COMMON["hardware_error_status"]
        answer = self._packets.read_byte(self._ids[index], register.address)
        if answer.data is not None:
            self._hardware_error[index] = register.decode(answer.data)

    # Writing.

    def torque_on(self) -> None:
        """Switch torque on where the shafts stand, with the watchdog armed.

        Raises:
            BusError: Not configured, or a servo does not do it; torque is off again then.
            ConnectionLost: The port is gone.
        """
        self._need_configured()
        for _ in range(TORQUE_ON_READS):
            readings = self.read()
            if readings.valid.all():
                break
        else:
            raise BusError(
                f"{self._legs(~readings.valid)} did not answer; torque stays off",
                port=self._port.name,
                ids=tuple(int(i) for i in self.settings.ids[~readings.valid]),
            )
        try:
            self._goal_ticks = [hold_here(servo) for servo in self.servos()]
            for servo in self.servos():
                servo.write_verified("bus_watchdog", self.watchdog_units)
        except BusError:
            self.torque_off()
            raise
        self._torque_on = True

    def write_goals(self, command: JointCommand) -> None:
        """Send goal positions to all servos in one sync write.

        Args:
            command: Shaft angles in the leg's sense, (N,) [rad].

        Raises:
            BusError: Torque is off, or an angle is not a number or out of the servo's range;
                nothing has been sent.
            ConnectionLost: The port is gone.
        """
        if not self._torque_on:
            raise BusError("torque is off; call torque_on first", port=self._port.name)
        if not command.torque:
            raise BusError(
                "a command without torque has no goals; call torque_off", port=self._port.name
            )
        angles: list[float] = command.angle_rad.tolist()
        if not isfinite(sum(angles)):
            self._refuse(
                [not isfinite(one) for one in angles], "has a goal angle that is not a number"
            )
        most = BEYOND_ALL_TURNS_RAD
        if max(map(abs, angles), default=0.0) > most:
            angles = [min(max(one, -most), most) for one in angles]
        ticks = nearest_ticks(angles, self._signs, self._zeros)
        goals = [to + lost for to, lost in zip(ticks, self._lost_ticks, strict=True)]
        self._refuse(
            [abs(goal) > EXTENDED_POSITION_LIMIT for goal in goals],
            "has a goal beyond 256 turns; set the turn counter back at standstill",
        )
        self._goal_ticks = goals
        self._send_goals(self._ids)

    def repeat_goals(self, without: int) -> None:
        """Send the last goals again, so that watchdogs get requests while one servo is looked after.

        Args:
            without: Index of the leg that is left out: its servo restarts or has no torque.

        Raises:
            BusError: They could not be sent.
            ConnectionLost: The port is gone.
        """
        self._send_goals([i for index, i in enumerate(self._ids) if index != without])

    def _send_goals(self, ids: Sequence[int]) -> None:
        numbers = self._goal_ticks
        if ids is not self._ids:
            goals = dict(zip(self._ids, numbers, strict=True))
            numbers = [goals[i] for i in ids]
        if ids and self._packets.sync_write_numbers(GOAL, ids, numbers) != COMM_SUCCESS:
            raise BusError("the goals could not be sent whole", port=self._port.name)

    def torque_off(self) -> bool:
        """Switch all torque off and read it back.

        The watchdog stays armed until torque is known to be off: it stops a servo that did not
        hear us. One that heard us and kept its torque is asked again with its watchdog clear, in
        requests that wait for their answers (a servo that answers into the next request destroys
        both); if it still keeps its torque, its watchdog is armed again.

        Returns:
            True only if every servo says that its torque is off. Never raises: it is called on every exit,
            also when the bus is half broken.
        """
        self._torque_on = False
        left = list(self._ids)
        for _ in range(TORQUE_OFF_TRIES):
            self._tell_all("torque_enable", 0)
            torque = {servo_id: self._torque_of(servo_id) for servo_id in left}
            left = [servo_id for servo_id in left if torque[servo_id] != 0]
            if not left:
                self._tell_all("bus_watchdog", 0)
                return True
            for servo_id in [i for i in left if torque[i] is not None]:
                self._ask(servo_id, "bus_watchdog", 0)
                self._ask(servo_id, "torque_enable", 0)
        for servo_id in left:
            self._ask(servo_id, "bus_watchdog", self.watchdog_units)
        return False

    def _ask(self, servo_id: int, name: str, value: int) -> None:
        """Write a register of one servo as well as the port can, and wait for the answer."""
        register = COMMON[name]
        with contextlib.suppress(BusError, OSError):
            self._packets.write(servo_id, register.address, register.encode(value))

    def _tell_all(self, name: str, value: int) -> None:
        """Write a register of every servo as well as the port can; nobody answers a broadcast."""
        register = COMMON[name]
        with contextlib.suppress(BusError, OSError):
            self._packets.broadcast(register.address, register.encode(value))

    def _torque_of(self, servo_id: int) -> int | None:
        """Return Torque Enable as the servo says it, None if it says nothing."""
        register = COMMON["torque_enable"]
        with contextlib.suppress(BusError, OSError):
            answer = self._packets.read_byte(servo_id, register.address)
            if answer.data is not None:
                return register.decode(answer.data)
        return None

    def _need_configured(self) -> None:
        if not self._configured:
            raise BusError(
                "the servos are only being listened to; arm the robot to move it (--armed)",
                port=self._port.name,
            )

    def _refuse(self, where: Sequence[bool], why: str) -> None:
        if any(where):
            ids = tuple(i for i, here in zip(self._ids, where, strict=True) if here)
            raise BusError(f"{self._legs(where)} {why}", port=self._port.name, ids=ids)

    @property
    def watchdog_units(self) -> int:
        """The watchdog time in the servos' own units."""
        return round(self.settings.watchdog_s / WATCHDOG_UNIT_S)

    def servos(self) -> list[CheckedServo]:
        """Return the servos in leg order, to be read and written by register name."""
        legs = zip(self.settings.names, self._ids, self.settings.models, strict=True)
        return [CheckedServo(self._packets, leg, number, one.table) for leg, number, one in legs]

    def _legs(self, where: Iterable[bool]) -> str:
        return ", ".join(leg for leg, here in zip(self.settings.names, where, strict=True) if here)


@lru_cache(maxsize=4)  # the same in nearly every read
def _flags_as_arrays(
    flags: tuple[int, ...], count: int
) -> tuple[BoolArray, IntArray, IntArray, IntArray]:
    """Return four times so many flags, (N,) each, the first as what is true."""
    valid, error_byte, hardware_error, age = readonly(np.array(flags).reshape(4, count))
    known: BoolArray = readonly(valid != 0)
    return known, error_byte, hardware_error, age


def _longest_return_delay_ms(report: BusReport) -> float:
    delays = [servo.return_delay for servo in report.servos]
    return max(delays, default=254) * RETURN_DELAY_UNIT_S * 1e3
