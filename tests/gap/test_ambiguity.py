"""Which rivals are left open, and what is said of why."""

from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.alternatives.ambiguity import OpenRival, open_rivals
from gap.diagnosis.alternatives.probability import (
    RivalCause,
    blur_of,
    chances,
    clear_of_nothing,
    none_if_nothing,
    one_more_is_real,
    weight_of,
)
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.residuals.hunting import Hunting
from gap.search.candidates import Candidate
from gap.search.cross_validation import Advantage
from gap.search.fit import fit_causes
from gap.search.options import Option, fit_option
from gap.search.steps import Selection, Step
from tests.gap.test_selection import evidences
from tests.gap.toy import EFFECTS, Toy, toy_trial

BY_NAME = {effect.name: effect for effect in EFFECTS}


def opened(evidence: Evidence, selection: Selection) -> list[str]:
    shared = chances(selection, evidence.block_part, 0.0, 1e6, [1.0] * len(selection.steps))
    return [one.effect for one in open_rivals(evidence, selection, [r for _, r in shared], 1e6)]


def delay_and_lag() -> tuple[Evidence, Option, Option]:
    """A run with a delay, and both effects fitted to it."""
    evidence, _ = evidences(
        Toy(), [toy_trial([Cause("delay", (), (0.02,))], 0.05, "trot", seed=1)], []
    )
    standing = np.full(len(evidence.starts), 1e9)
    delay, lag = (
        fit_option(evidence, one, (one.cause((0.02,)),), standing)
        for one in (Candidate(BY_NAME[name], ()) for name in ("delay", "lag"))
    )
    return evidence, delay, lag


def test_what_a_healthy_machine_shows_by_chance_is_no_cause() -> None:
    """Three in ten of them show as much: neither it nor its alternatives can have more than 0.7."""
    evidence, delay, lag = delay_and_lag()
    sure = Selection(delay.fitted, delay.unseen, (Step(delay, (lag,)),))
    doubtful = replace(sure, steps=(replace(sure.steps[0], p=0.3),))
    ((one, (other,)),) = chances(sure, evidence.block_part, 0.1, 0.0, [1.0])
    ((less, (least,)),) = chances(doubtful, evidence.block_part, 0.1, 0.0, [1.0])
    assert one + other.probability == pytest.approx(0.9)
    assert (less, least.probability) == pytest.approx((0.7 * one, 0.7 * other.probability))
    ((half, _),) = chances(sure, evidence.block_part, 0.1, 0.0, [0.5])
    assert half == pytest.approx(0.5 * one), "nor is a size that may be one of nothing"


def test_a_chance_speaks_less_for_one_more_cause_than_for_the_first() -> None:
    """That there is a gap is known by the surest cause, and says nothing of another."""
    evidence, delay, lag = delay_and_lag()
    both = Selection(delay.fitted, delay.unseen, (Step(delay, (), 0.04), Step(lag, (), 0.05)))
    (first, _), (more, _) = chances(both, evidence.block_part, 0.0, 0.0, [1.0, 1.0])
    assert first == pytest.approx(0.96)
    assert more == pytest.approx(one_more_is_real(0.05)) == pytest.approx(0.71, abs=0.01)
    assert one_more_is_real(0.0) == 1.0
    assert one_more_is_real(0.01) == pytest.approx(0.89, abs=0.01)
    assert one_more_is_real(0.5) == one_more_is_real(1.0) == 0.5
    assert one_more_is_real(0.36) == pytest.approx(0.5, abs=1e-3), "without a step"


def test_a_size_of_two_errors_is_one_of_nothing_among_many_effects() -> None:
    evidence, _ = evidences(
        Toy(), [toy_trial([Cause("delay", (), (0.02,))], 0.05, "trot", seed=1)], []
    )
    effect, standing = BY_NAME["delay"], np.full(len(evidence.starts), 1e9)
    delay = Candidate(effect, ())
    option = fit_option(evidence, delay, (delay.cause((0.02,)),), standing)
    (away,) = abs(option.fitted.away)

    def clear(errors: float, added: Candidate = delay) -> float:
        step = Step(replace(option, added=added), ())
        selection = Selection(option.fitted, option.unseen, (step,))
        (one,) = clear_of_nothing(selection, BY_NAME, np.array([away / errors]))
        return one

    count = len({one.family for one in EFFECTS})
    assert clear(2.0) == pytest.approx(0.9545**count, rel=1e-3)
    assert clear(5.0) > 0.999
    assert clear(0.5) < 1e-3
    hunting = replace(delay, hunts=Hunting("a", 9.0, 0.03, 0.0, 0.3, 1e-4))
    assert clear(2.0, hunting) == pytest.approx(0.9545, rel=1e-3), "one alone was tried"
    law = Candidate(replace(effect, law=True), ())
    step = Step(replace(option, added=law), ())
    found = Selection(option.fitted, option.unseen, (step,))
    assert clear_of_nothing(found, {"delay": law.effect}, np.array([1e3])) == (1.0,)
    assert clear_of_nothing(found, BY_NAME, np.array([np.nan])) == (0.0,), "not known is not sure"
    none = Selection(replace(option.fitted, causes=()), option.unseen, ())
    assert clear_of_nothing(none, BY_NAME, np.zeros(0)) == ()
    assert none_if_nothing(0.1, ()) == 0.1
    assert none_if_nothing(0.1, (0.0,)) == 1.0
    assert none_if_nothing(0.1, (0.5, 1.0)) == pytest.approx(0.1), "one is surely there"
    assert none_if_nothing(0.1, (0.5, 0.5)) == pytest.approx(0.325)


