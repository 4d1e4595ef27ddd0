"""An edge on the ground that no foot crossed is no edge: less grip everywhere is not a patch of it."""

from functools import cache

import numpy as np
import pytest

from gap.diagnosis.comparison.study import make_study
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate
from gap.search.edges import limits_as_they_act, with_seen_edges
from gap.search.options import Option, fit_option
from gap.search.screen import Gain, gains, make_signatures
from tests.gap.walks import cause, simulator, walk

LEVEL, PATCH = cause("friction_level", 0.7), cause("friction_patch", 0.7, 0.1)


@cache
def evidence(truth: Cause) -> Evidence:
    trial = walk("tripod", 0.3, 6.0, (truth,), noise_seed=2)
    study = make_study([trial], simulator())
    return study.evidence(study.local)


def option(seen: Evidence, start: Cause) -> Option:
    effect = next(one for one in simulator().effects if one.name == start.effect)
    standing = np.full(len(seen.starts), 1e9)
    return fit_option(seen, Candidate(effect, ()), (start,), standing)


def names(truth: Cause, *starts: Cause) -> list[str]:
    seen = evidence(truth)
    return [
        one.added.effect.name for one in with_seen_edges(seen, [option(seen, s) for s in starts])
    ]


BEFORE = cause("friction_patch", 0.8, -0.9)


def test_a_patch_below_all_feet_is_no_alternative_to_less_grip() -> None:
    assert names(LEVEL, BEFORE, LEVEL) == ["friction_level"]


def test_a_patch_whose_edge_feet_crossed_stays() -> None:
    assert names(PATCH, PATCH, LEVEL) == ["friction_patch", "friction_level"]


def test_a_patch_without_another_explanation_stays() -> None:
    assert names(LEVEL, BEFORE) == ["friction_patch"]
    assert names(LEVEL, BEFORE, cause("drag", 50.0)) == ["friction_patch", "drag"]


def best_limit(truth: Cause, *, from_farthest_behind: bool) -> Gain:
    """The best first start of a limit, of a walk on a curve, from its start or from a late moment."""
    trial = walk("metachronal", 0.15, 14.0, (truth,), steer=-0.2, noise_seed=2)
    if from_farthest_behind:
        at = trial.header.joints.index(truth.joints[0])
        behind = np.abs(trial.shaft_rad[:, at] - trial.command_rad[:, at])
        trial = trial.rows(np.arange(len(behind)) >= np.argmax(behind))
    study = make_study([trial], simulator())
    seen = study.evidence(study.local)
    effect = next(one for one in simulator().effects if one.name == truth.effect)
    wanted = [Candidate(effect, place) for place in ((), ("ML",), ("FR",))]
    made = make_signatures(seen, wanted, (), lambda share: None)
    ranked = gains(made, seen.base, seen.weights(seen.base))
    return limits_as_they_act(seen, seen.base, made, ranked)[0]


@pytest.mark.parametrize(("limit_rad_s", "late"), [(1.3, False), (1.2, False), (1.2, True)])
def test_a_limit_is_found_at_the_edge_of_its_own_joint(limit_rad_s: float, late: bool) -> None:
    """On a curve the legs of one side turn faster: what they hardly reach, others never do.

    A walk that is recorded from where the shaft is far behind shows far higher limits, too, for a moment.
    """
    best = best_limit(
        cause("servo_speed_limit", limit_rad_s, legs=("ML",)), from_farthest_behind=late
    )
    assert best.signature.candidate.joints == ("ML",)
    assert abs(best.values[0] - limit_rad_s) < 0.2
