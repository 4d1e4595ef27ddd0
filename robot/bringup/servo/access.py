"""What the servo commands share: their port, who is on it, and a yes before anything is written."""

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from model.errors import ConfigError

if TYPE_CHECKING:
    from drivers.dynamixel.bus import ServoBus
    from drivers.dynamixel.checked_servo import CheckedServo
    from drivers.dynamixel.port import ClockedPort
    from drivers.dynamixel.requests import ServoRequests
    from drivers.dynamixel.scan import FoundServo
    from robot.config.robot_file import RobotConfig

BAUD_RATES = (57_600, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 115_200, 9_600, 4_500_000)


def add_port(parser: argparse.ArgumentParser, *, required: bool = True) -> None:
    """Add ``--port`` and ``--baud``."""
    parser.add_argument(
        "--port",
        metavar="PORT",
        required=required,
        help="serial port, for example /dev/ttyUSB0" + ("" if required else " (every USB port)"),
    )
    parser.add_argument("--baud", type=baud_rate, metavar="B", help="baud rate now (all eight)")


def baud_rate(text: str) -> int:
    """Read a baud rate that an MX-106 can be set to."""
    if not text.isdecimal() or int(text) not in BAUD_RATES:
        known = ", ".join(str(rate) for rate in sorted(BAUD_RATES))
        raise argparse.ArgumentTypeError(f"must be one of {known}, not {text}")
    return int(text)


def servo_id(text: str) -> int:
    """Read a Dynamixel id."""
    if not text.isdecimal() or int(text) > 252:
        raise argparse.ArgumentTypeError(f"must be from 0 to 252, not {text}")
    return int(text)


def bus_of(options: argparse.Namespace, config: "RobotConfig") -> "ServoBus":
    """Return the servo bus of a robot at the port and baud rate asked for, not yet open."""
    from dataclasses import replace

    from drivers.dynamixel.bus import ServoBus

    settings = config.servo_bus
    if options.baud is not None:
        settings = replace(settings, baud_rate=options.baud)
    port = new_port(options.port, settings.baud_rate)
    return ServoBus(port, settings, port.clock)


def robot_of(options: argparse.Namespace) -> "RobotConfig":
    """Return the robot file asked for, or the nominal one.

    Raises:
        ConfigError: It cannot be used.
    """
    from robot.config.robot_file import load_robot

    return load_robot(options.robot)


def bauds_of(options: argparse.Namespace) -> tuple[int, ...]:
    """Return the baud rates to look at."""
    return BAUD_RATES if options.baud is None else (options.baud,)


def scan_port(name: str, bauds: Sequence[int], *, quiet: bool = False) -> "list[FoundServo]":
    """Ask who is on a port, 0.8 s a baud rate, with a line of progress on a terminal.

    Raises:
        BusError: The port cannot be opened.
    """
    from drivers.dynamixel.scan import broadcast_ping

    found: list[FoundServo] = []
    for place, baud in enumerate(bauds, start=1):
        progress(f"scanning {name} at {baud} baud ({place} of {len(bauds)}) ...", quiet=quiet)
        with open_port(name, baud) as (port, _):
            found += broadcast_ping(port)
    progress("", quiet=quiet)
    return found


def progress(text: str, *, quiet: bool = False) -> None:
    """Show what is being done, in one line of a terminal that the next one replaces."""
    if not quiet and sys.stderr.isatty():
        print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)


def new_port(name: str, baud: int) -> "ClockedPort":
    """Return a serial port, not yet open. Every servo command gets its port here."""
    from drivers.clock import MonotonicClock
    from drivers.dynamixel.port import BusPort

    return BusPort(name, baud, MonotonicClock())


@contextmanager
def open_port(name: str, baud: int) -> "Iterator[tuple[ClockedPort, ServoRequests]]":
    """Open a port for requests, and close it whatever happens.

    Raises:
        BusError: It cannot be opened.
    """
    from drivers.dynamixel.requests import ServoRequests

    port = new_port(name, baud)
    port.openPort()
    try:
        yield port, ServoRequests()
    finally:
        port.closePort()


def servo_at(
    port: "ClockedPort",
    packets: "ServoRequests",
    number: int,
    config: "RobotConfig | None" = None,
) -> "CheckedServo":
    """Return one servo, under its leg's name if it is one of a robot."""
    from drivers.dynamixel.checked_servo import CheckedServo

    return CheckedServo(port, packets, leg_of(number, config), number)


def leg_of(number: int, config: "RobotConfig | None") -> str:
    """Return the name of the leg of an id, ``servo`` if it has none."""
    if config is not None:
        for name, leg_id in zip(config.servo_bus.names, config.servo_bus.ids, strict=True):
            if leg_id == number:
                return str(name)
    return "servo"


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
    """Write a file that must not exist yet: somebody's calibration is not to be lost.

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
