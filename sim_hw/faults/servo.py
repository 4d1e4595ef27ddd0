"""Faults of the servo bus, put between the wire of sound servos and the host.

What happens to single requests and replies is here; what happens to servos, shafts and the cable is in
``sim_hw.faults.mishaps``. The servos know nothing of either.
"""

import heapq
from collections.abc import Sequence
from typing import Protocol

from drivers.dynamixel.frames import HEADER, build_status
from model.errors import ConnectionLost
from sim_hw.dynamixel.bus import Reply, split_frames, wire_ns
from sim_hw.faults.kinds import (
    BitFlip,
    ChanceFault,
    DamagedRequest,
    DuplicatedReply,
    Echo,
    ForeignReply,
    LateReply,
    LateRequest,
    LostReply,
    LostRequest,
    ReplyFault,
    RequestFault,
    ScenarioFault,
    TruncatedReply,
    TruncatedRequest,
)
from sim_hw.faults.mishaps import ServoMishaps
from sim_hw.faults.time import Dice, ScenarioTime
from sim_hw.interfaces import ServoWire

FOREVER_NS = 2**62


class ServoLine(ServoWire, Protocol):
    """A servo wire that hands its replies over one by one."""

    def due(self, t_ns: int) -> list[Reply]:
        """Return all replies complete by a time."""
        ...