def test_a_rival_that_was_named_itself_later_on_is_no_rival() -> None:
    true = [Cause("delay", (), (0.02,)), Cause("lag", (), (0.03,))]
    evidence, _ = evidences(Toy(), [toy_trial(true, 0.05, "trot", seconds=30.0, seed=1)], [])
    standing = np.full(len(evidence.starts), 1e9)

    def option(added: str, *start: str) -> Option:
        causes = tuple(Candidate(BY_NAME[name], ()).cause((0.02,)) for name in start)
        return fit_option(evidence, Candidate(BY_NAME[added], ()), causes, standing)

    delay, lag = option("delay", "delay"), option("lag", "lag")
    alone = Selection(delay.fitted, delay.unseen, (Step(delay, (lag,)),))
    assert opened(evidence, alone) == ["lag"]
    both = fit_causes(evidence, (*delay.fitted.causes, *lag.fitted.causes))
    steps = (Step(delay, (lag,)), Step(option("lag", "delay", "lag"), ()))
    named = replace(alone, fitted=both, steps=steps)
    assert opened(evidence, named) == []
    ((before, rivals),) = chances(alone, evidence.block_part, 0.0, 0.0, (1.0,))
    assert [one.effect for one in rivals] == ["lag"]
    assert before + rivals[0].probability == pytest.approx(1.0)
    (after, none), _ = chances(named, evidence.block_part, 0.0, 0.0, (1.0, 1.0))
    assert (after, none) == (1.0, ()), "what is named beside it takes nothing of its probability"


@pytest.mark.parametrize(
    ("separation", "behind", "error", "probability", "said", "apart"),
    [
        (3.2, 900.0, 1.0, 0.1, "separation 3.2, 22 settles it", False),
        (533.0, 3.0, 2.0, 0.1, "lower by only 3 +- 2 nats", False),
        (533.0, -3.0, 2.0, 0.1, "higher by 3 +- 2 nats", False),
        (533.0, -372.0, 41.0, 0.1, "its held-out log-likelihood is higher by 370 +- 40 nats", True),
        (
            533.0,
            38.0,
            2.0,
            0.1,
            "is 38 nats lower, less than 5% of what all causes leave unexplain",
            True,
        ),
        (533.0, 67.0, 2.0, 0.27, "its probability is still 0.27", True),
    ],
)
def test_why_a_rival_is_open_is_what_left_it_open(
    separation: float, behind: float, error: float, probability: float, said: str, apart: bool
) -> None:
    one = OpenRival(0, "lag", (), probability, behind, error, ("delay", ()), "lag", separation)
    assert said in one.why
    assert one.is_distinguished == apart


@pytest.mark.parametrize(("probability", "open_then"), [(0.27, ["tether"]), (0.1, [])])
def test_what_is_still_likely_is_open_however_much_worse_it_predicts(
    probability: float, open_then: list[str]
) -> None:
    """A percent of a large gain: the simulator may be as wrong as that about either."""
    true = [Cause("delay", (), (0.05,))]
    evidence, _ = evidences(Toy(), [toy_trial(true, 0.05, "trot", seconds=30.0, seed=1)], [])
    standing = np.full(len(evidence.starts), 1e9)
    delay, tether = (
        fit_option(evidence, one, (one.cause((0.02,)),), standing)
        for one in (Candidate(BY_NAME[name], ()) for name in ("delay", "tether"))
    )
    chosen = Selection(delay.fitted, delay.unseen, (Step(delay, (tether,)),))
    rival = RivalCause(0, "tether", (), probability, 90.0, 1.0, ("delay", ()), "tether")
    assert [one.effect for one in open_rivals(evidence, chosen, [[rival]], 0.0)] == open_then


def test_an_alternative_a_few_percent_of_the_gain_behind_is_not_ruled_out() -> None:
    # 190 of 3300 nats, five standard errors: no simulator knows to a few percent how an effect looks
    behind = Advantage(190.0, 35.0)
    close = weight_of(behind, blur_of(behind, 0.0, 3300.0))
    assert 0.01 < close < 0.3
    assert weight_of(behind, blur_of(behind, 0.0, 300.0)) < 1e-3
    far = Advantage(1000.0, 35.0)
    assert weight_of(far, blur_of(far, 0.0, 3300.0)) < 1e-4
