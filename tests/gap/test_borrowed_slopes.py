"""A fit that begins with slopes of another one ends where it would without them, and asks for less."""

from collections.abc import Sequence

import numpy as np
import pytest

from gap.diagnosis.comparison.study import Study
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.residuals.parts import whole_parts
from gap.residuals.predictions import Predictor
from gap.search.fit import Fitted, fit_causes, free_values, slopes_of
from tests.gap.toy import EFFECTS, Toy, toy_trial

BY_NAME = {effect.name: effect for effect in EFFECTS}
TRUE = (
    Cause("lag", (), (0.05,)),
    Cause("stiffness", ("b",), (0.7,)),
    Cause("grip", ("c",), (1.4,)),
)


def fresh() -> Evidence:
    """The same trials each time, with nothing predicted yet."""
    toy = Toy()
    trials = [toy_trial(TRUE, 0.05 + 0.02 * i, "trot", seconds=30.0, seed=i) for i in range(2)]
    study = Study(Predictor(toy, trials), whole_parts(toy, trials))
    return study.evidence(study.local)


def fitted(start: Sequence[Cause], near: Fitted | None = None) -> tuple[Fitted, int]:
    """Fit them, and return how many predictions that took."""
    evidence = fresh()
    before = evidence.predictor.count
    return fit_causes(evidence, start, near=near), evidence.predictor.count - before


def neutral(name: str, *joints: str) -> Cause:
    return Cause(name, joints, tuple(p.neutral for p in BY_NAME[name].parameters))


@pytest.mark.parametrize("added", [TRUE[2], neutral("grip", "c"), neutral("tether")])
def test_slopes_of_a_fit_with_less_lead_to_the_same_fit(added: Cause) -> None:
    two, _ = fitted([neutral("lag"), neutral("stiffness", "b")])
    start = (*two.causes, added)
    plain, asked = fitted(start)
    near, now = fitted(start, two)
    far = added.values == neutral("grip").values
    assert now < asked or not far, "where it takes more than one step"
    assert near.nats == pytest.approx(plain.nats, abs=0.1)
    for one, other in zip(near.causes, plain.causes, strict=True):
        assert one.values == pytest.approx(other.values, abs=2e-3), one.effect


def test_slopes_that_point_elsewhere_do_no_harm() -> None:
    """The first step fails then, and the slopes are made."""
    start = (neutral("lag"), neutral("stiffness", "b"))
    plain, _ = fitted(start)
    wrong = Fitted(plain.causes, plain.residual, -plain.slopes, plain.away, plain.nats)
    near, _ = fitted(start, wrong)
    assert near.nats == pytest.approx(plain.nats, abs=0.1)
    for one, other in zip(near.causes, plain.causes, strict=True):
        assert one.values == pytest.approx(other.values, abs=2e-3)


@pytest.mark.parametrize("near_too", [False, True])
def test_slopes_at_the_end_are_those_of_the_fitted_values(near_too: bool) -> None:
    """Cross-validation and standard errors follow from them."""
    two, _ = fitted([neutral("lag"), neutral("stiffness", "b")])
    one, _ = fitted((*two.causes, neutral("grip", "c")), two if near_too else None)
    evidence = fresh()
    free = free_values(one.causes, evidence.effects)
    slopes = slopes_of(evidence, one.causes, free, one.residual)
    off = np.sqrt(((slopes - one.slopes) ** 2).sum(axis=(1, 2)) / (slopes**2).sum(axis=(1, 2)))
    assert (off < 0.04).all(), off


def test_only_what_is_not_known_is_predicted() -> None:
    evidence = fresh()
    causes = TRUE[:2]
    free = free_values(causes, evidence.effects)
    residual = evidence.residuals([causes])[0]
    before = evidence.predictor.count
    known = np.full(residual.shape, 3.0)
    slopes = slopes_of(evidence, causes, free, residual, known={0: known})
    assert evidence.predictor.count - before == len(evidence.parts), "one set of causes"
    assert (slopes[0] == 3.0).all()
    assert slopes[1].any()
