"""A robot file reviewed: its gaits walked through the model, and all that is wrong with it in words."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gaits.catalog import make_gait, make_gaits
from gaits.gait import Gait
from model.errors import ConfigError
from model.kinematics.legs import leg_kinematics
from model.values.arrays import FloatArray
from robot.config.robot_file import RobotConfig
from robot.console.program_output import complain
from robot.design.body_concerns import (
    body_concerns,
    contact_concerns,
    sensor_concerns,
    size_concerns,
)
from robot.design.concern import Concern, Severity
from robot.design.gait_concerns import gait_concerns
from robot.design.gait_figures import WalkedGait, walk_gait
from robot.design.leg_places import place_concerns, sign_concerns
from robot.design.servo_concerns import servo_concerns
from robot.design.standing import StandingStill

TURN_SAMPLES = 90
MEANINGLESS = frozenset({"units", "too stiff"})
ORDER = (Severity.IMPOSSIBLE, Severity.WARNING, Severity.NOTE)


@dataclass(frozen=True, slots=True, eq=False)
class RobotReview:
    """What a robot file makes.

    Attributes:
        config: The robot file.
        path_m: Foot of each leg over a whole turn of its shaft, relative to the shaft, (T, N, 3) [m].
        gaits: Each gait walked.
        concerns: What is wrong, the worst first.
    """

    config: RobotConfig
    path_m: FloatArray
    gaits: tuple[WalkedGait, ...]
    concerns: tuple[Concern, ...]

    @property
    def warnings(self) -> tuple[Concern, ...]:
        """Without the notes."""
        return tuple(one for one in self.concerns if one.severity is not Severity.NOTE)


def review_robot(
    config: RobotConfig, gaits: Sequence[Gait] | None = None, frequency_hz: float | None = None
) -> RobotReview:
    """Walk the gaits of a robot file through the model and judge the file.

    Args:
        config: The robot file.
        gaits: Gaits to walk; if None all that are in the file, or standing where it has none.
        frequency_hz: Cycles a second; each gait's own if None.
    """
    robot = config.parameters
    chosen = make_gaits(robot) if gaits is None else gaits
    if not robot.gaits and gaits is None:
        joints = leg_kinematics(robot).joint_count
        chosen = [StandingStill(joints, robot.legs.count)]
    walked = tuple(walk_gait(robot, gait, frequency_hz) for gait in chosen)
    path = foot_path(config)
    concerns = [*_file_concerns(config, path)]
    # sizes in another unit make a walk of them meaningless
    for one in () if any(concern.topic in MEANINGLESS for concern in concerns) else walked:
        concerns += gait_concerns(one.figures, robot.servo, config.body_limits.max_tilt)
    concerns.sort(key=lambda concern: ORDER.index(concern.severity))
    return RobotReview(config, path, walked, tuple(concerns))


def review_for_run(
    config: RobotConfig, gait: str | None = None, frequency_hz: float | None = None
) -> RobotReview:
    """Judge a robot file for a run of one gait, or of any where none is named.

    Raises:
        ConfigError: There is no such gait.
    """
    if gait is None:
        return review_robot(config)
    return review_robot(config, [make_gait(gait, config.parameters)], frequency_hz)


def foot_path(config: RobotConfig) -> FloatArray:
    """Return each foot over a whole turn of its shaft, relative to the shaft, (T, N, 3) [m].

    Of legs of several joints: where the foot is with all joints at zero, T = 1.
    """
    robot = config.parameters
    legs = leg_kinematics(robot)
    turns = robot.names.one_joint_a_leg
    turn = np.linspace(0.0, 2 * np.pi, TURN_SAMPLES + 1) if turns else np.zeros(1)
    angle = np.repeat(turn[:, None], legs.joint_count, axis=1)
    feet = legs.feet(angle, np.zeros_like(angle)).position_m
    path: FloatArray = feet - robot.legs.shaft_position
    return path


def _file_concerns(config: RobotConfig, path_m: FloatArray) -> Iterator[Concern]:
    robot = config.parameters
    names, shafts = robot.legs.names, robot.legs.shaft_position
    leg_m = float(np.sqrt((path_m**2).sum(-1)).max())
    extent_m = float(np.sqrt(((shafts + path_m) ** 2).sum(-1)).max())
    sizes = list(size_concerns(shafts, leg_m))
    yield from sizes
    if not sizes:
        yield from body_concerns(robot.body, extent_m)
    yield from contact_concerns(robot.contact, robot.body, names, leg_m)
    yield from place_concerns(names, shafts)
    if not config.driven:
        return  # the file says nothing of servos and sensors
    yield from sign_concerns(names, shafts, config.servo_bus.signs)
    sensors = config.force_sensor
    offset = np.where(sensors.transducers[:, None] > 0, sensors.offset_m, 0.0)
    yield from sensor_concerns(offset, names, leg_m)
    yield from servo_concerns(robot.servo, names)


def warning_lines(review: RobotReview) -> list[str]:
    """Return each warning in one line; notes are left out."""
    return [f"warning: {one.line}" for one in review.warnings]


def print_warnings(review: RobotReview) -> None:
    """Print each warning beside the output, as all do that let the robot move."""
    for line in warning_lines(review):
        complain(line)


def log_warnings(review: RobotReview) -> str:
    """Return the warnings as the header of a log keeps them, one a line."""
    return "\n".join(one.line for one in review.warnings)


def refuse_impossible(review: RobotReview) -> None:
    """Refuse a robot that cannot be or cannot stand.

    Raises:
        ConfigError: There is such a concern; names the place.
    """
    for one in review.concerns:
        if one.severity is Severity.IMPOSSIBLE:
            raise ConfigError(one.place, f"{one.reason}; {one.advice}")
