"""What one servo keeps: read it whole, compare it, write what differs and read it back.

For backups, for setting a servo up, and for putting a replaced one into the place of another. Writing
needs torque off, because the servo locks its EEPROM while torque is on.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from drivers.dynamixel.catalog import COMMON
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.units import BAUD_CODES
from model.errors import BusError

# Changing one of these changes how the servo is to be spoken to: they come last, in this order.
ADDRESSING = ("id", "baud_rate")
BAUD_OF_CODE = {code: baud for baud, code in BAUD_CODES.items()}
TALK_TRIES = 5


@dataclass(frozen=True, slots=True)
class ServoImage:
    """Everything one servo keeps, and its gains.

    Attributes:
        servo_id: Dynamixel id.
        model: Model number.
        firmware: Firmware version.
        values: Value of every writable EEPROM register and of the gains (RAM), by name [counts].
    """

    servo_id: int
    model: int
    firmware: int
    values: Mapping[str, int]


@dataclass(frozen=True, slots=True)
class Change:
    """One register that is to have another value.

    Attributes:
        name: Register name.
        present: What it has.
        wanted: What it is to have.
        why: In words; may be empty.
    """

    name: str
    present: int
    wanted: int
    why: str = ""


GAINS = COMMON.gains  # every model has the same


def read_image(servo: CheckedServo) -> ServoImage:
    """Read all of it. Writes nothing.

    Raises:
        BusError: It does not answer soundly.
    """
    registers: dict[str, int] = {}
    table = servo.table
    for first, last in (*table.kept_runs, *table.gain_runs):
        registers |= servo.read_run(first, last)
    return ServoImage(
        servo_id=servo.servo_id,
        model=registers["model_number"],
        firmware=registers["firmware_version"],
        values={name: registers[name] for name in (*table.kept, *GAINS)},
    )


def read_gains(servo: CheckedServo) -> tuple[int, ...]:
    """Return the gains in the order of ``GAINS``, in two requests.

    Raises:
        BusError: It does not answer soundly.
    """
    gains: dict[str, int] = {}
    for first, last in COMMON.gain_runs:
        gains |= servo.read_run(first, last)
    return tuple(gains[name] for name in GAINS)


def changes_to(image: ServoImage, wanted: Mapping[str, int]) -> tuple[Change, ...]:
    """Return what has to be written so that a servo has the values wanted, by register."""
    return tuple(
        Change(name, image.values[name], value)
        for name, value in wanted.items()
        if image.values[name] != value
    )


def require_torque_off(servo: CheckedServo) -> None:
    """Refuse a servo that holds torque: it would drop what it carries, and its EEPROM is locked.

    Raises:
        BusError: Torque is on, or it does not answer.
    """
    if servo.read("torque_enable"):
        raise servo.error(
            "has its torque on: support what it carries, switch torque off (bigant servo reboot "
            f"--port {servo.port.name} --id {servo.servo_id} --yes) and try again",
            "torque_enable",
        )


def write_changes(servo: CheckedServo, changes: Sequence[Change]) -> CheckedServo:
    """Write changes and read each back, id and baud rate last; torque has to be off.

    The port is left at the servo's new baud rate if that has changed.

    Args:
        servo: The servo as it can be spoken to now.
        changes: What is to be written.

    Returns:
        The servo as it can be spoken to afterwards.

    Raises:
        BusError: Torque is on, or a value was not taken or not kept; values before it are written.
    """
    require_torque_off(servo)
    servo.answer_everything()
    for change in changes:
        if change.name not in ADDRESSING:
            servo.write_verified(change.name, change.wanted)
    by_name = {change.name: change for change in changes}
    if "id" in by_name:
        servo = _change_id(servo, by_name["id"].wanted)
    if "baud_rate" in by_name:
        _change_baud_rate(servo, BAUD_OF_CODE[by_name["baud_rate"].wanted])
    return servo


def _change_id(servo: CheckedServo, new_id: int) -> CheckedServo:
    """Set an id, and prove it; the answer to this write may come under either, so nobody looks."""
    register = COMMON["id"]
    servo.packets.write(servo.servo_id, register.address, register.encode(new_id))
    renamed = replace(servo, servo_id=new_id)
    if not any(renamed.answers() for _ in range(TALK_TRIES)) or servo.answers():
        raise BusError(
            f"{servo.leg} was told to take id {new_id} and does not go by it alone; is there a second "
            f"servo with id {servo.servo_id} or {new_id}? Connect one at a time",
            port=servo.port.name,
            ids=(servo.servo_id, new_id),
            register="id",
        )
    return renamed


def _change_baud_rate(servo: CheckedServo, baud_rate: int) -> None:
    """Set a baud rate, and prove it by talking at it.

    The answer to this write may come at either rate, so nobody looks at it.
    """
    port, before = servo.port, int(servo.port.baudrate)
    register = COMMON["baud_rate"]
    servo.packets.write(servo.servo_id, register.address, register.encode(BAUD_CODES[baud_rate]))
    port.setBaudRate(baud_rate)
    if _talks(servo):
        return
    port.setBaudRate(before)
    still = f"it still answers at {before}" if _talks(servo) else f"nor does it at {before}"
    raise servo.error(
        f"does not answer at its new rate of {baud_rate} baud, {still}: find it with bigant servo "
        f"scan --port {port.name}",
        "baud_rate",
    )


def _talks(servo: CheckedServo) -> bool:
    register = COMMON["baud_rate"]
    for _ in range(TALK_TRIES):
        answer = servo.packets.read(servo.servo_id, register.address, register.size)
        if answer.data is not None:
            return BAUD_OF_CODE.get(register.decode(answer.data)) == servo.port.baudrate
    return False
