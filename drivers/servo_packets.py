"""The SDK's protocol 2.0 packet handler, put right.

Replaced are the two methods that every request of the SDK goes through: ``txPacket`` (the original
computes the stuffing and sends the packet without it) and ``rxPacket`` (its unstuffing is not the
inverse of stuffing, and it leaves the port marked busy when an exception passes). On top stand typed
requests that check id, length and error byte before anyone looks at the data, and a sync read in
which one silent servo costs one timeout and hides nobody else.
"""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

from dynamixel_sdk import (
    COMM_RX_CORRUPT,
    COMM_RX_TIMEOUT,
    COMM_SUCCESS,
    COMM_TX_FAIL,
    Protocol2PacketHandler,
)

from drivers.dynamixel_frames import (
    ALERT,
    BROADCAST_ID,
    BadFrame,
    Frame,
    FrameParser,
    Instruction,
    StatusError,
    build_instruction,
    build_status,
)
from drivers.servo_port import ClockedPort

STATUS_BYTES = 11  # a status frame without parameters
# What a servo takes to begin its answer, on top of its return delay setting [ms].
PROCESSING_MS = 0.1
READ_CHUNK = 1024


@dataclass(slots=True)
class BusCounters:
    """What happened on the bus since it was opened.

    Attributes:
        requests: Requests sent.
        timeouts: Answers that did not come in time, counted per servo.
        corrupt: Frames with a wrong CRC, length or stuffing.
        late: Answers that came after their time was over, and were dropped.
        foreign: Answers of the wrong servo or length.
        errors: Answers that report an error.
        round_trips_us: Latest round trips of sync reads.
    """

    requests: int = 0
    timeouts: int = 0
    corrupt: int = 0
    late: int = 0
    foreign: int = 0
    errors: int = 0
    round_trips_us: deque[int] = field(default_factory=lambda: deque(maxlen=10_000))


@dataclass(frozen=True, slots=True)
class Answer:
    """One servo's answer to a request.

    Attributes:
        data: The data, None if there is none that may be used.
        error: Error byte, 0 if none came.
        code: Result code of the SDK: COMM_SUCCESS, COMM_RX_TIMEOUT, COMM_RX_CORRUPT or COMM_TX_FAIL.
    """

    data: bytes | None
    error: int
    code: int

    @property
    def ok(self) -> bool:
        """Whether the servo did what it was asked; an alert does not count against it."""
        return self.code == COMM_SUCCESS and self.error & ~ALERT == StatusError.NONE

    @property
    def words(self) -> str:
        """What went wrong, for a person."""
        if self.code == COMM_RX_TIMEOUT:
            return "no answer"
        if self.code == COMM_RX_CORRUPT:
            return "a damaged answer"
        if self.code != COMM_SUCCESS:
            return "the request could not be sent"
        number = self.error & ~ALERT
        try:
            return f"error: {StatusError(number).name.lower().replace('_', ' ')}"
        except ValueError:
            return f"error {number}"


