"""What is learned of each source, from drawn innovations whose size and memory are known."""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import pytest

from model.estimator import sources
from model.estimator.filter import Estimator
from model.estimator.settings import EstimatorSettings, Record, record_of
from model.estimator.sources import ABSOLUTE, FORCE, GYRO, LOAD, NO_SOURCE, TILT
from model.values.arrays import FloatArray, IntArray
from model.values.estimate import NEVER, SOURCES, SourceMemory
from tests.model.estimator_world import CONTACT, WEIGHT_N, simulate

SETTINGS = EstimatorSettings()
RECORD = record_of(SETTINGS, WEIGHT_N)
LEGS = 6
PERIOD_NS = 50_000_000
NOISE = 0.02**2
# first number, source and leg of each block: six loads, six pairs of forces, a pose, a gyro, two tilts
BLOCKS = np.array(
    [[k, LOAD, k] for k in range(6)]
    + [[6 + 2 * k, FORCE, k] for k in range(6)]
    + [[18, ABSOLUTE, 0], [21, GYRO, 0], [22, TILT, 0], [23, TILT, 1]]
)
COUNT = 24


class NumberPlaces(NamedTuple):
    """Of some numbers: their source, and the place of each in the memory."""

    source: IntArray
    place: IntArray


def places(blocks: IntArray, count: int, legs: int) -> NumberPlaces:
    where = NumberPlaces(np.full(count, NO_SOURCE), np.zeros(count, dtype=np.int64))
    sources.place_kernel(blocks, legs, *where)
    return where


EVERY = places(BLOCKS, COUNT, LEGS)


def learn(
    before: SourceMemory,
    where: NumberPlaces,
    innovation: FloatArray,
    expected: FloatArray,
    noise: FloatArray,
    t_ns: int,
    settings: Record,
) -> SourceMemory:
    """What is known of the sources after a tick."""
    after = sources.room_for(before)
    then, now = ([getattr(one, name) for name in SourceMemory.__slots__] for one in (before, after))
    sources.learn_kernel(*where, innovation, expected, noise, t_ns, settings, *then, *now)
    return sources.closed(after)


def fields(memory: SourceMemory) -> list[bytes]:
    return [getattr(memory, name).tobytes() for name in SourceMemory.__slots__]


def lasting(ticks: int, like: float, size: float, seed: int = 1) -> FloatArray:
    """Numbers of this standard deviation, each like the one before it, (T, COUNT)."""
    white = np.random.default_rng(seed).normal(size=(ticks, COUNT))
    drawn = white.copy()
    for i in range(1, ticks):
        drawn[i] = like * drawn[i - 1] + np.sqrt(1 - like**2) * white[i]
    return size * drawn


def learned(
    innovations: FloatArray,
    expected: float = 0.0,
    where: NumberPlaces = EVERY,
    settings: EstimatorSettings = SETTINGS,
) -> list[SourceMemory]:
    memory, history = sources.at_start(LEGS), []
    record, flat = record_of(settings, WEIGHT_N), np.ones(innovations.shape[1])
    for i, left in enumerate(innovations):
        memory = learn(memory, where, left, expected * flat, NOISE * flat, i * PERIOD_NS, record)
        history.append(memory)
    return history


