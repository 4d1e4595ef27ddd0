"""The virtual MX-106 bus: protocol 2.0 behaviour of all servos, without any input or output of its own.

Bytes go in with the time at which they were sent, answers come out with the time at which their last
byte is on the wire: ten bits a byte, the servo's return delay, and about 50 us of its own work. Source:
ROBOTIS e-manual, MX-106(2.0) and "Protocol 2.0"; what it does not publish is marked where it is decided.
"""

from collections import deque
from dataclasses import dataclass

from drivers.dynamixel_frames import (
    ALERT,
    BROADCAST_ID,
    BadFrame,
    Frame,
    FrameParser,
    Instruction,
    build_status,
)
from drivers.mx106 import BAUD_CODES, RETURN_DELAY_UNIT_S
from sim_hw.interfaces import MotorWorld
from sim_hw.servo_firmware import FirmwareBank
from sim_hw.virtual_servo import VirtualServo

PROCESSING_NS = 50_000
BITS_PER_BYTE = 10
# A longer pause inside a packet makes the servo drop it (e-manual, "Protocol 2.0").
LARGEST_BYTE_GAP_NS = 1_500_000
DEFAULT_RETURN_DELAY = 0
# How often watchdogs and protections are looked after.
CHECK_PERIOD_NS = 2_000_000


@dataclass(frozen=True, slots=True)
class Reply:
    """An answer on the wire.

    Attributes:
        t_ns: When its last byte has been sent.
        data: Its bytes.
    """

    t_ns: int
    data: bytes


