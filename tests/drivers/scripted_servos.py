"""Servos for the driver's tests: a table of bytes each, obedient except where a test says otherwise.

Much less than the virtual bus on purpose: what a test needs to go wrong is one line here.
"""

import os
import select
import threading
from collections.abc import Callable
from dataclasses import dataclass, field

from drivers.dynamixel.catalog import MX_106
from drivers.dynamixel.frames import (
    ALERT,
    BROADCAST_ID,
    Frame,
    FrameParser,
    Instruction,
    StatusError,
    build_status,
)
from drivers.dynamixel.port import ClockedPort
from drivers.dynamixel.units import EXTENDED_POSITION_LIMIT
from sim_hw.clock import VirtualClock

RESPONSE_NS = 50_000  # what a servo takes before it answers

# What comes back for a request: delay after the request [ns] and bytes, in order.
Replies = list[tuple[int, bytes]]


@dataclass
class Servo:
    """One servo. ``values`` holds its registers by name."""

    servo_id: int
    values: dict[str, int] = field(default_factory=dict)
    silent: bool = False
    alert: bool = False
    deaf_to: tuple[str, ...] = ()  # registers it says it takes, and does not
    refuses: dict[str, StatusError] = field(default_factory=dict)

    def __post_init__(self) -> None:
        fresh = {name: register.initial or 0 for name, register in MX_106.table.by_name.items()}
        fresh |= {
            "model_number": 321,
            "firmware_version": 44,
            "return_delay_time": 0,
            "operating_mode": 4,
            "present_position": 2048,
            "present_input_voltage": 120,
            "present_temperature": 30,
        }
        self.values = fresh | self.values

    def memory(self, address: int, length: int) -> bytes:
        """Return bytes of the control table, 0 where there is no register."""
        memory = bytearray(1000)
        for name, value in self.values.items():
            register = MX_106.table[name]
            memory[register.address : register.address + register.size] = register.encode(value)
        return bytes(memory[address : address + length])

    def write(self, address: int, data: bytes) -> StatusError:
        """Write one register."""
        register = next(r for r in MX_106.table if r.address == address)
        assert len(data) == register.size, f"partial write of {register.name}"
        value = register.decode(data)
        if register.name in self.refuses:
            return self.refuses[register.name]
        if register.eeprom and self.values["torque_enable"]:
            return StatusError.ACCESS
        tripped, far = self.values["bus_watchdog"] == -1, abs(value) > EXTENDED_POSITION_LIMIT
        if register.name == "goal_position" and (tripped or far):
            return StatusError.DATA_RANGE
        if register.name not in self.deaf_to:
            self.values[register.name] = value
        return StatusError.NONE


class ScriptedServos:
    """Several servos on one wire; ``respond`` answers the bytes of one request."""

    def __init__(self, *servos: Servo, baud_rate: int = 1_000_000) -> None:
        self.servos = {servo.servo_id: servo for servo in servos}
        self.baud_rate = baud_rate
        # Called with every reply before it goes out: a test damages, delays or drops it here.
        self.edit: Callable[[int, Frame, int, bytes], Replies] = lambda _, __, at, data: [
            (at, data)
        ]
        self.requests: list[Frame] = []

    def respond(self, request: bytes) -> Replies:
        """Return what comes back."""
        replies: Replies = []
        at_ns = 0
        for frame in FrameParser().feed(request):
            if not isinstance(frame, Frame):
                continue
            self.requests.append(frame)
            for servo_id, data in self._answers(frame):
                at_ns += RESPONSE_NS + round(len(data) * 10e9 / self.baud_rate)
                replies += self.edit(servo_id, frame, at_ns, data)
        return sorted(replies, key=lambda reply: reply[0])

    def _answers(self, frame: Frame) -> list[tuple[int, bytes]]:
        p = frame.parameters
        alive = {i: s for i, s in self.servos.items() if not s.silent}
        if frame.instruction == Instruction.SYNC_WRITE:
            size = int.from_bytes(p[2:4], "little")
            for start in range(4, len(p), size + 1):
                if p[start] in alive:
                    address = int.from_bytes(p[:2], "little")
                    alive[p[start]].write(address, p[start + 1 : start + 1 + size])
            return []
        if frame.instruction == Instruction.SYNC_READ:
            ids = [i for i in p[4:] if i in alive]
            read = Frame(0, Instruction.READ, p[:4], None)
            return [(i, self._single(alive[i], read)) for i in ids]
        if frame.servo_id == BROADCAST_ID:
            answers = [(i, self._single(alive[i], frame)) for i in sorted(alive)]
            return answers if frame.instruction == Instruction.PING else []
        if frame.servo_id not in alive:
            return []
        servo = alive[frame.servo_id]
        level = servo.values["status_return_level"]
        answer = self._single(servo, frame)
        needed = {Instruction.PING: 0, Instruction.READ: 1}.get(Instruction(frame.instruction), 2)
        return [(servo.servo_id, answer)] if level >= needed else []

    def _single(self, servo: Servo, frame: Frame) -> bytes:
        address, rest = int.from_bytes(frame.parameters[:2], "little"), frame.parameters[2:]
        error, data = StatusError.NONE, b""
        if frame.instruction == Instruction.PING:
            data = servo.memory(0, 2) + servo.memory(6, 1)
        elif frame.instruction == Instruction.READ:
            names = [r.name for r in MX_106.table if r.address == address]
            error = servo.refuses.get(names[0], StatusError.NONE) if names else StatusError.NONE
            data = b"" if error else servo.memory(address, int.from_bytes(rest, "little"))
        elif frame.instruction == Instruction.WRITE:
            error = servo.write(address, rest)
        elif frame.instruction == Instruction.CLEAR:
            servo.values["present_position"] %= 4096
        return build_status(servo.servo_id, error | (ALERT if servo.alert else 0), data)


