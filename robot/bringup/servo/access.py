"""What the servo commands share: the port, who answers on it, and a yes before anything is written."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from drivers.clock import MonotonicClock
from drivers.dynamixel.bus import ServoBus
from drivers.dynamixel.catalog import MODEL_BY_NUMBER
from drivers.dynamixel.checked_servo import CheckedServo
from drivers.dynamixel.port import BusPort, ClockedPort
from drivers.dynamixel.requests import ServoRequests
from drivers.dynamixel.scan import ScannedServo, broadcast_ping
from model.errors import BusError, ConfigError
from robot.config.robot_file import RobotConfig
from robot.console.arguments import BAUD_RATES
from robot.console.progress import StatusLine


def bus_of(name: str, baud: int | None, config: RobotConfig) -> ServoBus:
    """Return the servo bus of a robot at a port, not yet open.

    Args:
        name: Serial port.
        baud: Baud rate; None for the robot file's.
        config: Robot file.
    """
    settings = config.servo_bus
    if baud is not None:
        settings = replace(settings, baud_rate=baud)
    port = new_port(name, settings.baud_rate)
    return ServoBus(port, settings)


def scan_port(name: str, baud: int | None) -> list[ScannedServo]:
    """Return who answers on a port, 0.8 s a baud rate.

    Args:
        name: Serial port.
        baud: The one baud rate to ask at; None for all eight.

    Raises:
        BusError: The port cannot be opened.
    """
    rates = BAUD_RATES if baud is None else (baud,)
    servos: list[ScannedServo] = []
    with StatusLine() as status:
        for place, rate in enumerate(rates, start=1):
            status.step(f"scanning {name} at {rate} baud ({place} of {len(rates)}) ...")
            with open_port(name, rate) as (port, _):
                servos += broadcast_ping(port)
    return servos


def require_answers(
    servos: list[ScannedServo], port: str, what: str = "servo"
) -> list[ScannedServo]:
    """Return the servos of a port, at least one.

    Raises:
        BusError: There is none.
    """
    if not servos:
        raise BusError(f"no {what} answers on {port}: check power and cable", port=port)
    return servos


def new_port(name: str, baud: int) -> ClockedPort:
    """Return a serial port, not yet open. Every servo command gets its port here."""
    return BusPort(name, baud, MonotonicClock())


@contextmanager
def open_port(name: str, baud: int) -> Iterator[tuple[ClockedPort, ServoRequests]]:
    """Open a port for requests, and close it whatever happens.

    Raises:
        BusError: It cannot be opened.
    """
    port = new_port(name, baud)
    port.openPort()
    try:
        yield port, ServoRequests(port)
    finally:
        port.closePort()


def servo_at(
    port: ClockedPort, packets: ServoRequests, number: int, config: RobotConfig | None = None
) -> CheckedServo:
    """Return one servo, under its leg's name if it is one of a robot."""
    return CheckedServo(packets, leg_of(number, config), number)


def scanned_servo(
    port: ClockedPort,
    packets: ServoRequests,
    servo: ScannedServo,
    config: RobotConfig | None = None,
) -> CheckedServo:
    """Return one servo that answered, with the registers of its model where that is known."""
    one = servo_at(port, packets, servo.servo_id, config)
    model = MODEL_BY_NUMBER.get(servo.model)
    return one if model is None else replace(one, table=model.table)


def leg_of(number: int, config: RobotConfig | None) -> str:
    """Return the name of the leg of an id, ``servo`` if it has none."""
    if config is None:
        return "servo"
    legs: dict[int, str] = dict(
        zip(config.servo_bus.ids.tolist(), config.servo_bus.names, strict=True)
    )
    return legs.get(number, "servo")


def confirmed(question: str, *, yes: bool) -> bool:
    """Ask before writing; without a terminal only ``--yes`` is a yes."""
    if yes:
        return True
    if not sys.stdin.isatty():
        print("nothing has been done; add --yes to do it", file=sys.stderr)
        return False
    if input(f"{question} [y/N] ").strip().lower() in {"y", "yes"}:
        return True
    print("nothing has been done", file=sys.stderr)
    return False


def write_new(path: Path, text: str, option: str) -> None:
    """Write a file that must not exist yet: no measurement is overwritten.

    Raises:
        ConfigError: It exists, or cannot be written.
    """
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError as error:
        raise ConfigError(option, f"{path} exists; choose another name") from error
    except OSError as error:
        raise ConfigError(option, f"{path} cannot be written: {error.strerror}") from error
