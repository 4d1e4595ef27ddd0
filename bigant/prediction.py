"""Model and gaits in a notebook: body velocity and foot forces of moving feet, joint angles of a gait."""

from dataclasses import dataclass

import numpy as np

from bigant.logs import Log
from gaits.catalog import make_gait
from model.quasistatic.frames import FrictionLaw
from model.systems.predict import SystemPrediction
from model.systems.predict import predict as predict_system
from model.systems.system import RATE_HZ, System
from model.values.arrays import BoolArray, FloatArray
from model.values.legs import FootMotion
from robot.config.gait_file import with_gait
from robot.config.robot_file import RobotConfig, load_robot
from robot.odometry.measured_feet import system_of_feet, system_of_log
from robot.study.systems import bigant as system_of_gait


def predict(
    motion: System | Log | FootMotion | str | None = None,
    robot: RobotConfig | None = None,
    *,
    law: str = "coulomb",
    cycles: float = 3.0,
    rate_hz: float = RATE_HZ,
) -> SystemPrediction:
    """Run the model of slipping alone: no servos, no simulator, no estimator.

    Args:
        motion: How the feet move in the body frame: a gait as for ``walk``; a log, for its measured joints;
            feet, (F, N, 3) at ``rate_hz``; or a named system (``robot.study.systems``).
        robot: The robot; the log's own, or the nominal BigANT, if None. A system has its own.
        law: ``coulomb``, or ``viscous`` for the paper's ansatz.
        cycles: Length of a gait's motion.
        rate_hz: Frames a second of feet.

    Returns:
        Body velocity ``velocity_B`` (F, 3), path ``poses`` (F + 1, 3), and in ``solutions`` the loads
        ``load_n`` (F, N) and horizontal forces ``force_xy_B`` (F, N, 2) on the feet, their slip, and which
        frames have an answer.

    Raises:
        ConfigError: There is no such gait, or the robot file has effects on the model.
        ModelError: The motion cannot be solved (shapes, a joint that was never read).
        RecordError: Nobody walks in the log.
    """
    return predict_system(_system(motion, robot, cycles, rate_hz), law=FrictionLaw(law))


def _system(
    motion: System | Log | FootMotion | str | None,
    robot: RobotConfig | None,
    cycles: float,
    rate_hz: float,
) -> System:
    if isinstance(motion, System):
        return motion
    if isinstance(motion, Log):
        return system_of_log(motion, robot if robot is not None else motion.robot)
    config = robot if robot is not None else load_robot()
    if motion is None or isinstance(motion, str):
        config, gait = with_gait(config, motion)
        return system_of_gait(config.parameters, config.name, gait, cycles)
    return system_of_feet(motion, config, np.arange(len(motion.position_m)) / rate_hz)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class GaitSamples:
    """A gait at F phases, N legs.

    Attributes:
        gait: Its name.
        legs: Names of the legs.
        frequency_hz: Cycles a second.
        phase: (F,) [cycles].
        angle_rad: Shaft angles, unwrapped, (F, N).
        rate_rad_s: Their speeds, (F, N).
        stance: Whether the leg is scheduled to be on the ground, (F, N).
    """

    gait: str
    legs: tuple[str, ...]
    frequency_hz: float
    phase: FloatArray
    angle_rad: FloatArray
    rate_rad_s: FloatArray
    stance: BoolArray

    def __repr__(self) -> str:
        """Return a line about it."""
        duty = ", ".join(f"{share:.2f}" for share in self.stance.mean(axis=0))
        return (
            f"GaitSamples of {self.gait} at {self.frequency_hz:g} Hz: {len(self.phase)} phases, "
            f"share in stance {duty}"
        )


def sample_gait(
    gait: str | None = None,
    robot: RobotConfig | None = None,
    *,
    phase: FloatArray | None = None,
    steer: float = 0.0,
) -> GaitSamples:
    """Return what a gait asks of every leg over a cycle, or at given phases.

    Args:
        gait: As for ``walk``.
        robot: The robot; the nominal BigANT if None.
        phase: Phases, (F,) [cycles]; 361 over one cycle if None.
        steer: -1 (right) to 1 (left).

    Raises:
        ConfigError: There is no such gait.
    """
    config, name = with_gait(robot if robot is not None else load_robot(), gait)
    parameters = config.parameters
    made = make_gait(name, parameters)
    at = np.linspace(0.0, 1.0, 361) if phase is None else np.asarray(phase, dtype=np.float64)
    motion = made.motion(at, steer)
    return GaitSamples(
        gait=name,
        legs=parameters.legs.names,
        frequency_hz=made.frequency_hz,
        phase=at,
        angle_rad=motion.angle_rad,
        rate_rad_s=motion.slope * made.frequency_hz,
        stance=made.stance(at),
    )
