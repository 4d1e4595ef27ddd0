"""Foot forces as the robot file has them: without what its effects say that the sensors add.

A log keeps what the sensors said. Whoever compares that with the model takes the file's gain, bias, drift
and rotation out first, as the controller and the odometry do.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from model.errors import BigantError
from model.values.arrays import FloatArray
from model.values.legs import FootForces
from model.values.tick import Tick

if TYPE_CHECKING:
    from record.log.reader import LogContents, StampedTick
    from robot.config.robot_file import RobotConfig

OF_FORCES = frozenset({"force_gain", "force_bias", "force_drift", "force_rotation"})
# forces, (..., N, 3) [N], at times since the run began, (...,) [s], to forces without the sensors' errors
TrueForces = Callable[[FloatArray, "FloatArray | float"], FloatArray]


def true_forces_of(config: "RobotConfig") -> TrueForces | None:
    """Return what takes a robot file's sensor errors out; None for a file that has none."""
    if not any(cause.effect in OF_FORCES for cause in config.effects):
        return None
    from gap.machines.legged.frame import FrameModel
    from robot.control.file_model import machine_of

    return FrameModel(machine_of(config)).without_sensor_errors


def true_forces_of_log(config_text: str) -> TrueForces | None:
    """Return what takes the sensor errors of a log's robot file out; None if it has none."""
    from robot.config.robot_file import parse_robot

    try:
        return true_forces_of(parse_robot(config_text))
    except BigantError:
        return None  # a log of another robot's software: what it measured is shown as it is


def with_true_forces(tick: Tick, true_forces: TrueForces | None, start_ns: int) -> Tick:
    """Return a tick whose forces are without the sensors' errors."""
    if true_forces is None:
        return tick
    force_n = true_forces(tick.forces.force_n, (tick.t_ns - start_ns) * 1e-9)
    return replace(tick, forces=FootForces(tick.forces.t_ns, force_n, tick.forces.valid))


def ticks_with_true_forces(
    ticks: "Iterator[StampedTick]", contents: "LogContents"
) -> "Iterator[StampedTick]":
    """Yield the ticks of a log with forces as its robot file has them."""
    first = next(ticks, None)  # the robot file comes before the first tick
    if first is None:
        return
    true_forces = true_forces_of_log(contents.config_text)
    start_ns = contents.start_ns(first.tick.t_ns)
    yield replace(first, tick=with_true_forces(first.tick, true_forces, start_ns))
    for item in ticks:
        yield replace(item, tick=with_true_forces(item.tick, true_forces, start_ns))
