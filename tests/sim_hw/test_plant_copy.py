"""A plant that was settled before for the same robot is the one that settles now, to the bit."""

from dataclasses import replace

import numpy as np
import pytest

from robot.config.robot_file import load_robot
from sim_hw.plant.parameters import PlantParameters
from sim_hw.plant.plant import Plant
from tests import standing

NOMINAL = PlantParameters.nominal(load_robot().parameters)
STEPS = 100


def moved(plant: Plant) -> list[bytes]:
    """All that a plant has after it was made, and after torque."""
    draw = np.random.default_rng(0)
    found = []
    for _ in range(STEPS):
        data = plant.data
        numbers = (data.qpos, data.qvel, data.qacc, plant.leg_state, plant.foot_force_B)
        found += [one.tobytes() for one in numbers]
        legs = plant.parameters.legs
        plant.step(draw.uniform(-0.5, 0.5, legs), np.ones(legs, dtype=bool))
    return found


def test_a_copy_is_the_plant_that_settles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(standing, "_kept", {})
    monkeypatch.setattr(Plant, "_stand", standing.SETTLED)
    settles = moved(Plant(NOMINAL))
    monkeypatch.setattr(Plant, "_stand", standing.stand)
    assert moved(Plant(NOMINAL)) == settles, "who is the first"
    assert moved(Plant(NOMINAL)) == settles, "from its copy"
    heavy = replace(NOMINAL, mass=NOMINAL.mass + 1.0)
    assert moved(Plant(heavy)) != settles
    assert len(standing._kept) == 2
