"""The force stream: set the unit up over its console, then read records as they come.

The data path never waits. Losses, repeats and late records are counted by sequence number; a stream
that falls silent is started again, with pauses that grow, while the loop goes on, and a unit that does
not come back from that is set up again beside the loop (``drivers.ati.repair``).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drivers.ati.calibration import Calibration
from drivers.ati.clock import ClockEstimate, DeviceClock
from drivers.ati.console import Console
from drivers.ati.links import DatagramLink, TextLink
from drivers.ati.packets import (
    Led,
    Malformed,
    UnitCommand,
    battery_led,
    build_command,
    parse_datagram,
)
from drivers.ati.repair import Background, Repair, Repaired, in_thread
from drivers.ati.sequence import Arrival, SequenceWatch
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.setup import free_console, set_up
from drivers.ati.unit_state import UnitState, read_unit_state
from drivers.clock import Clock
from model.errors import ForceStreamError
from model.values.arrays import IntArray, readonly
from model.values.faults import Fault, FaultKind
from model.values.readings import ForceRecord

START_TRIES = 10
START_WAIT_S = 0.3
LOOK_S = 0.005
FIRST_RESTART_S = 0.25
LONGEST_RESTART_S = 4.0
# Silent for so long in spite of start packets: the unit needs more than those.
REPAIR_AFTER_S = 1.0
STOPS = 3  # the unit sends for ever if the only stop is lost in the air


@dataclass(slots=True)
class StreamCounters:
    """What happened on the stream.

    Attributes:
        records: Records received.
        missing: Samples lost, by sequence number.
        duplicate: Records received twice.
        late: Records that came behind a newer one; dropped.
        malformed: Datagrams that were none.
        saturated: Samples of single transducers dropped because they were saturated.
        unit_restarts: Times the unit's sequence numbers began again.
        restarts: Times the stream was started again.
        repairs: Times the unit was set up again.
    """

    records: int = 0
    missing: int = 0
    duplicate: int = 0
    late: int = 0
    malformed: int = 0
    saturated: int = 0
    unit_restarts: int = 0
    restarts: int = 0
    repairs: int = 0


class ForceStream:
    """The unit's stream of records.

    Args:
        datagrams: Way of commands and data.
        console: Way of text.
        settings: Transducers, rate and limits.
        clock: Clock of both.
        reopen: Opens the console again for a unit that fell silent; None leaves it at start packets.
        background: Runs that where it holds nobody up.
    """

    def __init__(
        self,
        datagrams: DatagramLink,
        console: TextLink,
        settings: ForceSensorSettings,
        clock: Clock,
        *,
        reopen: Callable[[], TextLink] | None = None,
        background: Background = in_thread,
    ) -> None:
        self.counters = StreamCounters()
        self.calibrations: tuple[Calibration | None, ...] = (None,) * len(settings.names)
        self.unit_state: UnitState | None = None  # as it was at the start
        self._datagrams = datagrams
        self._console = Console(console, clock)
        self._settings = settings
        self._numbers: list[int] = settings.transducers.tolist()  # of each leg's transducer
        self._clock = clock
        self._reopen = reopen
        self._repair = Repair(self._set_up_anew, background) if reopen is not None else None
        self._sequence = SequenceWatch()
        self._device_clock = DeviceClock()
        self._sound_ns = [-1] * len(settings.names)
        self._last_heard_ns = clock.now_ns()
        self._restart_ns = 0
        self._restart_pause_s = FIRST_RESTART_S
        self._faults: list[Fault] = []
        self._ahead: list[ForceRecord] = []

    def connect(self) -> None:
        """Set the unit up and start it.

        Raises:
            ForceStreamError: It does not answer, sends gage counts, or sends nothing.
        """
        self.calibrations = set_up(self._console, self._settings)
        self.unit_state = read_unit_state(self._console)
        for _ in range(START_TRIES):  # a start packet may be lost in the air
            self._datagrams.send(build_command(UnitCommand.START, 0))
            if self._wait_for_record(START_WAIT_S):
                self._restart_pause_s = FIRST_RESTART_S
                return
        raise ForceStreamError(
            f"the force-torque unit at {self._settings.address} takes commands and sends no data: "
            f"switch it off and on (it may be bound to another port than {self._settings.local_port})"
        )

    def _wait_for_record(self, limit_s: float) -> bool:
        deadline_ns = self._clock.now_ns() + round(limit_s * 1e9)
        while self._clock.now_ns() < deadline_ns:
            self._clock.sleep_until_ns(self._clock.now_ns() + round(LOOK_S * 1e9))
            self._ahead += self._receive()
            if self._ahead:
                return True
        return False

    def read(self) -> tuple[ForceRecord, ...]:
        """Return all records since the last call, oldest first; never waits."""
        records = [*self._ahead, *self._receive()]
        self._ahead = []
        self._take_over_repaired()
        if not records:
            self._look_after_silence()
        return tuple(records)

    def _receive(self) -> list[ForceRecord]:
        kept: list[ForceRecord] = []
        for t_ns, data in self._datagrams.receive():
            parsed = parse_datagram(data, t_ns)
            if isinstance(parsed, Malformed):
                self.counters.malformed += 1
                continue
            kept += [record for record in parsed if self._fresh(record)]
        if kept:
            self._last_heard_ns = self._clock.now_ns()
            self._restart_pause_s = FIRST_RESTART_S
            if self._repair is not None:
                self._repair.heard()
            self._report_condition(kept[-1])
        return kept

    def _fresh(self, record: ForceRecord) -> bool:
        """Count what the sequence number says; return whether the record is to be used."""
        counters = self.counters
        counters.records += 1
        arrival, missing = self._sequence.judge(record.sequence)
        if not arrival.fresh:
            counters.duplicate += arrival is Arrival.DUPLICATE
            counters.late += arrival is Arrival.LATE
            return False
        if arrival is Arrival.RESTART:
            counters.unit_restarts += 1
            self._device_clock.restart()
        if missing:
            counters.missing += missing
            detail = f"{missing} samples lost"
            self._faults.append(Fault(FaultKind.FORCE_GAP, "force unit", detail))
        self._device_clock.add(record.device_ticks, record.t_ns)
        self._note_sensors(record)
        return True

    def _note_sensors(self, record: ForceRecord) -> None:
        present, saturated = record.present.tolist(), record.saturated.tolist()
        for leg, number in enumerate(self._numbers):
            if number and present[number - 1]:
                if saturated[number - 1]:
                    self.counters.saturated += 1
                else:
                    self._sound_ns[leg] = record.t_ns

    def _report_condition(self, record: ForceRecord) -> None:
        """Say which transducers are absent or saturated, and whether the battery is low."""
        present, saturated = record.present.tolist(), record.saturated.tolist()
        as_usual = False not in present and True not in saturated
        for leg, number in (
            () if as_usual else zip(self._settings.names, self._numbers, strict=True)
        ):
            if number and not present[number - 1]:
                detail = f"transducer {number} is not in the record: switched off or unplugged"
                self._faults.append(Fault(FaultKind.FORCE_ABSENT, leg, detail))
            elif number and saturated[number - 1]:
                detail = f"transducer {number} is saturated"
                self._faults.append(Fault(FaultKind.FORCE_SATURATED, leg, detail))
        if battery_led(int(record.status[0])) is Led.RED:
            detail = f"its battery light is red (level {record.battery}): charge it"
            self._faults.append(Fault(FaultKind.FORCE_BATTERY, "force unit", detail))

    def _look_after_silence(self) -> None:
        now_ns = self._clock.now_ns()
        silent_s = (now_ns - self._last_heard_ns) * 1e-9
        if silent_s >= self._settings.silent_limit_s:
            detail = f"no record for {silent_s:.2f} s"
            self._faults.append(Fault(FaultKind.FORCE_SILENT, "force unit", detail))
        if self._repair is not None and silent_s >= REPAIR_AFTER_S:
            self._repair.begin(now_ns)
        if silent_s >= self._settings.silent_limit_s / 2 and now_ns >= self._restart_ns:
            self.counters.restarts += 1
            self._datagrams.send(build_command(UnitCommand.START, 0))
            self._restart_ns = now_ns + round(self._restart_pause_s * 1e9)
            self._restart_pause_s = min(2 * self._restart_pause_s, LONGEST_RESTART_S)

    def _set_up_anew(self) -> Repaired:
        """One attempt, in the background: a new console, everything set and read again.

        Raises:
            ForceStreamError: It did not succeed.
        """
        assert self._reopen is not None
        self._console.close()
        free_console(self._datagrams, self._clock)
        console = Console(self._reopen(), self._clock)
        try:
            calibrations = set_up(console, self._settings, self.calibrations)
        except BaseException:
            console.close()
            raise
        return Repaired(console, calibrations)

    def _take_over_repaired(self) -> None:
        repaired = None if self._repair is None else self._repair.take(self._clock.now_ns())
        if repaired is not None:
            self._console = repaired.console
            self.counters.repairs += 1
            self._restart_ns = self._clock.now_ns()
            self._restart_pause_s = FIRST_RESTART_S

    @property
    def repair_error(self) -> str:
        """Why the last attempt to set the unit up again failed; empty if none did."""
        return "" if self._repair is None else self._repair.last_error

    def take_faults(self) -> tuple[Fault, ...]:
        """Return the faults since the last call."""
        faults, self._faults = tuple(self._faults), []
        return faults

    def age_ns(self) -> IntArray:
        """Return the time since each leg's last sample that was not saturated, (N,); -1: never."""
        now_ns = self._clock.now_ns()
        return readonly(np.array([now_ns - t if t >= 0 else -1 for t in self._sound_ns]))

    def clock_estimate(self) -> ClockEstimate | None:
        """Return how the unit's clock stands to ours; None before the first record."""
        return self._device_clock.estimate()

    def sample_time_ns(self, record: ForceRecord) -> int | None:
        """Return the host time at which a recent record was sampled, plus the shortest delay."""
        return self._device_clock.host_ns(record.device_ticks)

    def set_device_bias(self, *, on: bool) -> None:
        """Let the unit itself take the present readings of our transducers as zero, or no longer.

        Raises:
            ForceStreamError: Its console does not answer.
        """
        for number in self._settings.transducers.tolist():
            if number:
                self._console.query(f"BIAS {number} {'ON' if on else 'OFF'}")

    def stop(self) -> None:
        """Tell the unit to stop sending; never fails. It remembers us until it is told."""
        for _ in range(STOPS):
            self._datagrams.send(build_command(UnitCommand.STOP))

    def close(self) -> None:
        """Give back both links."""
        if self._repair is not None:
            self._repair.close()
        self._console.close()
        self._datagrams.close()
