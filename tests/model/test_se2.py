"""Planar motion against the matrix exponential, and trajectories against the product in order."""

from itertools import accumulate

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from model.errors import ModelError
from model.motion.se2 import (
    aligning,
    compose,
    exponential,
    integrate,
    inverse,
    products,
    quaternion_of,
    seen_from,
    yaw_of,
)
from model.values.arrays import root_mean_square

twists = st.tuples(
    st.floats(-2, 2), st.floats(-2, 2), st.floats(-7, 7) | st.floats(-3e-4, 3e-4)
).map(np.array)


def matrix(pose: np.ndarray) -> np.ndarray:
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([[c, -s, pose[0]], [s, c, pose[1]], [0, 0, 1]])


@given(twists)
def test_the_exponential_is_that_of_the_matrix(twist: np.ndarray) -> None:
    algebra = np.array([[0, -twist[2], twist[0]], [twist[2], 0, twist[1]], [0, 0, 0]])
    np.testing.assert_allclose(matrix(exponential(twist)), expm(algebra), atol=1e-13)


@given(twists, twists)
def test_composition_is_that_of_the_matrices(one: np.ndarray, two: np.ndarray) -> None:
    np.testing.assert_allclose(matrix(compose(one, two)), matrix(one) @ matrix(two), atol=1e-13)


@pytest.mark.parametrize("count", [0, 1, 2, 3, 7, 8, 9, 1000, 10_000])
def test_running_sums_are_the_product_in_order(count: int) -> None:
    rng = np.random.default_rng(count)
    steps = rng.normal(scale=[1e-3, 1e-3, 5e-3], size=(count, 3))
    start = np.array([1.0, -2.0, 0.7])
    for origin, made in ((np.zeros(3), products(steps)), (start, products(steps, start))):
        one_by_one = np.array(list(accumulate(steps, compose, initial=origin)))
        np.testing.assert_allclose(made, one_by_one, atol=1e-12, rtol=1e-12)


def test_a_constant_velocity_draws_a_circle() -> None:
    velocity = np.tile([0.2, 0.0, 0.5], (1000, 1))
    poses = integrate(velocity, 2 * np.pi / 0.5 / 1000)
    np.testing.assert_allclose(poses[-1], [0, 0, 2 * np.pi], atol=1e-12)
    radius = np.hypot(poses[:, 0], poses[:, 1] - 0.4)
    np.testing.assert_allclose(radius, 0.4, atol=1e-12)


def test_periods_may_differ_and_the_start_may_be_anywhere() -> None:
    velocity = np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
    poses = integrate(velocity, np.array([1.0, 0.5]), start=np.array([1.0, 1.0, np.pi / 2]))
    np.testing.assert_allclose(poses[-1], [0.0, 2.0, np.pi / 2], atol=1e-12)


def test_after_a_gap_the_pose_is_not_known() -> None:
    velocity = np.zeros((6, 3))
    velocity[3] = np.nan
    known = np.isfinite(integrate(velocity, 0.01)).all(axis=1)
    assert known.tolist() == [True, True, True, True, False, False, False]


def test_wrong_shapes_are_refused() -> None:
    with pytest.raises(ModelError, match="frames, 3"):
        integrate(np.zeros(3), 0.1)
    with pytest.raises(ModelError, match="periods"):
        integrate(np.zeros((4, 3)), np.zeros(3))


def test_a_pose_seen_from_itself_is_the_origin() -> None:
    pose = np.array([[1.0, 2.0, 0.3], [0.0, -1.0, 2.0]])
    np.testing.assert_allclose(seen_from(pose, pose), 0, atol=1e-15)
    ahead = seen_from(np.array([[0, 0, np.pi / 2]]), np.array([[0, 1.0, np.pi / 2]]))
    np.testing.assert_allclose(ahead, [[1, 0, 0]], atol=1e-15)


@given(twists, twists)
def test_inverse_and_aligning_are_those_of_the_matrices(one: np.ndarray, two: np.ndarray) -> None:
    np.testing.assert_allclose(matrix(inverse(one)) @ matrix(one), np.eye(3), atol=1e-13)
    np.testing.assert_allclose(compose(aligning(one, two), two), one, atol=1e-13)


@given(st.floats(-3.1, 3.1), st.floats(-0.5, 0.5))
def test_yaw_and_its_quaternion(yaw: float, tilt: float) -> None:
    assert yaw_of(quaternion_of(yaw)) == pytest.approx(yaw, abs=1e-14)
    attitude = Rotation.from_euler("ZYX", [yaw, tilt, -tilt])
    assert yaw_of(attitude.as_quat()) == pytest.approx(yaw, abs=1e-14)
    assert quaternion_of(np.array([yaw, tilt])).shape == (2, 4)


def test_root_mean_square_leaves_out_what_is_not_known() -> None:
    np.testing.assert_allclose(
        root_mean_square(np.array([[3.0, np.nan], [4.0, np.nan]]))[0], np.sqrt(12.5)
    )
    assert np.isnan(root_mean_square(np.full((2, 2), np.nan))).all()
