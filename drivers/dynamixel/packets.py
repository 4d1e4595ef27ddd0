"""Protocol 2.0 requests over one port: sent stuffed, answered by whoever was asked, or not at all.

The SDK's own packet handler is not used: it computes the stuffing and sends the packet without it, its
unstuffing is no inverse of stuffing, and it hands out data without a look at length and error byte. Tests
hold ours to it where it is right. ``drivers.dynamixel.requests`` stands on top.
"""

from collections import deque
from collections.abc import Callable
from typing import NamedTuple, TypeVar

from dynamixel_sdk import (
    COMM_RX_CORRUPT,
    COMM_RX_TIMEOUT,
    COMM_SUCCESS,
    COMM_TX_FAIL,
)

from drivers.dynamixel.frames import (
    ALERT,
    OUTSIDE,
    STATUS,
    STATUS_BYTES,
    BadFrame,
    Frame,
    FrameParser,
    StatusError,
    build_instruction,
    statuses_in_order,
)
from drivers.dynamixel.port import READ_CHUNK, ClockedPort
from drivers.dynamixel.stats import BusCounters

T = TypeVar("T")
# For so long after an answer failed to come it may still do so, in the middle of another request.
OWED_NS = 500_000_000


class ServoAnswer(NamedTuple):
    """One servo's answer to a request; a tuple, because one is made of every answer.

    Attributes:
        data: The data, None if there is none that may be used.
        error: Error byte, 0 if none came.
        code: The SDK's result code: COMM_SUCCESS, COMM_RX_TIMEOUT, COMM_RX_CORRUPT, COMM_TX_FAIL.
    """

    data: bytes | None
    error: int
    code: int

    @property
    def ok(self) -> bool:
        """Whether the servo did what it was asked; an alert does not count against it."""
        return self.code == COMM_SUCCESS and self.error & ~ALERT == StatusError.NONE

    @property
    def refused(self) -> bool:
        """Whether the servo understood the request and does not do it: asking again gives the same.

        A CRC error is none: the request was damaged on the way, and the next one may arrive whole.
        """
        return self.error & ~ALERT not in {StatusError.NONE, StatusError.CRC}

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


class PacketHandler:
    """Protocol 2.0 over one port. Not for two threads at once.

    Args:
        port: The port; it may be opened later.
    """

    def __init__(self, port: ClockedPort) -> None:
        self.port = port
        self.counters = BusCounters()
        self._parser = FrameParser()
        self._frames: deque[Frame | BadFrame] = deque()
        # True from a timeout on, until the port has been given time to bring what was late.
        self.suspect_late = False
        self.sent_ns = 0  # when the last request had been handed to the port
        self._owed_until_ns = 0

    def owed(self) -> bool:
        """Whether an answer that failed to come may still do so: the next one may not be what it seems."""
        return self.port.clock.now_ns() < self._owed_until_ns

    def note_missing(self) -> None:
        """Take note that an answer has failed to come."""
        self._owed_until_ns = self.port.clock.now_ns() + OWED_NS

    def request(
        self, servo_id: int, instruction: int, parameters: bytes, length: int
    ) -> ServoAnswer:
        """Send one servo an instruction and wait for its answer of ``length`` data bytes."""
        frame = build_instruction(servo_id, instruction, parameters)
        code = self.send(frame)
        if code != COMM_SUCCESS:
            return ServoAnswer(None, 0, code)
        self.port.setPacketTimeout(len(frame) + STATUS_BYTES + length)
        return self.answer(servo_id, length)

    def answer(self, servo_id: int, length: int) -> ServoAnswer:
        """Wait for one servo's answer; others, and answers of another length, are dropped."""
        while True:
            frame, code = self.next_status()
            if frame is None:
                self.counters.timeouts += code == COMM_RX_TIMEOUT
                self.suspect_late = True
                self.note_missing()
                return ServoAnswer(None, 0, code)
            answer = self.checked(frame, length) if frame.servo_id == servo_id else None
            if answer is not None:
                return answer
            self.counters.foreign_replies += 1

    def checked(self, frame: Frame, length: int) -> ServoAnswer | None:
        """Return the answer in a frame; None if its length fits neither the data nor an error."""
        error = frame.error or 0
        if error & ~ALERT:
            self.counters.status_errors += 1
            return ServoAnswer(None, error, COMM_SUCCESS)
        if len(frame.parameters) != length:
            return None
        return ServoAnswer(frame.parameters, error, COMM_SUCCESS)

    def send(self, frame: bytes) -> int:
        """Empty the port, send a frame; return the SDK's result code."""
        self.port.is_using = True
        try:
            self._drain()
            self.counters.requests += 1
            whole = self.port.writePort(frame) == len(frame)
            self.sent_ns = self.port.clock.now_ns()
            return int(COMM_SUCCESS if whole else COMM_TX_FAIL)
        finally:
            self.port.is_using = False

    def _drain(self) -> None:
        """Empty the port, so that nobody takes an old answer for a new one.

        After a timeout the answer may still be under way: it is given one latency period.
        """
        port, waited = self.port, self.suspect_late
        self.suspect_late = False
        stale = [*self._frames]
        self._frames.clear()
        if waited:
            port.setPacketTimeoutMillis(port.latency_ms)
            while port.remaining_ms() > 0:
                stale += self._parser.feed(port.readPort(READ_CHUNK))
        elif port.getBytesAvailable():
            stale += self._parser.feed(port.readPort(READ_CHUNK))
        if stale:
            self.counters.late_replies += sum(_is_status(item) for item in stale)
        self._parser.clear()
        port.clearPort()

    def all_in_order(self, count: int, length: int, read: Callable[[bytes], T | None]) -> T | None:
        """Wait for the answers of several servos that were asked together.

        Args:
            count: How many they are.
            length: Bytes of data of each.
            read: Takes their bytes apart, if each servo has answered in its turn and done what it was
                asked, as is usual; else None.

        Returns:
            What was read; None if nothing was: what has come so far is then there for ``next_status``.
        """
        data = self.port.readAnswers(count, STATUS_BYTES + length)
        answered = read(data)
        if answered is None:
            self._frames.extend(self._parser.feed(data))
        return answered

    def next_status(self) -> tuple[Frame | None, int]:
        """Wait for one status frame until the port's timeout."""
        port, damaged = self.port, False
        while True:
            while self._frames:
                item = self._frames.popleft()
                if isinstance(item, BadFrame):
                    damaged |= self._count_damage(item)
                elif item.instruction == STATUS:
                    return item, COMM_SUCCESS
            if port.remaining_ms() > 0:
                self._frames.extend(self._parser.feed(port.readPort(READ_CHUNK)))
            elif self._parser.pending:
                self._frames.extend(self._parser.give_up())
            else:
                return None, COMM_RX_CORRUPT if damaged else COMM_RX_TIMEOUT

    def _count_damage(self, item: BadFrame) -> bool:
        if item.reason == OUTSIDE:
            self.counters.noise_bytes += len(item.raw)
            return False
        self.counters.crc_errors += 1
        return True


def answers_in_order(ids: bytes, length: int, data: bytes) -> list[ServoAnswer] | None:
    """Return the answers of servos; None unless all have answered in their turn, without an error."""
    answered = statuses_in_order(data, ids, length)
    if answered is None or {error & ~ALERT for error, _ in answered} != {0}:
        return None
    return [ServoAnswer(parameters, error, COMM_SUCCESS) for error, parameters in answered]


def _is_status(item: Frame | BadFrame) -> bool:
    """Tell a reply from damage, and from the echo of a request that some adapters give."""
    return isinstance(item, Frame) and item.instruction == STATUS
