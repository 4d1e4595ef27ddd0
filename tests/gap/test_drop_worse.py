"""Which causes held-out runs may drop, and which they may not."""

from collections.abc import Callable
from dataclasses import replace

import pytest

import gap.diagnosis.held_out.drop_worse as drop_module
from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.comparison.gap_evidence import GapEvidence, compare
from gap.diagnosis.comparison.how_far import HowFar, how_far
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.diagnosis.held_out import held_stage
from gap.diagnosis.held_out.drop_worse import drop_unclear, drop_worse
from gap.diagnosis.held_out.held_stage import helps_its_stage
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.residuals.vibration import ChannelVibration
from gap.search.candidates import Candidate
from gap.search.cross_validation import Advantage, unseen_score
from gap.search.fit import fit_causes
from gap.search.options import fit_option, worth
from gap.search.steps import Selection, Step
from tests.gap.toy import CHATTER, EFFECTS, SPEED_GAIN, Toy, toy_case, toy_references


def selected(comparison: GapEvidence, causes: list[Cause]) -> Selection:
    """Causes as if the search had taken them."""
    evidence = comparison.evidence
    effects = evidence.effects
    fitted = fit_causes(evidence, ())
    selection = Selection(fitted, unseen_score(evidence, fitted), ())
    for one in causes:
        added = Candidate(effects[one.effect], one.joints)
        start = (*selection.fitted.causes, one)
        option = fit_option(evidence, added, start, selection.unseen)
        steps = (*selection.steps, Step(option, ()))
        selection = Selection(option.fitted, option.unseen, steps)
    return selection


def all_worse(held: Evidence, causes: tuple[Cause, ...], seed: int) -> HowFar:
    """How far it shrinks, and that every cause makes it worse."""
    return replace(how_far(held, causes, seed), worse=(True,) * len(causes))


