"""Where the plant's feet are and how they move: the compiled sums against vectors."""

import numpy as np
from scipy.spatial.transform import Rotation

from sim_hw.plant.foot_surface import feet_truth, foot_arms

FEET = 4


def test_feet_move_with_the_torso_its_spin_and_their_own_slides() -> None:
    random = np.random.default_rng(3)
    for rotation in Rotation.random(20, random).as_matrix():
        places, rows = random.normal(size=(9, 3)), random.permutation(9)[:FEET].astype(np.int64)
        torso, rate = random.normal(size=3), random.normal(size=6 + 3 * FEET)
        own = 6 + random.permutation(3 * FEET).reshape(FEET, 3).astype(np.int64)
        force = random.normal(size=(FEET, 3))
        feet, contact = np.empty((3, FEET, 3)), np.zeros(FEET, dtype=np.bool_)
        feet_truth(places, rows, torso, rate, own, rotation, force, 0.2, feet, contact)
        arms = np.empty((FEET, 3))
        foot_arms(places, rows, torso, arms)
        assert np.array_equal(arms, places[rows] - torso)
        spin = rotation @ rate[3:6]
        moving = rate[:3] + np.cross(spin, arms) + rate[own] @ rotation.T
        assert np.array_equal(feet[0], places[rows])
        assert np.allclose(feet[1], moving, rtol=0, atol=1e-13)
        assert np.array_equal(feet[2], force)
        assert np.array_equal(contact, force[:, 2] > 0.2)
