"""Support on poses, random and degenerate, against an independent solver: 100,000 in ``make soak``."""

from collections import Counter

import numpy as np
import pytest

from model.quasistatic.frames import Reason, solve_frames
from model.values.arrays import FloatArray
from model.values.legs import FootMotion
from model.values.parameters import ContactParameters
from tests.model.contact_oracle import oracle_loads
from tests.model.oracles.support import solve_support
from tests.model.poses import KINDS, poses
from tests.soaked import THOROUGH, soaked

WEIGHT_N = 60.0
BLOCKS = 50
POSES = 100_000


def solved(feet: FloatArray, stiffness: FloatArray) -> tuple[FloatArray, FloatArray, int]:
    """Pose, loads and reason of one frame from the compiled search."""
    count = len(stiffness)
    contact = ContactParameters(stiffness, np.ones(count), np.zeros((count, 2)))
    motion = FootMotion(feet[None], np.zeros((1, count, 3)))
    answer = solve_frames(motion, contact, WEIGHT_N)
    return answer.pose[0], answer.load_n[0], int(answer.reason[0])


def proves_itself(
    feet: FloatArray, stiffness: FloatArray, pose: FloatArray, load: FloatArray
) -> bool:
    """The loads are those of the springs at this pose, and they balance: nothing else is to show."""
    height = -pose[0] * feet[:, 0] + pose[1] * feet[:, 1] + feet[:, 2] + pose[2]
    springs = stiffness * np.maximum(-height, 0.0)
    rounding = 1e-12 * float((stiffness * np.abs(feet[:, 2])).sum())
    same = np.abs(springs - load).max() <= 1e-10 * WEIGHT_N + rounding
    balance = np.array([load.sum() - WEIGHT_N, load @ feet[:, 0], load @ feet[:, 1]])
    return bool(same and np.abs(balance).max() <= 1e-9 * WEIGHT_N + rounding)


@pytest.mark.parametrize("block", soaked(range(BLOCKS), lambda block: block < 1, mark=THOROUGH))
def test_loads_are_those_of_an_independent_solver(block: int) -> None:
    counts: Counter[str] = Counter()
    for kind, feet, stiffness in poses(POSES // BLOCKS, seed=block):
        expected = oracle_loads(feet, stiffness, WEIGHT_N)
        pose, load, reason = solved(feet, stiffness)
        if np.isnan(load).any():
            assert reason == Reason.TIPS, (kind, reason)
            assert expected is None, (kind, "the oracle found loads, we did not")
            counts["tips"] += 1
            continue
        assert proves_itself(feet, stiffness, pose, load), kind
        if expected is None:  # on the very edge, where the oracle's own tolerance decides
            counts["edge"] += 1
        else:
            assert np.abs(load - expected).max() <= 1e-9 * WEIGHT_N, kind
            counts["same"] += 1
    assert counts["same"] > 0.5 * POSES / BLOCKS
    assert counts["tips"] > 0.1 * POSES / BLOCKS
    assert counts["edge"] < 0.005 * POSES / BLOCKS


def test_the_compiled_search_and_numpy_agree() -> None:
    for kind, feet, stiffness in poses(750, seed=99):
        reference = solve_support(feet, stiffness, WEIGHT_N)
        pose, load, _ = solved(feet, stiffness)
        if not reference.converged:
            assert np.isnan(load).all(), kind
            continue
        exact = 1e-12 if kind not in {"stiff", "edge"} else 1e-9  # what the condition number leaves
        assert np.abs(load - reference.load_n).max() <= exact * WEIGHT_N, kind
        if kind == "polygon":
            assert abs(pose[2] - reference.height_m) < 1e-14


def test_every_kind_of_pose_is_there() -> None:
    seen = Counter(kind for kind, _, _ in poses(200, seed=0))
    assert set(seen) == set(KINDS)
    counts = [len(k) for _, _, k in poses(2000, seed=0)]
    assert min(counts) == 3
    assert max(counts) == 50


def test_one_foot_below_the_centre_of_mass_carries_all() -> None:
    feet = np.array([[0.0, 0.0, -0.2], [0.3, 0.0, 0.5]])
    _, load, _ = solved(feet, np.array([1000.0, 1000.0]))
    np.testing.assert_allclose(load, [WEIGHT_N, 0.0], atol=1e-9)


def test_the_body_stands_higher_on_a_step() -> None:
    angle = np.arange(6) * np.pi / 3
    feet = np.stack([0.3 * np.cos(angle), 0.3 * np.sin(angle), np.full(6, -0.15)], axis=1)
    contact = ContactParameters(np.full(6, 2000.0), np.ones(6), np.zeros((6, 2)))
    motion = FootMotion(np.tile(feet, (2, 1, 1)), np.zeros((2, 6, 3)))
    ground = np.stack([np.zeros(6), np.full(6, 0.1)])
    answer = solve_frames(motion, contact, WEIGHT_N, ground_m=ground)
    assert answer.pose[1, 2] - answer.pose[0, 2] == pytest.approx(0.1, abs=1e-12)
    uneven = np.where(feet[:, 0] > 0.01, 0.02, 0.0)
    tilted = solve_frames(motion, contact, WEIGHT_N, ground_m=uneven)
    assert tilted.pose[0, 0] < -0.01, (
        "front feet on a step: slope_x lifts the front (p falls by it)"
    )
