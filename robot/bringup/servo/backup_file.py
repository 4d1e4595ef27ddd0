"""The file of a servo backup: TOML, one table a servo, every register by name."""

import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from drivers.dynamixel.image import GAINS, KEPT, RegisterValue, ServoImage
from drivers.dynamixel.mx106 import REGISTER
from model.errors import ConfigError
from model.parameters.toml_table import Table

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


def backup_text(backup: Backup) -> str:
    """Return a backup as TOML."""
    lines = [
        f"# What {len(backup.servos)} servos keep; put it back with: bigant servo restore",
        f'kind = "{KIND}"',
        f"version = {VERSION}",
        f"date = {json.dumps(backup.date)}",
        f"port = {json.dumps(backup.port)}",
    ]
    for servo in backup.servos:
        lines += ["", "[[servo]]", f"id = {servo.servo_id}", f"model = {servo.model}"]
        lines += [f"firmware = {servo.firmware}", "", "[servo.eeprom]"]
        lines += [f"{name} = {servo.value(name)}" for name in KEPT]
        lines += ["", "[servo.gains]  # RAM: lost without power"]
        lines += [f"{name} = {servo.value(name)}" for name in GAINS]
    return "\n".join(lines) + "\n"


def load_backup(path: Path) -> Backup:
    """Read a backup file.

    Raises:
        ConfigError: It cannot be read, or is no backup of ours.
    """
    try:
        data = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise ConfigError(str(path), f"the backup cannot be read: {reason}") from error
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(str(path), f"is not valid TOML: {error}") from error
    if data.get("kind") != KIND or data.get("version") != VERSION:
        raise ConfigError(
            str(path), "is no servo backup of this version; make one with servo backup"
        )
    entries = data.pop("servo", None)
    if not isinstance(entries, list) or not entries:
        raise ConfigError(str(path), "holds no servo")
    top = Table(data, path.name)
    top.text("kind")
    top.integer("version", minimum=VERSION, maximum=VERSION)
    date, port = top.text("date"), top.text("port")
    top.done()
    servos = [_servo(entry, f"{path.name}: servo[{i}]") for i, entry in enumerate(entries)]
    if len({servo.servo_id for servo in servos}) != len(servos):
        raise ConfigError(str(path), "holds one id twice")
    return Backup(date, port, tuple(servos))


def _servo(entry: object, name: str) -> ServoImage:
    if not isinstance(entry, dict):
        raise ConfigError(name, "must be a table")
    table = Table(entry, name)
    eeprom, gains = table.table("eeprom"), table.table("gains")
    image = ServoImage(
        servo_id=table.integer("id", minimum=0, maximum=252),
        model=table.integer("model", minimum=0, maximum=65535),
        firmware=table.integer("firmware", minimum=0, maximum=255),
        values=(*_values(eeprom, KEPT), *_values(gains, GAINS)),
    )
    for part in (table, eeprom, gains):
        part.done()
    if image.value("id") != image.servo_id:
        raise ConfigError(name, "has two different ids")
    return image


def _values(table: Table, names: Sequence[str]) -> tuple[RegisterValue, ...]:
    values = []
    for name in names:
        register = REGISTER[name]
        number = table.integer(name, minimum=register.minimum, maximum=register.maximum)
        values.append(RegisterValue(name, number))
    return tuple(values)
