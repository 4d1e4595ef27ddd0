"""What a log says of the controller that made it, and that controller, built again."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from drivers.ati.calibration import Calibration
from model.errors import ConfigError, RecordError
from record.json_text import parse_json
from record.log.reader import LogContents
from record.log.writer import RATE_KEY
from robot.config.calibration import CALIBRATION_KEY, parse_calibration
from robot.config.robot_file import RobotConfig, parse_robot
from robot.control.controller import Controller
from robot.run.gait_texts import with_gaits_of_log
from robot.run.header import ARMED_KEY, CALIBRATIONS_KEY, UNITS_KEY


def calibrations_of(
    metadata: Mapping[str, str], names: Sequence[str]
) -> tuple[Calibration | None, ...] | None:
    """Return what the counts of a log's force records mean, for each leg; None if it does not say.

    Args:
        metadata: The log's metadata.
        names: Leg names.

    Raises:
        RecordError: It cannot be read.
    """
    key = CALIBRATIONS_KEY if CALIBRATIONS_KEY in metadata else UNITS_KEY
    if not metadata.get(key):
        return None
    try:
        texts = parse_json(metadata[key])
        if key == UNITS_KEY:
            texts = [texts.get(name) for name in names]
        return tuple(None if values is None else _calibration(values) for values in texts)
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise RecordError(
            f"the log's {key} cannot be read ({error}): it is damaged, or newer than this software"
        ) from error


def _calibration(values: Mapping[str, Any]) -> Calibration:
    ratings = values.get("max_rating", (None,) * 6)
    rating = tuple(math.nan if value is None else value for value in ratings)
    return Calibration(**{"mult_on": True, **values, "max_rating": rating})


@dataclass(frozen=True, slots=True)
class RecordedRun:
    """What a log says of the controller that made it.

    Attributes:
        config: Its robot file, with calibration and gaits of the log.
        calibrations: Calibrations of the force sensors, None for each leg without one.
        armed: Whether torque could be asked for.
        rate_hz: Rate of its loop.
        forces_known: Whether the log holds the calibrations; older logs do not.
        notes: What had to be assumed, in words.
    """

    config: RobotConfig
    calibrations: tuple[Calibration | None, ...]
    armed: bool
    rate_hz: int
    forces_known: bool
    notes: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Rebuilt:
    """The controller of a log.

    Attributes:
        controller: The controller, with today's code.
        run: What the log says of it.
    """

    controller: Controller
    run: RecordedRun


def rebuild_controller(
    contents: LogContents,
    config: RobotConfig | None = None,
    gait: str | None = None,
    *,
    estimate: bool = True,
) -> Rebuilt:
    """Build the controller that a log was made with; it loads all that a tick calls.

    Args:
        contents: As for ``recorded_run``, as are the next two.
        config: Another robot file.
        gait: What may be run.
        estimate: Whether it runs the estimator.

    Raises:
        RecordError: As ``recorded_run``.
        ConfigError: As ``recorded_run``.
    """
    run = recorded_run(contents, config, gait)
    controller = Controller(
        run.config, run.calibrations, armed=run.armed, rate_hz=run.rate_hz, estimate=estimate
    )
    return Rebuilt(controller, run)


def recorded_run(
    contents: LogContents, config: RobotConfig | None = None, gait: str | None = None
) -> RecordedRun:
    """Read what a log says of its controller.

    Args:
        contents: Robot file and metadata of the log.
        config: Another robot file to try instead of the log's.
        gait: What may be run of a gait that a Python file gave: see ``with_gaits_of_log``.

    Raises:
        RecordError: The log holds no robot file, its metadata make no sense, or its run had the gait of a
            Python file and ``gait`` does not say what may be run.
        ConfigError: The robot file is none of today's, or the other one has other legs.
    """
    metadata = contents.metadata
    used, gait_notes = with_gaits_of_log(_config(contents, config), metadata, gait)
    notes = list(gait_notes)
    names = used.parameters.legs.names
    recorded = calibrations_of(metadata, names)
    calibrations = (None,) * len(names) if recorded is None else recorded
    if recorded is None:
        notes.append("the log is older than recorded calibrations: forces are not compared")
    rate_hz = used.loop.rate_hz
    if RATE_KEY in metadata:
        rate_hz = _whole(metadata[RATE_KEY])
    else:
        notes.append(f"the log does not say its rate: {rate_hz} Hz taken from the robot file")
    armed = metadata.get(ARMED_KEY, "true") == "true"
    if len(calibrations) != len(names):
        raise ConfigError(
            "--robot", f"has {len(names)} legs, the log {len(calibrations)}; choose another file"
        )
    return RecordedRun(used, calibrations, armed, rate_hz, recorded is not None, tuple(notes))


def _config(contents: LogContents, config: RobotConfig | None) -> RobotConfig:
    """Return the robot file in use, with the sensors' calibration that the log holds."""
    used = config if config is not None else config_of(contents)
    text = contents.metadata.get(CALIBRATION_KEY, "")
    if not text or (config is not None and config.force_sensor.calibration is not None):
        return used
    calibration = parse_calibration(text, used.parameters.legs.names)
    return replace(used, force_sensor=replace(used.force_sensor, calibration=calibration))


def config_of(contents: LogContents) -> RobotConfig:
    """Return the robot file of a log.

    Raises:
        RecordError: The log holds none.
        ConfigError: It is none of today's.
    """
    if not contents.config_text:
        raise RecordError("the log holds no robot file to run it with; give one with --robot")
    try:
        return parse_robot(contents.config_text)
    except ConfigError as error:
        raise ConfigError(f"robot file in the log: {error.key}", error.reason) from error


def _whole(text: str) -> int:
    try:
        rate_hz = int(text)
    except ValueError:
        rate_hz = 0
    if not 1 <= rate_hz <= 1000:
        raise RecordError(f"the log says that its loop ran at {text!r} Hz: it is damaged")
    return rate_hz