class PacketHandler(Protocol2PacketHandler):  # type: ignore[misc]  # the SDK is not typed
    """Protocol 2.0 over one port. Not for two threads at once."""

    def __init__(self) -> None:
        super().__init__()
        self.counters = BusCounters()
        self._parser = FrameParser()
        self._frames: deque[Frame | BadFrame] = deque()
        self._suspect_late = False

    # What the SDK's own requests (ping, reboot, clearMultiTurn, ...) go through.

    def txPacket(self, port: ClockedPort, txpacket: Sequence[int]) -> int:  # noqa: N802
        """Send a request that the SDK has laid out: header and CRC are made here, stuffing too."""
        length = txpacket[5] | txpacket[6] << 8
        payload = bytes(txpacket[7 : 7 + length - 2])
        return self._send(port, build_instruction(txpacket[4], payload[0], payload[1:]))

    def rxPacket(  # noqa: N802
        self, port: ClockedPort, _fast_option: bool = False
    ) -> tuple[list[int], int]:
        """Return the next status frame, unstuffed, laid out as the SDK expects it."""
        frame, code = self._next_status(port)
        port.is_using = False
        if frame is None:
            return [], code
        plain = build_status(frame.servo_id, frame.error or 0)
        packet = [*plain[:9], *frame.parameters, 0, 0]
        packet[5], packet[6] = (len(packet) - 7) & 0xFF, (len(packet) - 7) >> 8
        return packet, code

    def _send(self, port: ClockedPort, frame: bytes) -> int:
        port.is_using = True
        try:
            self._drain_late(port)
            port.clearPort()
            self._parser.clear()
            self._frames.clear()
            self.counters.requests += 1
            sent = port.writePort(frame) == len(frame)
            return int(COMM_SUCCESS if sent else COMM_TX_FAIL)
        finally:
            port.is_using = False

    def _drain_late(self, port: ClockedPort) -> None:
        """After a timeout, let the answer that was late come in, so that nobody takes it for new."""
        if not self._suspect_late:
            return
        self._suspect_late = False
        port.setPacketTimeoutMillis(port.latency_ms)
        while port.remaining_ms() > 0:
            for item in self._parser.feed(port.readPort(READ_CHUNK)):
                self.counters.late += isinstance(item, Frame)

    def _next_status(self, port: ClockedPort) -> tuple[Frame | None, int]:
        """Wait for one status frame until the port's timeout."""
        damaged = False
        while True:
            while self._frames:
                item = self._frames.popleft()
                if isinstance(item, BadFrame):
                    self.counters.corrupt += 1
                    damaged = True
                elif item.instruction == Instruction.STATUS:
                    return item, COMM_SUCCESS
            if port.remaining_ms() <= 0:
                damaged = damaged or self._parser.pending > 0
                return None, COMM_RX_CORRUPT if damaged else COMM_RX_TIMEOUT
            self._frames.extend(self._parser.feed(port.readPort(READ_CHUNK)))

    # Typed requests.

    def read(self, port: ClockedPort, servo_id: int, address: int, length: int) -> Answer:
        """Read ``length`` bytes of one servo."""
        parameters = address.to_bytes(2, "little") + length.to_bytes(2, "little")
        frame = build_instruction(servo_id, Instruction.READ, parameters)
        return self._request(port, servo_id, frame, length)

    def write(self, port: ClockedPort, servo_id: int, address: int, data: bytes) -> Answer:
        """Write bytes to one servo and wait for its word that it took them."""
        frame = build_instruction(servo_id, Instruction.WRITE, address.to_bytes(2, "little") + data)
        return self._request(port, servo_id, frame, 0)

    def ask(self, port: ClockedPort, servo_id: int, instruction: int, data: bytes = b"") -> Answer:
        """Send any other instruction to one servo (ping answers three bytes, the rest none)."""
        length = 3 if instruction == Instruction.PING else 0
        return self._request(port, servo_id, build_instruction(servo_id, instruction, data), length)

    def tell_all(self, port: ClockedPort, address: int, data: bytes) -> int:
        """Broadcast a write; nobody answers it."""
        frame = build_instruction(
            BROADCAST_ID, Instruction.WRITE, address.to_bytes(2, "little") + data
        )
        return self._send(port, frame)

    def sync_write(
        self, port: ClockedPort, address: int, items: Sequence[tuple[int, bytes]]
    ) -> int:
        """Write to several servos at once; nobody answers it.

        Args:
            port: The port.
            address: First byte.
            items: Servo id and data of each; all data of one length.
        """
        length = len(items[0][1])
        if any(len(data) != length for _, data in items):
            raise ValueError("a sync write needs data of one length")
        parameters = address.to_bytes(2, "little") + length.to_bytes(2, "little")
        parameters += b"".join(bytes([servo_id]) + data for servo_id, data in items)
        frame = build_instruction(BROADCAST_ID, Instruction.SYNC_WRITE, parameters)
        return self._send(port, frame)

    def sync_read(
        self,
        port: ClockedPort,
        ids: Sequence[int],
        address: int,
        length: int,
        return_delay_ms: float,
    ) -> list[Answer]:
        """Read the same registers of several servos in one request.

        Each servo's answer stands by itself: who is silent or damaged is said of that one alone, and
        the wait ends as soon as all have answered.

        Returns:
            One answer per id, in the order of ``ids``.
        """
        parameters = address.to_bytes(2, "little") + length.to_bytes(2, "little") + bytes(ids)
        began_ns = port.clock.now_ns()
        code = self._send(port, build_instruction(BROADCAST_ID, Instruction.SYNC_READ, parameters))
        if code != COMM_SUCCESS:
            return [Answer(None, 0, code)] * len(ids)
        port.setPacketTimeout((STATUS_BYTES + length) * len(ids) + STATUS_BYTES + 3 + len(ids))
        port.packet_timeout += (return_delay_ms + PROCESSING_MS) * len(ids)
        answers: dict[int, Answer] = {}
        missing = COMM_RX_TIMEOUT
        while len(answers) < len(ids):
            frame, code = self._next_status(port)
            if frame is None:
                missing = code
                break
            answer = self._checked(frame, length)
            if answer is None or frame.servo_id not in ids or frame.servo_id in answers:
                self.counters.foreign += 1
                continue
            answers[frame.servo_id] = answer
        silent = len(ids) - len(answers)
        self.counters.timeouts += silent
        self._suspect_late = silent > 0
        if not silent:
            self.counters.round_trips_us.append((port.clock.now_ns() - began_ns) // 1000)
        return [answers.get(servo_id, Answer(None, 0, missing)) for servo_id in ids]

    def _request(self, port: ClockedPort, servo_id: int, frame: bytes, length: int) -> Answer:
        code = self._send(port, frame)
        if code != COMM_SUCCESS:
            return Answer(None, 0, code)
        port.setPacketTimeout(len(frame) + STATUS_BYTES + length)
        while True:
            status, code = self._next_status(port)
            if status is None:
                self.counters.timeouts += code == COMM_RX_TIMEOUT
                self._suspect_late = True
                return Answer(None, 0, code)
            answer = self._checked(status, length) if status.servo_id == servo_id else None
            if answer is not None:
                return answer
            self.counters.foreign += 1

    def _checked(self, frame: Frame, length: int) -> Answer | None:
        """Return the answer in a frame; None if its length fits neither the data nor an error."""
        error = frame.error or 0
        if error & ~ALERT:
            self.counters.errors += 1
            return Answer(None, error, COMM_SUCCESS)
        if len(frame.parameters) != length:
            return None
        return Answer(frame.parameters, error, COMM_SUCCESS)
