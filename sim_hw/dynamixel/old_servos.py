"""MX-106 with protocol 1.0 firmware (model 320) on the bus: enough of it to be recognised and refused.

They answer protocol 1.0 pings and reads of one id, and any other instruction with the instruction error.
They are deaf to protocol 2.0 and their motors do nothing. Broadcasts are not answered. Source: ROBOTIS
e-manual, MX-106 and "Protocol 1.0": ``FF FF | id | length | instruction | parameters | checksum``, where
length counts what follows it and the checksum is the inverted low byte of the sum from the id on.
"""

from collections import deque

from sim_hw.dynamixel.bus import LARGEST_BYTE_GAP_NS, Reply, VirtualServoBus, wire_ns

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


class BusWithOldServos:
    """A virtual bus with servos of the old firmware beside the new ones.

    Args:
        bus: The new ones; those of the old ids are taken off it.
        ids: Ids of the old ones.
        baud_rate: Baud rate they are set to.
    """

    def __init__(self, bus: VirtualServoBus, ids: tuple[int, ...], baud_rate: int) -> None:
        self._bus = bus
        self._baud_rate = baud_rate
        self._tables = {servo_id: _table(servo_id, baud_rate) for servo_id in ids}
        self._buffer = bytearray()
        self._last_byte_ns = 0
        self._replies: deque[Reply] = deque()
        for servo_id in ids:
            bus.silence(servo_id)

    def poll(self, t_ns: int) -> None:
        """Let time pass."""
        self._bus.poll(t_ns)

    def receive(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        """Take bytes from the wire."""
        self._bus.receive(data, t_ns, baud_rate)
        if baud_rate != self._baud_rate:
            return
        if t_ns - self._last_byte_ns > LARGEST_BYTE_GAP_NS + wire_ns(len(data), baud_rate):
            self._buffer.clear()
        self._last_byte_ns = t_ns
        self._buffer += data
        while (packet := take_packet(self._buffer)) is not None:
            servo_id, instruction, parameters = packet
            table = self._tables.get(servo_id)
            if table is not None:
                answer = build_packet(servo_id, *_obey(table, instruction, parameters))
                end_ns = t_ns + PROCESSING_NS + wire_ns(len(answer), baud_rate)
                self._replies.append(Reply(end_ns, answer, servo_id))

    def next_reply_ns(self) -> int | None:
        """When the next reply is complete, None if none is under way."""
        times = [self._bus.next_reply_ns(), self._replies[0].t_ns if self._replies else None]
        return min((t for t in times if t is not None), default=None)

    def due(self, t_ns: int) -> list[Reply]:
        """Return all replies complete by a time, each by itself."""
        ready = self._bus.due(t_ns)
        while self._replies and self._replies[0].t_ns <= t_ns:
            ready.append(self._replies.popleft())
        return sorted(ready, key=lambda reply: reply.t_ns)

    def replies(self, t_ns: int) -> bytes:
        """Return the bytes of all replies complete by a time."""
        return b"".join(reply.data for reply in self.due(t_ns))


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
