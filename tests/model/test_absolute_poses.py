"""Absolute poses that come late, out of order, and now and then from somewhere else."""

import numpy as np
import pytest

from model.estimator.filter import Estimator
from model.estimator.history import EstimatorMemory, LateSample, advance, use_late
from model.estimator.settings import EstimatorSettings
from model.values.arrays import FloatArray
from model.values.estimate import Estimate, Health
from tests.model.estimator_world import CONTACT, PERIOD_NS, WEIGHT_N, World, simulate
from tests.soaked import THOROUGH, soaked

SETTINGS = EstimatorSettings()
TICKS = 800
EVERY = 4  # a camera at 25 Hz
MEMORY_S = 0.15
OUTLIERS = 0.05
NOISE = np.array([SETTINGS.pose_sd, SETTINGS.pose_sd, SETTINGS.yaw_sd])


@pytest.fixture(scope="module")
def world() -> World:
    return simulate(SETTINGS, 21, TICKS)


def samples(
    world: World, seed: int, outliers: float
) -> tuple[dict[int, list[LateSample]], dict[int, float]]:
    """Poses by the tick in which they arrive, and the size [m] of each outlier by the tick it is of."""
    draw = np.random.default_rng(seed)
    arriving: dict[int, list[LateSample]] = {}
    off: dict[int, float] = {}
    for i in range(0, TICKS - 20, EVERY):
        pose: FloatArray = world.pose[i] + NOISE * draw.normal(size=3)
        if i > 40 and draw.random() < outliers:
            size, angle = float(np.exp(draw.uniform(np.log(0.1), np.log(5.0)))), draw.uniform(0, 7)
            pose[:2] += size * np.array([np.cos(angle), np.sin(angle)])
            off[i] = size
        later = int(draw.integers(1, round(MEMORY_S * 1e9) // PERIOD_NS))
        arriving.setdefault(i + later, []).append(LateSample(i * PERIOD_NS, pose))
    return arriving, off


def tracked(
    world: World, arriving: dict[int, list[LateSample]]
) -> tuple[EstimatorMemory, list[Estimate], list[int]]:
    """The memory at the end, the estimates, and the rejections after each tick."""
    estimator = Estimator(CONTACT, WEIGHT_N, SETTINGS)
    memory = EstimatorMemory(estimator.initial())
    said, rejects = [], []
    for i, known in enumerate(world.inputs):
        memory, _ = use_late(estimator, memory, arriving.get(i, []))
        memory, estimate = advance(estimator, memory, known, MEMORY_S)
        said.append(estimate)
        rejects.append(estimate.rejects)
    return memory, said, rejects


@pytest.mark.soak
@pytest.mark.parametrize("seed", soaked([1, 2, 3], lambda seed: seed == 1, mark=THOROUGH))
def test_outliers_among_late_poses_are_rejected_with_a_reason(world: World, seed: int) -> None:
    clean_arriving, _ = samples(world, seed, 0.0)
    arriving, off = samples(world, seed, OUTLIERS)
    assert len(off) > 4
    assert min(off.values()) < 0.5
    clean_memory, clean, clean_rejects = tracked(world, clean_arriving)
    memory, said, rejects = tracked(world, arriving)
    assert memory.refused == clean_memory.refused == 0, "all came within the memory"
    # force measurements are rejected now and then as well, in both
    assert rejects[-1] - clean_rejects[-1] == pytest.approx(len(off), abs=1)
    error = np.array([e.position_m for e in said]) - world.pose[:, :2]
    clean_error = np.array([e.position_m for e in clean]) - world.pose[:, :2]
    assert np.abs(error[-1]).max() < 0.005
    assert np.abs(error).max() < np.abs(clean_error).max() + 0.005, "no outlier moved it"
    for i, size in off.items():
        (arrival,) = [
            k for k, late in arriving.items() if any(s.t_ns == i * PERIOD_NS for s in late)
        ]
        newest = max(s.t_ns for k, late in arriving.items() if k <= arrival for s in late)
        if newest != i * PERIOD_NS:
            continue  # a later pose was there already, and agreed
        estimate = said[arrival]
        assert estimate.health is Health.DEGRADED, (i, size)
        assert "absolute poses" in estimate.reason
        words = "pose_limit" if size > SETTINGS.pose_limit + 0.1 else "poses contradict"
        if abs(size - SETTINGS.pose_limit) > 0.1:
            assert words in estimate.reason, (size, estimate.reason)
    assert sum(e.health is Health.OK for e in said) > 0.8 * len(said), "between them all is well"


def test_a_pose_older_than_the_memory_changes_nothing(world: World) -> None:
    estimator = Estimator(CONTACT, WEIGHT_N, SETTINGS)
    memory = EstimatorMemory(estimator.initial())
    for known in world.inputs[:100]:
        memory, _ = advance(estimator, memory, known, MEMORY_S)
    late = LateSample(70 * PERIOD_NS, world.pose[70] + 0.5)
    after, estimate = use_late(estimator, memory, [late])
    assert estimate is None
    assert after.refused == 1
    np.testing.assert_array_equal(after.state.mean, memory.state.mean)
