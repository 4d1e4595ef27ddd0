"""A cause that explains most of a large misfit is fitted to most of it, not to the little that fits."""

from functools import cache

import numpy as np
import pytest

from gap.diagnosis.comparison.study import make_study
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search import options
from gap.search.candidates import Candidate
from gap.search.fit import fit_causes
from gap.search.options import fit_option
from tests.gap.walks import cause, simulator, walk

TURNED = cause("pose_yaw_offset", -0.1)
MOVED = cause("hip_mount_offset", 0.025, -0.025, legs=("FL",))


@cache
def evidence() -> Evidence:
    trial = walk("tripod", 0.3, 6.0, (TURNED, MOVED), noise_seed=2)
    study = make_study([trial], simulator())
    return study.evidence(study.local)


def yaw_fitted_to(seen: Evidence, start_rad: float) -> float:
    effect = next(one for one in simulator().effects if one.name == "pose_yaw_offset")
    start = Cause("pose_yaw_offset", (), (start_rad,))
    standing = np.full(len(seen.starts), 1e9)
    return fit_option(seen, Candidate(effect, ()), (start,), standing).cause.values[0]


def test_a_turn_is_found_though_one_hip_hides_it_at_its_own_leg() -> None:
    """Where that leg fits there is a minimum of its own, which a descent from nothing ends in."""
    start = cause("pose_yaw_offset", 0.0)
    stuck = fit_causes(evidence(), (start,)).causes[0].values[0]
    assert abs(stuck) < 0.02
    assert yaw_fitted_to(evidence(), 0.0) == pytest.approx(-0.1, abs=0.002)


def test_a_fit_that_least_squares_would_hardly_better_stays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """From the truth nothing begins again: what one hip leaves is not for a turn to explain."""
    found = yaw_fitted_to(evidence(), -0.1)
    monkeypatch.setattr(options, "MUCH_LESS", 0.0)
    assert yaw_fitted_to(evidence(), -0.1) == found
