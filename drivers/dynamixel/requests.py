"""What the bus asks of servos: read, write, ping, and all of them in one request.

Each request says per servo what came back; none of them raises for a servo that is silent.
"""

from collections.abc import Callable, Sequence
from functools import cache, partial
from itertools import chain
from struct import Struct
from typing import TypeVar

from dynamixel_sdk import COMM_RX_CORRUPT, COMM_RX_TIMEOUT, COMM_SUCCESS

from drivers.dynamixel.frames import BROADCAST_ID, STATUS_BYTES, Instruction, build_instruction
from drivers.dynamixel.packets import PacketHandler, ServoAnswer, answers_in_order
from drivers.dynamixel.registers import Register

T = TypeVar("T")
IDENTITY_BYTES = 3  # what a ping is answered with: model number and firmware version
# What a servo takes to begin its answer, on top of its return delay setting [ms].
PROCESSING_MS = 0.1
# Two one-byte answers in a row should agree within so many more reads.
AGREE_TRIES = 4
# While an answer is owed, these registers are read with their neighbours: torque with what shuts it down
# (63, 64), the hardware error with what stands before it (68 to 70). Each has a length of its own then, so
# that a late "torque is on" (1) cannot pass for "input voltage" (1).
WITH_NEIGHBOURS = {64: (63, 2), 70: (68, 3)}


