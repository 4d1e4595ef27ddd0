"""The virtual MX-106 bus: protocol 2.0 behaviour of all servos, without any input or output of its own.

Bytes go in with the time at which they were sent, answers come out with the time at which their last
byte is on the wire: ten bits a byte, the servo's return delay, and about 50 us of its own work. Source:
ROBOTIS e-manual, MX-106(2.0) and "Protocol 2.0"; what it does not publish is in ``sim_hw.assumed``, or
marked where it is decided. That the answer to a write of the id comes from the old id is assumed.
"""

from collections import deque
from dataclasses import dataclass

from drivers.dynamixel.frames import (
    ALERT,
    BROADCAST_ID,
    WRONG_CRC,
    BadFrame,
    Frame,
    FrameParser,
    Instruction,
    StatusError,
    build_status,
)
from drivers.dynamixel.mx106 import BAUD_CODES, RETURN_DELAY_UNIT_S
from sim_hw.assumed import SERVO_ASSUMED, ServoAssumed
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.servo import VirtualServo
from sim_hw.interfaces import MotorWorld

BITS_PER_BYTE = 10
LARGEST_ID = 252
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
        servo_id: Who sent it.
    """

    t_ns: int
    data: bytes
    servo_id: int


class VirtualServoBus:
    """All virtual servos on one pair of wires.

    Args:
        world: The motors.
        firmware: The control loops, shared with the world.
        ids: Dynamixel ids, in the world's order.
        baud_rate: Baud rate they are set to.
        return_delay: Return delay they are set to, in units of 2 us.
        assumed: What is assumed about them.
    """

    def __init__(
        self,
        world: MotorWorld,
        firmware: FirmwareBank,
        ids: tuple[int, ...],
        baud_rate: int,
        return_delay: int = DEFAULT_RETURN_DELAY,
        assumed: ServoAssumed = SERVO_ASSUMED,
    ) -> None:
        self._world = world
        self._assumed = assumed
        code = BAUD_CODES[baud_rate]
        self.servos = tuple(
            VirtualServo(index, servo_id, code, return_delay, world, firmware, assumed)
            for index, servo_id in enumerate(ids)
        )
        self._parser = FrameParser()
        self._replies: deque[Reply] = deque()
        self._last_byte_ns = 0
        self._wire_free_ns = 0
        self._next_check_ns = 0
        self._silent: dict[int, bool] = {}

    def silence(self, servo_id: int, *, on: bool = True, chain_breaks: bool = False) -> None:
        """Take a servo off the wire, deaf and mute, or put it back.

        Args:
            servo_id: Which.
            on: False ends it.
            chain_breaks: Servos behind it in a sync read wait for it and stay silent as well.
        """
        if on:
            self._silent[servo_id] = chain_breaks
        else:
            self._silent.pop(servo_id, None)

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
        if t_ns - self._last_byte_ns > LARGEST_BYTE_GAP_NS + wire_ns(len(data), baud_rate):
            self._parser.clear()
        self._last_byte_ns = t_ns
        code = BAUD_CODES.get(baud_rate)
        listening = [
            s
            for s in self.servos
            if s.table.get("baud_rate") == code and s.awake(t_ns) and s.servo_id not in self._silent
        ]
        for item in self._parser.feed(data):
            self._wire_free_ns = max(self._wire_free_ns, t_ns)
            if isinstance(item, BadFrame):
                self._answer_damage(item, listening, baud_rate)
            elif item.error is None:
                self._hear(item, listening, t_ns)
                self._obey(item, t_ns, baud_rate, listening)

    def _hear(self, frame: Frame, listening: list[VirtualServo], t_ns: int) -> None:
        """Let the watchdogs know of an instruction packet."""
        every = self._assumed.watchdog_hears == "all" or frame.servo_id == BROADCAST_ID
        for servo in listening:
            if every or servo.servo_id == frame.servo_id:
                servo.heard_traffic(t_ns)

    def _answer_damage(self, bad: BadFrame, listening: list[VirtualServo], baud_rate: int) -> None:
        if not self._assumed.answers_bad_crc or bad.reason != WRONG_CRC:
            return
        for servo in listening:
            if servo.servo_id == bad.raw[4]:
                self._send(servo, servo.servo_id, StatusError.CRC, b"", baud_rate)

    def next_reply_ns(self) -> int | None:
        """When the next reply is complete, None if none is under way."""
        return self._replies[0].t_ns if self._replies else None

    def replies(self, t_ns: int) -> bytes:
        """Return the bytes of all replies complete by a time."""
        return b"".join(reply.data for reply in self.due(t_ns))

    def due(self, t_ns: int) -> list[Reply]:
        """Return all replies complete by a time, each by itself."""
        ready: list[Reply] = []
        while self._replies and self._replies[0].t_ns <= t_ns:
            ready.append(self._replies.popleft())
        return ready

    def _send(
        self, servo: VirtualServo, servo_id: int, error: int, data: bytes, baud_rate: int
    ) -> None:
        frame = build_status(servo_id, error | (ALERT if servo.alert else 0), data)
        delay_ns = round(servo.table.get("return_delay_time") * RETURN_DELAY_UNIT_S * 1e9)
        start_ns = self._wire_free_ns + delay_ns + round(self._assumed.processing_s * 1e9)
        self._wire_free_ns = start_ns + wire_ns(len(frame), baud_rate)
        self._replies.append(Reply(self._wire_free_ns, frame, servo_id))

    # What the servos do.

    def _obey(self, frame: Frame, t_ns: int, baud_rate: int, listening: list[VirtualServo]) -> None:
        by_id = {s.servo_id: s for s in listening}
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
                    self._send(servo, servo.servo_id, 0, servo.identity(), baud_rate)
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
        for servo in _shadows(by_id, frame.servo_id):
            servo.obey_as_shadow(frame.instruction, frame.parameters, t_ns)
        servo_or_none = by_id.get(frame.servo_id)
        if servo_or_none is None:
            return
        answers = servo_or_none.answers(frame.instruction)
        error, data = servo_or_none.obey(frame.instruction, frame.parameters, t_ns, broadcast=False)
        if answers:
            self._send(servo_or_none, frame.servo_id, error, data, baud_rate)

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
            self._send(servo, servo_id, error, data, baud_rate)
        return False


def _pair(parameters: bytes) -> tuple[int, int]:
    return int.from_bytes(parameters[:2], "little"), int.from_bytes(parameters[2:4], "little")


def _sync_write(parameters: bytes, t_ns: int, by_id: dict[int, VirtualServo]) -> None:
    if len(parameters) < 5:
        return
    address, length = _pair(parameters)
    for start in range(4, len(parameters) - length, length + 1):
        _write(by_id, parameters[start], address, parameters[start + 1 : start + 1 + length], t_ns)


def _bulk_write(parameters: bytes, t_ns: int, by_id: dict[int, VirtualServo]) -> None:
    start = 0
    while start + 5 <= len(parameters):
        address, length = _pair(parameters[start + 1 :])
        data = parameters[start + 5 : start + 5 + length]
        if len(data) == length:
            _write(by_id, parameters[start], address, data, t_ns)
        start += 5 + length


def _write(
    by_id: dict[int, VirtualServo], servo_id: int, address: int, data: bytes, t_ns: int
) -> None:
    """Write to the servo of an id, and to those that listen to it as their secondary id."""
    servo = by_id.get(servo_id)
    if servo is not None:
        servo.write(address, data, t_ns)
    for shadow in _shadows(by_id, servo_id):
        shadow.write_as_shadow(address, data, t_ns)


def _shadows(by_id: dict[int, VirtualServo], servo_id: int) -> list[VirtualServo]:
    """Return the servos whose secondary id this is; they listen and never answer."""
    if servo_id > LARGEST_ID:
        return []
    return [s for s in by_id.values() if s.shadow_id == servo_id and s.servo_id != servo_id]


def wire_ns(count: int, baud_rate: int) -> int:
    """Return how long so many bytes take on the wire [ns]."""
    return round(count * BITS_PER_BYTE * 1e9 / baud_rate)
