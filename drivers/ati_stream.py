"""The force stream: set the unit up over its console, then read records as they come.

The data path never waits. Losses, repeats and late records are counted by sequence number; a stream
that falls silent is started again, with pauses that grow, while the loop goes on.
"""

from dataclasses import dataclass

from drivers.ati_calibration import Calibration, parse_cal
from drivers.ati_console import Console
from drivers.ati_links import DatagramLink, TextLink
from drivers.ati_packets import Arrival, Command, Malformed, build_command, classify, parse_datagram
from drivers.clock import Clock
from drivers.settings import ForceSensorSettings
from model.errors import ForceStreamError
from model.signals import Fault, FaultKind, ForceRecord

RESETS = 3
RESET_PAUSE_S = 0.2
START_TRIES = 10
START_WAIT_S = 0.3
LOOK_S = 0.005
FIRST_RESTART_S = 0.25
LONGEST_RESTART_S = 4.0


@dataclass(slots=True)
class StreamCounters:
    """What happened on the stream.

    Attributes:
        records: Records received.
        missing: Samples lost, by sequence number.
        duplicate: Records received twice.
        late: Records that came behind a newer one; dropped.
        malformed: Datagrams that were none.
        restarts: Times the stream was started again.
    """

    records: int = 0
    missing: int = 0
    duplicate: int = 0
    late: int = 0
    malformed: int = 0
    restarts: int = 0


def free_console(datagrams: DatagramLink, clock: Clock) -> None:
    """Free a console that a dead program still holds; three times, as radio loses packets."""
    for _ in range(RESETS):
        datagrams.send(build_command(Command.RESET_CONSOLE))
        clock.sleep_until_ns(clock.now_ns() + round(RESET_PAUSE_S * 1e9))


class ForceStream:
    """The unit's stream of records.

    Args:
        datagrams: Way of commands and data.
        console: Way of text.
        settings: Transducers, rate and limits.
        clock: Clock of both.
    """

    def __init__(
        self,
        datagrams: DatagramLink,
        console: TextLink,
        settings: ForceSensorSettings,
        clock: Clock,
    ) -> None:
        self.counters = StreamCounters()
        self.calibrations: tuple[Calibration | None, ...] = (None,) * len(settings.names)
        self._datagrams = datagrams
        self._console = Console(console, clock)
        self._settings = settings
        self._clock = clock
        self._last_sequence: int | None = None
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
        self._configure()
        for _ in range(START_TRIES):  # a start packet may be lost in the air
            self._datagrams.send(build_command(Command.START, 0))
            if self._wait_for_record(START_WAIT_S):
                self._restart_pause_s = FIRST_RESTART_S
                return
        raise ForceStreamError(
            f"the force-torque unit at {self._settings.address} takes commands and sends no data: "
            f"switch it off and on (it may be bound to another port than {self._settings.local_port})"
        )

    def _configure(self) -> None:
        settings = self._settings
        self._console.query(f"RATE {settings.rate_hz} {settings.oversampling}")
        self._console.query("T OFF")
        found: list[Calibration | None] = []
        for leg, number in zip(settings.names, settings.transducers, strict=True):
            if number == 0:
                found.append(None)
                continue
            self._console.query(f"TRANS {number}")
            calibration = parse_cal(self._console.query("CAL"), int(number))
            if not calibration.mult_on:
                raise ForceStreamError(
                    f"transducer {number} ({leg}) sends raw gage counts: switch its matrix on with "
                    f"TRANS {number} and CAL MULT ON, then SAVEALL, on the unit's console"
                )
            found.append(calibration)
        self.calibrations = tuple(found)
        self._console.query("T ON")

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
            kept += [record for record in parsed if self._in_order(record)]
        if kept:
            self._last_heard_ns = self._clock.now_ns()
            self._restart_pause_s = FIRST_RESTART_S
            self._report_saturation(kept[-1])
        return kept

    def _in_order(self, record: ForceRecord) -> bool:
        """Count what the sequence number says; return whether the record is to be used."""
        self.counters.records += 1
        last = self._last_sequence
        arrival, missing = (Arrival.RESTART, 0) if last is None else classify(record.sequence, last)
        if arrival is Arrival.DUPLICATE:
            self.counters.duplicate += 1
            return False
        if arrival is Arrival.LATE:
            self.counters.late += 1
            return False
        if missing:
            self.counters.missing += missing
            self._faults.append(Fault(FaultKind.FORCE_GAP, "force unit", f"{missing} samples lost"))
        self._last_sequence = record.sequence
        return True

    def _report_saturation(self, record: ForceRecord) -> None:
        for leg, number in zip(self._settings.names, self._settings.transducers, strict=True):
            if number and record.saturated[number - 1]:
                detail = f"transducer {number} is saturated"
                self._faults.append(Fault(FaultKind.FORCE_SATURATED, leg, detail))

    def _look_after_silence(self) -> None:
        now_ns = self._clock.now_ns()
        silent_s = (now_ns - self._last_heard_ns) * 1e-9
        if silent_s >= self._settings.silent_limit_s:
            detail = f"no record for {silent_s:.2f} s"
            self._faults.append(Fault(FaultKind.FORCE_SILENT, "force unit", detail))
        if silent_s >= self._settings.silent_limit_s / 2 and now_ns >= self._restart_ns:
            self.counters.restarts += 1
            self._datagrams.send(build_command(Command.START, 0))
            self._restart_ns = now_ns + round(self._restart_pause_s * 1e9)
            self._restart_pause_s = min(2 * self._restart_pause_s, LONGEST_RESTART_S)

    def take_faults(self) -> tuple[Fault, ...]:
        """Return the faults since the last call."""
        faults, self._faults = tuple(self._faults), []
        return faults

    def stop(self) -> None:
        """Tell the unit to stop sending; never fails. It remembers us until it is told."""
        self._datagrams.send(build_command(Command.STOP))

    def close(self) -> None:
        """Give back both links."""
        self._console.close()
        self._datagrams.close()
