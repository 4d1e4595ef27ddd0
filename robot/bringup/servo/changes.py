"""Registers that are to change: shown in words, asked for, written with torque off, read back."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from drivers.dynamixel.catalog import MODEL_BY_NUMBER
from drivers.dynamixel.image import (
    BAUD_OF_CODE,
    Change,
    ServoImage,
    read_image,
    require_torque_off,
    write_changes,
)
from drivers.dynamixel.registers import OperatingMode, hardware_error_names
from drivers.dynamixel.scan import ScannedServo, id_is_shared
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.units import VELOCITY_UNIT_RAD_S, VOLTAGE_UNIT_V
from model.errors import BusError
from robot.bringup.servo.access import confirmed, open_port, scanned_servo
from robot.config.robot_file import RobotConfig
from robot.console.exit_codes import ExitCode
from robot.console.progress import StatusLine
from robot.console.table import Column, table_lines


@dataclass(frozen=True, slots=True)
class Task:
    """One servo that is to hold something else.

    Attributes:
        servo: Who answered.
        title: The servo, for the list that is shown.
        changes_of: What has to change, given what it holds.
        note: A warning below the title, empty for none.
    """

    servo: ScannedServo
    title: str
    changes_of: Callable[[ServoImage], tuple[Change, ...]]
    note: str = ""


@dataclass(frozen=True, slots=True)
class Writing:
    """How tasks are shown and written.

    Attributes:
        port: Serial port.
        config: Robot file, for the names of the legs; None without one.
        same: Words for a servo that holds what it is to hold.
        differ: Words behind the number of registers that do not.
        done: Words behind the number of servos that were written.
        yes: Whether to write without being asked.
    """

    port: str
    config: RobotConfig | None
    same: str
    differ: str
    done: str
    yes: bool

    def carry_out(self, tasks: Sequence[Task]) -> ExitCode:
        """Show what differs, ask, write, read back. Nothing is written before all have been read.

        Returns:
            OK when all servos hold what they are to hold, VERDICT_FAILED when they differ and stay so.

        Raises:
            BusError: A servo has its torque on, shares its id, or does not keep a value.
        """
        changes = [self._read(task) for task in tasks]
        for task, some in zip(tasks, changes, strict=True):
            print(f"{task.title}: " + (f"{len(some)} {self.differ}" if some else self.same))
            for line in (
                *([task.note] if task.note else []),
                *change_lines(some, MODEL_BY_NUMBER[task.servo.model]),
            ):
                print(line)
        todo = [(task, some) for task, some in zip(tasks, changes, strict=True) if some]
        if not todo:
            return ExitCode.OK
        if not confirmed(f"write this to {len(todo)} servo(s)?", yes=self.yes):
            return ExitCode.VERDICT_FAILED
        with StatusLine() as status:
            for place, (task, some) in enumerate(todo, start=1):
                status.step(f"writing servo {place} of {len(todo)} ...")
                self._write(task, some)
        print(f"{len(todo)} servo(s) {self.done}")
        return ExitCode.OK

    def _read(self, task: Task) -> tuple[Change, ...]:
        number = task.servo.servo_id
        with open_port(self.port, task.servo.baud_rate) as (port, packets):
            if id_is_shared(packets, number):
                refuse_shared(number, self.port)
            servo = scanned_servo(port, packets, task.servo, self.config)
            require_torque_off(servo)
            return task.changes_of(read_image(servo))

    def _write(self, task: Task, changes: Sequence[Change]) -> None:
        with open_port(self.port, task.servo.baud_rate) as (port, packets):
            servo = scanned_servo(port, packets, task.servo, self.config)
            left = changes
            for _ in range(2):  # a change of mode sets gains back to that mode's own
                servo = write_changes(servo, left)
                left = task.changes_of(read_image(servo))
                if not left:
                    return
        raise BusError(
            f"{servo.leg} (id {servo.servo_id}) does not keep {left[0].name}: switch its power off "
            "and on and try again",
            port=self.port,
            ids=(servo.servo_id,),
            register=left[0].name,
        )


def refuse_shared(number: int, port: str) -> None:
    """Raise for an id that two servos have.

    Raises:
        BusError: Always.
    """
    raise BusError(
        f"two servos on {port} share id {number}: connect one at a time and give each its own with "
        "bigant servo setup --new-id",
        port=port,
        ids=(number,),
    )


def in_words(name: str, value: int, model: ServoModel) -> str:
    """Return a register's value with what it means in a model."""
    if name == "baud_rate":
        return f"{value} ({BAUD_OF_CODE.get(value, '?')} baud)"
    if name == "operating_mode":
        known = {int(mode): mode.name.lower().replace("_", " ") for mode in OperatingMode}
        return f"{value} ({known.get(value, '?')})"
    if name == "shutdown":
        return f"0x{value:02x} ({', '.join(hardware_error_names(value)) or 'never'})"
    quantities = {
        "return_delay_time": f"{2 * value} us",
        "temperature_limit": "degC",
        "min_voltage_limit": f"{value * VOLTAGE_UNIT_V:.1f} V",
        "max_voltage_limit": f"{value * VOLTAGE_UNIT_V:.1f} V",
        "current_limit": f"{value * model.current_unit_a:.2f} A",
        "velocity_limit": f"{value * VELOCITY_UNIT_RAD_S:.2f} rad/s",
    }
    return f"{value} ({quantities[name]})" if name in quantities else str(value)


def change_lines(changes: Sequence[Change], model: ServoModel) -> list[str]:
    """Return changes as a table: register, what is there, what is wanted, why."""
    if not changes:
        return []
    rows = [
        (c.name, in_words(c.name, c.present, model), in_words(c.name, c.wanted, model), c.why)
        for c in changes
    ]
    return table_lines(
        [Column(name) for name in ("register", "there", "wanted", "why")], rows, "  "
    )
