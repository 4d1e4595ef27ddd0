"""Candidates by what they gain at a few sizes: to first order a large one looks small, and like another."""

import numpy as np
import pytest

from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import candidates_of
from gap.search.fit import Fitted, fit_causes
from gap.search.options import as_they_act
from gap.search.screen import Gain, gains, make_signatures
from tests.gap.test_selection import evidences
from tests.gap.toy import BUMP, EFFECTS, Toy, toy_case

TOY = Toy((*EFFECTS, BUMP))


def ranked_for(*causes: Cause) -> tuple[Evidence, Fitted, list[Gain]]:
    found, _ = evidences(TOY, toy_case(causes, seed=4), [])
    nothing = fit_causes(found, ())
    signatures = make_signatures(found, candidates_of(TOY), (), lambda _: None)
    return found, nothing, gains(signatures, nothing.residual, found.weights(nothing.residual))


def test_a_large_delay_is_a_lag_to_first_order_and_a_delay_as_it_acts() -> None:
    """Of 0.4 s the slope at 0 asks for 0.07 s; on that way it gains eighty times as much."""
    found, nothing, ranked = ranked_for(Cause("delay", (), (0.4,)))
    assert ranked[0].signature.candidate.effect.name == "lag"
    best, *_ = as_they_act(found, nothing, ranked)
    assert best.gain.signature.candidate.effect.name == "delay"
    assert best.gain.values == pytest.approx((0.4,), rel=0.1)
    slope = next(one for one in ranked if one.signature.candidate.effect.name == "delay")
    assert slope.values[0] < 0.1
    assert best.gain.nats > 10 * slope.nats


def test_what_is_gained_is_predicted() -> None:
    found, nothing, ranked = ranked_for(Cause("stiffness", ("a",), (8.0,)))
    for one in as_they_act(found, nothing, ranked):
        cause = one.gain.signature.candidate.cause(one.gain.values)
        left = found.score(found.residuals([(cause,)])[0]).sum()
        before = found.score(nothing.residual).sum()
        assert one.gain.nats == pytest.approx(before - left, abs=1e-6 * before)
        assert 0.0 <= one.share <= 1.0


def test_places_stay_where_they_are_and_numbers_within_their_bounds() -> None:
    both = (Cause("stiffness", ("a",), (8.0,)), Cause("tether", (), (2.0,)))
    found, nothing, ranked = ranked_for(*both)
    first = {one.signature.candidate.key: one.values for one in ranked}
    higher = 0
    for one in as_they_act(found, nothing, ranked):
        candidate, values = one.gain.signature.candidate, one.gain.values
        for p, value in zip(candidate.effect.parameters, values, strict=True):
            assert p.lower <= value <= p.upper
        if candidate.effect.name == "bump":
            height, place = first[candidate.key]
            assert values[1] == place
            higher += abs(values[0]) > abs(height)
    assert higher > 0


def test_only_the_first_few_are_looked_at() -> None:
    found, nothing, ranked = ranked_for(Cause("tether", (), (2.0,)))
    walked = as_they_act(found, nothing, ranked, 3)
    assert {one.gain.signature for one in walked} == {one.signature for one in ranked[:3]}
    assert np.all(np.diff([one.gain.nats for one in walked]) <= 0.0)
