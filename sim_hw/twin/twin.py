"""A physical twin: one robot as it really is, with its sensors as they really are."""

from dataclasses import dataclass

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