class ServoRequests(PacketHandler):
    """Typed requests to servos. Not for two threads at once."""

    def read(self, servo_id: int, address: int, length: int) -> ServoAnswer:
        """Read ``length`` bytes of one servo."""
        return self.request(servo_id, Instruction.READ, _span(address, length), length)

    def read_byte(self, servo_id: int, address: int) -> ServoAnswer:
        """Read one byte, and again while an older answer may still come, until two in a row agree.

        All one-byte answers look alike, so one that comes late would pass for the answer to another
        question; torque and hardware error are read with their neighbours then.
        """
        answer = self._last_byte(servo_id, address)
        for _ in range(AGREE_TRIES):
            if not self.owed():
                return answer
            again = self._last_byte(servo_id, address)
            if again == answer:
                return again
            answer = again
        return ServoAnswer(None, 0, COMM_RX_CORRUPT)

    def _last_byte(self, servo_id: int, address: int) -> ServoAnswer:
        """Read one byte, at the end of its neighbours while an answer is owed."""
        alone = (address, 1)
        start, length = WITH_NEIGHBOURS.get(address, alone) if self.owed() else alone
        answer = self.read(servo_id, start, length)
        return answer if answer.data is None else answer._replace(data=answer.data[-1:])

    def write(self, servo_id: int, address: int, data: bytes) -> ServoAnswer:
        """Write bytes to one servo and wait for its word that it took them."""
        return self.request(servo_id, Instruction.WRITE, _word(address) + data, 0)

    def broadcast(self, address: int, data: bytes) -> int:
        """Write bytes to all servos; nobody answers it."""
        frame = build_instruction(BROADCAST_ID, Instruction.WRITE, _word(address) + data)
        return self.send(frame)

    def ask(self, servo_id: int, instruction: int, data: bytes = b"") -> ServoAnswer:
        """Send any other instruction to one servo (ping answers three bytes, the rest none)."""
        length = IDENTITY_BYTES if instruction == Instruction.PING else 0
        return self.request(servo_id, instruction, data, length)

    def sync_write(self, address: int, items: Sequence[tuple[int, bytes]]) -> int:
        """Write to several servos at once; nobody answers it.

        Args:
            address: First byte.
            items: Servo id and data of each; all data of one length, each id once.

        Raises:
            ValueError: The items break these rules; nothing has been sent.
        """
        if len({len(data) for _, data in items}) != 1:
            raise ValueError("a sync write needs data of one length")
        if len({servo_id for servo_id, _ in items}) != len(items):
            raise ValueError("a sync write takes each id once")
        parameters = _span(address, len(items[0][1]))
        parameters += b"".join([bytes((servo_id,)) + data for servo_id, data in items])
        frame = build_instruction(BROADCAST_ID, Instruction.SYNC_WRITE, parameters)
        return self.send(frame)

    def sync_write_numbers(
        self, register: Register, ids: Sequence[int], numbers: Sequence[int]
    ) -> int:
        """Write a register of four bytes of several servos; as ``sync_write``.

        Args:
            register: The register.
            ids: Servo ids, each once.
            numbers: What to write.
        """
        layout = _id_and_number(len(ids))
        pairs = layout.pack(*chain.from_iterable(zip(ids, numbers, strict=True)))
        parameters = _span(register.address, register.size) + pairs
        return self.send(build_instruction(BROADCAST_ID, Instruction.SYNC_WRITE, parameters))

    def sync_read(
        self,
        ids: Sequence[int],
        address: int,
        length: int,
        return_delay_ms: float,
    ) -> list[ServoAnswer]:
        """Read the same registers of several servos in one request.

        Each servo's answer stands by itself: who is silent or damaged is said of that one alone,
        and the wait ends as soon as all have answered.

        Args:
            ids: Servo ids, each once; they answer in this order.
            address: First byte.
            length: Bytes of each servo.
            return_delay_ms: Longest return delay of any of them.

        Returns:
            One answer per id, in the order of ``ids``.
        """
        usual = partial(answers_in_order, bytes(ids), length)
        return self.sync_read_as(ids, address, length, return_delay_ms, usual)

    def sync_read_as(
        self,
        ids: Sequence[int],
        address: int,
        length: int,
        return_delay_ms: float,
        read: Callable[[bytes], T | None],
    ) -> T | list[ServoAnswer]:
        """Do the same, with the bytes of usual answers taken apart by ``read``; see ``all_in_order``."""
        port = self.port
        began_ns = port.clock.now_ns()
        parameters = _span(address, length) + bytes(ids)
        frame = build_instruction(BROADCAST_ID, Instruction.SYNC_READ, parameters)
        self.counters.reads += 1
        self.counters.note_begin(began_ns)
        code = self.send(frame)
        if code != COMM_SUCCESS:
            return [ServoAnswer(None, 0, code)] * len(ids)
        port.setPacketTimeout(len(frame) + (STATUS_BYTES + length) * len(ids))
        port.packet_timeout += (return_delay_ms + PROCESSING_MS) * len(ids)
        everyone = self.all_in_order(len(ids), length, read)
        if everyone is not None:
            self.suspect_late = False
            self.counters.note_round_trip(port.clock.now_ns() - began_ns)
            return everyone
        damaged_before = self.counters.crc_errors
        answers = self._collect(ids, length)
        silent = len(ids) - len(answers)
        damaged = self.counters.crc_errors - damaged_before
        # whose answer was damaged cannot be known: it is said of all who are missing
        code = COMM_RX_CORRUPT if damaged else COMM_RX_TIMEOUT
        self.counters.timeouts += max(0, silent - damaged)
        self.suspect_late = silent > 0
        if silent:
            self.note_missing()
        if not silent:
            self.counters.note_round_trip(port.clock.now_ns() - began_ns)
        return [answers.get(servo_id, ServoAnswer(None, 0, code)) for servo_id in ids]

    def _collect(self, ids: Sequence[int], length: int) -> dict[int, ServoAnswer]:
        """Gather the answers to a sync read until all are there or the time is over."""
        answers: dict[int, ServoAnswer] = {}
        while len(answers) < len(ids):
            frame, _ = self.next_status()
            if frame is None:
                break
            answer = self.checked(frame, length)
            if answer is None or frame.servo_id not in ids:
                self.counters.foreign_replies += 1
                continue
            # Servos answer in the order of the request. One that stands before its forerunners, or
            # twice, answered an earlier request: of such answers the later one counts.
            place = ids.index(frame.servo_id)
            for early in [i for i in ids[place:] if i in answers]:
                del answers[early]
                self.counters.late_replies += 1
            answers[frame.servo_id] = answer
        return answers


@cache
def _id_and_number(count: int) -> Struct:
    return Struct("<" + count * "Bi")


def _word(value: int) -> bytes:
    return value.to_bytes(2, "little")


def _span(address: int, length: int) -> bytes:
    return _word(address) + _word(length)
