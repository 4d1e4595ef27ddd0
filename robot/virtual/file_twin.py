"""The virtual robot that a robot file describes: its parameters, and its effects in plant and sensors."""

from collections.abc import Sequence

from model.effects.catalogue import EFFECTS as CATALOGUE
from model.effects.causes import Cause
from model.effects.written import table_name
from model.errors import ConfigError
from robot.config.robot_file import RobotConfig
from sim_hw.plant.parameters import PlantParameters
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import TwinEffect, apply_effects
from sim_hw.twin.sensing import SensorParameters
from sim_hw.twin.twin import Twin

STICK_SLIP = "stick_slip"
SLIP_SPEED_M_S = 0.01  # at which the virtual robot's friction has come down from that at rest


def file_effects(config: RobotConfig, asked: Sequence[TwinEffect] = ()) -> tuple[TwinEffect, ...]:
    """Return the effects of a robot file as the virtual robot knows them.

    Args:
        config: Robot file.
        asked: Effects that are to come on top; one of the same name and place would take the file's away.

    Raises:
        ConfigError: Both have the same effect.
    """
    effects = tuple(effect for cause in config.effects for effect in twin_effects(cause))
    for one in asked:
        if any(
            f.name == one.name and (not f.leg or not one.leg or f.leg == one.leg) for f in effects
        ):
            raise ConfigError(
                f"effects.{one.name}",
                "is in the robot file already; take it out there, or do not ask for it",
            )
    return effects


def twin_effects(cause: Cause) -> tuple[TwinEffect, ...]:
    """Return a cause as the virtual robot knows it: names and numbers are the same, one leg each.

    Raises:
        ConfigError: It is a form that the virtual robot of a file does not have.
    """
    if cause.effect == STICK_SLIP:
        cause = Cause(CATALOGUE[STICK_SLIP].form_of, cause.joints, (*cause.values, SLIP_SPEED_M_S))
    if CATALOGUE[cause.effect].form_of:
        raise ConfigError(
            table_name(cause.effect, cause.joints),
            "cannot be had by a virtual robot of a file: its encoders are behind all that gives and plays, "
            "its loops before it; take it out of the robot file for virtual runs",
        )
    return tuple(TwinEffect(cause.effect, leg, cause.values) for leg in cause.joints or ("",))


def file_twin(config: RobotConfig, seed: int) -> Twin | None:
    """Return the nominal robot of a file with the file's effects; None where it has none.

    Raises:
        ConfigError: The virtual robot cannot have one of the effects.
    """
    if not config.effects:
        return None
    return apply_effects(nominal_twin(config, seed), file_effects(config), EFFECTS)


def nominal_twin(config: RobotConfig, seed: int) -> Twin:
    """Return the robot that a file describes without its effects, on no particular day."""
    robot = config.parameters
    sensors = SensorParameters.healthy(robot.legs.count)
    return Twin(robot.legs.names, PlantParameters.nominal(robot), sensors, seed)
