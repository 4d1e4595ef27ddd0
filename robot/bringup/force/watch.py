"""``bigant force watch``: reads the stream, shows it, and writes every sample that is asked for."""

import csv
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from drivers.ati.foot_forces import foot_wrenches, sensed_wrenches
from drivers.ati.settings import ForceSensorSettings
from drivers.ati.stream import ForceStream
from drivers.clock import MonotonicClock
from model.values.arrays import FloatArray
from model.values.readings import ForceRecord
from record.whole_file import clear_name, writing
from robot.bringup.force.table import (
    Snapshot,
    leg_lines,
    one_line,
    snapshot_json,
    stream_lines,
)
from robot.config.robot_file import load_robot
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.screen_fit import Screen
from robot.requests.force import ForceWatchRequest
from robot.run.force_unit import running_stream, unit_settings
from robot.run.operator import Interrupts

LOOK_NS = 10_000_000
LINE_NS = 1_000_000_000
SCREEN_NS = 250_000_000
CSV_HEAD = (
    "leg", "host_t_ns", "sample_t_ns", "device_ticks", "sequence", "saturated",
    "fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm",
)  # fmt: skip

WriteRow = Callable[[Sequence[object]], object]


def watch_forces(request: ForceWatchRequest) -> ExitCode:
    """Watch.

    Returns:
        OK, or HARDWARE when the unit was silent at the end.

    Raises:
        BigantError: The unit cannot be reached, or a file cannot be used.
    """
    config = load_robot(request.robot, request.calibration)
    settings = unit_settings(request.force_unit, config.force_sensor)
    clock = MonotonicClock()
    screen = Screen(sys.stdout) if sys.stdout.isatty() else None
    with (
        Interrupts() as interrupts,
        _sample_rows(request.csv) as write_row,
        running_stream(settings, clock) as stream,
    ):
        interrupts.begin()
        next_ns = start_ns = clock.now_ns()
        watch = Watch(stream, settings, write_row, start_ns)
        end_ns = None if request.seconds is None else start_ns + request.seconds * 1e9
        while not interrupts.count and (end_ns is None or clock.now_ns() < end_ns):
            clock.sleep_until_ns(clock.now_ns() + LOOK_NS)
            watch.read()
            if not request.json and clock.now_ns() >= next_ns + (SCREEN_NS if screen else LINE_NS):
                next_ns = clock.now_ns()
                show(watch.snapshot(next_ns), screen)
        last = watch.snapshot(clock.now_ns())
    if request.json:
        print_json(snapshot_json(last))
    elif screen:
        show(last, screen)
        screen.leave()
    else:
        print("\n".join([*leg_lines(last), *stream_lines(last)]))
    silent = (last.age_ns < 0) | (last.age_ns >= settings.silent_limit_s * 1e9)
    return ExitCode.HARDWARE if silent.all() else ExitCode.OK


def show(shot: Snapshot, screen: Screen | None) -> None:
    """Draw a table on a terminal, print a line anywhere else."""
    if screen:
        title = f"force-torque unit   {shot.seconds:.1f} s"
        screen.draw(title, leg_lines(shot), ["", *stream_lines(shot), "Ctrl-C ends"])
    else:
        print(one_line(shot), flush=True)


class Watch:
    """Reads the stream and keeps what is shown.

    Args:
        stream: Running.
        settings: The same settings.
        write_row: Takes each sample as a row; None for nobody.
        start_ns: Now.
    """

    def __init__(
        self,
        stream: ForceStream,
        settings: ForceSensorSettings,
        write_row: WriteRow | None,
        start_ns: int,
    ) -> None:
        self._stream = stream
        self._settings = settings
        self._write_row = write_row
        self._start_ns = self._since_ns = start_ns
        self._since = 0
        self._newest: ForceRecord | None = None

    def read(self) -> None:
        """Take what has arrived; never waits."""
        for record in self._stream.read():
            self._newest = record
            self._since += 1
            if self._write_row is not None:
                self._write(record, self._write_row)
        self._stream.take_faults()

    def _write(self, record: ForceRecord, write_row: WriteRow) -> None:
        sample_t_ns, wrench = self._stream.sample_time_ns(record), self._wrench(record)
        for leg, number in enumerate(self._settings.transducers.tolist()):
            if number and record.present[number - 1]:
                times = (record.t_ns, sample_t_ns, record.device_ticks, record.sequence)
                saturated = int(record.saturated[number - 1])
                write_row([self._settings.names[leg], *times, saturated, *wrench[leg].tolist()])

    def _wrench(self, record: ForceRecord | None) -> FloatArray:
        count = len(self._settings.names)
        if record is None:
            return np.full((count, 6), np.nan)
        sensed = sensed_wrenches(record, self._stream.calibrations, self._settings)
        return foot_wrenches(sensed, self._settings, np.full(count, np.nan))

    def snapshot(self, now_ns: int) -> Snapshot:
        """Return what is to be shown now; the packet rate is that since the last call."""
        span_s = max(now_ns - self._since_ns, 1) * 1e-9
        shot = Snapshot(
            seconds=(now_ns - self._start_ns) * 1e-9,
            names=self._settings.names,
            transducers=self._settings.transducers,
            record=self._newest,
            wrench=self._wrench(self._newest),
            age_ns=self._stream.age_ns(),
            rate_hz=self._since / span_s,
            counters=self._stream.counters,
            clock=self._stream.clock_estimate(),
            repair_error=self._stream.repair_error,
        )
        if span_s > 0.5 or self._since_ns == self._start_ns:
            self._since_ns, self._since = now_ns, 0
        return shot


@contextmanager
def _sample_rows(path: Path | None) -> Iterator[WriteRow | None]:
    """Yield what writes a row of the CSV file; None without one."""
    if path is None:
        yield None
        return
    clear_name(path, "--csv")
    with writing(path, "--csv"):
        file = path.open("w", newline="", encoding="utf-8")
    with file:
        writer = csv.writer(file)
        writer.writerow(CSV_HEAD)
        yield writer.writerow
