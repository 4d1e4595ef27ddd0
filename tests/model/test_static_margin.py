"""The static margin against the convex hull of scipy, and against what a drawing shows."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from model.support.static_margin import hull_edges, static_margin
from model.values.arrays import BoolArray, FloatArray


def of_scipy(feet: FloatArray) -> float:
    """Signed distance of the origin from the hull: equations inside, segments outside."""
    hull = ConvexHull(feet)
    reach = -hull.equations[:, 2].max()
    if hull.equations[:, 2].max() <= 0:
        return float(reach)
    distances = []
    for first, second in hull.simplices:
        along = feet[second] - feet[first]
        share = np.clip(-feet[first] @ along / (along @ along), 0, 1)
        distances.append(np.hypot(*(feet[first] + share * along)))
    return -float(min(distances))


@pytest.mark.parametrize("legs", [3, 4, 6, 9])
def test_as_the_hull_of_scipy_has_it(legs: int) -> None:
    random = np.random.default_rng(legs)
    feet = random.normal(size=(300, legs, 2)) + random.normal(size=(300, 1, 2))
    margin = static_margin(feet, np.ones((300, legs), dtype=np.bool_))
    expected = np.array([of_scipy(frame) for frame in feet])
    assert (expected > 0).any()
    assert (expected < 0).any()
    np.testing.assert_allclose(margin.margin_m, expected, atol=1e-9)
    distance = np.hypot(*margin.nearest_m.T)
    np.testing.assert_allclose(distance, np.abs(expected), atol=1e-9)


def test_feet_in_the_air_do_not_count() -> None:
    random = np.random.default_rng(0)
    feet = random.normal(size=(200, 6, 2))
    down = random.random((200, 6)) < 0.7
    down[:, :3] = True
    margin = static_margin(feet, down).margin_m
    expected = [of_scipy(frame[row]) for frame, row in zip(feet, down, strict=True)]
    np.testing.assert_allclose(margin, expected, atol=1e-9)


SQUARE = np.array([[-2.0, -1], [-2, 1], [1, 1], [1, -1]])


@pytest.mark.parametrize(
    ("feet", "margin", "nearest"),
    [
        (SQUARE, 1.0, None),
        (SQUARE - [-0.5, 0], 1.0, None),
        (SQUARE - [0.5, 0], 0.5, [0.5, 0.0]),
        (SQUARE - [3.0, 0], -2.0, [-2.0, 0.0]),
        (SQUARE - [4.0, 4.0], -np.hypot(3, 3), [-3.0, -3.0]),  # nearest to a corner
        (np.array([[1.0, -1], [1, 1]]), -1.0, [1.0, 0.0]),  # two feet: a line
        (np.array([[-1.0, 0], [1, 0]]), 0.0, [0.0, 0.0]),  # above the line: it tips either way
        (np.array([[3.0, 4.0]]), -5.0, [3.0, 4.0]),
        (np.array([[1.0, -1], [1, 0], [1, 1]]), -1.0, [1.0, 0.0]),  # three in a row
    ],
)
def test_as_a_drawing_shows(feet: FloatArray, margin: float, nearest: list[float] | None) -> None:
    answer = static_margin(feet[None], np.ones((1, len(feet)), dtype=np.bool_))
    assert answer.margin_m[0] == pytest.approx(margin, abs=1e-12)
    if nearest is not None:
        np.testing.assert_allclose(answer.nearest_m[0], nearest, atol=1e-12)


def test_no_feet_is_no_margin() -> None:
    none: BoolArray = np.zeros((2, 4), dtype=np.bool_)
    answer = static_margin(np.ones((2, 4, 2)), none)
    assert np.isneginf(answer.margin_m).all()
    assert np.isnan(answer.nearest_m).all()


def test_edges_of_a_square() -> None:
    edges = hull_edges(SQUARE[None], np.ones((1, 4), dtype=np.bool_))
    assert sorted(edges.reach_m.tolist()) == [1.0, 1.0, 1.0, 2.0]
    np.testing.assert_allclose(np.hypot(*edges.normal.T), 1.0)
