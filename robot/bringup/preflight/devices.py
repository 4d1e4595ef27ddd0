"""What is plugged in: serial ports, servos at each baud rate, force-torque units. Asks, never writes."""

from collections.abc import Iterable
from dataclasses import asdict

from drivers.ati.discovery import DISCOVERY_PORT, DiscoveredUnit, discover
from drivers.dynamixel.model_words import model_name
from drivers.dynamixel.scan import ScannedServo, SerialPort, serial_ports
from model.errors import BusError, ConfigError
from robot.bringup.servo.access import scan_port
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.program_output import complain
from robot.console.table import Column, table_lines
from robot.requests.ft import FtScanRequest
from robot.requests.servo import ServoScanRequest
from robot.requests.single import DevicesRequest


def list_devices(request: DevicesRequest) -> ExitCode:
    """List ports, servos and force-torque units.

    Returns:
        OK when something answered, VERDICT_FAILED when nothing did.

    Raises:
        BusError: The port asked for cannot be opened.
        ConfigError: The discovery address makes no sense.
    """
    address, port = discovery_target(request.discover)
    ports = serial_ports()
    names = [request.port] if request.port else [p.name for p in ports if p.usb_id]
    servos: list[tuple[str, ScannedServo]] = []
    problems: list[str] = []
    for name in names:
        try:
            servos += [(name, servo) for servo in scan_port(name, request.baud)]
        except BusError as error:
            if request.port:
                raise
            problems.append(str(error))
    units = discover(address, port) if address else ()
    result = {
        "serial_ports": ports,
        "servos": [{"port": name, **asdict(servo)} for name, servo in servos],
        "force_units": units,
        "problems": problems,
    }
    print_result(result, _lines(ports, names, servos, units), as_json=request.json)
    for problem in () if request.json else problems:
        complain(f"warning: {problem}")
    return ExitCode.OK if servos or units else ExitCode.VERDICT_FAILED


def scan_servos(request: ServoScanRequest) -> ExitCode:
    """Scan and print.

    Returns:
        OK when a servo answered, VERDICT_FAILED when none did.

    Raises:
        BusError: A port cannot be opened.
    """
    names = [request.port] if request.port else [p.name for p in serial_ports() if p.usb_id]
    servos = [(name, servo) for name in names for servo in scan_port(name, request.baud)]
    lines = [f"{name}  {servo_line(servo)}" for name, servo in servos]
    if not names:
        lines = ["no USB serial port: plug in the U2D2, or name a port with --port"]
    elif not servos:
        lines = [f"no servo answers on {', '.join(names)}: check power and cable"]
    result = [{"port": name, **asdict(servo)} for name, servo in servos]
    print_result(result, lines, as_json=request.json)
    return ExitCode.OK if servos else ExitCode.VERDICT_FAILED


def servo_line(servo: ScannedServo) -> str:
    """Return one servo as a line."""
    kind = model_name(servo.model)
    return f"{servo.baud_rate:>8} baud  id {servo.servo_id:>3}  {kind}  firmware {servo.firmware}"


def list_force_units(request: FtScanRequest) -> ExitCode:
    """List the force-torque units that answer; otherwise as ``list_devices``.

    Raises:
        ConfigError: The address makes no sense.
        ForceStreamError: The question cannot be sent.
    """
    address, port = discovery_target(request.discover)
    units = discover(address, port) if address else ()
    lines = [f"{u.address:<16} {u.mac}  {u.text}  {u.location}" for u in units]
    nobody = ["no force-torque unit answered: check that it is on and on this network"]
    print_result({"force_units": units}, lines or nobody, as_json=request.json)
    return ExitCode.OK if units else ExitCode.VERDICT_FAILED


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


def _lines(
    ports: tuple[SerialPort, ...],
    scanned: list[str],
    servos: list[tuple[str, ScannedServo]],
    units: tuple[DiscoveredUnit, ...],
) -> list[str]:
    where = ", ".join(scanned) if scanned else "no port was scanned"
    return [
        "serial ports",
        *_rows((port.name, port.usb_id or None, port.description) for port in ports),
        *([] if ports else [
            "  none: plug in the U2D2, or start virtual hardware with: bigant sim serve"
        ]),
        "servos",
        *_rows((name, servo_line(servo)) for name, servo in servos),
        *([] if servos else [
            f"  none answered ({where}): check power, cable and the port's name"
        ]),
        "force-torque units",
        *_rows((unit.address, unit.text, unit.location) for unit in units),
        *([] if units else ["  none answered: check that the unit is on and on this network"]),
    ]  # fmt: skip


def _rows(rows: Iterable[tuple[str | None, ...]]) -> list[str]:
    """Return rows of texts below a heading, one column below the other."""
    there = list(rows)
    return table_lines([Column("")] * len(there[0]), there, "  ") if there else []
