"""Faults of the force-torque unit's console: it stalls, or prints in pieces."""

from collections.abc import Sequence

from sim_hw.faults.kinds import ConsoleStall, ScenarioFault, SplitConsole
from sim_hw.faults.time import ScenarioTime
from sim_hw.interfaces import ConsoleEnd


class FaultyConsole:
    """``sim_hw.interfaces.ConsoleEnd`` with a scenario's faults.

    Args:
        end: The sound session.
        faults: All faults of the scenario.
        time: The scenario's time.
    """

    def __init__(
        self, end: ConsoleEnd, faults: Sequence[ScenarioFault], time: ScenarioTime
    ) -> None:
        self._end = end
        self._time = time
        self._stalls = [fault for fault in faults if isinstance(fault, ConsoleStall)]
        self._splits = [fault for fault in faults if isinstance(fault, SplitConsole)]
        self._waiting = bytearray()
        self._next_piece_ns = 0
        self._looked_ns = 0

    def give(self, data: bytes, t_ns: int) -> None:
        """Send bytes to the unit."""
        self._time.look(t_ns, torque=False)
        self._end.give(data, t_ns)

    def take(self, t_ns: int) -> bytes:
        """Return what has been printed by a time: nothing, a piece, or all of it."""
        self._looked_ns = t_ns
        self._time.look(t_ns, torque=False)
        if any(self._time.active(fault, t_ns) for fault in self._stalls):
            return b""
        self._waiting += self._end.take(t_ns)
        split = next((f for f in self._splits if self._time.active(f, t_ns)), None)
        if not self._waiting or (split is not None and t_ns < self._next_piece_ns):
            return b""
        count = len(self._waiting) if split is None else split.piece_bytes
        piece = bytes(self._waiting[:count])
        del self._waiting[:count]
        if split is not None:
            self._next_piece_ns = t_ns + round(split.gap_s * 1e9)
        return piece

    def next_due_ns(self) -> int | None:
        """When there may be something to take."""
        due_ns = self._next_piece_ns if self._waiting else self._end.next_due_ns()
        if due_ns is None:
            return None
        due_ns = max(due_ns, self._looked_ns)  # printed before a stall, taken after it
        ends_ns = [
            self._time.end_ns(fault) for fault in self._stalls if self._time.active(fault, due_ns)
        ]
        if None in ends_ns:
            return None
        return max([due_ns, *(t for t in ends_ns if t is not None)])
