"""Measured joints of a log, or any feet, as a system that the model can be run on."""

import numpy as np

from model.errors import ConfigError, ModelError
from model.kinematics.legs import leg_kinematics
from model.systems.system import System
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.legs import FootMotion
from record.log.recording import Recording
from robot.config.robot_file import RobotConfig
from robot.control.effects import model_of
from robot.odometry.compare import walking_part


def system_of_feet(feet: FootMotion, config: RobotConfig, time_s: FloatArray) -> System:
    """Return feet in the body frame, (F, N, 3), as a system with a robot's weight, springs and friction.

    Args:
        feet: Unloaded feet.
        config: The robot.
        time_s: Evenly spaced times, (F,).

    Raises:
        ModelError: Shapes do not fit, or the times are not evenly spaced.
    """
    robot = config.parameters
    return System(
        name="feet",
        description=f"{config.name}, {len(time_s)} frames of its feet",
        time_s=time_s,
        feet=feet,
        contact=robot.contact,
        weight_n=robot.body.mass * STANDARD_GRAVITY,
    )


def system_of_log(log: Recording, config: RobotConfig) -> System:
    """Return the walking part of a log as a system: measured joints on an even grid of their median period.

    Between ticks angles and speeds are interpolated; where a joint was not read for a while, so are they.

    Raises:
        RecordError: There is no walking.
        ModelError: A joint was never read.
        ConfigError: The robot file has effects on the model, which a system cannot have.
    """
    if model_of(config) is not None:
        raise ConfigError(
            "effects",
            "of the robot file are not in the bare model; the log's predicted_velocity_B has them",
        )
    span = walking_part(log)
    t_s = log.t_s[span]
    grid = t_s[0] + np.arange(0.0, t_s[-1] - t_s[0], float(np.median(np.diff(t_s))))
    angle, rate = (_even(values[span], t_s, grid) for values in (log.angle_rad, log.rate_rad_s))
    feet = leg_kinematics(config.parameters).feet(angle, rate)
    return system_of_feet(feet, config, grid)


def _even(values: FloatArray, t_s: FloatArray, grid: FloatArray) -> FloatArray:
    """Columns at other times, (F, J)."""
    known = np.isfinite(values)
    if not known.any(axis=0).all():
        raise ModelError("a joint was never read: its foot is nowhere")
    columns = [
        np.interp(grid, t_s[fine], column[fine])
        for column, fine in zip(values.T, known.T, strict=True)
    ]
    return np.stack(columns, axis=1)
