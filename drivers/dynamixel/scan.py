"""What is plugged in: serial ports, servos at each baud rate, two servos with one id. Only asks."""

from collections.abc import Sequence
from dataclasses import dataclass

from serial.tools import list_ports

from drivers.clock import Clock
from drivers.dynamixel.catalog import COMMON
from drivers.dynamixel.frames import (
    BROADCAST_ID,
    Frame,
    FrameParser,
    Instruction,
    build_instruction,
)
from drivers.dynamixel.packets import PacketHandler
from drivers.dynamixel.port import BusPort, ClockedPort

PING_ANSWER_BYTES = 14
# To a broadcast each servo answers in the time slot of its id, whoever else is there: 3 ms each is
# what the SDK allows for, and ids end at 252. Together 0.8 s, at any baud rate.
SLOT_MS = 3.0
IDS = 253
# Requests that tell whether two servos share an id.
PROBES = 6
# One damaged answer happens on any wire; of colliding ones nearly all are damaged.
DAMAGED_LIMIT = 2


@dataclass(frozen=True, slots=True)
class SerialPort:
    """One serial port of this computer.

    Attributes:
        name: Device name.
        usb_id: Vendor and product id, empty for a port that is no USB adapter.
        description: As the system describes it.
    """

    name: str
    usb_id: str
    description: str


@dataclass(frozen=True, slots=True)
class ScannedServo:
    """One servo that answered.

    Attributes:
        baud_rate: Baud rate it answered at.
        servo_id: Its id.
        model: Model number.
        firmware: Firmware version.
    """

    baud_rate: int
    servo_id: int
    model: int
    firmware: int


def serial_ports() -> tuple[SerialPort, ...]:
    """List the serial ports of this computer, USB adapters first."""
    ports = [
        SerialPort(
            name=str(p.device),
            usb_id=f"{p.vid:04x}:{p.pid:04x}" if p.vid is not None else "",
            description=str(p.description or ""),
        )
        for p in list_ports.comports()
    ]
    return tuple(sorted(ports, key=lambda p: (not p.usb_id, p.name)))


def scan(port_name: str, baud_rates: Sequence[int], clock: Clock) -> tuple[ScannedServo, ...]:
    """Ping everybody at each baud rate. Writes nothing to any servo.

    Args:
        port_name: Serial port.
        baud_rates: Baud rates to try, in this order [baud].
        clock: Where time comes from.

    Raises:
        BusError: The port cannot be opened.
    """
    servos: list[ScannedServo] = []
    for baud_rate in baud_rates:
        port = BusPort(port_name, baud_rate, clock)
        port.openPort()
        try:
            servos += broadcast_ping(port)
        finally:
            port.closePort()
    return tuple(servos)


def broadcast_ping(port: ClockedPort) -> list[ScannedServo]:
    """Ping everybody on an open port.

    Waits for the slots of all ids, and longer by the wire time of each answer that comes.

    Returns:
        Who answered, by id.
    """
    port.clearPort()
    port.writePort(build_instruction(BROADCAST_ID, Instruction.PING))
    port.setPacketTimeoutMillis(SLOT_MS * IDS + 2 * port.latency_ms)
    parser = FrameParser()
    by_id: dict[int, ScannedServo] = {}
    while port.remaining_ms() > 0:
        for item in parser.feed(port.readPort(1024)):
            if isinstance(item, Frame) and item.error is not None and len(item.parameters) == 3:
                model = int.from_bytes(item.parameters[:2], "little")
                servo = ScannedServo(port.baudrate, item.servo_id, model, item.parameters[2])
                by_id[item.servo_id] = servo
                port.packet_timeout += port.tx_time_per_byte * PING_ANSWER_BYTES
    return [by_id[servo_id] for servo_id in sorted(by_id)]


def id_is_shared(packets: PacketHandler, servo_id: int) -> bool:
    """Return whether more than one servo seems to answer to an id.

    What is asked for differs between any two servos (clock, position, current, temperature), so two
    answers at the same time damage each other, and two in a row are one too many.

    Args:
        packets: How to ask, over an open port.
        servo_id: The id; at least one servo answers to it.
    """
    first, last = COMMON["realtime_tick"], COMMON["present_temperature"]
    length = last.end - first.address
    parameters = first.address.to_bytes(2, "little") + length.to_bytes(2, "little")
    damaged, answered = 0, False
    for _ in range(PROBES):
        bad, late = _damage(packets), packets.counters.late_replies
        answer = packets.request(servo_id, Instruction.READ, parameters, length)
        # what this request found waiting came behind a sound answer; behind a timeout it is just late
        second = answered and packets.counters.late_replies > late
        damaged += second or _damage(packets) > bad
        answered = answer.data is not None
        packets.suspect_late = True  # the next request first listens for a second answer
    return damaged >= DAMAGED_LIMIT


def _damage(packets: PacketHandler) -> int:
    counters = packets.counters
    return counters.crc_errors + counters.foreign_replies + counters.noise_bytes
