"""Logs to poses at rest, for calibrating force sensors."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from drivers.ati.calibration import Calibration
from model.errors import RecordError
from model.fit.cross_talk import SensorPlaces, StillPoses
from record.log.reader import LogContents, read_ticks
from robot.bringup.force.still_poses import find_still_poses, joined, sensor_places
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.run.header import calibrations_of


@dataclass(frozen=True, slots=True, eq=False)
class PoseLogs:
    """What logs of a robot at rest say.

    Attributes:
        poses: Their poses.
        places: Where the sensors are.
        legs: Leg names.
        serials: Serial number of each leg's sensor.
    """

    poses: StillPoses
    places: SensorPlaces
    legs: tuple[str, ...]
    serials: tuple[str, ...]


def read_pose_logs(
    standing: Sequence[Path], hung_up: Sequence[Path], robot_file: Path | None
) -> PoseLogs:
    """Read logs.

    Args:
        standing: Logs of a robot on its feet.
        hung_up: Logs of a robot that hangs free.
        robot_file: Robot file to believe, None for the one in each log.

    Raises:
        RecordError: A log cannot be read, or they are of different sensors.
        ConfigError: A robot file cannot be used.
    """
    parts: list[StillPoses] = []
    config: RobotConfig | None = None
    units: tuple[Calibration | None, ...] = ()
    for path, hung in [*((p, False) for p in standing), *((p, True) for p in hung_up)]:
        contents = LogContents()
        ticks = list(read_ticks(path, contents))
        if not ticks:
            raise RecordError(f"{path} is no log of ours, or it is empty: {contents.damage}")
        here = (
            load_robot(robot_file) if robot_file is not None else parse_robot(contents.config_text)
        )
        legs = here.parameters.legs.names
        try:
            calibrations = calibrations_of(contents.metadata, legs)
        except RecordError as error:
            raise RecordError(f"{path}: {error}") from error
        if calibrations is None:
            raise RecordError(
                f"{path}: the log does not say what its force counts mean (it is older than that): "
                "record anew"
            )
        if config is not None and (legs, _serials(calibrations)) != (
            config.parameters.legs.names, _serials(units),
        ):  # fmt: skip
            raise RecordError(f"{path} is of other legs or sensors than the logs before it")
        config, units = here, calibrations
        parts.append(find_still_poses(ticks, here, calibrations, hung_up=hung))
    assert config is not None  # the command asks for one log or more
    names = config.parameters.legs.names
    return PoseLogs(joined(parts), sensor_places(config), names, _serials(units))


def _serials(units: tuple[Calibration | None, ...]) -> tuple[str, ...]:
    return tuple("" if unit is None else unit.serial for unit in units)
