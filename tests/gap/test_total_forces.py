"""The total force on all feet: the weight and what pulls at the robot, however feet push at each other."""

from dataclasses import replace

import numpy as np
import pytest

from gap.interfaces import Cause
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from record.trial.trial import Trial
from tests.gap.predictions import Prediction, inside
from tests.gap.walks import cause, simulator, walk

TOTALS = tuple(f"total_force_{axis}" for axis in "xyz")


@pytest.fixture(scope="module")
def trial() -> Trial:
    return walk("tripod", 0.2, 6.0)


def _totals(trial: Trial, *causes: Cause) -> FloatArray:
    got = Prediction(trial, list(causes))
    return inside(np.column_stack([got[name] for name in TOTALS]))


def test_they_are_the_sum_of_all_feet_measured_and_predicted(trial: Trial) -> None:
    got = Prediction(trial)
    for axis, name in zip("xyz", TOTALS, strict=True):
        assert np.allclose(got[name], got[f"force_{axis}"].sum(axis=1))
    seen, names = _observed(trial)
    for axis, name in zip("xyz", TOTALS, strict=True):
        feet = [k for k, one in enumerate(names) if one == f"force_{axis}"]
        assert np.allclose(seen[:, names.index(name)], seen[:, feet].sum(axis=1))


def test_what_pulls_is_in_the_sum_and_what_one_leg_has_is_not(trial: Trial) -> None:
    base = _totals(trial)
    pulled = _totals(trial, cause("tether_force", -3.0, 0.0)) - base
    assert pulled.mean(axis=0) == pytest.approx([3.0, 0.0, 0.0], abs=0.1)
    softer = _totals(trial, cause("leg_stiffness", 0.5, legs=("ML",))) - base
    assert np.abs(softer.mean(axis=0)).max() < 0.3, "others carry what it does not"
    biased = _totals(trial, cause("force_bias", 0.0, 0.0, 3.0, legs=("ML",))) - base
    assert biased.mean(axis=0) == pytest.approx([0.0, 0.0, 3.0], abs=0.1)


def test_the_moment_says_where_a_load_lies(trial: Trial) -> None:
    """Its weight at its place: -m g x about y, and m g y about x."""
    names = [f"total_moment_{axis}" for axis in "xyz"]
    base, loaded = Prediction(trial), Prediction(trial, [cause("payload", 0.5, 0.1, -0.05)])
    change = inside(np.column_stack([loaded[name] - base[name] for name in names])).mean(axis=0)
    weight_n = 0.5 * STANDARD_GRAVITY
    assert change[:2] == pytest.approx([-0.05 * weight_n, -0.1 * weight_n], rel=0.1)
    turned = Prediction(trial, [cause("leg_stiffness", 0.5, legs=("ML",))])
    for name in names[:2]:
        assert abs(inside(turned[name] - base[name]).mean()) < 0.05


def test_it_is_not_measured_where_a_foot_has_no_sensor(trial: Trial) -> None:
    force_n = trial.force_n.copy()
    force_n[:, 2] = np.nan
    seen, names = _observed(replace(trial, force_n=force_n))
    assert not np.isfinite(seen[:, [names.index(name) for name in TOTALS]]).any()


def _observed(trial: Trial) -> tuple[FloatArray, list[str]]:
    observation = simulator().observe(trial)
    known = np.where(observation.weight > 0.0, observation.values, np.nan)
    return inside(known), [channel.name for channel in simulator().channels]