class VirtualServoBus:
    """All virtual servos on one pair of wires.

    Args:
        world: The motors.
        firmware: The control loops, shared with the world.
        ids: Dynamixel ids, in the world's order.
        baud_rate: Baud rate they are set to.
        return_delay: Return delay they are set to, in units of 2 us.
    """

    def __init__(
        self,
        world: MotorWorld,
        firmware: FirmwareBank,
        ids: tuple[int, ...],
        baud_rate: int,
        return_delay: int = DEFAULT_RETURN_DELAY,
    ) -> None:
        self._world = world
        self.servos = tuple(
            VirtualServo(index, servo_id, BAUD_CODES[baud_rate], return_delay, world, firmware)
            for index, servo_id in enumerate(ids)
        )
        self._parser = FrameParser()
        self._replies: deque[Reply] = deque()
        self._last_byte_ns = 0
        self._wire_free_ns = 0
        self._next_check_ns = 0
        self._silent: dict[int, bool] = {}
        self._damage_next = 0
        self._delay_next_ns = 0

    # Faults on purpose.

    def silence(self, servo_id: int, *, on: bool = True, chain_breaks: bool = False) -> None:
        """Make a servo deaf and mute, or give it back its voice.

        Args:
            servo_id: Which.
            on: False ends it.
            chain_breaks: Servos behind it in a sync read wait for it and stay silent as well.
        """
        if on:
            self._silent[servo_id] = chain_breaks
        else:
            self._silent.pop(servo_id, None)

    def damage_next_reply(self) -> None:
        """Flip one bit of the next reply."""
        self._damage_next += 1

    def delay_next_reply(self, duration_ns: int) -> None:
        """Send the next reply so much later."""
        self._delay_next_ns = duration_ns

    # The wire.

    def poll(self, t_ns: int) -> None:
        """Let time pass: watchdogs trip and protections act without any traffic."""
        self._world.advance_to(t_ns)
        if t_ns >= self._next_check_ns:
            self._next_check_ns = t_ns + CHECK_PERIOD_NS
            for servo in self.servos:
                servo.check(t_ns)

    def receive(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        """Take bytes from the wire.

        Args:
            data: The bytes.
            t_ns: When the last of them arrived.
            baud_rate: Baud rate they were sent at; servos set to another understand nothing.
        """
        self.poll(t_ns)
        if t_ns - self._last_byte_ns > LARGEST_BYTE_GAP_NS + _wire_ns(len(data), baud_rate):
            self._parser.clear()
        self._last_byte_ns = t_ns
        code = BAUD_CODES.get(baud_rate)
        listening = [s for s in self.servos if s.table.get("baud_rate") == code]
        for item in self._parser.feed(data):
            if isinstance(item, BadFrame) or item.error is not None:
                continue
            self._wire_free_ns = max(self._wire_free_ns, t_ns)
            for servo in listening:
                if servo.servo_id not in self._silent:
                    servo.heard_traffic(t_ns)
            self._obey(item, t_ns, baud_rate, listening)

    def next_reply_ns(self) -> int | None:
        """When the next reply is complete, None if none is under way."""
        return self._replies[0].t_ns if self._replies else None

    def replies(self, t_ns: int) -> bytes:
        """Return the bytes of all replies complete by a time."""
        ready = bytearray()
        while self._replies and self._replies[0].t_ns <= t_ns:
            ready += self._replies.popleft().data
        return bytes(ready)

    def drop_replies(self) -> None:
        """Forget what is under way; the receiver has gone."""
        self._replies.clear()

    def _send(self, servo: VirtualServo, error: int, data: bytes, baud_rate: int) -> None:
        frame = build_status(servo.servo_id, error | (ALERT if servo.alert else 0), data)
        if self._damage_next:
            self._damage_next -= 1
            frame = frame[:-3] + bytes([frame[-3] ^ 0x10]) + frame[-2:]
        delay_ns = round(servo.table.get("return_delay_time") * RETURN_DELAY_UNIT_S * 1e9)
        start_ns = self._wire_free_ns + delay_ns + PROCESSING_NS + self._delay_next_ns
        self._delay_next_ns = 0
        self._wire_free_ns = start_ns + _wire_ns(len(frame), baud_rate)
        self._replies.append(Reply(self._wire_free_ns, frame))

    # What the servos do.

    def _obey(self, frame: Frame, t_ns: int, baud_rate: int, listening: list[VirtualServo]) -> None:
        by_id = {s.servo_id: s for s in listening if s.servo_id not in self._silent}
        match frame.instruction:
            case Instruction.SYNC_READ:
                self._sync_read(frame.parameters, t_ns, baud_rate, by_id)
            case Instruction.BULK_READ:
                self._bulk_read(frame.parameters, t_ns, baud_rate, by_id)
            case Instruction.SYNC_WRITE:
                _sync_write(frame.parameters, t_ns, by_id)
            case Instruction.BULK_WRITE:
                _bulk_write(frame.parameters, t_ns, by_id)
            case Instruction.FAST_SYNC_READ | Instruction.FAST_BULK_READ:
                return  # MX firmware does not know them; they go to everybody, so it is silent
            case Instruction.PING if frame.servo_id == BROADCAST_ID:
                for servo in sorted(by_id.values(), key=lambda s: s.servo_id):
                    self._send(servo, 0, servo.identity(), baud_rate)
            case _:
                self._single(frame, t_ns, baud_rate, by_id)

    def _single(
        self, frame: Frame, t_ns: int, baud_rate: int, by_id: dict[int, VirtualServo]
    ) -> None:
        broadcast = frame.servo_id == BROADCAST_ID
        if broadcast:
            for servo in by_id.values():
                servo.obey(frame.instruction, frame.parameters, t_ns, broadcast=True)
            return
        for servo in by_id.values():  # a shadow id listens and never answers
            if servo.shadow_id == frame.servo_id and servo.servo_id != frame.servo_id:
                servo.obey_as_shadow(frame.instruction, frame.parameters, t_ns)
        servo_or_none = by_id.get(frame.servo_id)
        if servo_or_none is None:
            return
        answers = servo_or_none.answers(frame.instruction)
        error, data = servo_or_none.obey(frame.instruction, frame.parameters, t_ns, broadcast=False)
        if answers:
            self._send(servo_or_none, error, data, baud_rate)

    def _sync_read(
        self, parameters: bytes, t_ns: int, baud_rate: int, by_id: dict[int, VirtualServo]
    ) -> None:
        if len(parameters) < 5:
            return
        address, length = _pair(parameters)
        for servo_id in parameters[4:]:
            if self._answer_read(by_id, servo_id, address, length, t_ns, baud_rate):
                break

    def _bulk_read(
        self, parameters: bytes, t_ns: int, baud_rate: int, by_id: dict[int, VirtualServo]
    ) -> None:
        for start in range(0, len(parameters) - 4, 5):
            address, length = _pair(parameters[start + 1 :])
            if self._answer_read(by_id, parameters[start], address, length, t_ns, baud_rate):
                break

    def _answer_read(
        self,
        by_id: dict[int, VirtualServo],
        servo_id: int,
        address: int,
        length: int,
        t_ns: int,
        baud_rate: int,
    ) -> bool:
        """Answer for one servo; return whether the chain of answers breaks here."""
        servo = by_id.get(servo_id)
        if servo is None:
            return self._silent.get(servo_id, False)
        if servo.table.get("status_return_level") >= 1:
            error, data = servo.read(address, length, t_ns)
            self._send(servo, error, data, baud_rate)
        return False


def _pair(parameters: bytes) -> tuple[int, int]:
    return int.from_bytes(parameters[:2], "little"), int.from_bytes(parameters[2:4], "little")


def _sync_write(parameters: bytes, t_ns: int, by_id: dict[int, VirtualServo]) -> None:
    if len(parameters) < 5:
        return
    address, length = _pair(parameters)
    for start in range(4, len(parameters) - length, length + 1):
        servo = by_id.get(parameters[start])
        if servo is not None:
            servo.write(address, parameters[start + 1 : start + 1 + length], t_ns)


def _bulk_write(parameters: bytes, t_ns: int, by_id: dict[int, VirtualServo]) -> None:
    start = 0
    while start + 5 <= len(parameters):
        address, length = _pair(parameters[start + 1 :])
        servo = by_id.get(parameters[start])
        if servo is not None:
            servo.write(address, parameters[start + 5 : start + 5 + length], t_ns)
        start += 5 + length


def _wire_ns(count: int, baud_rate: int) -> int:
    return round(count * BITS_PER_BYTE * 1e9 / baud_rate)