def test_a_cause_that_only_the_whole_chain_cannot_follow_stays(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """End to end every cause is said to make held-out runs worse; measured inputs know better of one."""
    true, made_up = Cause("stiffness", ("c",), (0.8,)), Cause("bias", ("a",), (0.1,))
    toy = Toy()
    study = make_study(toy_case([true], 3), toy, toy_references(3))
    comparison = compare(study, lambda _: None)

    monkeypatch.setattr(drop_module, "how_far", all_worse)
    left, _ = drop_worse(comparison, selected(comparison, [true, made_up]), 0)
    assert [one.effect for one in left.fitted.causes] == ["stiffness"]


@pytest.mark.parametrize("references", [3, 0])
def test_what_explains_most_of_its_channels_stays_though_cycles_differ_too_much_to_be_sure(
    references: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One of a few held-out cycles is unlike the others: their scatter says nothing clearly."""
    true, made_up = Cause("stiffness", ("c",), (0.8,)), Cause("bias", ("a",), (0.1,))
    study = make_study(toy_case([true], 3), Toy(), toy_references(3)[:references])
    comparison = compare(study, lambda _: None)

    def never_sure(over: Advantage, parameters: int, blocks: int) -> bool:
        return over.error == 0.0 and worth(over, parameters, blocks)

    monkeypatch.setattr(held_stage, "worth", never_sure)
    causes = selected(comparison, [true, made_up]).fitted.causes
    assert [helps_its_stage(comparison, causes, at) for at in (0, 1)] == [references > 0, False]


def test_the_reader_is_told_what_the_whole_chain_says(monkeypatch: pytest.MonkeyPatch) -> None:
    trials, references = toy_case([Cause("stiffness", ("c",), (0.8,))], 3), toy_references(3)
    assert not any("end to end" in one for one in diagnose(trials, Toy(), references).warnings)
    monkeypatch.setattr(drop_module, "how_far", all_worse)
    said = diagnose(trials, Toy(), references)
    assert [one.effect for one in said.causes] == ["stiffness"]
    assert any("end to end" in one for one in said.warnings)


def surely_worse(held: Evidence, causes: tuple[Cause, ...], seed: int) -> HowFar:
    """The same, and that they make the gap half as large again, beyond any doubt."""
    return replace(all_worse(held, causes, seed), shrink=-0.5, low=-0.6, high=-0.4)


def test_what_makes_held_out_runs_surely_worse_explains_nothing(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It may be there, as measured inputs say; but a simulator that has it predicts no better."""
    trials, references = toy_case([Cause("stiffness", ("c",), (0.8,))], 3), toy_references(3)
    assert diagnose(trials, Toy(), references).verdict is Verdict.EXPLAINED
    monkeypatch.setattr(drop_module, "how_far", surely_worse)
    said = diagnose(trials, Toy(), references)
    assert said.verdict is Verdict.UNEXPLAINED
    assert [one.effect for one in said.causes] == ["stiffness"]
    assert "but from commands alone a held-out run is predicted worse with it" in said.sentence


def all_idle(held: Evidence, causes: tuple[Cause, ...], seed: int) -> HowFar:
    """How far it shrinks, and that every cause adds nothing to the others."""
    far, none = how_far(held, causes, seed), (0.0,) * len(causes)
    return replace(far, worse=(False,) * len(causes), last=none, after=0.5 * far.before)


def beside_a_lag(monkeypatch: pytest.MonkeyPatch) -> tuple[GapEvidence, Selection]:
    """Without references, a stiffness and a tiny bias beside a lag; none adds anything to the others."""
    causes = [
        Cause("lag", (), (0.05,)),
        Cause("stiffness", ("c",), (0.8,)),
        Cause("bias", ("a",), (0.02,)),
    ]
    comparison = compare(make_study(toy_case(causes, 3), Toy(), ()), lambda _: None)
    monkeypatch.setattr(drop_module, "how_far", all_idle)
    return comparison, selected(comparison, causes)


def test_with_references_what_adds_nothing_stays_only_if_it_clearly_helps_its_stage(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """In what a large cause leaves, chance finds others: they add nothing to held-out runs."""
    true, made_up = Cause("stiffness", ("c",), (0.8,)), Cause("bias", ("a",), (0.1,))
    study = make_study(toy_case([true], 3), Toy(), toy_references(3))
    comparison = compare(study, lambda _: None)
    monkeypatch.setattr(drop_module, "how_far", all_idle)
    left, _ = drop_worse(comparison, selected(comparison, [true, made_up]), 0)
    assert [one.effect for one in left.fitted.causes] == ["stiffness"]


@pytest.mark.parametrize(("p", "stays"), [(0.01, True), (0.1, False)])
def test_with_references_what_adds_nothing_must_be_as_new_as_a_first_cause(
    p: float, stays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Behind a first cause the level is higher, and one in five healthy sets shows something there."""
    both = [Cause("stiffness", ("c",), (0.8,)), Cause("bias", ("a",), (0.3,))]
    comparison = compare(make_study(toy_case(both, 3), Toy(), toy_references(3)), lambda _: None)
    selection = selected(comparison, both)
    steps = tuple(replace(one, p=own) for one, own in zip(selection.steps, (0.0, p), strict=True))
    monkeypatch.setattr(drop_module, "how_far", all_idle)
    left, _ = drop_worse(comparison, replace(selection, steps=steps), 0)
    assert ("bias" in {one.effect for one in left.fitted.causes}) is stays


@pytest.mark.parametrize(("judge", "stays"), [(all_idle, True), (all_worse, False)])
def test_what_surely_vibrates_may_add_nothing_but_not_make_it_worse(
    judge: Callable[[Evidence, tuple[Cause, ...], int], HowFar], stays: bool,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """What feet that stick and slip grip in the mean may be another in each gait."""
    true, shaking = Cause("stiffness", ("c",), (0.8,)), Cause("chatter", (), (1.01,))
    toy = Toy((*EFFECTS, SPEED_GAIN, CHATTER))
    study = make_study(toy_case([true], 3), toy, toy_references(3))
    comparison = compare(study, lambda _: None)
    selection = selected(comparison, [true, shaking])
    calm, step = selection.steps
    seen = replace(step.chosen.added, vibration=ChannelVibration(("speed",), 2.0, 7.0, 1e-4))
    assert seen.vibrates
    steps = (calm, replace(step, chosen=replace(step.chosen, added=seen)))
    monkeypatch.setattr(drop_module, "how_far", judge)
    for one, named in ((selection, False), (replace(selection, steps=steps), stays)):
        left, _ = drop_worse(comparison, one, 0)
        assert ("chatter" in {cause.effect for cause in left.fitted.causes}) == named


def test_without_references_what_adds_nothing_to_the_whole_stays_if_it_clearly_helps_its_stage(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Beside a servo that lags, which is nearly all of a gap, a scale that is off by a fifth is nothing."""
    comparison, all_three = beside_a_lag(monkeypatch)
    left, _ = drop_worse(comparison, all_three, 0)
    assert {one.effect for one in left.fitted.causes} == {"lag", "stiffness"}


def test_without_references_a_small_cause_that_adds_nothing_to_the_whole_is_dropped() -> None:
    """A simulator with a wrong law asks for a little of everything."""
    lag, stiffness = Cause("lag", (), (0.05,)), Cause("stiffness", ("c",), (0.8,))
    tiny = Cause("bias", ("a",), (0.1,))  # a third of its spread, twice the noise
    trials = toy_case([lag, stiffness, tiny], 3)
    alone = compare(make_study(trials, Toy(), ()), lambda _: None)
    left, _ = drop_worse(alone, selected(alone, [lag, stiffness, tiny]), 0)
    assert {one.effect for one in left.fitted.causes} == {"lag", "stiffness"}
    known = compare(make_study(trials, Toy(), toy_references(3)), lambda _: None)
    left, _ = drop_worse(known, selected(known, [lag, stiffness, tiny]), 0)
    assert {one.effect for one in left.fitted.causes} == {"lag", "stiffness", "bias"}


def test_without_references_a_law_stays_if_it_clearly_helps_its_stage(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It has no size that could be small, however little of its stage is left for it to explain."""
    lag, law = Cause("lag", (), (0.05,)), Cause("square_law", (), ())
    comparison = compare(make_study(toy_case([lag, law], 3), Toy(), ()), lambda _: None)
    monkeypatch.setattr(drop_module, "how_far", all_idle)
    monkeypatch.setattr(drop_module, "HELD_OUT_STAGE", 2.0)
    monkeypatch.setattr(drop_module, "HELD_OUT_SIZEABLE", 2.0)
    monkeypatch.setattr(drop_module, "HELD_OUT_MOST", 2.0)
    left, _ = drop_worse(comparison, selected(comparison, [lag, law]), 0)
    assert [one.effect for one in left.fitted.causes] == ["square_law"]


@pytest.mark.parametrize(("share", "stays"), [(0.6, True), (0.4, False)])
def test_without_references_a_large_cause_stays_if_it_is_most_of_what_its_channels_show(
    share: float, stays: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A patch of the ground acts on few feet at a time: it is little of its stage."""
    lag, stiffness = Cause("lag", (), (0.05,)), Cause("stiffness", ("c",), (0.8,))
    comparison = compare(make_study(toy_case([lag, stiffness], 3), Toy(), ()), lambda _: None)
    monkeypatch.setattr(drop_module, "how_far", all_idle)
    monkeypatch.setattr(drop_module, "HELD_OUT_STAGE", 2.0)
    monkeypatch.setattr(drop_module, "HELD_OUT_SIZEABLE", 2.0)
    monkeypatch.setattr(
        drop_module,
        "share_of_stage",
        lambda _, causes, at: 1.0 if causes[at].effect == "lag" else share,
    )
    left, _ = drop_worse(comparison, selected(comparison, [lag, stiffness]), 0)
    assert ("stiffness" in {one.effect for one in left.fitted.causes}) == stays


def test_without_references_what_helped_beside_others_stays_when_these_are_dropped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With fewer next to it, it may seem to help less."""
    comparison, all_three = beside_a_lag(monkeypatch)
    monkeypatch.setattr(drop_module, "agrees", lambda _, causes, *__: len(causes) == 3)
    left, _ = drop_worse(comparison, all_three, 0)
    assert {one.effect for one in left.fitted.causes} == {"lag", "stiffness"}


def test_without_references_a_large_cause_needs_a_smaller_part_of_its_stage(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stiffness, weaker = Cause("stiffness", ("c",), (0.7,)), Cause("stiffness", ("a",), (0.85,))
    trials = toy_case([stiffness, weaker], 3)
    comparison = compare(make_study(trials, Toy(), ()), lambda _: None)
    monkeypatch.setattr(drop_module, "how_far", all_idle)
    monkeypatch.setattr(drop_module, "HELD_OUT_STAGE", 2.0)  # more than any cause has
    left, _ = drop_worse(comparison, selected(comparison, [stiffness, weaker]), 0)
    assert [one.joints for one in left.fitted.causes] == [("c",)]


@pytest.mark.parametrize(("references", "kept"), [(6, ["stiffness"]), (0, ["stiffness"])])
def test_of_several_causes_one_that_may_be_nothing_is_not_named(
    references: int, kept: list[str]
) -> None:
    """Without references, which say how much its size scatters, only if it surely is."""
    true, little = Cause("stiffness", ("c",), (0.8,)), Cause("bias", ("a",), (0.001,))
    study = make_study(toy_case([true], 3), Toy(), toy_references(6)[:references])
    comparison = compare(study, lambda _: None)
    selection = selected(comparison, [true, little])
    far = how_far(comparison.held, selection.fitted.causes, 0)
    left, again = drop_unclear(comparison, selection, far, 0)
    assert [one.effect for one in left.fitted.causes] == kept
    assert len(again.last) == len(kept)
    alone, _ = drop_unclear(comparison, selected(comparison, [little]), far, 0)
    assert [one.effect for one in alone.fitted.causes] == ["bias"], "it is what is known of the gap"


def test_one_alone_that_may_be_nothing_is_no_gap_unless_energies_show_one() -> None:
    """A single healthy run had a gap by a cause of 1.1e-5 +- 0.6e-5, one of many that were tried."""
    little = Cause("bias", ("a",), (0.001,))
    comparison = compare(make_study(toy_case([], 3), Toy(), toy_references(6)), lambda _: None)
    found = selected(comparison, [little])
    found = replace(found, p=0.01)
    far = how_far(comparison.held, found.fitted.causes, 0)
    left, again = drop_unclear(comparison, found, far, 0)
    assert left.steps == ()
    assert left.p > 0.5
    assert left.nearest is found.steps[0].chosen
    assert again.last == ()


@pytest.mark.parametrize(
    ("idle", "references", "kept"), [(True, 6, 1), (False, 6, 2), (True, 0, 2)]
)
def test_one_that_adds_nothing_is_not_named_if_it_is_as_likely_nothing_as_not(
    monkeypatch: pytest.MonkeyPatch, idle: bool, references: int, kept: int
) -> None:
    true, little = Cause("stiffness", ("c",), (0.8,)), Cause("bias", ("a",), (0.001,))
    study = make_study(toy_case([true], 3), Toy(), toy_references(6)[:references])
    comparison = compare(study, lambda _: None)
    selection = selected(comparison, [true, little])
    monkeypatch.setattr(
        drop_module, "clear_of_nothing", lambda one, *_: (1.0, 0.3)[: len(one.steps)]
    )
    far = how_far(comparison.held, selection.fitted.causes, 0)
    far = replace(far, last=(0.6, 0.001 if idle else 0.02))
    left, _ = drop_unclear(comparison, selection, far, 0)
    assert len(left.steps) == kept
