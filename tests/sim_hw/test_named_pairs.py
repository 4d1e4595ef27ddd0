"""Pairs of geoms that are named beforehand touch as those that MuJoCo finds."""

from dataclasses import replace

import numpy as np
import pytest

from model.values.arrays import FloatArray
from robot.config.robot_file import load_robot
from sim_hw.plant import mujoco_model
from sim_hw.plant.parameters import PlantParameters
from sim_hw.plant.plant import Plant
from tests.soaked import soaked
from tests.standing import SETTLED

NOMINAL = PlantParameters.nominal(load_robot().parameters)


def _changed(**ground: object) -> PlantParameters:
    return replace(NOMINAL, ground=replace(NOMINAL.ground, **ground))  # type: ignore[arg-type]


PLANTS = {
    "level": lambda: NOMINAL,
    "slope": lambda: _changed(slope=np.array([0.05, -0.02])),
    "step": lambda: _changed(step_height=0.01, step_x=0.02),
    "pads": lambda: _changed(stiffness=np.full(NOMINAL.legs, 4000.0)),
    "twisting chassis": lambda: replace(NOMINAL, twist=30.0),
    "pyramids": lambda: replace(NOMINAL, contact=replace(NOMINAL.contact, elliptic=False)),
}


def _walked(plant: PlantParameters) -> tuple[int, FloatArray]:
    """Pairs of the model, and MuJoCo's state in the course of half a second of turning motors."""
    robot = Plant(plant, seed=3)
    random, states = np.random.default_rng(4), []
    for _ in range(20):
        duty = random.uniform(-0.6, 0.6, plant.legs)
        for _ in range(25):
            robot.step(duty, np.ones(plant.legs, dtype=bool))
        states.append(
            np.concatenate([robot.data.qpos, robot.data.qvel, robot.data.qfrc_constraint])
        )
    return robot.model.npair, np.array(states)


@pytest.mark.parametrize("kind", soaked(PLANTS, lambda kind: kind in {"level", "twisting chassis"}))
def test_named_pairs_touch_as_those_that_are_found(
    kind: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Plant, "_stand", SETTLED)  # each model settles by itself
    plant = PLANTS[kind]()
    pairs, named = _walked(plant)
    monkeypatch.setattr(mujoco_model, "_name_pairs", lambda spec: None)
    none, found = _walked(plant)
    assert pairs > plant.legs
    assert none == 0
    np.testing.assert_array_equal(named, found)


def test_friction_that_changes_is_that_of_the_geoms(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Plant, "_stand", lambda plant: None)
    slippery = replace(NOMINAL, friction=replace(NOMINAL.friction, static_ratio=1.5))
    assert Plant(slippery).model.npair == 0
