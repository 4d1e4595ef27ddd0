"""The virtual servo bus: protocol 2.0 behaviour of all servos, without any input or output of its own.

Bytes go in with the time at which they were sent, answers come out with the time at which their last
byte is on the wire: ten bits a byte, the servo's return delay, and about 50 us of its own work. The wire
is one for both directions: a frame of the host that overlaps a reply destroys both, and servos of one id
talk at the same time. Source: ROBOTIS e-manual, MX-106(2.0) and "Protocol 2.0"; what it does not publish
is in ``sim_hw.assumed``, or marked where it is decided. That the answer to a write of the id comes from the
old id is assumed.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple, Protocol

from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.frames import (
    ALERT,
    BROADCAST_ID,
    HEADER,
    LARGEST_ID,
    WRONG_CRC,
    BadFrame,
    Frame,
    FrameParser,
    Instruction,
    StatusError,
    build_status,
)
from drivers.dynamixel.servo_model import ServoModel
from drivers.dynamixel.units import BAUD_CODES
from sim_hw.assumed import SERVO_ASSUMED, ServoAssumed
from sim_hw.clock import VirtualClock
from sim_hw.dynamixel import measured_kernel
from sim_hw.dynamixel.firmware import FirmwareBank
from sim_hw.dynamixel.listeners import Listeners, MeasuredRead
from sim_hw.dynamixel.request_parts import number_of, reads_of, writes_of
from sim_hw.dynamixel.servo import VirtualServo
from sim_hw.dynamixel.servo_watch import ServoWatch
from sim_hw.interfaces import MotorReadings, MotorWorld

BITS_PER_BYTE = 10
# A longer pause inside a packet makes the servo drop it (e-manual, "Protocol 2.0").
LARGEST_BYTE_GAP_NS = 1_500_000
# Two on the wire at once for less than a bit of the fastest rate: rounded times, no collision.
ROUNDING_NS = 200
# How often watchdogs and protections are looked after.
CHECK_PERIOD_NS = 2_000_000


class Reply(NamedTuple):
    """An answer on the wire.

    Attributes:
        t_ns: When its last byte has been sent.
        data: Its bytes.
        servo_id: Who sent it.
    """

    t_ns: int
    data: bytes
    servo_id: int


class BusNeighbours(Protocol):
    """Devices of another protocol on the same wire: see ``old_servos``."""

    @property
    def ids(self) -> tuple[int, ...]:
        """Their ids; no servo of the bus answers to these."""
        ...

    def hear(self, data: bytes, t_ns: int, baud_rate: int) -> Sequence[Reply]:
        """Return the answers to bytes of the host whose last one arrived at ``t_ns``."""
        ...

    def lose(self) -> None:
        """Drop the received part of a packet: another device sent at the same time."""
        ...


ASK_ALL = frozenset({int(Instruction.SYNC_READ), int(Instruction.BULK_READ)})
# A servo, the error and the data of its answer.
ServoReply = tuple[VirtualServo, int, bytes]


class VirtualServoBus:
    """All virtual servos on one pair of wires.

    Args:
        world: The motors.
        firmware: The control loops, shared with the world.
        ids: Dynamixel ids, in the world's order.
        baud_rate: Baud rate they are set to.
        assumed: What is assumed about them.
        models: Their models; MX-106 where none are given.

    Attributes:
        servos: The servos, in the world's order.
        collisions: Frames of the host that were lost because a servo was talking.
    """

    def __init__(
        self,
        world: MotorWorld,
        firmware: FirmwareBank,
        ids: tuple[int, ...],
        baud_rate: int,
        assumed: ServoAssumed = SERVO_ASSUMED,
        models: Sequence[ServoModel] = (),
    ) -> None:
        measured_kernel.prepare()
        self._world = world
        self._firmware = firmware
        self._assumed = assumed
        self._work_ns = round(assumed.processing_s * 1e9)
        code = BAUD_CODES[baud_rate]
        self.servos = tuple(
            VirtualServo(
                model,
                index,
                ids[index - 1] if servo_id in assumed.shares_id else servo_id,
                code,
                world,
                firmware,
                assumed,
            )
            for index, (servo_id, model) in enumerate(
                zip(ids, models or [MX_106] * len(ids), strict=True)
            )
        )
        self._watch = ServoWatch(self.servos)
        self._parser = FrameParser()
        self._replies: deque[Reply] = deque()
        self._last_byte_ns = 0
        self._wire_free_ns = 0
        self._next_check_ns = 0
        self._silent: dict[int, bool] = {}
        self._listeners: Listeners | None = None
        self._neighbours: list[BusNeighbours] = []
        self.collisions = 0

    def join(self, neighbours: BusNeighbours) -> None:
        """Put devices of another protocol on the wire, in place of the servos of their ids."""
        self._neighbours.append(neighbours)
        for servo_id in neighbours.ids:
            self.silence(servo_id)

    def silence(self, servo_id: int, *, on: bool = True, chain_breaks: bool = False) -> None:
        """Take a servo off the wire, deaf and mute, or put it back.

        Args:
            servo_id: Which.
            on: False ends it.
            chain_breaks: Servos behind it in a sync read wait for it and stay silent as well.
        """
        self._listeners = None
        if on:
            self._silent[servo_id] = chain_breaks
        else:
            self._silent.pop(servo_id, None)

    # The wire.

    def poll(self, t_ns: int) -> None:
        """Let time pass: watchdogs trip and protections act without any traffic."""
        self._pass_time(t_ns)

    def _pass_time(self, t_ns: int) -> MotorReadings | None:
        """Let time pass; return the motors as they are then, if they were looked at."""
        self._world.advance_to(t_ns)
        if t_ns < self._next_check_ns:
            return None
        self._next_check_ns = t_ns + CHECK_PERIOD_NS
        motors = self._world.motors()
        self._watch.check(t_ns, motors)
        return motors

    def receive(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        """Take bytes from the wire.

        Args:
            data: The bytes.
            t_ns: When the last of them arrived.
            baud_rate: Baud rate they were sent at; servos set to another understand nothing.
        """
        if data and data.find(HEADER, 1) < 0:  # one frame, as nearly always: it ends now
            self._take(data, t_ns, baud_rate)
            return
        for piece, behind in split_frames(data):
            self._take(piece, t_ns - wire_ns(behind, baud_rate), baud_rate)
        self.poll(t_ns)

    def _take(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        """Take bytes of one frame, or of none."""
        motors = self._pass_time(t_ns)
        start_ns = t_ns - wire_ns(len(data), baud_rate)
        if start_ns - self._last_byte_ns > LARGEST_BYTE_GAP_NS:
            self._parser.clear()
        self._last_byte_ns = t_ns
        if self._collide(start_ns, t_ns, baud_rate):
            self.collisions += 1
            self._parser.clear()
            for neighbours in self._neighbours:
                neighbours.lose()
            return
        listening = self._listening(t_ns, baud_rate)
        for item in self._parser.feed(data):
            self._wire_free_ns = max(self._wire_free_ns, t_ns)
            if isinstance(item, BadFrame):
                self._answer_damage(item, listening, baud_rate)
            elif item.error is None:
                self._hear(item, listening, t_ns)
                if item.instruction in ASK_ALL:
                    now = self._world.motors() if motors is None else motors
                    self._answer_reads(item, t_ns, baud_rate, listening, now)
                else:
                    self._obey(item, t_ns, baud_rate, listening)
        for neighbours in self._neighbours:
            for reply in neighbours.hear(data, t_ns, baud_rate):
                self._put(reply, baud_rate)

    def _listening(self, t_ns: int, baud_rate: int) -> Listeners:
        """Return the servos that understand what is on the wire."""
        code, known = BAUD_CODES.get(baud_rate), self._listeners
        if known is None or not known.hold(code):
            known = self._listeners = Listeners(self.servos, code, t_ns, self._silent)
        return known

    def _put(self, reply: Reply, baud_rate: int) -> None:
        """Put a reply on the wire, in its place by time; those that overlap destroy each other."""
        if self._collide(reply.t_ns - wire_ns(len(reply.data), baud_rate), reply.t_ns, baud_rate):
            reply = Reply(reply.t_ns, garbled(reply.data), reply.servo_id)
        self._replies.append(reply)
        if len(self._replies) > 1 and self._replies[-2].t_ns > reply.t_ns:
            self._replies = deque(sorted(self._replies, key=lambda one: one.t_ns))

    def _put_in_turn(self, read: MeasuredRead, frames: Sequence[bytes], baud_rate: int) -> None:
        """Put the answers to a sync read on the wire, each behind the one before."""
        free_ns, replies = self._wire_free_ns, []
        for servo_id, delay_ns, data in zip(read.ids, read.delays_ns, frames, strict=True):
            free_ns += delay_ns + self._work_ns + wire_ns(len(data), baud_rate)
            replies.append(Reply(free_ns, data, servo_id))
        self._wire_free_ns = free_ns
        if not self._replies:  # then they are in order, and none meets another
            self._replies.extend(replies)
            return
        for reply in replies:
            self._put(reply, baud_rate)

    def _collide(self, start_ns: int, end_ns: int, baud_rate: int) -> bool:
        """Garble the replies on the wire in this time; return whether there were any."""
        hit = False
        if not self._replies or self._replies[-1].t_ns <= start_ns + ROUNDING_NS:
            return hit  # the last of them is over
        for at, reply in enumerate(self._replies):
            begin_ns = reply.t_ns - wire_ns(len(reply.data), baud_rate)
            if reply.t_ns > start_ns + ROUNDING_NS and begin_ns < end_ns - ROUNDING_NS:
                self._replies[at] = Reply(reply.t_ns, garbled(reply.data), reply.servo_id)
                hit = True
        return hit

    def _hear(self, frame: Frame, listening: Listeners, t_ns: int) -> None:
        """Let the watchdogs know of an instruction packet."""
        every = self._assumed.watchdog_hears == "all" or frame.servo_id == BROADCAST_ID
        for servo in listening.servos if every else listening.by_id.get(frame.servo_id, ()):
            servo.heard_ns = t_ns

    def _answer_damage(self, bad: BadFrame, listening: Listeners, baud_rate: int) -> None:
        if not self._assumed.answers_bad_crc or bad.reason != WRONG_CRC:
            return
        servo_id = bad.raw[4]
        damaged = [(s, int(StatusError.CRC), b"") for s in listening.by_id.get(servo_id, ())]
        self._send(servo_id, damaged, baud_rate)

    def next_reply_ns(self) -> int | None:
        """When the next reply is complete, None if none is under way."""
        return self._replies[0].t_ns if self._replies else None

    def replies(self, t_ns: int) -> bytes:
        """Return the bytes of all replies complete by a time."""
        replies = self._replies
        if not replies or replies[0].t_ns > t_ns:
            return b""
        return b"".join([reply.data for reply in self.due(t_ns)])

    def all_replies(
        self, count: int, size: int, clock: VirtualClock, until_ns: int
    ) -> bytes | None:
        """Let time pass until all replies under way are complete; return their bytes.

        Args:
            count: How many they should be.
            size: Bytes of each.
            clock: The virtual clock.
            until_ns: When they have to be complete.

        Returns:
            None, and nothing has happened, if they are others.
        """
        replies = self._replies
        if len(replies) != count or not count or replies[-1].t_ns >= until_ns:
            return None
        if {len(reply.data) for reply in replies} != {size}:
            return None
        data = b"".join([reply.data for reply in replies])
        for reply in replies:
            if reply.t_ns >= self._next_check_ns:
                self.poll(reply.t_ns)
        clock.sleep_until_ns(replies[-1].t_ns)
        self.poll(replies[-1].t_ns)
        replies.clear()
        return data

    def due(self, t_ns: int) -> list[Reply]:
        """Return all replies complete by a time, each by itself."""
        ready: list[Reply] = []
        while self._replies and self._replies[0].t_ns <= t_ns:
            ready.append(self._replies.popleft())
        return ready

    def _send(self, servo_id: int, answers: Sequence[ServoReply], baud_rate: int) -> None:
        """Put the answers of one id on the wire: servos that share it talk at the same time."""
        sent: list[tuple[int, bytes]] = []  # when it begins, what
        for servo, error, data in answers:
            frame = build_status(servo_id, error | (ALERT if servo.alert else 0), data)
            sent.append((self._wire_free_ns + servo.return_delay_ns + self._work_ns, frame))
        while sent:
            start_ns, frame = sent.pop(0)
            end_ns = start_ns + wire_ns(len(frame), baud_rate)
            while sent and sent[0][0] < end_ns:
                if sent[0] != (start_ns, frame):
                    frame = garbled(max(frame, sent[0][1], key=len))
                end_ns = max(end_ns, sent[0][0] + wire_ns(len(sent.pop(0)[1]), baud_rate))
            self._wire_free_ns = end_ns
            self._put(Reply(end_ns, frame, servo_id), baud_rate)

    # What the servos do.

    def _obey(self, frame: Frame, t_ns: int, baud_rate: int, listening: Listeners) -> None:
        by_id = listening.by_id
        match frame.instruction:
            case Instruction.SYNC_WRITE | Instruction.BULK_WRITE:
                if frame.instruction == Instruction.SYNC_WRITE:
                    goals = listening.goal_write(frame.parameters)
                    if goals is not None and goals.done(frame.parameters, self._firmware):
                        return
                for servo_id, address, data in writes_of(frame):
                    for servo in by_id.get(servo_id, ()):
                        servo.write(address, data, t_ns)
                    for shadow in _shadows(listening, servo_id):
                        shadow.write_as_shadow(address, data, t_ns)
            case Instruction.FAST_SYNC_READ | Instruction.FAST_BULK_READ:
                return  # MX firmware does not know them; they go to everybody, so it is silent
            case Instruction.PING if frame.servo_id == BROADCAST_ID:
                for servo_id in sorted(by_id):
                    identities = [(servo, 0, servo.identity()) for servo in by_id[servo_id]]
                    self._send(servo_id, identities, baud_rate)
            case _ if frame.servo_id == BROADCAST_ID:
                for servo in listening.servos:
                    servo.obey(frame.instruction, frame.parameters, t_ns, broadcast=True)
            case _:
                self._single(frame, t_ns, baud_rate, listening)

    def _single(self, frame: Frame, t_ns: int, baud_rate: int, listening: Listeners) -> None:
        parameters = frame.parameters
        if frame.instruction == Instruction.WRITE:
            for shadow in _shadows(listening, frame.servo_id):
                shadow.write_as_shadow(number_of(parameters), parameters[2:], t_ns)
        answers: list[ServoReply] = []
        for servo in listening.by_id.get(frame.servo_id, ()):
            speaks = servo.answers(frame.instruction)
            error, data = servo.obey(frame.instruction, parameters, t_ns, broadcast=False)
            if speaks:
                answers.append((servo, error, data))
        self._send(frame.servo_id, answers, baud_rate)

    def _answer_reads(
        self,
        frame: Frame,
        t_ns: int,
        baud_rate: int,
        listening: Listeners,
        motors: MotorReadings,
    ) -> None:
        """Answer a sync or bulk read in its order, up to where the chain of answers breaks.

        All are asked at once: what they measure is what the motors gave when the request came.
        """
        if frame.instruction == Instruction.SYNC_READ:
            at_once = listening.measured_read(frame.parameters)
            frames = (
                None if at_once is None else at_once.answers(self._firmware.servos, motors, t_ns)
            )
            if at_once is not None and frames is not None:
                self._put_in_turn(at_once, frames, baud_rate)
                return
        for servo_id, address, length in reads_of(frame):
            if servo_id not in listening.by_id and self._silent.get(servo_id, False):
                return
            answers: list[ServoReply] = []
            for servo in listening.by_id.get(servo_id, ()):
                if servo.table.values["status_return_level"] >= 1:
                    error, data = servo.read(address, length, t_ns, motors)
                    answers.append((servo, error, data))
            self._send(servo_id, answers, baud_rate)


def _shadows(listening: Listeners, servo_id: int) -> list[VirtualServo]:
    """Return the servos whose secondary id this is; they listen and never answer."""
    if servo_id > LARGEST_ID:
        return []
    return [s for s in listening.shadows if s.shadow_id == servo_id and s.servo_id != servo_id]


def split_frames(data: bytes) -> Iterator[tuple[bytes, int]]:
    """Cut bytes where frames begin: each piece, and how many bytes come behind it."""
    begin = 0
    while begin < len(data):
        end = data.find(HEADER, begin + 1)
        end = end if end > 0 else len(data)
        yield data[begin:end], len(data) - end
        begin = end


def garbled(data: bytes) -> bytes:
    """Return what is received when two devices send at once."""
    return bytes(byte ^ 0xAA for byte in data)


@lru_cache(maxsize=1024)
def wire_ns(count: int, baud_rate: int) -> int:
    """Return how long so many bytes take on the wire [ns]."""
    return round(count * BITS_PER_BYTE * 1e9 / baud_rate)
