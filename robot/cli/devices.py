"""``bigant devices``: what is plugged in. Asks, never writes, never moves."""

import argparse
import json
import sys
from dataclasses import asdict

from drivers.ati.discovery import DISCOVERY_PORT, FoundUnit, discover
from drivers.dynamixel.scan import FoundServo, SerialPort, serial_ports
from model.errors import BusError, ConfigError
from robot.bringup.servo.access import BAUD_RATES, scan_port
from robot.cli.servo.scan import servo_line
from robot.console.exit_codes import ExitCode


def devices(options: argparse.Namespace) -> ExitCode:
    """List ports, servos and force-torque units.

    Returns:
        OK when something was found, VERDICT_FAILED when nothing answered.

    Raises:
        BusError: The port asked for cannot be opened.
        ConfigError: The discovery address makes no sense.
    """
    address, port = discovery_target(options.discover)
    ports = serial_ports()
    names = [options.port] if options.port else [p.name for p in ports if p.usb_id]
    bauds = (options.baud,) if options.baud else BAUD_RATES
    servos: list[tuple[str, FoundServo]] = []
    problems: list[str] = []
    for name in names:
        try:
            servos += [(name, found) for found in scan_port(name, bauds, quiet=options.json)]
        except BusError as error:
            if options.port:
                raise
            problems.append(str(error))
    units = discover(address, port) if address else ()
    if options.json:
        print(json.dumps(_as_json(ports, servos, units, problems), indent=2))
    else:
        _print(ports, names, servos, units, problems)
    return ExitCode.OK if servos or units else ExitCode.VERDICT_FAILED


def discovery_target(text: str) -> tuple[str, int]:
    """Return address and port of --discover; an empty address for none.

    Raises:
        ConfigError: It makes no sense.
    """
    if text == "none":
        return "", 0
    host, _, port = text.partition(":")
    if not host or (port and not (port.isdecimal() and 0 < int(port) < 65536)):
        raise ConfigError("--discover", f"must be ADDRESS, ADDRESS:PORT or none, not {text!r}")
    return host, int(port) if port else DISCOVERY_PORT


def _print(
    ports: tuple[SerialPort, ...],
    scanned: list[str],
    servos: list[tuple[str, FoundServo]],
    units: tuple[FoundUnit, ...],
    problems: list[str],
) -> None:
    print("serial ports")
    for port in ports:
        print(f"  {port.name:<16} {port.usb_id or '-':<10} {port.description}")
    if not ports:
        print("  none: plug in the U2D2, or start virtual hardware with: bigant sim serve")
    print("servos")
    for name, servo in servos:
        print(f"  {name:<16} {servo_line(servo)}")
    if not servos:
        where = ", ".join(scanned) if scanned else "no port was scanned"
        print(f"  none answered ({where}): check power, cable and the port's name")
    print("force-torque units")
    for unit in units:
        print(f"  {unit.address:<16} {unit.text}  {unit.location}")
    if not units:
        print("  none answered: check that the unit is on and on this network")
    for problem in problems:
        print(f"warning: {problem}", file=sys.stderr)


def _as_json(
    ports: tuple[SerialPort, ...],
    servos: list[tuple[str, FoundServo]],
    units: tuple[FoundUnit, ...],
    problems: list[str],
) -> dict[str, object]:
    return {
        "serial_ports": [asdict(port) for port in ports],
        "servos": [{"port": name, **asdict(servo)} for name, servo in servos],
        "force_units": [asdict(unit) for unit in units],
        "problems": problems,
    }
