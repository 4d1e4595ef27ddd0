"""A wrong zero is found in the loads, with its leg and size, and no other error is taken for one."""

import numpy as np
import pytest

from benchmarks.odometry.bars import noticed
from model.estimator.senses import Heard
from model.estimator.shaft_zeros import NO_LEG, SMALL_RAD, at_start, learn
from model.estimator.tolerance_kernel import OTHERS
from model.estimator.tolerances import Apart
from model.values.arrays import FloatArray
from model.values.estimate import ZeroEvidence

LEGS = 6
COMPANION_M = 0.002
RECORDS = 2000
# what a foot that is higher takes from the others, over the weight, for each companion's height
STIFF = 0.03 * (np.full((LEGS, LEGS), 1 / LEGS) - np.eye(LEGS))


def walked(
    zero_rad: FloatArray, height_m: FloatArray, noise: float = 0.002, slopes: bool = True
) -> ZeroEvidence:
    """Loads of a robot whose feet are off by a height and by their zeros, over a few strides."""
    random = np.random.default_rng(3)
    known = at_start(LEGS)
    apart_share = np.zeros((2 * (LEGS + OTHERS), LEGS))
    for record in range(RECORDS):
        phase = 2 * np.pi * record / 400 + np.arange(LEGS)
        slope_m = 0.03 * np.sin(phase)
        apart_share[:LEGS], apart_share[LEGS + OTHERS : -OTHERS] = STIFF, -STIFF
        off = (height_m + slope_m * zero_rad) / COMPANION_M
        share = np.zeros((LEGS, 3))
        share[:, 2] = 1 / LEGS + STIFF @ off + noise * random.standard_normal(LEGS)
        total = float(share[:, 2].sum())
        heard = Heard(share, whole=True, total=total, fresh=True, use=True)
        known = learn(
            known, heard, np.full((LEGS, 3), 1 / LEGS), Apart(np.zeros((0, 3)), apart_share),
            np.outer(slope_m, [0, 0, 1]), np.ones(LEGS) if slopes else None, COMPANION_M,
        )  # fmt: skip
    return known


def test_a_wrong_zero_is_named_with_its_leg_and_size() -> None:
    zero = np.zeros(LEGS)
    zero[4] = -0.15
    known = walked(zero, np.full(LEGS, 0.001))
    assert known.suspected == 4
    assert known.angle_rad[0, 4] == pytest.approx(-0.15, rel=0.05)


@pytest.mark.parametrize("size", [0.0, 0.5 * SMALL_RAD])
def test_lengths_and_small_zeros_are_no_wrong_zero(size: float) -> None:
    zero, height = np.zeros(LEGS), np.zeros(LEGS)
    zero[2], height[0] = size, 0.012
    assert walked(zero, height).suspected == NO_LEG


def test_two_wrong_zeros_do_not_name_one_of_them() -> None:
    zero = np.zeros(LEGS)
    zero[[1, 5]] = 0.15, -0.12
    assert walked(zero, np.zeros(LEGS)).suspected == NO_LEG


def test_nothing_is_said_of_noise_or_of_legs_without_a_shaft_of_their_own() -> None:
    zero = np.zeros(LEGS)
    zero[4] = 0.15
    assert walked(zero, np.zeros(LEGS), slopes=False).suspected == NO_LEG
    assert walked(np.zeros(LEGS), np.zeros(LEGS), noise=0.1).suspected == NO_LEG
    assert at_start(LEGS).suspected == NO_LEG


@pytest.mark.thorough
@pytest.mark.parametrize(("gait", "leg"), [("tripod", "ML"), ("metachronal", "MR")])
def test_a_robot_that_walks_with_a_wrong_zero_says_so(gait: str, leg: str) -> None:
    words = noticed(f"shaft_zero_offset@{leg}:offset_rad=0.17", gait)
    assert f"the zero of {leg} seems to be off by" in words
    assert "zero of" not in noticed("leg_length@FR:offset_m=0.012", gait)


@pytest.mark.thorough
def test_a_zero_whose_loads_look_like_those_of_another_leg_is_not_blamed_on_it() -> None:
    """In the metachronal gait a wrong zero of HL loads the feet much as one of FR, its diagonal, does."""
    assert "zero of" not in noticed("shaft_zero_offset@HL:offset_rad=0.17", "metachronal")
