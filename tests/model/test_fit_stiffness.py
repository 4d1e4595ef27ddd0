"""Stiffness from load shares: derivatives, recovery, honest errors, and what cannot be told."""

import numpy as np
import pytest

from model.errors import ModelError
from model.fit.result import FitResult
from model.fit.stiffness import StiffnessConventions, fit_stiffness
from model.support.frames import load_derivatives
from model.values.arrays import FloatArray

TRUE = np.array([2000.0, 2500.0, 3000.0, 1500.0, 2200.0, 2800.0])
START = np.full(6, 1000.0)
WEIGHT = 64.0
NAMES = ("HL", "ML", "FL", "HR", "MR", "FR")


def feet(seed: int, *, frames: int = 120, uneven: float = 0.01) -> FloatArray:
    rng = np.random.default_rng(seed)
    x, y = np.array([-0.2, 0.0, 0.2, -0.2, 0.0, 0.2]), np.array([0.25] * 3 + [-0.25] * 3)
    found = np.stack([x, y, np.full(6, -0.12)], axis=1) + np.zeros((frames, 1, 1))
    found[..., :2] += rng.uniform(-0.03, 0.03, (frames, 6, 2))
    found[..., 2] += rng.uniform(-uneven, uneven, (frames, 6))
    return found


def loads(position: FloatArray, stiffness: FloatArray = TRUE) -> FloatArray:
    return load_derivatives(position, stiffness, WEIGHT).solved.load_n


def fit(position: FloatArray, vertical: FloatArray, **more: object) -> FitResult:
    pose = more.pop("pose", None)
    conventions = StiffnessConventions(**({"spread_weight": 0.0} | more))  # type: ignore[arg-type]
    return fit_stiffness(
        position, vertical, WEIGHT, START, leg_names=NAMES, conventions=conventions,
        pose=pose,  # type: ignore[arg-type]
    )  # fmt: skip


def test_derivatives_agree_with_differences() -> None:
    position, step = feet(0), 1e-6
    analytic = load_derivatives(position, TRUE, WEIGHT)
    for leg in range(6):
        log = np.zeros(6)
        log[leg] = step
        up = load_derivatives(position, TRUE * np.exp(log), WEIGHT).solved
        down = load_derivatives(position, TRUE * np.exp(-log), WEIGHT).solved
        slope = (up.load_n - down.load_n) / (2 * step)
        assert np.abs(slope - analytic.load_slope[:, :, leg]).max() < 1e-6 * WEIGHT
        slope = (up.pose - down.pose) / (2 * step)
        assert np.abs(slope - analytic.pose_slope[:, :, leg]).max() < 1e-8


def test_the_truth_is_found_without_noise() -> None:
    position = feet(1)
    found = fit(position, 7.0 * loads(position))  # the unit of the forces does not matter
    assert found.values == pytest.approx(TRUE, rel=1e-6)
    assert found.converged
    assert found.frames_used == len(position)
    assert found.undetermined == ()
    assert found.warnings == ()
    assert found.residual_rms < 1e-9
    assert found.names[0] == "K HL"


def test_standard_errors_cover_the_truth() -> None:
    position = feet(2)
    clean = loads(position)
    rng = np.random.default_rng(0)
    scores = []
    for _ in range(40):
        found = fit(position, clean + rng.normal(0, 0.4, clean.shape))
        scores.append((found.values - TRUE) / found.standard_errors)
    z = np.abs(np.array(scores))
    assert 0.8 < np.sqrt(np.mean(z**2)) < 1.2
    assert np.mean(z < 1) == pytest.approx(0.68, abs=0.1)
    assert (z < 3).mean() > 0.98


def test_feet_in_a_plane_hide_the_scale() -> None:
    position = feet(4, uneven=0.0)
    found = fit(position, loads(position))
    assert found.undetermined == found.names
    assert np.isnan(found.standard_errors).all()
    assert "common scale" in found.warnings[0]
    assert found.values / found.values.mean() == pytest.approx(TRUE / TRUE.mean(), rel=1e-5)


def test_the_mean_fixes_the_scale() -> None:
    position = feet(4, uneven=0.0)
    found = fit(position, loads(position), mean_stiffness=TRUE.mean())
    assert found.values == pytest.approx(TRUE, rel=1e-5)
    assert found.undetermined == ()
    assert np.isfinite(found.standard_errors).all()


def test_measured_height_and_slopes_fix_the_scale() -> None:
    position = feet(4, uneven=0.0)
    solved = load_derivatives(position, TRUE, WEIGHT).solved
    found = fit(position, solved.load_n, pose=solved.pose)
    assert found.values == pytest.approx(TRUE, rel=1e-5)
    assert found.undetermined == ()


@pytest.mark.parametrize("mean", [None, 2400.0])
def test_a_leg_that_is_never_loaded_is_not_known(mean: float | None) -> None:
    position = feet(5)
    position[:, 0, 2] += 0.1
    found = fit(position, loads(position), mean_stiffness=mean, spread_weight=1e-4)
    assert found.undetermined == ("K HL",)
    assert "leg HL was never loaded" in found.warnings[0]
    assert np.isnan(found.standard_errors[0])
    assert np.isfinite(found.standard_errors[1:]).all()
    if mean is not None:
        assert found.values[1:].mean() == pytest.approx(mean)
    else:
        assert found.values[1:] == pytest.approx(TRUE[1:], rel=0.05)


def test_three_feet_tell_nothing() -> None:
    position = feet(6)
    position[:, [0, 2, 4], 2] += 0.1  # a tripod stands, whatever its stiffness
    found = fit(position, loads(position))
    assert found.undetermined == found.names
    assert len(found.warnings) == 6


def test_the_penalty_draws_legs_together() -> None:
    position = feet(7)
    found = fit(position, loads(position), spread_weight=100.0).values
    assert np.ptp(np.log(found)) < 0.1 * np.ptp(np.log(TRUE))


def test_frames_that_cannot_be_used_are_counted() -> None:
    position = feet(8)
    vertical = loads(position).copy()
    vertical[0, 3] = np.nan
    position[1, :, 0] += 1.0  # the centre of mass is not above the feet
    vertical[2] = 0.0
    found = fit(position, vertical)
    assert found.frames_used == len(position) - 3
    assert dict(found.left_out) == {
        "a foot or a force is missing": 1,
        "the robot tips": 1,
        "no foot is loaded": 1,
    }
    assert found.values == pytest.approx(TRUE, rel=1e-6)


def test_mistakes_are_refused() -> None:
    position = feet(9, frames=5)
    vertical = loads(position)
    with pytest.raises(ModelError, match="no frame can be used"):
        fit(position, np.full_like(vertical, np.nan))
    with pytest.raises(ModelError, match="feet must be"):
        fit(position, vertical[:, :5])
    with pytest.raises(ModelError, match="must be positive"):
        fit(position, vertical, mean_stiffness=-1.0)
    with pytest.raises(ModelError, match="pose must be"):
        fit(position, vertical, pose=np.zeros(3))
