"""A foot that pulls at the ground as it comes off: what is far below 0 of its force is compared."""

from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.answer.findings import Verdict
from gap.interfaces import Cause
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.predictions import LEGS, Prediction, inside
from tests.gap.walks import cause, diagnosed_among, machine, simulator, walk

LAG = Cause("servo_lag", (), (0.05,))
KEPT = {"foot_friction", "force_bias", "force_gain", "servo_lag", "leg_stiffness"}
GAITS = ("tripod", "metachronal")
ML = 1


def walks(count: int, seed: int) -> list[Trial]:
    """On days of their own: the springs of each leg differ, so that others carry what it does not."""
    draws = np.random.default_rng(seed)
    return [
        walk(
            GAITS[k % 2], 0.2, 10.0,
            [LAG, *(cause("leg_stiffness", ratio, legs=(leg,)) for leg, ratio in day)],
            steer=0.05 * (k % 4), noise_seed=seed + k,
        )
        for k in range(count)
        for day in [list(zip(LEGS, draws.lognormal(0.0, 0.1, len(LEGS)), strict=True))]
    ]  # fmt: skip


def pulling(trial: Trial, pull_n: float, seconds: float = 0.15) -> Trial:
    """ML pulls for a moment after each of its stances."""
    force = trial.force_n.copy()
    down = force[:, ML, 2] > 1.0
    off = np.flatnonzero(down[:-1] & ~down[1:]) + 1
    rate_hz = trial.header.sample_rate_hz
    for first in off:
        pulls = slice(first, first + round(seconds * rate_hz))
        force[pulls, ML, 2] = np.where(down[pulls], force[pulls, ML, 2], -pull_n)
    return replace(trial, force_n=force)


def _pulls(trial: Trial, *causes: Cause) -> FloatArray:
    return inside(Prediction(trial, list(causes))["pull_z"])


def test_only_what_reads_far_below_zero_pulls() -> None:
    trial = walk("tripod", 0.2, 6.0)
    assert not _pulls(trial).any(), "feet only push"
    assert not _pulls(trial, cause("force_gain", 0.6, legs=("ML",))).any()
    assert not _pulls(trial, cause("foot_friction", 2.0, legs=("ML",))).any()
    zero = cause("force_bias", 0.0, 0.0, -0.9, legs=("ML",))
    assert not _pulls(trial, zero).any(), "zeros of load cells differ"
    pulls_n = 0.02 * machine().size.weight_n
    biased = _pulls(trial, cause("force_bias", 0.0, 0.0, -pulls_n - 1.5, legs=("ML",)))
    assert biased[:, ML].min() == pytest.approx(-1.5, abs=0.01)
    assert not np.delete(biased, ML, axis=1).any()


def test_it_counts_where_the_foot_comes_off_as_well() -> None:
    trial = walk("tripod", 0.2, 6.0)
    names = [channel.name for channel in simulator().channels]
    weight = simulator().observe(trial).weight[:, names.index("pull_z") + ML]
    assert set(np.unique(weight[15:-15])) == {weight.max()}


@pytest.mark.parametrize(("pull_n", "verdict"), [(0.0, Verdict.NO_GAP), (4.0, Verdict.UNEXPLAINED)])
def test_a_foot_that_pulls_for_a_moment_is_a_gap_that_nothing_explains(
    pull_n: float, verdict: Verdict
) -> None:
    trials = [pulling(trial, pull_n) if pull_n else trial for trial in walks(4, 20)]
    d = diagnosed_among(KEPT, trials, walks(4, 40), (LAG,))
    assert d.verdict is verdict
    if pull_n:
        assert d.stage == "support"
        assert d.none > 0.9
        assert d.detection is not None
        assert d.detection.energy_in == "pull_z ML"
