"""What is plugged in: serial ports, servos at each baud rate, force-torque units. Asks, never writes."""

from collections.abc import Iterable, Sequence
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
from robot.requests.single import DevicesRequest

NONE = "none"


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
    names = [request.port] if request.port else [port.name for port in ports if port.usb_id]
    if request.port == NONE:
        names = []
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


def servo_line(servo: ScannedServo) -> str:
    """Return one servo as a line."""
    kind = model_name(servo.model)
    return f"{servo.baud_rate:>8} baud  id {servo.servo_id:>3}  {kind}  firmware {servo.firmware}"


def discovery_target(text: str) -> tuple[str, int]:
    """Return address and port of --discover; an empty address for none.

    Raises:
        ConfigError: It makes no sense.
    """
    if text == NONE:
        return "", 0
    host, _, port = text.partition(":")
    if not host or (port and not (port.isdecimal() and 0 < int(port) < 65536)):
        raise ConfigError("--discover", f"must be ADDRESS, ADDRESS:PORT or none, not {text!r}")
    return host, int(port) if port else DISCOVERY_PORT


def _lines(
    ports: tuple[SerialPort, ...],
    scanned: Sequence[str],
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
