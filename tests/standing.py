"""Plants are settled once for each robot: that is most of the time that a virtual robot takes to be made.

Every plant that is made stands for a second and a half of its own time until nothing moves, and hundreds of
tests make the same one. What comes of it depends on nothing but the parameters as long as no gust blows and
no ground changes, so a copy is the same to the bit (``tests/sim_hw/test_plant_copy.py``).
"""

import pickle
from collections.abc import Iterator

import mujoco
import pytest

from model.values.arrays import FloatArray
from sim_hw.plant.plant import Plant

MOST = 64  # robots; who makes more of them begins again
SETTLED = Plant._stand
_kept: dict[bytes, tuple[mujoco.MjData, FloatArray, FloatArray]] = {}


def stand(plant: Plant) -> None:
    """As ``Plant._stand``; from a copy if it was done before."""
    if not plant.plain:
        SETTLED(plant)
        return
    key = pickle.dumps(plant.parameters)
    if key in _kept:
        data, legs, force = _kept[key]
        mujoco.mj_copyData(plant.data, plant.model, data)
        plant.leg_state[:] = legs
        plant.foot_force_B = force.copy()
        return
    SETTLED(plant)
    if len(_kept) == MOST:
        _kept.clear()
    data = mujoco.MjData(plant.model)
    mujoco.mj_copyData(data, plant.model, plant.data)
    _kept[key] = data, plant.leg_state.copy(), plant.foot_force_B.copy()


@pytest.fixture(scope="session", autouse=True)
def settled_once() -> Iterator[None]:
    """All tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Plant, "_stand", stand)
        yield
