"""Candidates by what they gain at a few sizes: to first order a large one looks small, and like another."""

from dataclasses import replace

import pytest

from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import candidates_of
from gap.search.cross_validation import unseen_score
from gap.search.fit import Fitted, fit_causes
from gap.search.look import Look
from gap.search.options import _walk, as_they_act
from gap.search.screen import Gain, Signature, gains, make_signatures
from gap.search.selection import WHOLE_SEARCH
from gap.search.steps import Selection
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


def test_what_is_gained_is_predicted_less_what_its_size_costs() -> None:
    found, nothing, ranked = ranked_for(Cause("stiffness", ("a",), (8.0,)))
    for one in as_they_act(found, nothing, ranked):
        candidate, values = one.gain.signature.candidate, one.gain.values
        pairs = zip(candidate.effect.parameters, values, strict=True)
        cost = sum(0.5 * ((value - p.neutral) / p.spread) ** 2 for p, value in pairs)
        left = found.score(found.residuals([(candidate.cause(values),)])[0]).sum()
        before = found.score(nothing.residual).sum()
        assert one.gain.nats == pytest.approx(before - left - cost, abs=1e-6 * before)


@pytest.mark.parametrize(
    ("name", "first", "sizes"),
    [
        ("tether", (0.2,), [(0.2,), (0.5,), (1.2,)]),
        ("stiffness", (0.8,), [(0.8,), (0.8**2.5,), (0.8**6,)]),  # a ratio
        ("bump", (0.3, 0.2), [(0.3, 0.2), (0.75, 0.2), (1.8, 0.2)]),  # its place stays
        ("delay", (4.0,), [(4.0,)]),  # farther ones are beyond its bound
        ("square_law", (), [()]),  # there or not
    ],
)
def test_sizes_that_are_tried(
    name: str, first: tuple[float, ...], sizes: list[tuple[float, ...]]
) -> None:
    candidate = next(one for one in candidates_of(TOY) if one.effect.name == name)
    tried = _walk(Gain(Signature(candidate, candidate.neutral, (), (), -1), first, 1.0))
    assert len(tried) == len(sizes)
    for values, size in zip(tried, sizes, strict=True):
        assert values == pytest.approx(size)


def test_the_search_fits_it_where_no_reference_helps_and_only_there() -> None:
    """The others are as they were: where healthy runs explain the rest, first order is right."""
    found, _, _ = ranked_for(Cause("delay", (), (0.4,)))
    signatures = make_signatures(found, candidates_of(TOY), (), lambda _: None)
    nothing = fit_causes(found, ())
    selection = Selection(nothing, unseen_score(found, nothing), ())
    for walk, values in ((True, 0.42), (False, 0.07)):
        forms = Look(found, None, replace(WHOLE_SEARCH, walk=walk))._forms(selection, signatures)
        listed = {family[0]: own[0].values[0] for family, own in forms.items() if own[0].values}
        assert listed["delay"] == pytest.approx(values, rel=0.05)
        assert next(iter(forms))[0] == ("delay" if walk else "lag")
