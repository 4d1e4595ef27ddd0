"""The model of a robot file with effects, for controller and estimator; none for a file without."""

from typing import TYPE_CHECKING

from model.kinematics.four_bar import Linkage
from robot.config.robot_file import RobotConfig
from robot.control.estimator_stage import EstimatorStage

if TYPE_CHECKING:
    from gap.machines.legged.frame import FrameModel
    from gap.machines.legged.machine import LeggedMachine


def machine_of(config: RobotConfig) -> "LeggedMachine":
    """Return the robot of a robot file, effects included, as the diagnosis knows it."""
    from gap.machines.legged.machine import LeggedMachine

    own = config.parameters
    return LeggedMachine(own.body.mass, own.legs, own.linkage, own.contact, config.effects)


def model_of(config: RobotConfig) -> "FrameModel | None":
    """Return the frame-by-frame model of a robot file's effects.

    Nothing of the diagnosis is imported for a robot file without effects.
    """
    if not config.effects:
        return None
    from gap.machines.legged.frame import FrameModel

    model = FrameModel(machine_of(config))
    model.prepare()
    return model


def estimator_stage(config: RobotConfig, linkage: Linkage) -> EstimatorStage:
    """Return the estimator of a robot file, with what its effects add."""
    if not config.effects:
        return EstimatorStage(config.parameters, config.estimator, linkage)
    from robot.control.effects import EffectsBeside

    beside = EffectsBeside(config, config.estimator.settings.law)
    beside.prepare()
    return EstimatorStage(config.parameters, config.estimator, linkage, beside)
