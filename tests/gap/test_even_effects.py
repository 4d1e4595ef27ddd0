"""An effect that begins with the squares of its numbers, which no difference at neutral shows."""

import numpy as np
import pytest

from gap.diagnosis.diagnose import diagnose
from gap.diagnosis.gap_evidence import compare
from gap.diagnosis.study import make_study
from gap.interfaces import Cause
from gap.search.screen import gains
from model.effects.catalogue import EFFECTS as LEGGED
from tests.gap.toy import BEND, EFFECTS, Toy, toy_case

TOY = Toy((*EFFECTS, BEND))


@pytest.mark.parametrize("size", [0.2, 0.5])
def test_it_gains_most_to_first_order_where_it_is_the_cause(size: float) -> None:
    trials = toy_case([Cause("bend", (), (size,))], 3)
    comparison = compare(make_study(trials, TOY, ()), lambda _: None)
    base = comparison.evidence.base
    best = gains(comparison.signatures, base, np.ones(base.shape))[0]
    assert best.signature.candidate.effect.name == "bend"
    assert best.values[0] == pytest.approx(size, rel=0.3)
    (named,) = diagnose(trials, TOY).causes
    assert named.effect == "bend"
    assert named.values[0].value == pytest.approx(size, rel=0.05)


def test_grip_along_and_across_is_such_an_effect_and_the_only_one() -> None:
    assert [name for name, one in LEGGED.items() if one.even] == ["friction_anisotropy"]
