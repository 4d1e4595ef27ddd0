"""What one servo keeps: read it whole, compare it, write what differs and read it back.

For backups, for setting a servo up, and for putting a replaced one into the place of another. Writing
needs torque off, because the servo locks its EEPROM while torque is on.
"""

from collections.abc import Sequence
from dataclasses import dataclass

from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.mx106 import BAUD_CODES, REGISTER, REGISTERS, Register
from model.errors import BusError

# Neighbours without a gap: one request each.
EEPROM_RUNS = (
    ("model_number", "protocol_type"),
    ("homing_offset", "moving_threshold"),
    ("temperature_limit", "min_position_limit"),
    ("shutdown", "shutdown"),
)
GAIN_RUNS = (
    ("velocity_i_gain", "position_p_gain"),
    ("feedforward_2nd_gain", "feedforward_1st_gain"),
)
# Changing one of these changes how the servo is to be spoken to: they come last, in this order.
ADDRESSING = ("id", "baud_rate")
BAUD_OF_CODE = {code: baud for baud, code in BAUD_CODES.items()}
TALK_TRIES = 5


@dataclass(frozen=True, slots=True)
class RegisterValue:
    """One register and its value.

    Attributes:
        name: Register name.
        value: Its value in counts.
    """

    name: str
    value: int


@dataclass(frozen=True, slots=True)
class ServoImage:
    """Everything one servo keeps, and its gains.

    Attributes:
        servo_id: Dynamixel id.
        model: Model number.
        firmware: Firmware version.
        values: All writable EEPROM registers and the gains (RAM), by address.
    """

    servo_id: int
    model: int
    firmware: int
    values: tuple[RegisterValue, ...]

    def value(self, name: str) -> int:
        """Return one register's value; KeyError if it is not in the image."""
        for item in self.values:
            if item.name == name:
                return item.value
        raise KeyError(name)


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


def _between(first: str, last: str) -> list[Register]:
    low, high = REGISTER[first].address, REGISTER[last].address
    return [register for register in REGISTERS if low <= register.address <= high]


KEPT = tuple(r.name for run in EEPROM_RUNS for r in _between(*run) if r.writable)
GAINS = tuple(r.name for run in GAIN_RUNS for r in _between(*run))


def read_image(servo: CheckedServo) -> ServoImage:
    """Read all of it. Writes nothing.

    Raises:
        BusError: It does not answer soundly.
    """
    found = _read_runs(servo, (*EEPROM_RUNS, *GAIN_RUNS))
    return ServoImage(
        servo_id=servo.servo_id,
        model=found["model_number"],
        firmware=found["firmware_version"],
        values=tuple(RegisterValue(name, found[name]) for name in (*KEPT, *GAINS)),
    )


def read_gains(servo: CheckedServo) -> tuple[int, ...]:
    """Return the gains in the order of ``GAINS``, in two requests.

    Raises:
        BusError: It does not answer soundly.
    """
    found = _read_runs(servo, GAIN_RUNS)
    return tuple(found[name] for name in GAINS)


def _read_runs(servo: CheckedServo, runs: Sequence[tuple[str, str]]) -> dict[str, int]:
    """Read runs of neighbours, one request each; return the registers by name."""
    found: dict[str, int] = {}
    for first, last in runs:
        data = servo.read_run(first, last)
        start = REGISTER[first].address
        for register in _between(first, last):
            at = register.address - start
            found[register.name] = register.decode(data[at : at + register.size])
    return found


def changes_to(image: ServoImage, wanted: Sequence[RegisterValue]) -> tuple[Change, ...]:
    """Return what has to be written so that a servo has the values wanted."""
    return tuple(
        Change(item.name, image.value(item.name), item.value)
        for item in wanted
        if image.value(item.name) != item.value
    )


def require_torque_off(servo: CheckedServo) -> None:
    """Refuse a servo that holds torque: it would drop what it carries, and its EEPROM is locked.

    Raises:
        BusError: Torque is on, or it does not answer.
    """
    if servo.read("torque_enable"):
        raise BusError(
            f"{servo.leg} (id {servo.servo_id}) has its torque on: support what it carries, switch "
            f"torque off (bigant servo reboot --port {servo.port.name} --id {servo.servo_id} --yes) "
            "and try again",
            port=servo.port.name,
            ids=(servo.servo_id,),
            register="torque_enable",
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
    register = REGISTER["id"]
    data = register.encode(new_id)
    servo.packets.write(servo.port, servo.servo_id, register.address, data)
    renamed = CheckedServo(servo.port, servo.packets, servo.leg, new_id)
    if not _knocks(renamed) or servo.answers():
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
    register = REGISTER["baud_rate"]
    data = register.encode(BAUD_CODES[baud_rate])
    servo.packets.write(port, servo.servo_id, register.address, data)
    port.setBaudRate(baud_rate)
    if _talks(servo):
        return
    port.setBaudRate(before)
    still = f"it still answers at {before}" if _talks(servo) else f"nor does it at {before}"
    raise BusError(
        f"{servo.leg} (id {servo.servo_id}) does not answer at its new rate of {baud_rate} baud, "
        f"{still}: find it with bigant servo scan --port {port.name}",
        port=port.name,
        ids=(servo.servo_id,),
        register="baud_rate",
    )


def _knocks(servo: CheckedServo) -> bool:
    return any(servo.answers() for _ in range(TALK_TRIES))


def _talks(servo: CheckedServo) -> bool:
    register = REGISTER["baud_rate"]
    for _ in range(TALK_TRIES):
        answer = servo.packets.read(servo.port, servo.servo_id, register.address, register.size)
        if answer.data is not None:
            return BAUD_OF_CODE.get(register.decode(answer.data)) == servo.port.baudrate
    return False
