"""Markers above the springs of their legs: what they show, and that healthy runs tell it once for all."""

import numpy as np
import pytest

from gap.delegate import Without
from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.comparison.commissioning import commissioned_study, standing_of
from gap.diagnosis.diagnose import diagnose_study
from gap.interfaces import Cause, Drive, Simulator
from record.trial.trial import Trial
from tests.gap.predictions import COULOMB, Prediction
from tests.gap.walks import cause, simulator, walk
from tests.soaked import soaked

SHARE = 0.4
ON_THE_SHANK = cause("marker_on_shank", SHARE)
SOFT = (3e-4, 2e-4)  # m/N sideways and along
LISTED = {
    "marker_on_shank", "leg_flex", "coulomb_friction", "ground_stiffness", "payload", "pose_delay",
    "servo_compliance", "servo_compliance_beyond_encoder", "leg_stiffness",
}  # fmt: skip


@pytest.mark.parametrize("drive", Drive, ids=lambda d: d.value)
def test_markers_show_a_share_of_what_springs_give_and_nothing_else_changes(drive: Drive) -> None:
    trial = walk("metachronal", 0.2, 6.0, [COULOMB])
    soft = cause("leg_flex", *SOFT)
    whole, part, none = (
        Prediction(trial, [COULOMB, soft, *more], drive)
        for more in ((), (ON_THE_SHANK,), (cause("marker_on_shank", 0.0),))
    )
    for name in ("force_x", "force_z", "body_z", "body_vx", "shaft_error"):
        assert np.allclose(part[name], whole[name], atol=1e-7)
    given = whole.feet - none.feet
    assert given[..., 2].max() > 2e-3
    assert np.abs(given[..., :2]).max() > 5e-4
    assert np.allclose(part.feet - none.feet, SHARE * given, atol=1e-9)


def test_a_longer_leg_shows_by_the_same_share() -> None:
    trial = walk("metachronal", 0.2, 3.0, [COULOMB])
    longer = cause("leg_length", 0.004, legs=("ML",))
    none = cause("marker_on_shank", 0.0)
    part, whole, rigid = (
        Prediction(trial, [longer, *more], Drive.MEASURED)
        for more in ((ON_THE_SHANK,), (), (none,))
    )
    assert np.allclose(part.feet - rigid.feet, SHARE * (whole.feet - rigid.feet), atol=1e-9)
    assert np.allclose(rigid.feet, Prediction(trial, [none], Drive.MEASURED).feet, atol=1e-9)


def test_two_shares_multiply() -> None:
    trial = walk("metachronal", 0.2, 3.0, [COULOMB])
    twice = Prediction(trial, [cause("marker_on_shank", 0.5), cause("marker_on_shank", 0.8)])
    assert np.allclose(twice.feet, Prediction(trial, [ON_THE_SHANK]).feet, atol=1e-9)


def shortened() -> Simulator:
    every = {effect.family for effect in simulator().effects}
    return Without(simulator(), tuple(every - LISTED))


def healthy(*causes: Cause) -> list[Trial]:
    walks = (("tripod", 0.2), ("metachronal", 0.15), ("tripod", 0.25), ("metachronal", 0.2))
    return [
        walk(gait, hz, 8.0, (COULOMB, *causes), noise_seed=20 + k, steer=0.05 * k)
        for k, (gait, hz) in enumerate(walks)
    ]


@pytest.mark.parametrize("share", soaked([SHARE, 0.0, 1.0], lambda share: share == SHARE))
def test_healthy_runs_show_where_markers_are_and_soft_legs_have_their_size(share: float) -> None:
    own = () if share == 1.0 else (cause("marker_on_shank", share),)
    references = healthy(*own)
    standing = standing_of(references, shortened())
    shares = [one.values[0] for one in standing if one.effect == "marker_on_shank"]
    assert shares == (pytest.approx([share], abs=0.02) if own else [])
    trials = [
        walk(gait, 0.2, 8.0, (COULOMB, *own, cause("leg_flex", *SOFT)), noise_seed=40 + k)
        for k, gait in enumerate(("tripod", "metachronal"))
    ]
    study = commissioned_study(trials, shortened(), references, standing=standing)
    found = diagnose_study(study)
    assert found.verdict is Verdict.EXPLAINED
    (one,) = found.causes
    assert one.effect == "leg_flex"
    assert [number.value for number in one.values] == pytest.approx(list(SOFT), rel=0.1)


def test_a_share_that_stiffer_springs_would_show_is_not_named() -> None:
    standing = standing_of(healthy(cause("marker_on_shank", 0.85)), shortened())
    assert "marker_on_shank" not in {one.effect for one in standing}
