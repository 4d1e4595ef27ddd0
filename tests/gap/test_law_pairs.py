"""Laws without a size that explain nothing by themselves, and much with their partner."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gap.diagnosis.comparison.commissioning import standing_of
from gap.diagnosis.comparison.study import Study
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.residuals.parts import whole_parts
from gap.residuals.predictions import Predictor
from gap.search.candidates import Candidate
from gap.search.fit import fit_causes
from gap.search.options import Option, fit_option
from gap.search.steps import Selection
from tests.gap.toy import EFFECTS, RISE, Toy, toy_case

LAW, PARTNER = Cause("square_law", (), ()), Cause("rise", (), (-1.6, 0.2))


def test_a_law_that_is_worse_than_none_alone_is_found_with_its_partner() -> None:
    toy = Toy((*EFFECTS, RISE))
    references = toy_case([LAW, PARTNER], seed=1)
    parts = whole_parts(toy, references)
    study = Study(Predictor(toy, references), parts)
    evidence = study.loose_evidence(study.local)

    def score(*causes: Cause) -> float:
        return float(evidence.score(fit_causes(evidence, causes).residual).sum())

    assert score(LAW) > score(), "alone it is worse than none"
    assert score(PARTNER) > 0.9 * score(), "its partner alone is worth little"
    law, partner = standing_of(references, toy)
    assert law == LAW
    assert partner.effect == "rise"
    assert partner.values == pytest.approx((-1.6, 0.2), abs=0.02)


@given(st.floats(0.01, 1000.0), st.integers(0, 1000))
@settings(max_examples=30)
def test_a_law_gains_no_more_than_its_change_could_at_the_best_place(
    left: float, seed: int
) -> None:
    """Whatever is left, taking a change of the prediction off it gains less than the bound."""
    evidence, before, law = law_alone()
    change = law.fitted.residual - before.fitted.residual
    draws = np.random.default_rng(seed)
    bound = evidence.most_gained(change)
    gains = [
        float((evidence.score(residual) - evidence.score(residual - change)).sum())
        for residual in (
            left * draws.normal(size=change.shape),
            left * change,
            change * (1.0 + left * draws.uniform(size=change.shape)),
        )
    ]
    assert 0.0 < max(gains) <= bound


@cache
def law_alone() -> tuple[Evidence, Selection, Option]:
    """Evidence of a healthy machine, the empty selection, and a law added to it."""
    toy = Toy((*EFFECTS, RISE))
    references = toy_case([LAW, PARTNER], seed=1)
    study = Study(Predictor(toy, references), whole_parts(toy, references))
    evidence = study.loose_evidence(study.local)
    nothing = fit_causes(evidence, ())
    unseen = evidence.score(nothing.residual).sum(axis=1)
    effect = next(e for e in toy.effects if e.name == LAW.effect)
    option = fit_option(evidence, Candidate(effect, ()), (LAW,), unseen)
    return evidence, Selection(nothing, unseen, ()), option


def test_a_healthy_machine_has_no_law_and_no_partner() -> None:
    toy = Toy((*EFFECTS, RISE))
    assert standing_of(toy_case(seed=1), toy) == ()
