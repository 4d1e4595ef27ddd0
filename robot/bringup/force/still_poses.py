"""Poses at rest in logs: where no shaft moves, what the sensors read on average, which feet carry.

Which feet carry, and how the body leans, comes from the spring support model: the robot has no sensor for
it. A foot neither clearly on nor clearly off the ground makes the pose unusable.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from drivers.ati.calibration import Calibration
from drivers.ati.foot_forces import sensed_wrenches
from model.errors import RecordError
from model.fit.cross_talk import SensorPlaces, StillPoses
from model.kinematics.legs import LegKinematics, leg_kinematics
from model.support.frames import solve_support_frames
from model.values.arrays import BoolArray, FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.tick import Tick
from record.log.reader import LogContents, read_ticks
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.run.force_unit import require_sensors
from robot.run.rebuilt import calibrations_of

# All shafts within this of where the pose began [rad]; an encoder count is 0.0015.
STILL_RAD = 0.012
SETTLE_S = 0.3
LEAST_SAMPLES = 20
# A foot this far above the ground of the support model is in the air [m].
CLEAR_M = 0.004


@dataclass(frozen=True, slots=True, eq=False)
class _Still:
    """A stretch without motion: mean shaft angles (N,), mean readings (N, 6)."""

    angle_rad: FloatArray
    sensed: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class PoseLogs:
    """What logs of a robot at rest hold.

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
        hung_up: Logs of a robot that hangs free; together with ``standing`` one log at least.
        robot_file: Robot file to use, None for the one in each log.

    Raises:
        RecordError: A log cannot be read, or they are of different sensors.
        ConfigError: A robot file cannot be used, or is of a robot without force sensors.
    """
    logs: list[PoseLogs] = []
    for path, hung in [*((p, False) for p in standing), *((p, True) for p in hung_up)]:
        contents = LogContents()
        ticks = list(read_ticks(path, contents))
        if not ticks:
            raise RecordError(f"{path} cannot be read as a log, or it is empty: {contents.damage}")
        here = (
            load_robot(robot_file) if robot_file is not None else parse_robot(contents.config_text)
        )
        require_sensors(here.force_sensor)
        legs = here.parameters.legs.names
        units = calibrations_of(contents.metadata, legs)
        if units is None:
            raise RecordError(
                f"{path}: the log does not say what its force counts mean (it is older than that): "
                "record again"
            )
        serials = tuple("" if unit is None else unit.serial for unit in units)
        if logs and (legs, serials) != (logs[-1].legs, logs[-1].serials):
            raise RecordError(f"{path} is of other legs or sensors than the logs before it")
        poses = find_still_poses(ticks, here, units, hung_up=hung)
        logs.append(PoseLogs(poses, sensor_places(here), legs, serials))
    return replace(logs[-1], poses=joined([each.poses for each in logs]))


def sensor_places(config: RobotConfig) -> SensorPlaces:
    """Return where the sensors are and what they carry, from the robot file."""
    robot = config.parameters
    return SensorPlaces(
        robot.legs.shaft_position + config.force_sensor.offset_m,
        config.force_sensor.yaw_rad,
        robot.body.mass * STANDARD_GRAVITY,
        config.force_sensor.up,
    )


def find_still_poses(
    ticks: Sequence[Tick],
    config: RobotConfig,
    calibrations: Sequence[Calibration | None],
    *,
    hung_up: bool,
) -> StillPoses:
    """Return the poses at rest of a log.

    Args:
        ticks: The log.
        config: Its robot file.
        calibrations: What its counts mean.
        hung_up: Whether the robot hung free, no foot on the ground.
    """
    stills = [still for part in _stretches(ticks) if (still := _mean(part, config, calibrations))]
    robot = config.parameters
    kinematics = leg_kinematics(robot)
    places = sensor_places(config)
    rows = []
    for still in stills:
        contact = _contact(still.angle_rad, kinematics, config, places, hung_up=hung_up)
        if contact is not None:
            rows.append((still, *contact))
    count = robot.legs.count
    return StillPoses(
        angle_rad=np.array([row[0].angle_rad for row in rows]).reshape(-1, count),
        sensed=np.array([row[0].sensed for row in rows]).reshape(-1, count, 6),
        in_air=np.array([row[1] for row in rows], dtype=bool).reshape(-1, count),
        up_B=np.array([row[2] for row in rows]).reshape(-1, 3),
        standing=np.full(len(rows), not hung_up),
        lever=np.array([row[3] for row in rows]).reshape(-1, count, 3),
    )


def joined(parts: Sequence[StillPoses]) -> StillPoses:
    """Return the poses of several logs as one."""
    return StillPoses(
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("angle_rad", "sensed", "in_air", "up_B", "standing", "lever")
        )
    )


def _stretches(ticks: Sequence[Tick]) -> list[list[Tick]]:
    """Cut a log where a shaft moves or is unknown; the time of settling is left out."""
    parts: list[list[Tick]] = []
    begin: Tick | None = None
    for tick in ticks:
        angle = tick.joints.angle_rad
        if not np.isfinite(angle).all():
            begin = None
            continue
        if begin is None or np.abs(angle - begin.joints.angle_rad).max() > STILL_RAD:
            begin = tick
            parts.append([])
        if tick.t_ns - begin.t_ns >= SETTLE_S * 1e9:
            parts[-1].append(tick)
    return [part for part in parts if part]


def _mean(
    part: list[Tick], config: RobotConfig, calibrations: Sequence[Calibration | None]
) -> _Still | None:
    records = [record for tick in part for record in tick.inputs.forces]
    if len(records) < LEAST_SAMPLES:
        return None
    sensed = np.array([sensed_wrenches(r, calibrations, config.force_sensor) for r in records])
    sound = np.isfinite(sensed).all(axis=2).sum(axis=0) >= LEAST_SAMPLES  # (N,)
    mean = np.full(sensed.shape[1:], np.nan)
    mean[sound] = np.nanmean(sensed[:, sound], axis=0)
    return _Still(np.mean([tick.joints.angle_rad for tick in part], axis=0), mean)


def _contact(
    angle_rad: FloatArray,
    kinematics: LegKinematics,
    config: RobotConfig,
    places: SensorPlaces,
    *,
    hung_up: bool,
) -> tuple[BoolArray, FloatArray, FloatArray] | None:
    """Return feet in the air (N,), up (3,) and levers (N, 3); None where it is not clear."""
    feet = kinematics.feet(angle_rad, np.zeros_like(angle_rad)).position_m.copy()
    count = len(feet)
    if hung_up:
        return np.ones(count, dtype=bool), np.array([0.0, 0.0, 1.0]), np.full((count, 3), np.nan)
    level, stiffness = np.zeros((1, count)), config.parameters.contact.stiffness
    support = solve_support_frames(feet[None], level, stiffness, places.weight_n)
    if not support.valid[0]:
        return None
    slope_x, slope_y, height_m = support.pose[0]
    up = np.array([-slope_x, slope_y, 1.0])
    above = feet @ up + height_m
    if ((above > 0) & (above < CLEAR_M)).any():
        return None
    in_air = above >= CLEAR_M
    feet[:, 2] -= np.minimum(above, 0.0)  # springs give way until the foot is on the ground
    x, y, z = (feet - places.origin_B).T
    c, s = np.cos(places.yaw_rad), np.sin(places.yaw_rad)
    up_or_down = np.ones(count) if places.up is None else places.up
    lever = np.stack([c * x + s * y, up_or_down * (c * y - s * x), up_or_down * z], axis=1)
    return in_air, up / np.linalg.norm(up), np.where(in_air[:, None], np.nan, lever)
