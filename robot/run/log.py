"""The log of a run: opened with everything that is needed to build its controller again."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from drivers.wire.tap import WireTap
from model.errors import RecordError
from model.values.tick import Tick
from record.log.background import BackgroundWriter
from record.log.header import RunHeader
from record.log.writer import LogWriter
from robot.control.controller import Controller
from robot.run.header import controller_metadata, wire_metadata
from robot.run.rig import Rig

# Virtual time has no calendar; its logs are stamped from this date so that two runs are the same.
VIRTUAL_EPOCH_UNIX_NS = 1_767_225_600_000_000_000  # 2026-01-01 00:00:00 UTC


def open_log(
    path: Path, header: RunHeader, rig: Rig, controller: Controller, *, with_bytes: bool = False
) -> LogWriter:
    """Open the log of a run that is about to begin.

    Args:
        path: The log.
        header: The run in a few words.
        rig: The robot, open.
        controller: Its controller.
        with_bytes: Whether the bytes of both devices are going to be in it.

    Raises:
        RecordError: It cannot be written.
    """
    return LogWriter(
        path,
        names=controller.config.parameters.legs.names,
        config_text=controller.config.text,
        metadata={
            **header.metadata(),
            **controller_metadata(controller, rig.calibrations),
            **(wire_metadata(rig) if with_bytes else {}),
        },
        start_ns=rig.clock.now_ns(),
        start_unix_ns=VIRTUAL_EPOCH_UNIX_NS if header.time == "virtual" else time.time_ns(),
    )


@contextmanager
def whole_log(
    path: Path, header: RunHeader, rig: Rig, controller: Controller
) -> Iterator[LogWriter]:
    """Open the log of a run, and close it afterwards.

    Args: as for ``open_log``.

    Raises:
        RecordError: It cannot be written.
    """
    writer = open_log(path, header, rig, controller)
    try:
        yield writer
    finally:
        writer.close()
    if writer.error is not None:
        raise writer.error


class TappedLog:
    """A log that takes what the tap received along with every tick.

    Args:
        log: The log.
        tap: The tap.
    """

    def __init__(self, log: LogWriter | BackgroundWriter, tap: WireTap) -> None:
        self._log = log
        self._tap = tap

    @property
    def error(self) -> RecordError | None:
        """Why the log can no longer be written, None while it can."""
        return self._log.error

    def write(self, tick: Tick) -> None:
        """Write what was received up to here, then the tick."""
        self._log.write_wires(self._tap.take())
        self._log.write(tick)

    def close(self) -> None:
        """Write what was received since the last tick (torque going off) and finish."""
        self._log.write_wires(self._tap.take())
        self._log.close()
