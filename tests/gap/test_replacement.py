"""What takes a named cause's place: all rounds of a fit for what may be better, one for the rest."""

import pytest

import gap.search.replacement as replacement_module
from gap.diagnosis.study import Study
from gap.interfaces import Cause
from gap.residuals.parts import whole_parts
from gap.residuals.predictions import Predictor
from gap.search.candidates import Candidate, candidates_of
from gap.search.cross_validation import unseen_score
from gap.search.fit import fit_causes
from gap.search.look import Look, Search, Selection, Step
from gap.search.options import Option, fit_option
from gap.search.replacement import FEW_ROUNDS, replaced
from gap.search.screen import make_signatures
from tests.gap.toy import EFFECTS, Toy, toy_trial

BY_NAME = {effect.name: effect for effect in EFFECTS}
LAG, STIFFNESS = Cause("lag", (), (0.05,)), Cause("stiffness", ("b",), (0.7,))


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
