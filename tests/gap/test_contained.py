"""A cause that passes the level, beside a better one that missed it by little."""

from dataclasses import replace

import pytest

from gap.constants import OPEN_LEVEL
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate
from gap.search.contained import containing
from gap.search.cross_validation import unseen_score
from gap.search.fit import fit_causes
from gap.search.options import Option, fit_option
from tests.gap.test_selection import evidences
from tests.gap.toy import EFFECTS, Toy, toy_case, toy_references
from tests.gap.walks import cause

BY_NAME = {effect.name: effect for effect in EFFECTS}
NEARLY = 1.5 * 0.04  # beyond the level of a cause, within that of an open gap


def _option(evidence: Evidence, start: Cause) -> Option:
    nothing = unseen_score(evidence, fit_causes(evidence, ()))
    return fit_option(evidence, Candidate(BY_NAME[start.effect], start.joints), (start,), nothing)


@pytest.fixture(scope="module")
def evidence() -> Evidence:
    """A machine whose commands are late, and that is pulled a little."""
    true = (cause("delay", 0.05), cause("tether", 0.05))
    return evidences(Toy(), toy_case(true, seed=3), toy_references(4))[0]


@pytest.fixture(scope="module")
def late(evidence: Evidence) -> Option:
    return _option(evidence, cause("delay", 0.03))


def test_what_explains_more_and_the_same_is_named_instead(evidence: Evidence, late: Option) -> None:
    lag = _option(evidence, cause("lag", 0.03))
    assert 0.0 < lag.over.nats < late.over.nats
    assert containing(evidence, lag, [(late, NEARLY)]) is late


def test_what_healthy_runs_may_well_show_is_not(evidence: Evidence, late: Option) -> None:
    lag = _option(evidence, cause("lag", 0.03))
    assert containing(evidence, lag, [(late, float(OPEN_LEVEL))]) is lag
    assert containing(evidence, lag, []) is lag


def test_nor_is_what_explains_something_else(evidence: Evidence, late: Option) -> None:
    pull = _option(evidence, cause("tether", 0.05))
    assert 0.0 < pull.over.nats < late.over.nats
    assert containing(evidence, pull, [(late, NEARLY)]) is pull


def test_nor_is_what_explains_less(evidence: Evidence, late: Option) -> None:
    lag = _option(evidence, cause("lag", 0.03))
    assert containing(evidence, late, [(lag, NEARLY)]) is late


def test_nor_is_what_lies_on_a_bound_of_its_values(evidence: Evidence, late: Option) -> None:
    lag = _option(evidence, cause("lag", 0.03))
    (value,) = late.cause.values
    (delay_s,) = late.added.effect.parameters
    tight = replace(late.added.effect, parameters=(replace(delay_s, upper=value),))
    stuck = replace(late, added=replace(late.added, effect=tight))
    assert containing(evidence, lag, [(stuck, NEARLY)]) is lag
    assert containing(evidence, lag, [(stuck, NEARLY), (late, NEARLY)]) is late
