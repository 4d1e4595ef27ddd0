"""The log of a run, and what it holds besides the ticks so that its controller can be built again.

The robot file is an attachment of every log. Here are the rest of a controller's arguments, as texts
of the log's metadata: calibrations of the force sensors, rate of the loop, whether torque was allowed.
The run in a few words is in ``record.log.header``.
"""

import json
import math
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Protocol

from drivers.ati.calibration import Calibration
from drivers.wire.tap import WireTap
from model.errors import RecordError
from model.values.tick import Tick
from model.values.wire import WireBytes
from record.log.header import RunHeader
from record.log.writer import RATE_KEY, LogWriter
from record.whole_file import whole_file
from robot.config.calibration import CALIBRATION_KEY, calibration_text
from robot.config.robot_file import RobotConfig
from robot.control.controller import Controller
from robot.run.gait_texts import gait_metadata
from robot.run.loop import StateSink, TickSink
from robot.run.operator import Script
from robot.run.rig import Rig

CALIBRATIONS_KEY = "calibrations"
UNITS_KEY = "force_units"  # of older logs: less of each calibration, by leg name
ARMED_KEY = "armed"
LATENCY_KEY = "bus_latency_ms"
FORCE_UNIT_KEY = "force_unit"
UNIT_STATE_KEY = "force_unit_state"
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
            **({UNIT_STATE_KEY: rig.unit_state} if rig.unit_state else {}),
            **(wire_metadata(rig) if with_bytes else {}),
        },
        start_ns=rig.clock.now_ns(),
        start_unix_ns=VIRTUAL_EPOCH_UNIX_NS if header.time == "virtual" else time.time_ns(),
    )


def virtual_header(config: RobotConfig, script: Script, seed: int | None = None) -> RunHeader:
    """Return the header of a run in virtual time.

    Args:
        config: Robot file.
        script: What is done.
        seed: Seed of virtual noise, None to leave it unsaid.
    """
    return RunHeader(
        robot=config.name,
        hardware="virtual",
        time="virtual",
        gait=script.gait,
        frequency_hz=script.frequency_hz,
        steer=script.steer,
        seed=seed,
    )


@contextmanager
def whole_log(
    path: Path, header: RunHeader, rig: Rig, controller: Controller
) -> Iterator[LogWriter]:
    """Open the log of a run, and close it afterwards; it appears when it is whole.

    Args: as for ``open_log``.

    Raises:
        RecordError: It cannot be written.
    """
    with whole_file(path, "--log") as part:
        writer = open_log(part, header, rig, controller)
        try:
            yield writer
        finally:
            writer.close()
        if writer.error is not None:
            raise writer.error


def controller_metadata(
    controller: Controller, calibrations: tuple[Calibration | None, ...]
) -> Mapping[str, str]:
    """Return what a log needs to know of a controller.

    Args:
        controller: The controller of the run.
        calibrations: Calibration of each leg's transducer, as the unit gave them.
    """
    return {
        CALIBRATIONS_KEY: json.dumps([_as_json(c) for c in calibrations], separators=(",", ":")),
        RATE_KEY: str(controller.rate_hz),
        ARMED_KEY: str(controller.armed).lower(),
        CALIBRATION_KEY: calibration_text(controller.config.force_sensor.calibration),
        **gait_metadata(controller.config.parameters),
    }


def wire_metadata(rig: Rig) -> Mapping[str, str]:
    """Return what a log that holds the bytes of both devices needs to know of their wires."""
    with_forces = any(calibration is not None for calibration in rig.calibrations)
    return {LATENCY_KEY: repr(rig.bus.latency_ms), FORCE_UNIT_KEY: str(with_forces).lower()}


def _as_json(calibration: Calibration | None) -> dict[str, object] | None:
    if calibration is None:
        return None
    values = asdict(calibration)
    ratings = calibration.max_rating
    values["max_rating"] = [r if math.isfinite(r) else None for r in ratings]  # JSON has no NaN
    return values


class RunLog(TickSink, StateSink, Protocol):
    """A log that is being written: here, in a thread, or in another process."""

    def write_wires(self, heard: tuple[WireBytes, ...], /) -> None:
        """Take raw bytes of the devices, oldest first."""

    def close(self) -> None:
        """Write what is left and finish the file."""


class TappedLog:
    """A log that takes what the tap received along with every tick.

    Args:
        log: The log.
        tap: The tap.
    """

    def __init__(self, log: RunLog, tap: WireTap) -> None:
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

    def write_state(self, t_ns: int, index: int, encode: Callable[[], bytes]) -> None:
        """Write what the controller remembers."""
        self._log.write_state(t_ns, index, encode)

    def close(self) -> None:
        """Write what was received since the last tick (torque going off) and finish."""
        self._log.write_wires(self._tap.take())
        self._log.close()