class FaultyServoWire:
    """``sim_hw.interfaces.ServoWire`` with a scenario's faults.

    Args:
        line: The sound servos.
        mishaps: What happens to servos, shafts and cable; it knows when.
        faults: All faults of the scenario.
        time: The scenario's time.
        seed: The scenario's seed.
    """

    def __init__(
        self,
        line: ServoLine,
        mishaps: ServoMishaps,
        faults: Sequence[ScenarioFault],
        time: ScenarioTime,
        seed: int,
    ) -> None:
        self._line = line
        self._mishaps = mishaps
        self._time = time
        self._dice = [
            Dice(fault, time, seed, index)
            for index, fault in enumerate(faults)
            if isinstance(fault, RequestFault | ReplyFault | Echo)
        ]
        # heaps: time, order of sending, bytes
        self._late: list[tuple[int, int, bytes]] = []  # to the servos
        self._in_flight: list[tuple[int, int, bytes]] = []  # to the host
        self._sent = 0
        self._baud_rate = 0

    def poll(self, t_ns: int) -> None:
        """Let time pass; faults that start or end on the way do so at their own time."""
        self._pass_time(t_ns, t_ns)

    def _pass_time(self, t_ns: int, due_ns: int) -> None:
        """Let time pass, but take replies only until a time: what comes next may destroy later ones."""
        while self._late and self._late[0][0] <= t_ns:
            late_ns, _, data = heapq.heappop(self._late)
            self._advance(late_ns, min(late_ns - wire_ns(len(data), self._baud_rate), due_ns))
            self._line.receive(data, late_ns, self._baud_rate)
        self._advance(t_ns, due_ns)

    def _advance(self, t_ns: int, due_ns: int) -> None:
        for change_ns in self._mishaps.changes(t_ns):
            self._line.poll(change_ns)
            self._mishaps.apply(change_ns)
        self._line.poll(t_ns)
        self._look(t_ns)
        for reply in self._line.due(due_ns):
            self._pass_on(reply)

    def _look(self, t_ns: int) -> None:
        if not self._time.begun:
            self._time.look(t_ns, torque=self._mishaps.any_torque())
        self._mishaps.apply(t_ns)

    def receive(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        """Take bytes from the host.

        Raises:
            ConnectionLost: The cable is out.
        """
        self._pass_time(t_ns, t_ns - wire_ns(len(data), baud_rate))
        self._need_cable()
        self._baud_rate = baud_rate
        for dice in self._dice:
            if isinstance(dice.fault, Echo) and dice.hits(t_ns):
                self._put(t_ns, data)
        for piece, behind in split_frames(data):
            self._send(piece, t_ns - wire_ns(behind, baud_rate))
        self._look(t_ns)

    def _send(self, data: bytes, t_ns: int) -> None:
        """Let every fault hit this request, in the scenario's order; send what is left of it."""
        pieces, servo_id = [(t_ns, data)], data[4] if data[:4] == HEADER and len(data) > 4 else None
        for dice in self._dice:
            fault = dice.fault
            if isinstance(fault, RequestFault) and fault.servo in {None, servo_id}:
                pieces = self._hit(dice, fault, t_ns, pieces)
        for sent_ns, piece in pieces:
            if sent_ns > t_ns:
                self._sent += 1
                heapq.heappush(self._late, (sent_ns, self._sent, piece))
            else:
                self._line.receive(piece, sent_ns, self._baud_rate)

    def _hit(
        self, dice: Dice, fault: ChanceFault, t_ns: int, pieces: list[tuple[int, bytes]]
    ) -> list[tuple[int, bytes]]:
        """Return the pieces as a fault leaves them, if it hits."""
        if not dice.hits(t_ns):
            return pieces
        return [p for at, data in pieces for p in _damaged(dice, fault, at, data, self._baud_rate)]

    def next_reply_ns(self) -> int | None:
        """When the next bytes arrive, or may."""
        times = [heap[0][0] for heap in (self._late, self._in_flight) if heap]
        reply_ns = self._line.next_reply_ns()
        return min(times if reply_ns is None else [*times, reply_ns], default=None)

    def replies(self, t_ns: int) -> bytes:
        """Return what has arrived by a time.

        Raises:
            ConnectionLost: The cable is out.
        """
        self.poll(t_ns)
        self._need_cable()
        arrived = bytearray()
        while self._in_flight and self._in_flight[0][0] <= t_ns:
            arrived += heapq.heappop(self._in_flight)[2]
        return bytes(arrived)

    def _need_cable(self) -> None:
        if not self._mishaps.plugged:
            self._line.due(FOREVER_NS)
            self._in_flight.clear()
            self._late.clear()
            raise ConnectionLost("the virtual adapter is gone: was the cable pulled?")

    def _put(self, t_ns: int, data: bytes) -> None:
        self._sent += 1
        heapq.heappush(self._in_flight, (t_ns, self._sent, data))

    def _pass_on(self, reply: Reply) -> None:
        """Let every fault hit this reply, in the scenario's order; the host gets what is left."""
        pieces = [(reply.t_ns, reply.data)]
        for dice in self._dice:
            fault = dice.fault
            if isinstance(fault, ReplyFault) and fault.servo in {None, reply.servo_id}:
                pieces = self._hit(dice, fault, reply.t_ns, pieces)
        for t_ns, data in pieces:
            self._put(t_ns, data)


def _damaged(
    dice: Dice, fault: ChanceFault, t_ns: int, data: bytes, baud_rate: int
) -> list[tuple[int, bytes]]:
    """Return what becomes of a request or a reply: when what arrives."""
    match fault:
        case LostRequest() | LostReply():
            return []
        case DamagedRequest() | BitFlip():
            return [(t_ns, _flipped(dice, data, fault.bit))]
        case LateRequest() | LateReply():
            return [(t_ns + round(fault.delay_s * 1e9), data)]
        case TruncatedRequest() | TruncatedReply():
            keep = len(data) // 2 if fault.keep_bytes < 0 else fault.keep_bytes
            return [(t_ns, data[:keep])]
        case DuplicatedReply():
            return [(t_ns, data), (t_ns + wire_ns(len(data), baud_rate), data)]
        case ForeignReply():
            other = build_status(fault.foreign_id, 0, bytes(max(0, len(data) - 11)))
            return [(t_ns, other), (t_ns + wire_ns(len(other), baud_rate), data)]
        case _:
            return [(t_ns, data)]


def _flipped(dice: Dice, data: bytes, bit: int) -> bytes:
    count = 8 * len(data)
    if not count:
        return data
    at = int(dice.random.integers(count)) if bit < 0 else bit % count
    changed = bytearray(data)
    changed[at // 8] ^= 1 << at % 8
    return bytes(changed)
