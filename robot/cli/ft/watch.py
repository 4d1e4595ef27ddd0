"""``bigant ft watch``: what the force-torque unit sends, live.

Per transducer forces and moments, state and age; for the stream its rate, losses and the unit's clock
against the host's. The robot file's bias or a calibration is taken off. Ctrl-C ends it; the unit is told
to stop on every way out.
"""

import argparse
import csv
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from model.errors import ConfigError
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from drivers.ati.stream import ForceStream
    from drivers.settings import ForceSensorSettings
    from model.values.arrays import FloatArray
    from model.values.readings import ForceRecord
    from robot.bringup.force.table import Snapshot

LOOK_NS = 10_000_000
LINE_NS = 1_000_000_000
SCREEN_NS = 250_000_000
HOME, CLEAR, END_LINE, CLEAR_BELOW = "\x1b[H", "\x1b[2J\x1b[H", "\x1b[K", "\x1b[J"
CSV_HEAD = (
    "leg", "host_t_ns", "sample_t_ns", "device_ticks", "sequence", "saturated",
    "fx_n", "fy_n", "fz_n", "tx_nm", "ty_nm", "tz_nm",
)  # fmt: skip


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("--robot", type=Path, metavar="FILE", help="robot file")
    parser.add_argument("--force-unit", metavar="HOST[:UDP:CONSOLE]", help="(default: robot file)")
    parser.add_argument("--seconds", type=float, metavar="S", help="end by itself after so long")
    parser.add_argument("--calibration", type=Path, metavar="FILE", help="calibration file to use")
    parser.add_argument("--csv", type=Path, metavar="FILE", help="write every sample")
    parser.add_argument("--json", action="store_true", help="only what was read last, as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Watch.

    Returns:
        OK, or HARDWARE when the unit was silent at the end.

    Raises:
        BigantError: The unit cannot be reached, or a file cannot be used.
    """
    from drivers.clock import MonotonicClock
    from robot.config.robot_file import DEFAULT_ROBOT_FILE, load_robot
    from robot.run.force_unit import running_stream, unit_settings
    from robot.run.operator import Interrupts

    if options.seconds is not None and not 0 < options.seconds < float("inf"):
        raise ConfigError("--seconds", f"must be a positive number, not {options.seconds:g}")
    config = load_robot(options.robot or DEFAULT_ROBOT_FILE, options.calibration)
    settings = unit_settings(options.force_unit, config.force_sensor)
    clock = MonotonicClock()
    screen = sys.stdout.isatty()
    with (
        Interrupts() as interrupts,
        _Table(options.csv) as table,
        running_stream(settings, clock) as stream,
    ):
        watch = Watch(stream, settings, table, clock.now_ns())
        end_ns = None if options.seconds is None else clock.now_ns() + options.seconds * 1e9
        next_ns = clock.now_ns()
        while not interrupts.count and (end_ns is None or clock.now_ns() < end_ns):
            clock.sleep_until_ns(clock.now_ns() + LOOK_NS)
            watch.read()
            if not options.json and clock.now_ns() >= next_ns + (SCREEN_NS if screen else LINE_NS):
                next_ns = clock.now_ns()
                show(watch.snapshot(next_ns), screen=screen)
        last = watch.snapshot(clock.now_ns())
    if options.json:
        from robot.bringup.force.table import snapshot_json

        print(json.dumps(snapshot_json(last), indent=2))
    else:
        show(last, screen=screen, whole=True)
    heard = (last.age_ns >= 0) & (last.age_ns < settings.silent_limit_s * 1e9)
    return ExitCode.OK if heard.any() else ExitCode.HARDWARE


def show(shot: "Snapshot", *, screen: bool, whole: bool = False) -> None:
    """Draw a table on a terminal, print a line (or the whole table, once) anywhere else."""
    from robot.bringup.force.table import one_line, table_lines

    if screen:
        body = [f"force-torque unit   {shot.seconds:.1f} s   Ctrl-C ends", *table_lines(shot)]
        print(HOME + "".join(line + END_LINE + "\n" for line in body) + CLEAR_BELOW, end="")
    elif whole:
        print("\n".join(table_lines(shot)))
    else:
        print(one_line(shot), flush=True)


class Watch:
    """Reads the stream and keeps what is shown.

    Args:
        stream: Running.
        settings: The same settings.
        table: Where samples go.
        start_ns: Now.
    """

    def __init__(
        self, stream: "ForceStream", settings: "ForceSensorSettings", table: "_Table", start_ns: int
    ) -> None:
        self._stream = stream
        self._settings = settings
        self._table = table
        self._start_ns = self._since_ns = start_ns
        self._since = 0
        self._newest: ForceRecord | None = None

    def read(self) -> None:
        """Take what has arrived; never waits."""
        for record in self._stream.read():
            self._newest = record
            self._since += 1
            if self._table.wanted:
                self._table.write(
                    self._settings,
                    record,
                    self._stream.sample_time_ns(record),
                    self._wrench(record),
                )
        self._stream.take_faults()

    def _wrench(self, record: "ForceRecord | None") -> "FloatArray":
        import numpy as np

        from drivers.ati.foot_forces import foot_wrenches, sensed_wrenches

        count = len(self._settings.names)
        if record is None:
            return np.full((count, 6), np.nan)
        sensed = sensed_wrenches(record, self._stream.calibrations, self._settings)
        return foot_wrenches(sensed, self._settings, np.full(count, np.nan))

    def snapshot(self, now_ns: int) -> "Snapshot":
        """Return what is to be shown now; the packet rate is that since the last call."""
        from robot.bringup.force.table import Snapshot

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


class _Table:
    """Every sample as a row of a CSV file, or nothing."""

    def __init__(self, path: Path | None) -> None:
        self.wanted = path is not None
        self._path = path
        self._file: Any = None

    def __enter__(self) -> "_Table":
        if self._path is not None:
            try:
                self._file = self._path.open("w", newline="", encoding="utf-8")
            except OSError as error:
                raise ConfigError("--csv", f"{self._path}: {error.strerror}") from error
            self._rows = csv.writer(self._file)
            self._rows.writerow(CSV_HEAD)
        return self

    def write(
        self,
        settings: "ForceSensorSettings",
        record: "ForceRecord",
        sample_t_ns: int | None,
        wrench: "FloatArray",
    ) -> None:
        for leg, number in enumerate(settings.transducers.tolist()):
            if number and record.present[number - 1]:
                saturated = int(record.saturated[number - 1])
                times = (record.t_ns, sample_t_ns, record.device_ticks, record.sequence)
                self._rows.writerow([settings.names[leg], *times, saturated, *wrench[leg].tolist()])

    def __exit__(self, *_: object) -> None:
        if self._file is not None:
            self._file.close()
