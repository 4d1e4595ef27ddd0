"""The frame's force scale: against brute force, and where there is nothing to scale."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from model.errors import ModelError
from model.traction.force_scale import force_scale
from model.values.arrays import FloatArray


def forces(seed: int, frames: int = 20) -> tuple[FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    predicted = rng.normal(0, 1, (frames, 6, 2))
    return predicted, 3.0 * predicted + rng.normal(0, 2, predicted.shape)


@pytest.mark.parametrize("norms", [False, True])
def test_it_is_the_least_squares_scale(norms: bool) -> None:
    predicted, measured = forces(0)
    found = force_scale(predicted, measured, norms=norms)

    def error(c: float, frame: int) -> float:
        if norms:
            there = np.linalg.norm(measured[frame], axis=1)
            left = c * np.linalg.norm(predicted[frame], axis=1) - there
        else:
            left = (c * predicted[frame] - measured[frame]).ravel()
        return float(left @ left)

    best = [
        minimize_scalar(error, args=(frame,), bounds=(0, 50), method="bounded").x
        for frame in range(len(predicted))
    ]
    assert found.scale == pytest.approx(best, abs=1e-4)
    assert not found.clamped.any()


def test_a_prediction_that_points_the_wrong_way_is_clamped_and_said_so() -> None:
    predicted, _ = forces(1)
    found = force_scale(predicted, -predicted)
    assert (found.scale == 0).all()
    assert found.clamped.all()
    assert force_scale(predicted, -predicted, norms=True).scale == pytest.approx(1.0)


def test_nothing_to_scale_is_not_a_number() -> None:
    predicted, measured = forces(2, frames=3)
    predicted[0] = 0.0
    measured[1] = np.nan
    found = force_scale(predicted, measured)
    assert np.isnan(found.scale[:2]).all()
    assert np.isfinite(found.scale[2])
    assert not found.clamped.any()


def test_a_foot_with_a_missing_value_is_left_out() -> None:
    predicted, measured = forces(3)
    without = force_scale(predicted[:, 1:], measured[:, 1:])
    measured[:, 0, 1] = np.nan
    assert force_scale(predicted, measured).scale == pytest.approx(without.scale)


def test_wrong_shapes_are_refused() -> None:
    with pytest.raises(ModelError, match="must both be"):
        force_scale(np.zeros((3, 6, 2)), np.zeros((3, 6, 3)))
