"""``bigant servo scan``: who answers at which baud rate."""

import json
from dataclasses import asdict, dataclass

from drivers.dynamixel.scan import FoundServo, serial_ports
from robot.bringup.servo.access import scan_port
from robot.console.exit_codes import ExitCode

KINDS = {321: "MX-106 (protocol 2.0)", 320: "MX-106 (protocol 1.0)"}


@dataclass(frozen=True, slots=True)
class ScanRequest:
    """Options of ``bigant servo scan``."""

    port: str | None
    baud: int | None
    json: bool


def scan(request: ScanRequest) -> ExitCode:
    """Scan and print.

    Returns:
        OK when a servo answered, VERDICT_FAILED when none did.

    Raises:
        BusError: A port cannot be opened.
    """
    names = [request.port] if request.port else [p.name for p in serial_ports() if p.usb_id]
    servos = [(name, servo) for name in names for servo in scan_port(name, request.baud)]
    if request.json:
        print(json.dumps([{"port": name, **asdict(servo)} for name, servo in servos], indent=2))
    elif not names:
        print("no USB serial port: plug in the U2D2, or name a port with --port")
    elif not servos:
        print(f"no servo answers on {', '.join(names)}: check power and cable")
    else:
        print("\n".join(f"{name}  {servo_line(servo)}" for name, servo in servos))
    return ExitCode.OK if servos else ExitCode.VERDICT_FAILED


def servo_line(servo: FoundServo) -> str:
    """Return one servo as a line."""
    kind = KINDS.get(servo.model, f"model {servo.model}")
    return f"{servo.baud_rate:>8} baud  id {servo.servo_id:>3}  {kind}  firmware {servo.firmware}"
