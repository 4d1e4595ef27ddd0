"""Faults of the force-torque unit, put between a sound unit and the host.

Each record goes through what changes its bytes (``sim_hw.faults.records``), then through what stops the
stream, then into datagrams, and those may be lost, doubled or held back. The unit knows nothing of it.
"""

from collections.abc import Sequence

from drivers.ati.packets import UnitCommand, parse_command
from sim_hw.ati.unit import VirtualWnet
from sim_hw.faults.console import FaultyConsole
from sim_hw.faults.kinds import (
    Batching,
    DuplicatePacket,
    PacketLoss,
    PortChangeStall,
    ReorderedPacket,
    SampleRate,
    ScenarioFault,
    SilentStop,
)
from sim_hw.faults.records import RecordFaults
from sim_hw.faults.time import Dice, ScenarioTime
from sim_hw.interfaces import ConsoleEnd

SMALLEST_RECORD = 18
Datagrams = list[tuple[int, bytes]]


class FaultyWnet:
    """``sim_hw.ati.unit.WnetWire`` with a scenario's faults.

    Args:
        unit: The sound unit.
        faults: All faults of the scenario.
        time: The scenario's time.
        seed: The scenario's seed.
    """

    def __init__(
        self, unit: VirtualWnet, faults: Sequence[ScenarioFault], time: ScenarioTime, seed: int
    ) -> None:
        self.unit = unit
        self._faults = faults
        self._time = time
        self._records = RecordFaults(faults, time)
        self._dice = [
            Dice(fault, time, seed, index)
            for index, fault in enumerate(faults)
            if isinstance(fault, PacketLoss | DuplicatePacket | ReorderedPacket)
        ]
        self._batches = [fault for fault in faults if isinstance(fault, Batching)]
        self._crystals = [fault for fault in faults if isinstance(fault, SampleRate)]
        self._stops = [_Stop(f, time) for f in faults if isinstance(f, SilentStop)]
        self._ports = [_PortStall(f, time) for f in faults if isinstance(f, PortChangeStall)]
        self._batch: list[bytes] = []
        self._held: list[bytes] = []
        self._polled_ns = -1

    def wrap_console(self, end: ConsoleEnd) -> ConsoleEnd:
        """Return a console session with the scenario's faults."""
        return FaultyConsole(end, self._faults, self._time)

    def command(self, data: bytes, t_ns: int, host_port: int) -> bool:
        """Take a command sent from a port."""
        self._time.look(t_ns, torque=False)
        parsed = parse_command(data)
        if parsed is not None and parsed.command == UnitCommand.START:
            for stop in self._stops:
                stop.start(t_ns)
            for port in self._ports:
                port.start(t_ns, host_port)
        return self.unit.command(data, t_ns, host_port)

    def next_due_ns(self) -> int | None:
        """When the unit has its next record."""
        return self.unit.next_due_ns()

    def poll(self, t_ns: int) -> Datagrams:
        """Return the datagrams that arrive by a time."""
        self._time.look(t_ns, torque=False)
        taken: Datagrams = []
        # the crystal changes at its own time, however long nobody has looked
        for change_ns in self._time.changes(self._crystals, self._polled_ns, t_ns):
            taken += self.unit.poll(change_ns)
            self._set_crystal(change_ns)
        taken += self.unit.poll(t_ns)
        self._set_crystal(t_ns)
        self._polled_ns = t_ns
        return [
            datagram
            for sent_ns, data in taken
            for packed in self._pack(sent_ns, data)
            for datagram in self._in_the_air(*packed)
        ]

    def _set_crystal(self, t_ns: int) -> None:
        ratio = 1.0
        for fault in self._crystals:
            if self._time.active(fault, t_ns):
                ratio *= 1.0 + fault.percent / 100.0
        self.unit.sampling_ratio = ratio

    def _pack(self, t_ns: int, data: bytes) -> Datagrams:
        """Put a record into a datagram, or keep it until its batch is full."""
        if len(data) < SMALLEST_RECORD:  # an acknowledgement
            return [(t_ns, data)]
        record = self._records.change(t_ns, data)
        stopped = [stop.holds(t_ns) for stop in self._stops]
        stalled = [port.holds(t_ns) for port in self._ports]
        if any(stopped) or any(stalled):
            self._batch.clear()
            return []
        wanted = max((f.records for f in self._batches if self._time.active(f, t_ns)), default=1)
        ready: Datagrams = []
        if self._batch and wanted == 1:  # batching is over: what was kept goes first
            ready.append((t_ns, b"".join(self._batch)))
            self._batch.clear()
        self._batch.append(record)
        if len(self._batch) >= wanted:
            ready.append((t_ns, b"".join(self._batch)))
            self._batch.clear()
        return ready

    def _in_the_air(self, t_ns: int, data: bytes) -> Datagrams:
        """Return what of a datagram arrives now: it, behind it the one that it has overtaken."""
        copies = [data]
        for dice in self._dice:
            overtaking = isinstance(dice.fault, ReorderedPacket)
            # one that overtakes is not itself overtaken, or else nothing would ever arrive
            if not copies or (overtaking and self._held) or not dice.hits(t_ns):
                continue
            if overtaking:
                self._held, copies = copies, []
            else:
                copies = [] if isinstance(dice.fault, PacketLoss) else 2 * copies
        if copies:
            copies += self._held
            self._held = []
        return [(t_ns, copy) for copy in copies]


class _Stop:
    """A stream that has stopped without a word."""

    def __init__(self, fault: SilentStop, time: ScenarioTime) -> None:
        self._fault = fault
        self._time = time
        self._waiting = False

    def start(self, t_ns: int) -> None:
        """A start command came by; it helps only after the fault's end."""
        if not self._time.active(self._fault, t_ns):
            self._waiting = False

    def holds(self, t_ns: int) -> bool:
        """Whether a record of this time is not sent."""
        active = self._time.active(self._fault, t_ns)
        if active:
            self._waiting = self._fault.needs_start
        return active or self._waiting


class _PortStall:
    """A unit that goes silent when it is asked to send to another port."""

    def __init__(self, fault: PortChangeStall, time: ScenarioTime) -> None:
        self._fault = fault
        self._time = time
        self._stored_port = fault.stored_port
        self._stalled = False

    def start(self, t_ns: int, host_port: int) -> None:
        """A start command came from a port."""
        self._stored_port = self._stored_port or host_port
        if self._time.active(self._fault, t_ns) and host_port != self._stored_port:
            self._stalled = True

    def holds(self, t_ns: int) -> bool:
        """Whether a record of this time is not sent; the fault's end is a power cycle."""
        self._stalled = self._stalled and self._time.active(self._fault, t_ns)
        return self._stalled
