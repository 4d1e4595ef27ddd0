"""Faults of the servo bus, put between the wire of sound servos and the host.

What happens to single replies is here; what happens to servos, shafts and the cable is in
``sim_hw.faults.mishaps``. The servos know nothing of either.
"""

import heapq
from collections.abc import Sequence
from typing import Protocol

from drivers.dynamixel.frames import build_status
from model.errors import ConnectionLost
from sim_hw.dynamixel.bus import Reply, wire_ns
from sim_hw.faults.kinds import (
    BitFlip,
    ChanceFault,
    DuplicatedReply,
    Echo,
    Fault,
    ForeignReply,
    LateReply,
    LostReply,
    ReplyFault,
    TruncatedReply,
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
        faults: Sequence[Fault],
        time: ScenarioTime,
        seed: int,
    ) -> None:
        self._line = line
        self._mishaps = mishaps
        self._time = time
        self._dice = [
            Dice(fault, time, seed, index)
            for index, fault in enumerate(faults)
            if isinstance(fault, ReplyFault | Echo)
        ]
        self._under_way: list[tuple[int, int, bytes]] = []  # heap: time, order of sending, bytes
        self._sent = 0

    def poll(self, t_ns: int) -> None:
        """Let time pass; faults that start or end on the way do so at their own time."""
        for change_ns in self._mishaps.changes(t_ns):
            self._line.poll(change_ns)
            self._mishaps.apply(change_ns)
        self._line.poll(t_ns)
        self._look(t_ns)

    def _look(self, t_ns: int) -> None:
        self._time.look(t_ns, torque=self._mishaps.any_torque())
        self._mishaps.apply(t_ns)

    def receive(self, data: bytes, t_ns: int, baud_rate: int) -> None:
        """Take bytes from the host.

        Raises:
            ConnectionLost: The cable is out.
        """
        self.poll(t_ns)
        self._need_cable()
        for dice in self._dice:
            if isinstance(dice.fault, Echo) and dice.hits(t_ns):
                self._put(t_ns, data)
        self._line.receive(data, t_ns, baud_rate)
        self._look(t_ns)
        for reply in self._line.due(FOREVER_NS):
            self._pass_on(reply, baud_rate)

    def next_reply_ns(self) -> int | None:
        """When the next bytes arrive."""
        return self._under_way[0][0] if self._under_way else None

    def replies(self, t_ns: int) -> bytes:
        """Return what has arrived by a time.

        Raises:
            ConnectionLost: The cable is out.
        """
        self.poll(t_ns)
        self._need_cable()
        arrived = bytearray()
        while self._under_way and self._under_way[0][0] <= t_ns:
            arrived += heapq.heappop(self._under_way)[2]
        return bytes(arrived)

    def _need_cable(self) -> None:
        if not self._mishaps.plugged:
            self._under_way.clear()
            raise ConnectionLost("the virtual adapter is gone: was the cable pulled?")

    def _put(self, t_ns: int, data: bytes) -> None:
        self._sent += 1
        heapq.heappush(self._under_way, (t_ns, self._sent, data))

    def _pass_on(self, reply: Reply, baud_rate: int) -> None:
        """Let every fault that hits this reply have its way with it, in the scenario's order."""
        pieces = [(reply.t_ns, reply.data)]
        for dice in self._dice:
            fault = dice.fault
            if not isinstance(fault, ReplyFault) or fault.servo not in {None, reply.servo_id}:
                continue
            if dice.hits(reply.t_ns):
                pieces = [
                    p for t_ns, data in pieces for p in _damaged(dice, fault, t_ns, data, baud_rate)
                ]
        for t_ns, data in pieces:
            self._put(t_ns, data)


def _damaged(
    dice: Dice, fault: ChanceFault, t_ns: int, data: bytes, baud_rate: int
) -> list[tuple[int, bytes]]:
    """Return what becomes of a reply: when what arrives."""
    match fault:
        case LostReply():
            return []
        case BitFlip():
            return [(t_ns, _flipped(dice, data, fault.bit))]
        case LateReply():
            return [(t_ns + round(fault.delay_s * 1e9), data)]
        case TruncatedReply():
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
