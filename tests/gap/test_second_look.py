"""What a second look without references adds to causes that are named, and what it leaves."""

from dataclasses import replace

import pytest

import gap.diagnosis.held_out.demand as demand
import gap.diagnosis.held_out.second_look as looking
import gap.search.unlike as unlike
from gap.diagnosis.comparison.gap_evidence import GapEvidence, compare
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.held_out.second_look import second_look
from gap.interfaces import Cause, Effect, Scope
from tests.gap.test_drop_worse import selected
from tests.gap.toy import BUMP, EFFECTS, RISE, Toy, toy_case, toy_references

KNOWN = tuple(one for one in EFFECTS if one.name in {"delay", "lag"})
LAG = Cause("lag", (), (0.05,))


def compared(
    causes: list[Cause], seed: int = 3, catalogue: tuple[Effect, ...] = EFFECTS
) -> GapEvidence:
    return compare(make_study(toy_case(causes, seed), Toy(catalogue), ()), lambda _: None)


def added(comparison: GapEvidence, named: list[Cause]) -> list[tuple[str, tuple[str, ...]]]:
    more = second_look(comparison, selected(comparison, named))
    return [(one.effect, one.joints) for one in more.fitted.causes][len(named) :]


def test_an_effect_of_the_whole_machine_that_was_not_named_is_added() -> None:
    tether = Cause("tether", (), (0.3,))
    assert added(compared([LAG, tether]), [LAG]) == [("tether", ())]


def test_a_joint_unlike_the_others_is_added(monkeypatch: pytest.MonkeyPatch) -> None:
    """The toy has three joints, so two are others; with one degree of freedom only much stands out."""
    monkeypatch.setattr(unlike, "FEWEST_OTHERS", 2)
    stiffness = Cause("stiffness", ("c",), (0.4,))
    assert added(compared([LAG, stiffness]), [LAG]) == [("stiffness", ("c",))]


def test_at_a_joint_unlike_the_others_what_fits_it_best_is_named(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A bump has no slope where it is flat, so it cannot be compared over joints; its mimics can."""
    monkeypatch.setattr(unlike, "FEWEST_OTHERS", 2)
    monkeypatch.setattr(looking, "_at_a_place", lambda *_: None)
    bump = Cause("bump", ("c",), (0.8, 0.2))
    comparison = compared([LAG, bump], catalogue=(*EFFECTS, BUMP))
    more = second_look(comparison, selected(comparison, [LAG]))
    _, named = more.fitted.causes
    assert (named.effect, named.joints) == ("bump", ("c",))
    assert named.values == pytest.approx((0.8, 0.2), abs=0.1)
    mimic = more.steps[-1].rivals[0].added
    assert mimic.joints == ("c",)
    assert mimic.effect.name != "bump"


@pytest.mark.parametrize(("held_out", "named"), [(0.1, False), (0.3, True)])
def test_what_held_out_runs_spoke_against_is_named_again_only_as_a_large_part(
    held_out: float, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs from end to end spoke against it; each stage by itself may speak for it."""
    monkeypatch.setattr(demand, "share_of_stage", lambda *_: held_out)
    comparison = compared([LAG, Cause("tether", (), (0.3,))])
    more = second_look(comparison, selected(comparison, [LAG]), {("tether", ())})
    assert ("tether" in {one.effect for one in more.fitted.causes}) == named


@pytest.mark.parametrize(
    ("pull", "held_out", "named"),
    [
        (0.19, 0.6, True), (0.19, 0.4, False), (0.05, 0.6, False), (20.0, 0.6, False),
        (0.3, 0.15, True), (0.3, 0.05, False),
    ],
)  # fmt: skip
def test_what_gains_little_of_the_whole_is_added_if_it_explains_most_of_its_channels(
    pull: float, held_out: float, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not if half of what held-out runs show there is left, if it is small, or at a bound.

    Of one that is larger than machines are built with, they need to show a part (0.3 is three spreads).
    """
    monkeypatch.setattr(looking, "_as_a_law", lambda *_: None)
    monkeypatch.setattr(demand, "share_of_stage", lambda *_: held_out)
    more = [("tether", ())] if named else []
    assert added(compared([LAG, Cause("tether", (), (pull,))]), [LAG]) == more


@pytest.mark.parametrize(
    ("ratio", "held_out", "named"),
    [
        (0.85, 0.6, True),
        (0.85, 0.4, False),
        (0.95, 0.6, False),
        (0.4, 0.15, True),
        (0.4, 0.05, False),
    ],
)
def test_what_explains_most_of_a_joint_is_added_where_it_is_not_unlike_the_others(
    ratio: float, held_out: float, named: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With three joints none is unlike the two others. A small one may be what a wrong law looks like.

    A ratio of 0.4 is six spreads off, and more than machines are built with.
    """
    monkeypatch.setattr(looking, "_as_a_law", lambda *_: None)
    monkeypatch.setattr(demand, "share_of_stage", lambda *_: held_out)
    more = [("stiffness", ("c",))] if named else []
    assert added(compared([LAG, Cause("stiffness", ("c",), (ratio,))]), [LAG]) == more


@pytest.mark.parametrize("joints", [("c",), ()])
def test_what_most_of_a_joint_shows_and_all_joints_show_is_one_cause_of_them_all(
    joints: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the whole it is too little; of each joint it is most of what its channels show."""
    monkeypatch.setattr(looking, "_as_a_law", lambda *_: None)
    monkeypatch.setattr(looking, "_in_its_channels", lambda *_: None)
    catalogue = tuple(
        replace(one, scopes=(Scope.ALL, Scope.JOINT)) if one.name == "stiffness" else one
        for one in EFFECTS
    )
    truth = Cause("stiffness", joints, (0.6,))
    assert added(compared([LAG, truth], catalogue=catalogue), [LAG]) == [("stiffness", joints)]


def test_what_it_hides_is_still_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(looking, "meets", lambda *_: False)
    law, tether = Cause("square_law", (), ()), Cause("tether", (), (0.5,))
    comparison = compared([LAG, tether, law])
    named = selected(comparison, [LAG])
    lag, first, second = second_look(comparison, named).fitted.causes
    assert {first.effect, second.effect} == {"square_law", "tether"}
    more = second_look(comparison, named, {(first.effect, ())})
    assert [one.effect for one in more.fitted.causes] == ["lag", second.effect]
    assert [one.chosen.added.effect.name for one in more.steps] == ["lag", second.effect]
    assert lag.values[0] == pytest.approx(0.05, rel=0.02)


@pytest.mark.parametrize(
    ("truth", "named"),
    [
        (Cause("rise", (), (0.3, 0.5)), [("rise", ())]),
        # beyond the least angle of all, an effect at a place does what is there everywhere
        (Cause("bias", (), (0.4,)), []),
    ],
)
def test_what_acts_at_a_place_is_added_and_what_acts_everywhere_is_at_none(
    truth: Cause, named: list[tuple[str, tuple[str, ...]]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(looking, "_as_a_law", lambda *_: None)
    assert added(compared([LAG, truth], catalogue=(*KNOWN, RISE)), [LAG]) == named


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_nothing_is_added_where_nothing_is_left(seed: int) -> None:
    assert added(compared([LAG], seed), [LAG]) == []


def test_references_leave_no_second_look() -> None:
    trials = toy_case([LAG, Cause("tether", (), (0.3,))], 3)
    comparison = compare(make_study(trials, Toy(), toy_references(3)), lambda _: None)
    assert added(comparison, [LAG]) == []
