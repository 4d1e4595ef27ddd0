"""MX-106 with protocol 1.0 firmware (model 320) on the bus: enough of it to be recognised and refused.

They answer protocol 1.0 pings and reads of one id, and any other instruction with the instruction error.
Protocol 2.0 is noise to them and their motors do nothing. Broadcasts are not answered. Source: ROBOTIS
e-manual, MX-106 and "Protocol 1.0": ``FF FF | id | length | instruction | parameters | checksum``, where
length counts what follows it and the checksum is the inverted low byte of the sum from the id on.
"""

from sim_hw.dynamixel.bus import LARGEST_BYTE_GAP_NS, Reply, wire_ns

MODEL = 320
FIRMWARE = 36  # assumed
HEADER = b"\xff\xff"
PING, READ = 0x01, 0x02
RANGE_ERROR, INSTRUCTION_ERROR = 0x08, 0x40
PROCESSING_NS = 50_000
TABLE_BYTES = 74
# Non-zero values of a new servo: address, size, value.
INITIAL = (
    (0, 2, MODEL),
    (2, 1, FIRMWARE),
    (5, 1, 0),  # return delay, as our other virtual servos have it (250 when new)
    (8, 2, 4095),
    (11, 1, 80),
    (12, 1, 60),
    (13, 1, 160),
    (14, 2, 1023),
    (16, 1, 2),
    (17, 1, 36),
    (18, 1, 36),
    (28, 1, 32),
    (34, 2, 1023),
    (36, 2, 2048),
    (42, 1, 120),
    (43, 1, 30),
    (68, 2, 2048),
)


def checksum(body: bytes) -> int:
    """Return the checksum of everything from the id to the last parameter."""
    return ~sum(body) & 0xFF


def build_packet(servo_id: int, code: int, parameters: bytes = b"") -> bytes:
    """Return a packet; ``code`` is the instruction, or the error byte of a status."""
    body = bytes([servo_id, len(parameters) + 2, code]) + parameters
    return HEADER + body + bytes([checksum(body)])


def take_packet(buffer: bytearray) -> tuple[int, int, bytes] | None:
    """Take the next sound packet out of a buffer: id, instruction, parameters. None if none is whole."""
    while (start := buffer.find(HEADER)) >= 0:
        del buffer[:start]
        if len(buffer) < 4:
            return None
        length = buffer[3]
        if buffer[2] == 0xFF or length < 2:  # another FF before the header, or protocol 2.0
            del buffer[0]
            continue
        if len(buffer) < 4 + length:
            return None
        body = bytes(buffer[2 : 4 + length])
        if checksum(body[:-1]) != body[-1]:
            del buffer[0]
            continue
        del buffer[: 4 + length]
        return body[0], body[2], body[3:-1]
    return None


class OldServos:
    """Servos of the old firmware, for ``VirtualServoBus.join``: they are on the one wire with the new ones.

    Args:
        ids: Their ids.
        baud_rate: Baud rate they are set to.
    """

    def __init__(self, ids: tuple[int, ...], baud_rate: int) -> None:
        self._baud_rate = baud_rate
        self._tables = {servo_id: _table(servo_id, baud_rate) for servo_id in ids}
        self._buffer = bytearray()
        self._last_byte_ns = 0

    @property
    def ids(self) -> tuple[int, ...]:
        """Their ids."""
        return tuple(self._tables)

    def lose(self) -> None:
        """Drop the received part of a packet: another device sent at the same time."""
        self._buffer.clear()

    def hear(self, data: bytes, t_ns: int, baud_rate: int) -> list[Reply]:
        """Return the answers to bytes of the host whose last one arrived at ``t_ns``."""
        if baud_rate != self._baud_rate:
            return []
        if t_ns - self._last_byte_ns > LARGEST_BYTE_GAP_NS + wire_ns(len(data), baud_rate):
            self._buffer.clear()
        self._last_byte_ns = t_ns
        self._buffer += data
        replies: list[Reply] = []
        while (packet := take_packet(self._buffer)) is not None:
            servo_id, instruction, parameters = packet
            table = self._tables.get(servo_id)
            if table is not None:
                answer = build_packet(servo_id, *_obey(table, instruction, parameters))
                end_ns = t_ns + PROCESSING_NS + wire_ns(len(answer), baud_rate)
                replies.append(Reply(end_ns, answer, servo_id))
        return replies


def _table(servo_id: int, baud_rate: int) -> bytearray:
    table = bytearray(TABLE_BYTES)
    for address, size, value in INITIAL:
        table[address : address + size] = value.to_bytes(size, "little")
    table[3] = servo_id
    table[4] = min(249, max(0, round(2_000_000 / baud_rate) - 1))
    return table


def _obey(table: bytearray, instruction: int, parameters: bytes) -> tuple[int, bytes]:
    if instruction == PING:
        return 0, b""
    if instruction != READ:
        return INSTRUCTION_ERROR, b""
    if len(parameters) != 2 or parameters[0] + parameters[1] > TABLE_BYTES or not parameters[1]:
        return RANGE_ERROR, b""
    return 0, bytes(table[parameters[0] : parameters[0] + parameters[1]])
