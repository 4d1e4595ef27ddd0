"""``bigant servo backup`` and ``restore``: every register by name, one TOML table a servo."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from drivers.dynamixel.catalog import MODEL_BY_NUMBER
from drivers.dynamixel.image import GAINS, ServoImage, changes_to, read_image
from drivers.dynamixel.model_words import model_name, unknown_words
from drivers.dynamixel.registers import RegisterTable
from drivers.dynamixel.scan import ScannedServo
from model.errors import BusError, ConfigError
from model.parameters.tables import parse_table
from model.parameters.toml_table import Table
from record.toml_file import reading, toml_text
from robot.bringup.servo.access import (
    open_port,
    require_answers,
    scan_port,
    scanned_servo,
    write_new,
)
from robot.bringup.servo.changes import Task, Writing
from robot.console.exit_codes import ExitCode
from robot.console.progress import StatusLine
from robot.requests.servo import ServoBackupRequest, ServoRestoreRequest

KIND = "bigant servo backup"
VERSION = 1


@dataclass(frozen=True, slots=True)
class Backup:
    """What a backup file says.

    Attributes:
        date: When it was made, as text.
        port: Port it was made on.
        servos: The servos.
    """

    date: str
    port: str
    servos: tuple[ServoImage, ...]


def back_up(request: ServoBackupRequest) -> ExitCode:
    """Read the servos and write the file.

    Raises:
        BusError: Nobody answers, or a servo stops answering.
        ConfigError: The file exists or cannot be written.
    """
    servos = scan_port(request.port, request.baud)
    for servo in servos:
        if servo.model not in MODEL_BY_NUMBER:
            name = model_name(servo.model)
            print(f"id {servo.servo_id}: {name}, left out: its registers are not known")
    known = [servo for servo in servos if servo.model in MODEL_BY_NUMBER]
    images = []
    with StatusLine() as status:
        for place, servo in enumerate(
            require_answers(known, request.port, "servo known here"), start=1
        ):
            status.step(f"reading servo {place} of {len(known)} ...")
            with open_port(request.port, servo.baud_rate) as (port, packets):
                images.append(read_image(scanned_servo(port, packets, servo)))
    date = time.strftime("%Y-%m-%dT%H:%M:%S%z")
    write_new(request.out, backup_text(Backup(date, request.port, tuple(images))), "--out")
    ids = ", ".join(str(image.servo_id) for image in images)
    counts = " or ".join(map(str, sorted({len(image.values) for image in images})))
    print(f"{len(images)} servos (ids {ids}), {counts} registers each: {request.out}")
    return ExitCode.OK


def restore(request: ServoRestoreRequest) -> ExitCode:
    """Show, ask, write, read back.

    Returns:
        OK when the servos are as in the file, VERDICT_FAILED when they differ and stay so.

    Raises:
        BusError: A servo is missing, of another model, or does not take a value.
        ConfigError: The file cannot be used.
    """
    backup = load_backup(request.path)
    servos = scan_port(request.port, request.baud)
    tasks = []
    for image in backup.servos:
        servo = _counterpart(image, servos, request.port)
        note = ""
        if image.firmware != servo.firmware:
            note = f"  warning: saved with firmware {image.firmware}, it has {servo.firmware} now"
        title = f"id {image.servo_id}"
        tasks.append(Task(servo, title, partial(changes_to, wanted=image.values), note))
    done = f"restored as of {backup.date} and read back"
    writing = Writing(request.port, None, "as in the file", "differ", done, request.yes)
    return writing.carry_out(tasks)


def _counterpart(image: ServoImage, servos: Sequence[ScannedServo], port: str) -> ScannedServo:
    here = [servo for servo in servos if servo.servo_id == image.servo_id]
    if len(here) != 1:
        what = "does not answer" if not here else "answers at two baud rates"
        raise BusError(
            f"id {image.servo_id} of the backup {what} on {port}; nothing has been written: give a "
            "replaced servo its id first, with bigant servo setup",
            port=port,
            ids=(image.servo_id,),
        )
    if here[0].model != image.model:
        raise BusError(
            f"id {image.servo_id} is {model_name(here[0].model)} and the backup is of "
            f"{model_name(image.model)}; nothing has been written: choose another backup",
            port=port,
            ids=(image.servo_id,),
            register="model_number",
        )
    return here[0]


def backup_text(backup: Backup) -> str:
    """Return a backup as TOML; the gains are in RAM, and lost without power."""
    document = {
        "kind": KIND,
        "version": VERSION,
        "date": backup.date,
        "port": backup.port,
        "servo": [
            {
                "id": servo.servo_id,
                "model": servo.model,
                "firmware": servo.firmware,
                "eeprom": {
                    name: servo.values[name] for name in MODEL_BY_NUMBER[servo.model].table.kept
                },
                "gains": {name: servo.values[name] for name in GAINS},
            }
            for servo in backup.servos
        ],
    }
    head = f"What {len(backup.servos)} servos keep; put it back with: bigant servo restore"
    return toml_text(document, (head,))


def load_backup(path: Path) -> Backup:
    """Read a backup file.

    Raises:
        ConfigError: It cannot be read, or is no backup of ours.
    """
    with reading(path, "the backup") as text:
        top = parse_table(text, "servo backup")
        if not top.has("kind") or (top.raw("kind"), top.raw("version")) != (KIND, VERSION):
            raise ConfigError("kind", "is no servo backup of this version; make one again")
        date, port = top.text("date"), top.text("port")
        servos = [_servo(table) for table in top.tables("servo")]
        top.done()
        if not servos:
            raise ConfigError("servo", "is missing: the backup holds no servo")
        if len({servo.servo_id for servo in servos}) != len(servos):
            raise ConfigError("servo", "holds one id twice")
        return Backup(date, port, tuple(servos))


def _servo(table: Table) -> ServoImage:
    eeprom, gains = table.table("eeprom"), table.table("gains")
    number = table.integer("model", minimum=0, maximum=65535)
    if number not in MODEL_BY_NUMBER:
        raise ConfigError(table.name("model"), unknown_words(number))
    registers = MODEL_BY_NUMBER[number].table
    image = ServoImage(
        servo_id=table.integer("id", minimum=0, maximum=252),
        model=number,
        firmware=table.integer("firmware", minimum=0, maximum=255),
        values=_values(eeprom, registers.kept, registers) | _values(gains, GAINS, registers),
    )
    if image.values["id"] != image.servo_id:
        raise ConfigError(table.name("id"), "has two different ids, here and in its eeprom table")
    return image


def _values(table: Table, names: Sequence[str], registers: RegisterTable) -> dict[str, int]:
    values = {}
    for name in names:
        register = registers[name]
        values[name] = table.integer(name, minimum=register.minimum, maximum=register.maximum)
    return values
