"""What differs in a healthy robot from one day to the next."""

from dataclasses import dataclass, replace

import numpy as np

from model.values.arrays import FloatArray
from sim_hw.twin.sensing import SensorParameters
from sim_hw.twin.twin import Twin


@dataclass(frozen=True, slots=True)
class DayScatter:
    """One standard deviation of what differs from day to day.

    Assumed: a few per cent, as of rubber feet and hand-set legs.

    Attributes:
        mu: Relative, of each foot's friction.
        stiffness: Relative, of each leg's spring.
        com_m: Centre of mass along x and y [m].
        floor_mu: Relative, of all feet's friction together: dust, damp, another floor.
        length_m: Length of each leg [m].
        zero_rad: Each crank against its encoder, as after homing again [rad].
        force_zero_n: Zero of each axis of each transducer [N].
        legs: How many times as much at each leg, over and over.
    """

    mu: float = 0.04
    stiffness: float = 0.03
    com_m: float = 0.0015
    floor_mu: float = 0.0
    length_m: float = 0.0
    zero_rad: float = 0.0
    force_zero_n: float = 0.0
    legs: tuple[float, ...] = (1.0,)


USUAL_DAYS = DayScatter()


def on_day(twin: Twin, scatter: DayScatter = USUAL_DAYS) -> Twin:
    """Return the twin on the day that its seed stands for."""
    random = np.random.default_rng([twin.seed, 0x70])
    plant, count = twin.plant, twin.plant.legs
    times = np.resize(scatter.legs, count)

    def legs(size: float) -> FloatArray:
        drawn: FloatArray = size * times * random.standard_normal(count)
        return drawn

    mu, stiffness = np.exp(legs(scatter.mu)), np.exp(legs(scatter.stiffness))
    com = scatter.com_m * random.standard_normal(2)
    floor_mu = np.exp(scatter.floor_mu * random.standard_normal())
    length, zero = legs(scatter.length_m), legs(scatter.zero_rad)
    bias = scatter.force_zero_n * times[:, None] * random.standard_normal((count, 3))
    drive = replace(plant.drive, crank_offset=plant.drive.crank_offset + zero)
    sensors: SensorParameters = replace(twin.sensors, force_bias=twin.sensors.force_bias + bias)
    return replace(
        twin,
        plant=replace(
            plant,
            mu=plant.mu * mu * floor_mu,
            stiffness=plant.stiffness * stiffness,
            com=plant.com + com,
            leg_offset=plant.leg_offset + length,
            drive=drive,
        ),
        sensors=sensors,
    )
