"""The filter against filterpy's used at once and in the open, and its gates."""

from dataclasses import replace

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter

from model.estimator.kalman import Kalman, MeasurementStack, sound
from model.estimator.measurements import stacked
from model.estimator.settings import EstimatorSettings
from model.estimator.sources import FORCE, LOAD, NO_SOURCE, at_start
from model.values.arrays import FloatArray
from model.values.estimate import FIXED

SETTINGS = EstimatorSettings()
SIZE = FIXED + 12
PATIENCE = (FIXED, SETTINGS)
SOURCES = at_start(6)


def stack_of(blocks: list[MeasurementStack]) -> MeasurementStack:
    stack = stacked(blocks)
    assert stack is not None
    return stack


def problem(draw: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """A transition, mostly zeros beside its diagonal, and noise."""
    rare = draw.random((SIZE, SIZE)) < 0.2
    transition = np.eye(SIZE) + np.where(rare, 0.1 * draw.normal(size=(SIZE, SIZE)), 0.0)
    return transition, 0.1 * np.eye(SIZE)


def near(one: object, other: object) -> None:
    np.testing.assert_allclose(
        np.asarray(one, dtype=float), np.asarray(other, dtype=float), rtol=1e-9, atol=1e-11
    )


def block(
    innovation: FloatArray, rows: FloatArray, variance: FloatArray, gate: float = np.inf,
    kind: int = NO_SOURCE, leg: int = 0,
) -> MeasurementStack:  # fmt: skip
    return MeasurementStack(
        innovation, rows, variance, np.array([gate]), np.array([[0, kind, leg]])
    )


def test_gated_blocks_equal_filterpys_update_of_all_at_once() -> None:
    draw = np.random.default_rng(4)
    theirs, kalman = (
        ExtendedKalmanFilter(SIZE, 9),
        Kalman(SIZE, FIXED, replace(SETTINGS, parameter_limit=1e6)),
    )
    transition, noise = problem(draw)
    theirs.x, theirs.F, theirs.Q = np.zeros(SIZE), transition, noise
    mean, covariance = np.zeros(SIZE), np.eye(SIZE)
    streak = np.zeros((5, 6), dtype=np.int64)
    for _ in range(20):
        z, rows = draw.normal(size=9), draw.normal(size=(9, SIZE))
        variance = draw.uniform(0.05, 0.3, 9)
        theirs.predict()
        mean = transition @ mean
        covariance = kalman.predict(covariance, transition, noise)
        near(covariance, theirs.P)
        left = z - rows @ mean
        blocks = [
            block(left[:1], rows[:1], variance[:1], 1e9, 0, 2),
            block(left[1:3], rows[1:3], variance[1:3], 1e9, 1, 4),
            block(left[3:6], rows[3:6], variance[3:6], 1e9, 2, 0),
            block(left[6:], rows[6:], variance[6:]),
        ]
        inner = rows @ covariance @ rows.T + np.diag(variance)
        theirs.update(
            z, lambda _, rows=rows: rows, lambda x, rows=rows: rows @ x, np.diag(variance)
        )
        used = kalman.update(mean, covariance, stack_of(blocks), streak, SOURCES, 0)
        mean, covariance = used.mean, used.covariance
        near(mean, theirs.x)
        near(covariance, theirs.P)
        assert np.array_equal(covariance, covariance.T)
        assert (used.numbers, used.rejects) == (9, 0)
        assert used.nis == pytest.approx(left @ np.linalg.solve(inner, left), rel=1e-9)
        assert used.log_likelihood == pytest.approx(theirs.log_likelihood, rel=1e-9)
        normal = left / np.sqrt(np.diagonal(inner))
        assert used.innovation[2, 2] == pytest.approx(normal[0])
        near(used.innovation[4, :2], normal[1:3])
        assert np.isfinite(used.innovation).sum() == 3


@pytest.mark.parametrize("numbers", [1, 2, 3])
def test_a_block_outside_its_gate_is_left_out_until_it_has_insisted(numbers: int) -> None:
    kalman = Kalman(SIZE, *PATIENCE)
    rows = np.eye(SIZE)[3 : 3 + numbers]
    far = block(np.full(numbers, 10.0), rows, np.full(numbers, 0.5), 16.0, 1, 3)
    mean, covariance = np.zeros(SIZE), np.eye(SIZE)
    streak = np.zeros((5, 6), dtype=np.int64)
    for times in range(SETTINGS.reject_limit):
        used = kalman.update(mean, covariance, far, streak, SOURCES, 0)
        streak = used.streak
        assert (used.rejects, used.numbers, streak[1, 3]) == (1, 0, times + 1)
        assert np.isnan([used.nis, used.log_likelihood]).all()
        assert not used.mean.any()
        assert np.array_equal(used.covariance, covariance)
    used = kalman.update(mean, covariance, far, streak, SOURCES, 0)
    # the noise has grown until the block lies on its gate: each number has 1.5 times the factor
    factor = numbers * 100.0 / 1.5 / 16.0
    assert (used.rejects, used.numbers, used.streak[1, 3]) == (1, numbers, 11)
    near(used.mean[3 : 3 + numbers], np.full(numbers, 10.0 / (1.5 * factor)))
    assert used.nis == pytest.approx(16.0)
    close = far._replace(innovation=np.full(numbers, 0.1))
    assert not kalman.update(mean, covariance, close, used.streak, SOURCES, 0).streak.any()


def test_what_was_not_used_changes_nothing() -> None:
    far, close = (
        block(np.array([left]), np.eye(SIZE)[[i]], np.full(1, 0.5), 10.0, 0, i)
        for i, left in enumerate((9.0, 0.5))
    )
    mean, covariance = np.zeros(SIZE), np.eye(SIZE)
    streak = np.zeros((5, 6), dtype=np.int64)
    used = Kalman(SIZE, *PATIENCE).update(
        mean, covariance, stack_of([far, close]), streak, SOURCES, 0
    )
    near(used.mean, np.where(np.arange(SIZE) == 1, 0.5 / 1.5, 0.0))
    near(used.covariance, np.diag(np.where(np.arange(SIZE) == 1, 0.5 / 1.5, 1.0)))
    assert (used.rejects, used.numbers) == (1, 1)
    assert np.isnan(used.innovation[0, 2])
    assert used.streak[0].tolist() == [1, 0, 0, 0, 0, 0]


def test_parameters_go_no_farther_than_their_limit() -> None:
    one = block(np.array([-50.0, 50.0]), np.eye(SIZE)[[3, FIXED]], np.full(2, 0.5))
    used = Kalman(SIZE, *PATIENCE).update(
        np.zeros(SIZE), np.eye(SIZE), one, np.zeros((5, 6), dtype=np.int64), SOURCES, 0
    )
    assert used.mean[FIXED] == SETTINGS.parameter_limit
    assert used.mean[3] == pytest.approx(-50.0 / 1.5)


@pytest.mark.parametrize("size", [1e12, 1e160, np.inf, np.nan])
def test_a_number_beyond_all_measure_harms_no_other(size: float) -> None:
    """Neither an overflow nor an inverse that fails, however long it insists."""
    pair = block(np.array([size, 1.0]), np.eye(SIZE)[3:5], np.full(2, 1e-6), 16.0, 1, 3)
    close = block(np.array([0.1]), np.eye(SIZE)[[7]], np.full(1, 1e-6), 10.0, 0, 1)
    streak = np.full((5, 6), SETTINGS.reject_limit)
    used = Kalman(SIZE, *PATIENCE).update(
        np.zeros(SIZE), np.eye(SIZE), stack_of([pair, close]), streak, SOURCES, 0
    )
    assert used.mean[7] == pytest.approx(0.1, rel=1e-5)
    assert used.numbers == (3 if size == 1e12 else 1)
    assert np.isfinite(used.mean).all()
    assert sound(used.covariance)


def test_each_source_has_its_own_nis_and_they_add_up_where_nothing_correlates_them() -> None:
    draw = np.random.default_rng(8)
    blocks = [
        block(draw.normal(size=2), np.eye(SIZE)[[0, 1]], np.full(2, 0.3), np.inf, FORCE, 2),
        block(draw.normal(size=1), np.eye(SIZE)[[2]], np.full(1, 0.2), np.inf, LOAD, 1),
        block(draw.normal(size=1), np.eye(SIZE)[[3]], np.full(1, 0.2), np.inf, LOAD, 4),
        block(np.full(1, 0.4), np.eye(SIZE)[[4]], np.full(1, 0.7)),  # of no source
    ]
    streak = np.zeros((5, 6), dtype=np.int64)
    update = Kalman(SIZE, *PATIENCE).update
    apart = update(np.zeros(SIZE), np.eye(SIZE), stack_of(blocks), streak, SOURCES, 0)
    assert apart.source_dof.tolist() == [2, 2, 0, 0, 0]
    assert apart.numbers == apart.source_dof.sum() + 1
    gauge = 0.4**2 / 1.7
    assert np.nansum(apart.source_nis) + gauge == pytest.approx(apart.nis)
    assert np.isnan(apart.source_nis[2:]).all()
    # where the state correlates them, each is judged by its own part of S
    root = draw.normal(size=(SIZE, SIZE))
    covariance = root @ root.T / SIZE
    together = update(np.zeros(SIZE), covariance, stack_of(blocks), streak, SOURCES, 0)
    for source, numbers, variance in ((FORCE, [0, 1], 0.3), (LOAD, [2, 3], 0.2)):
        left = stack_of(blocks).innovation[numbers]
        own = covariance[np.ix_(numbers, numbers)] + variance * np.eye(2)
        assert together.source_nis[source] == pytest.approx(left @ np.linalg.solve(own, left))


@pytest.mark.parametrize(("scale", "colour"), [(25.0, 1.0), (1.0, 30.0), (25.0, 30.0), (2.0, 1.5)])
def test_a_gate_opens_by_no_more_than_four_times_the_settings_variance(
    scale: float, colour: float
) -> None:
    learned = replace(SOURCES, scale=np.full(5, scale), colour=np.full(5, colour))
    kalman, gate, variance, known = Kalman(SIZE, *PATIENCE), 10.8, 0.5, 0.1
    opens = min(scale * colour, 4.0)
    edge = np.sqrt(gate * (known + opens * variance))
    for left, rejects in ((0.999 * edge, 0), (1.001 * edge, 1)):
        one = block(np.full(1, left), np.eye(SIZE)[[5]], np.full(1, variance), gate, LOAD, 3)
        used = kalman.update(
            np.zeros(SIZE), known * np.eye(SIZE), one, np.zeros((5, 6), dtype=np.int64), learned, 0
        )
        assert (used.rejects, used.numbers) == (rejects, 1 - rejects)
        if not rejects:  # though it weighs in with all the noise that was learned
            assert used.mean[5] == pytest.approx(left * known / (known + scale * colour * variance))
            # what it is judged by does not count errors that last twice
            assert used.nis == pytest.approx(left**2 / (known + scale * variance))


def test_what_was_learned_makes_no_number_weigh_more_than_the_settings_say() -> None:
    quiet = replace(SOURCES, scale=np.full(5, 0.05))
    one = block(np.full(1, 0.1), np.eye(SIZE)[[5]], np.full(1, 0.5), 10.8, LOAD, 3)
    used = Kalman(SIZE, *PATIENCE).update(
        np.zeros(SIZE), np.eye(SIZE), one, np.zeros((5, 6), dtype=np.int64), quiet, 0
    )
    assert SETTINGS.least_weight == 1.0
    assert used.mean[5] == pytest.approx(0.1 / 1.5)
