"""A limit that one trial alone reaches: the others know nothing of it, and it is found all the same."""

from functools import cache

import numpy as np
import pytest

from gap.diagnosis.comparison.study import Study
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.residuals.parts import whole_parts
from gap.residuals.predictions import Predictor
from gap.search.candidates import FINE_BELOW, Candidate, fine_step
from gap.search.cross_validation import unseen_score
from gap.search.fit import fit_causes
from gap.search.options import Option, fit_option, worth
from tests.gap.walks import cause, simulator, walk

LIMIT = cause("servo_speed_limit", 2.4)
TURN = cause("pose_yaw_offset", 0.05)


@cache
def trials(truth: Cause) -> Evidence:
    """Two slow walks and a fast one, which alone asks for 2.4 rad/s."""
    runs = [
        walk("tripod", hz, 12.0, (truth,), noise_seed=i) for i, hz in enumerate((0.1, 0.1, 0.3))
    ]
    study = Study(Predictor(simulator(), runs), whole_parts(simulator(), runs))
    return study.evidence(study.local)


def option(truth: Cause, start: Cause) -> Option:
    evidence = trials(truth)
    effect = next(one for one in simulator().effects if one.name == start.effect)
    nothing = unseen_score(evidence, fit_causes(evidence, ()))
    return fit_option(evidence, Candidate(effect, ()), (start,), nothing)


def gained_in_each(truth: Cause, found: Option) -> list[float]:
    evidence = trials(truth)
    nothing = unseen_score(evidence, fit_causes(evidence, ()))
    gained: list[float] = np.bincount(evidence.block_part, nothing - found.unseen).tolist()
    return gained


def test_its_other_cycles_judge_a_limit_that_one_trial_reaches() -> None:
    found = option(LIMIT, cause("servo_speed_limit", 2.3))
    assert found.cause.values[0] == pytest.approx(2.4, abs=0.02)
    assert worth(found.over, 1, len(found.unseen))
    slow, as_slow, fast = gained_in_each(LIMIT, found)
    assert abs(slow) < 1.0
    assert abs(as_slow) < 1.0
    assert fast > 100.0


def test_what_all_trials_show_is_judged_by_the_others() -> None:
    """A limit that is not there gains nothing, and what is everywhere is left out trial by trial."""
    found = option(TURN, cause("servo_speed_limit", 2.3))
    assert not worth(found.over, 1, len(found.unseen))
    turned = option(TURN, TURN)
    assert worth(turned.over, 1, len(turned.unseen))
    assert min(gained_in_each(TURN, turned)) > 5.0


def test_the_slope_of_a_limit_is_short_and_to_where_it_shows_more() -> None:
    (limit,) = next(
        one for one in simulator().effects if one.name == "servo_speed_limit"
    ).parameters
    (turn,) = next(one for one in simulator().effects if one.name == "pose_yaw_offset").parameters
    assert fine_step(limit, 2.0, 0.05) == pytest.approx(-2.0 * FINE_BELOW)
    assert fine_step(limit, limit.lower, 0.05) == pytest.approx(limit.lower * FINE_BELOW)
    assert fine_step(turn, 0.0, 0.05) == pytest.approx(0.05 * turn.spread)
