"""Laws without a size that explain nothing by themselves, and much with their partner."""

import pytest

from gap.diagnosis.commissioning import standing_of
from gap.diagnosis.study import Study
from gap.interfaces import Cause
from gap.residuals.parts import whole_parts
from gap.residuals.predictions import Predictor
from gap.search.fit import fit_causes
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


def test_a_healthy_machine_has_no_law_and_no_partner() -> None:
    toy = Toy((*EFFECTS, RISE))
    assert standing_of(toy_case(seed=1), toy) == ()
