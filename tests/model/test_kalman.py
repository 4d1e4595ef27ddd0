"""The compiled filter against filterpy's own methods, and its gates."""

from dataclasses import replace

import numpy as np
import pytest
from filterpy.kalman import ExtendedKalmanFilter

from model.estimator.kalman import Kalman, Patience, Stack
from model.estimator.kalman_filter import CompiledFilter
from model.estimator.measurements import Block, stacked
from model.estimator.settings import EstimatorSettings
from model.values.arrays import FloatArray
from model.values.estimate import FIXED

SETTINGS = EstimatorSettings()
SIZE = FIXED + 12
PATIENCE = Patience(SETTINGS.reject_limit, FIXED, SETTINGS.parameter_limit)
FREE = Patience(10, FIXED, 1e6)


def stack_of(blocks: list[Block]) -> Stack:
    stack = stacked(None, blocks)
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


def test_compiled_methods_equal_filterpys_own() -> None:
    draw = np.random.default_rng(3)
    ours, theirs = CompiledFilter(SIZE), ExtendedKalmanFilter(SIZE, 1)
    assert isinstance(ours, ExtendedKalmanFilter)
    theirs.x = np.zeros(SIZE)
    ours.F, ours.Q = theirs.F, theirs.Q = problem(draw)
    for _ in range(20):
        z, rows = draw.normal(size=9), draw.normal(size=(9, SIZE))
        noise = np.diag(draw.uniform(0.05, 0.3, 9))
        for one in (ours, theirs):
            one.predict()
        for name in ("x", "P", "x_prior", "P_prior"):
            near(getattr(ours, name), getattr(theirs, name))
        for one in (ours, theirs):
            one.update(z, lambda _, rows=rows: rows, lambda x, rows=rows: rows @ x, noise)
        for name in (
            "x", "P", "x_prior", "P_prior", "x_post", "P_post", "y", "z", "S", "SI", "K",
            "log_likelihood", "mahalanobis",
        ):  # fmt: skip
            near(getattr(ours, name), getattr(theirs, name))
        assert ours.likelihood == pytest.approx(theirs.likelihood, rel=1e-8)
        assert np.array_equal(ours.P, ours.P.T)


def test_blocks_one_after_the_other_equal_filterpys_update_of_all_at_once() -> None:
    draw = np.random.default_rng(4)
    theirs, kalman = ExtendedKalmanFilter(SIZE, 9), Kalman(SIZE)
    transition, noise = problem(draw)
    theirs.x, theirs.F, theirs.Q = np.zeros(SIZE), transition, noise
    mean, covariance = np.zeros(SIZE), np.eye(SIZE)
    streak = np.zeros((3, 6), dtype=np.int64)
    for _ in range(20):
        z, rows = draw.normal(size=9), draw.normal(size=(9, SIZE))
        variance = draw.uniform(0.05, 0.3, 9)
        theirs.predict()
        mean = transition @ mean
        covariance = kalman.predict(mean, covariance, transition, noise)
        near(covariance, theirs.P)
        left = z - rows @ mean
        blocks = [
            Block(left[:1], rows[:1], variance[:1], 1e9, 0, 2),
            Block(left[1:3], rows[1:3], variance[1:3], 1e9, 1, 4),
            Block(left[3:6], rows[3:6], variance[3:6], 1e9, 2, 0),
            Block(left[6:], rows[6:], variance[6:]),
        ]
        inner = rows @ covariance @ rows.T + np.diag(variance)
        theirs.update(
            z, lambda _, rows=rows: rows, lambda x, rows=rows: rows @ x, np.diag(variance)
        )
        used = kalman.update(mean, covariance, stack_of(blocks), streak, FREE)
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
    kalman = Kalman(SIZE)
    rows = np.eye(SIZE)[3 : 3 + numbers]
    far = Block(np.full(numbers, 10.0), rows, np.full(numbers, 0.5), 16.0, 1, 3)
    mean, covariance = np.zeros(SIZE), np.eye(SIZE)
    streak = np.zeros((3, 6), dtype=np.int64)
    for times in range(SETTINGS.reject_limit):
        stack = stack_of([far])
        used = kalman.update(mean, covariance, stack, streak, PATIENCE)
        streak = used.streak
        assert (used.rejects, used.numbers, streak[1, 3]) == (1, 0, times + 1)
        assert np.isnan([used.nis, used.log_likelihood]).all()
        assert not used.mean.any()
        assert np.array_equal(used.covariance, covariance)
        assert np.isinf(stack.variance).all()
    used = kalman.update(mean, covariance, stack_of([far]), streak, PATIENCE)
    # the noise has grown until the block lies on its gate: each number has 1.5 times the factor
    factor = numbers * 100.0 / 1.5 / 16.0
    assert (used.rejects, used.numbers, used.streak[1, 3]) == (1, numbers, 11)
    near(used.mean[3 : 3 + numbers], np.full(numbers, 10.0 / (1.5 * factor)))
    assert used.nis == pytest.approx(16.0)
    close = replace(far, innovation=np.full(numbers, 0.1))
    assert not kalman.update(
        mean, covariance, stack_of([close]), used.streak, PATIENCE
    ).streak.any()


def test_what_was_not_used_has_no_gain() -> None:
    ours = CompiledFilter(3)
    rows, streak = np.eye(3)[:2], np.zeros((3, 1), dtype=np.int64)
    ours.gated_update(
        np.array([9.0, 0.5]), rows, np.full(2, 0.5), np.array([10.0, 10.0]),
        np.array([[0, 0, 0], [1, 1, 0]]), 5, 3, 1.0, streak, np.full((1, 3), np.nan),
    )  # fmt: skip
    assert np.isinf(ours.S[0, 0])
    near(ours.K, [[0, 0], [0, 1 / 1.5], [0, 0]])
    near(ours.x, [0, 0.5 / 1.5, 0])
