"""A physical twin: one robot as it really is, with its sensors as they really are."""

from dataclasses import dataclass

from model.values.parameters import RobotParameters
from sim_hw.plant.parameters import PlantParameters
from sim_hw.twin.sensing import SensorParameters


@dataclass(frozen=True, slots=True, eq=False)
class Twin:
    """A reality.

    Attributes:
        names: Legs, in the robot file's order.
        plant: What the robot and its ground are made of.
        sensors: What its sensors do.
        seed: Of everything random in plant and sensors.
    """

    names: tuple[str, ...]
    plant: PlantParameters
    sensors: SensorParameters
    seed: int


def healthy_twin(robot: RobotParameters, seed: int) -> Twin:
    """Return the twin of a robot file with nothing wrong, on the day that the seed stands for.

    Args:
        robot: The robot file's parameters.
        seed: Also of the day's friction, stiffness and centre of mass.
    """
    return Twin(
        names=robot.legs.names,
        plant=PlantParameters.nominal(robot).scattered(seed),
        sensors=SensorParameters.healthy(robot.legs.count),
        seed=seed,
    )