def mean_of(history: list[SourceMemory], name: str) -> FloatArray:
    """Over the second half, (S,)."""
    late: FloatArray = np.mean([getattr(m, name) for m in history[len(history) // 2 :]], axis=0)
    return late


@pytest.mark.parametrize(
    ("times", "expected"),
    [(0.4, 0.0), (1.0, 0.0), (2.0, 0.0), (4.0, 0.0), (1.0, NOISE), (2.0, NOISE), (4.0, 3 * NOISE)],
)
def test_noise_of_k_times_its_sd_is_learned_as_k_squared(times: float, expected: float) -> None:
    """What the filter's own covariance explains of the innovations is not the sensor's noise."""
    size = np.sqrt(expected + times**2 * NOISE)
    scale = mean_of(learned(lasting(4000, 0.0, size), expected), "scale")
    np.testing.assert_allclose(scale[[LOAD, FORCE]], times**2, rtol=0.2)


def test_what_is_learned_stays_within_its_bounds() -> None:
    silent, loud = learned(np.zeros((6000, COUNT))), learned(lasting(2000, 0.0, 100.0))
    for history in (silent, loud):
        for memory in history[::50]:
            assert (memory.scale >= SETTINGS.least_scale).all()
            assert (memory.scale <= SETTINGS.most_scale).all()
    np.testing.assert_allclose(silent[-1].scale[[LOAD, FORCE]], SETTINGS.least_scale)
    np.testing.assert_allclose(loud[-1].scale[[LOAD, FORCE]], SETTINGS.most_scale)


@pytest.mark.parametrize("like", [0.0, 0.3, 0.6])
def test_errors_that_last_count_as_many_times_as_they_repeat(like: float) -> None:
    colour = mean_of(learned(lasting(6000, like, np.sqrt(NOISE))), "colour")
    np.testing.assert_allclose(colour[[LOAD, FORCE]], (1 + like) / (1 - like), rtol=0.3)


def test_the_longer_errors_last_the_less_a_number_counts_and_never_too_little() -> None:
    means = [
        mean_of(learned(lasting(3000, like, np.sqrt(NOISE))), "colour")[[LOAD, FORCE]]
        for like in (0.0, 0.4, 0.8, 0.95)
    ]
    assert (np.diff(means, axis=0) > 0).all()
    other_way = mean_of(learned(lasting(3000, -0.6, np.sqrt(NOISE))), "colour")
    np.testing.assert_array_equal(other_way, 1.0)  # errors that take turns count once


def test_sensors_without_a_model_keep_the_noise_of_the_settings() -> None:
    last = learned(lasting(1000, 0.8, 5 * np.sqrt(NOISE)))[-1]
    direct = [ABSOLUTE, GYRO, TILT]
    np.testing.assert_array_equal(last.scale[direct], 1.0)
    np.testing.assert_array_equal(last.colour[direct], 1.0)
    assert (last.misfit[direct] > 5).all(), "health hears of it all the same"


@pytest.mark.parametrize("wrong", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_changes_nothing(wrong: float) -> None:
    before = learned(lasting(50, 0.5, 0.03))[-1]
    flat = np.full(COUNT, NOISE)
    after = learn(before, EVERY, np.full(COUNT, wrong), flat, flat, 10**10, RECORD)
    assert fields(after) == fields(before)
    # one of them among others is as one that is not there
    left = lasting(1, 0.0, 0.03)[0]
    left[3] = wrong
    others = np.delete(np.arange(COUNT), 3)
    with_it = learn(before, EVERY, left, flat, flat, 10**10, RECORD)
    fewer = NumberPlaces(EVERY.source[others], EVERY.place[others])
    without = learn(before, fewer, left[others], flat[others], flat[others], 10**10, RECORD)
    assert fields(with_it) == fields(without)


def test_a_source_that_was_not_heard_is_remembered_as_it_was() -> None:
    before = learned(lasting(50, 0.5, 0.03))[-1]
    loads = NumberPlaces(EVERY.source[:6], EVERY.place[:6])
    flat = np.full(6, NOISE)
    after = learn(before, loads, np.full(6, 0.05), flat, flat, 10**10, RECORD)
    for name in ("t_ns", "product", "normal", "misfit", "scale", "colour"):
        np.testing.assert_array_equal(getattr(after, name)[1:], getattr(before, name)[1:])
    assert after.t_ns[LOAD] == 10**10
    assert after.scale[LOAD] != before.scale[LOAD]
    np.testing.assert_array_equal(after.last[6:], before.last[6:])


def test_before_the_first_number_all_is_as_the_settings_say() -> None:
    start = sources.at_start(LEGS)
    assert (start.t_ns == NEVER).all()
    for name in ("misfit", "scale", "colour"):
        np.testing.assert_array_equal(getattr(start, name), np.ones(len(SOURCES)))
    assert sources.places_needed(LEGS) == COUNT


def test_every_number_has_a_place_of_its_own() -> None:
    assert sorted(EVERY.place.tolist()) == list(range(COUNT))
    assert EVERY.source.tolist() == [LOAD] * 6 + [FORCE] * 12 + [ABSOLUTE] * 3 + [GYRO, TILT, TILT]
    # a foot's numbers stand where they always do, whichever others are heard; the gauge has none
    few = places(np.array([[0, LOAD, 4], [1, FORCE, 5], [3, NO_SOURCE, 0]]), 4, LEGS)
    assert few.place[:3].tolist() == [4, 16, 17]
    assert few.source.tolist() == [LOAD, FORCE, FORCE, NO_SOURCE]


def test_same_innovations_same_bits() -> None:
    drawn = lasting(300, 0.4, 0.03)
    assert fields(learned(drawn)[-1]) == fields(learned(drawn)[-1])


def test_learning_changes_no_memory_that_it_was_given() -> None:
    before = learned(lasting(20, 0.4, 0.03))[-1]
    kept = fields(before)
    flat = np.full(COUNT, NOISE)
    after = learn(before, EVERY, np.full(COUNT, 0.1), flat, flat, 10**10, RECORD)
    assert fields(before) == kept != fields(after)
    assert not any(getattr(after, name).flags.writeable for name in SourceMemory.__slots__)


def test_without_a_compiler_the_same_is_learned(monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = lasting(200, 0.4, 0.03)
    drawn[50, 2], drawn[60] = np.nan, np.nan
    fast = learned(drawn, NOISE)[-1]
    kernel: Any = sources.learn_kernel
    monkeypatch.setattr(sources, "learn_kernel", kernel.py_func)
    slow = learned(drawn, NOISE)[-1]
    for name in SourceMemory.__slots__:
        np.testing.assert_allclose(getattr(slow, name), getattr(fast, name), rtol=1e-9)


def test_a_filter_that_is_not_adaptive_learns_no_noise_but_judges_its_health() -> None:
    inputs = simulate(SETTINGS, 41, 100).inputs
    for adaptive in (True, False):
        estimator = Estimator(CONTACT, WEIGHT_N, replace(SETTINGS, adaptive=adaptive))
        state = estimator.initial()
        for known in inputs:
            state, estimate = estimator.step(state, known)
        first = sources.at_start(LEGS)
        assert np.array_equal(state.sources.scale, first.scale) is not adaptive
        assert np.array_equal(state.sources.colour, first.colour) is not adaptive
        assert (estimate.noise_scale == 1.0).all() == (not adaptive)
        assert not np.array_equal(state.sources.misfit, first.misfit)
