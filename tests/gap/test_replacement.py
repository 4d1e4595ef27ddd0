"""What takes a named cause's place: all rounds of a fit for what may be better, one for the rest."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import pytest

import gap.search.replacement as replacement_module
from gap.diagnosis.comparison.study import Study
from gap.interfaces import Cause, Drive, Effect, Scope
from gap.residuals.parts import whole_parts
from gap.residuals.predictions import Predictor
from gap.residuals.vibration import ChannelVibration
from gap.search.candidates import Candidate, candidates_of
from gap.search.cross_validation import unseen_score
from gap.search.fit import fit_causes
from gap.search.look import Look
from gap.search.options import Option, fit_option
from gap.search.replacement import FEW_ROUNDS, replaced
from gap.search.screen import make_signatures
from gap.search.selection import widened
from gap.search.steps import Search, Selection, Step
from model.effects.causes import Shaking
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.toy import EFFECTS, Toy, toy_effect, toy_trial

BY_NAME = {effect.name: effect for effect in EFFECTS}
LAG, STIFFNESS = Cause("lag", (), (0.05,)), Cause("stiffness", ("b",), (0.7,))
LATE = toy_effect(
    "late", "drive", Scope.ALL, *BY_NAME["lag"].parameters, *BY_NAME["delay"].parameters
)


def test_what_is_hopeless_gets_one_round(monkeypatch: pytest.MonkeyPatch) -> None:
    """A lag is as good as a delay; nothing takes the place of a stiffness."""
    toy = Toy()
    trials = [toy_trial([LAG, STIFFNESS], 0.05, "trot", seconds=30.0, seed=1)]
    study = Study(Predictor(toy, trials), whole_parts(toy, trials))
    evidence = study.evidence(study.local)
    nothing = fit_causes(evidence, ())
    unseen, steps = unseen_score(evidence, nothing), []
    causes: tuple[Cause, ...] = ()
    for added in (Cause("delay", (), (0.05,)), STIFFNESS):
        candidate = Candidate(BY_NAME[added.effect], added.joints)
        option = fit_option(evidence, candidate, (*causes, added), unseen)
        unseen, causes = option.unseen, option.fitted.causes
        steps.append(Step(option, ()))
    selection = Selection(option.fitted, unseen, tuple(steps))
    asked: list[tuple[str, int]] = []

    def counted(*args: object) -> Option:
        option = fit_option(*args)  # type: ignore[arg-type]
        asked.append((option.added.effect.name, int(args[4])))  # type: ignore[call-overload]
        return option

    monkeypatch.setattr(replacement_module, "fit_option", counted)
    monkeypatch.setattr(replacement_module, "NEAR_AS_GOOD", 0.0)
    signatures = make_signatures(evidence, candidates_of(toy), (), lambda share: None)
    replaced(Look(evidence, None, Search()), selection, signatures)
    assert asked[:2] == [("lag", 1), ("lag", FEW_ROUNDS - 1)]
    assert len(asked) > 2
    assert all(name not in {"lag", "delay"} and rounds == 1 for name, rounds in asked[2:])
    late, stiff = selection.steps
    shaken = replace(
        late.chosen.added,
        effect=replace(late.chosen.added.effect, shaking=Shaking(("angle",), (), ())),
        vibration=ChannelVibration(("angle",), 2.0, 7.0, 1e-4),
    )
    asked.clear()
    seen = (replace(late, chosen=replace(late.chosen, added=shaken)), stiff)
    replaced(Look(evidence, None, Search()), replace(selection, steps=seen), signatures)
    assert asked, "another in the place of the stiffness is looked for"
    assert "lag" not in {name for name, _ in asked}, "what vibrates was not chosen by its fit"


@dataclass(eq=False)
class Late(Toy):
    """A toy with an effect that has the numbers of its lag and of its delay."""

    catalogue: tuple[Effect, ...] = (*EFFECTS, LATE)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        plain = [
            own
            for one in causes
            for own in (
                (Cause("lag", (), one.values[:1]), Cause("delay", (), one.values[1:]))
                if one.effect == LATE.name
                else (one,)
            )
        ]
        return super().predict(trial, plain, drive)


@pytest.mark.parametrize("delay_s", [0.0, 0.08])
def test_an_effect_with_a_causes_numbers_and_more_takes_its_place_if_that_is_better(
    delay_s: float,
) -> None:
    """A wider effect that explains no more leaves the cause as it was."""
    toy = Late()
    true = [LAG, Cause("delay", (), (delay_s,))]
    trials = [toy_trial(true, 0.3, gait, seed=2) for gait in ("trot", "walk")]
    study = Study(Predictor(toy, trials), whole_parts(toy, trials))
    evidence = study.evidence(study.local)
    candidates = [Candidate(BY_NAME["lag"], ()), Candidate(LATE, ())]
    signatures = make_signatures(evidence, candidates, (), lambda share: None)
    nothing = fit_causes(evidence, ())
    narrow = fit_option(evidence, candidates[0], (LAG,), unseen_score(evidence, nothing))
    selection = Selection(narrow.fitted, narrow.unseen, (Step(narrow, ()),))
    look = Look(evidence, None, Search())
    found = widened(look, selection, candidates, signatures, lambda share: None)
    if not delay_s:
        assert found is selection
        return
    (cause,) = found.fitted.causes
    assert cause.effect == LATE.name
    assert cause.values == pytest.approx((0.05, 0.08), abs=0.005)
    assert [one.added.effect.name for one in found.steps[0].rivals] == ["lag"]