class ScriptedPort(ClockedPort):
    """A port in memory under virtual time: nobody waits, every run is the same."""

    def __init__(self, respond: Callable[[bytes], Replies], baud_rate: int = 1_000_000) -> None:
        self.virtual = VirtualClock(start_ns=1_000_000_000)
        super().__init__("scripted", baud_rate, self.virtual)
        self.latency_ms = 1.0
        self.sent: list[bytes] = []
        self.respond = respond
        self._line: list[tuple[int, bytes]] = []

    def openPort(self) -> bool:  # noqa: N802
        self.is_open = True
        return True

    def closePort(self) -> None:  # noqa: N802
        self.is_open = False

    def writePort(self, packet: bytes) -> int:  # noqa: N802
        data = bytes(packet)
        self.virtual.advance(round(len(data) * self.tx_time_per_byte * 1e6))
        self.sent.append(data)
        now_ns = self.virtual.now_ns()
        self._line += [(now_ns + delay_ns, reply) for delay_ns, reply in self.respond(data)]
        self._line.sort(key=lambda reply: reply[0])
        return len(data)

    def getBytesAvailable(self) -> int:  # noqa: N802
        return sum(len(data) for at_ns, data in self._line if at_ns <= self.virtual.now_ns())

    def clearPort(self) -> None:  # noqa: N802
        self._line = [reply for reply in self._line if reply[0] > self.virtual.now_ns()]

    def readPort(self, length: int) -> bytes:  # noqa: N802
        over_ns = self.virtual.now_ns() + round(self.remaining_ms() * 1e6) + 1
        self.virtual.sleep_until_ns(min([over_ns, *(at_ns for at_ns, _ in self._line[:1])]))
        if not self.getBytesAvailable():
            return b""
        at_ns, data = self._line.pop(0)
        if len(data) > length:
            self._line.insert(0, (at_ns, data[length:]))
        return data[:length]


class PtyServos:
    """Scripted servos behind a pseudo-terminal, for the serial port and the SDK as they are."""

    def __init__(self, servos: ScriptedServos) -> None:
        self.master, self.slave = os.openpty()
        self.name = os.ttyname(self.slave)
        self._servos = servos
        self._stop_read, self._stop_write = os.pipe()
        self._thread = threading.Thread(target=self._serve, daemon=True)
        self._thread.start()

    def _serve(self) -> None:
        while True:
            ready, _, _ = select.select([self.master, self._stop_read], [], [])
            if self._stop_read in ready:
                return
            for _, data in self._servos.respond(os.read(self.master, 4096)):
                os.write(self.master, data)

    def stop(self) -> None:
        """Stop answering; the wire stays."""
        os.write(self._stop_write, b"x")
        self._thread.join()

    def unplug(self) -> None:
        """Pull the cable."""
        self.stop()
        os.close(self.slave)
        os.close(self.master)
        self.master = self.slave = -1

    def close(self) -> None:
        """Give back what is still open."""
        if self.master >= 0:
            self.unplug()
        os.close(self._stop_read)
        os.close(self._stop_write)
