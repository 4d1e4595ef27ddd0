"""An effect that begins with the squares of its numbers, which no difference at neutral shows."""

import numpy as np
import pytest

from gap.diagnosis.comparison.detection import detectable
from gap.diagnosis.comparison.gap_evidence import compare
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause
from gap.search.fit import fit_causes
from gap.search.screen import gains
from model.effects.catalogue import EFFECTS as LEGGED
from record.trial.trial import Trial
from tests.gap.toy import BEND, CONDITIONS, EFFECTS, JOINTS, Toy, toy_case, toy_trial

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


def _trials(seed: int, *causes: Cause) -> list[Trial]:
    """Stiffness differs a little from day to day; nothing else is unlike."""
    days = 0.05 * np.random.default_rng(seed).standard_normal((4, len(JOINTS)))
    return [
        toy_trial(
            [
                *(Cause("stiffness", (j,), (1 + day,)) for j, day in zip(JOINTS, own, strict=True)),
                *causes,
            ],
            *CONDITIONS[at],
            seed=1000 * seed + at,
        )
        for at, own in enumerate(days)
    ]


def test_a_size_said_to_be_visible_is_found_and_half_of_it_is_not() -> None:
    """Its change goes with the square of its size."""
    references = [*_trials(1), *_trials(2)]
    healthy = compare(make_study(_trials(3), TOY, references), lambda _: None)
    assert healthy.known is not None
    nothing = fit_causes(healthy.evidence, ())
    sizes = detectable(healthy.evidence, healthy.signatures, healthy.known, nothing)
    (size,) = (one.size for one in sizes if one.effect == "bend")
    named = [
        diagnose(_trials(4, Cause("bend", (), (share * size,))), TOY, references).causes
        for share in (0.5, 1.0)
    ]
    assert [[one.effect for one in each] for each in named] == [[], ["bend"]]


def test_grip_along_and_across_is_such_an_effect_and_the_only_one() -> None:
    assert [name for name, one in LEGGED.items() if one.even] == ["friction_anisotropy"]
