"""Counting: every figure on cases whose outcome is plain to see."""

import math
import re
from dataclasses import replace

import pytest

from gap.check.cases import (
    CONTROL,
    OUTSIDE,
    PAIR,
    SINGLE,
    CaseAnswer,
    CheckedCase,
    Named,
    Truth,
    group_of,
)
from gap.check.methods import THIS, Method, methods
from gap.check.score import area_under, calibration_error, confusions, figures, parameter_error
from gap.detectable import Detectable
from robot.campaign.score_text import score_lines, score_markdown

NAN = math.nan
FRICTION = Truth("foot_friction", "friction", "FL", (("ratio", 0.5),))
BIAS = Truth("force_bias", "sensing", "ML", (("x_n", 0.0), ("y_n", 0.0), ("z_n", 2.0)))
NEUTRAL = {("foot_friction", "ratio"): 1.0}


def said(*named: Named, verdict: str = "explained", stage: str = "friction") -> CaseAnswer:
    return CaseAnswer(verdict, stage, named, (), 0.02, 0.9, 30.0)


def named(
    effect: str = "foot_friction", joints: tuple[str, ...] = ("FL",), p: float = 1.0
) -> Named:
    return Named(effect, joints, (("ratio", 0.55),), p)


NO = CaseAnswer("no_gap", "", (), (), 0.0, NAN, 10.0)
RIGHT = CheckedCase("a", SINGLE, (FRICTION,), said(named()), 5.0, 0.95)
OTHER_LEG = replace(RIGHT, name="b", answer=said(named(joints=("FR",))))
WRONG = replace(RIGHT, name="c", answer=said(named("stiction", ()), stage="friction"))
MISSED = replace(RIGHT, name="d", answer=NO, visible=1.0)
HEALTHY = CheckedCase("e", CONTROL, (), NO, NAN, NAN)
ALARM = CheckedCase("f", CONTROL, (), said(named()), NAN, NAN)
UNKNOWN = CheckedCase(
    "g", OUTSIDE, (FRICTION,), replace(said(verdict="unexplained"), none=0.9), NAN, NAN
)
TWO = CheckedCase("h", PAIR, (FRICTION, BIAS), said(named(), named("stiction", ())), 9.0, 0.9)


def value(name: str, *cases: CheckedCase) -> tuple[object, int, bool | None]:
    found = next(f for f in figures(cases, NEUTRAL) if f.name.startswith(name))
    return found.value, found.cases, found.met


def test_shares() -> None:
    cases = (RIGHT, OTHER_LEG, WRONG, MISSED, HEALTHY, ALARM, UNKNOWN, TWO)
    assert value("detection", *cases) == (1.0, 3, True), "what is hardly visible does not count"
    assert value("effect right, of", *cases) == (pytest.approx(2 / 3), 3, False)
    assert value("leg right", *cases) == (0.5, 2, False)
    assert value("stage right", *cases) == (1.0, 3, True)
    assert value("controls", *cases) == (0.5, 2, False)
    assert value("two effects: recall", *cases) == (0.5, 2, False)
    assert value("two effects: precision", *cases) == (0.5, 2, False)
    assert value("outside", *cases) == (1.0, 1, True)
    assert value("called unexplained", *cases) == (0.0, 4, True)
    assert value("AUROC", *cases) == (1.0, 1, True)
    assert value("median shrink", *cases) == (pytest.approx(0.9 / 0.95), 3, False)


def test_nothing_is_said_of_no_case() -> None:
    for figure in figures([HEALTHY], NEUTRAL):
        if figure.name not in {"controls called no_gap", "time of a case, median"}:
            assert math.isnan(figure.value)
            assert figure.met is None
            assert figure.cases == 0


def test_an_interval_is_wilsons() -> None:
    """0 of 10: upper end z^2 / (n + z^2) = 3.8415 / 13.8415."""
    found = next(f for f in figures([HEALTHY] * 10, NEUTRAL) if f.name.startswith("controls"))
    assert found.value == 1.0
    assert found.low == pytest.approx(10 / 13.8415, abs=1e-4)
    assert found.high == pytest.approx(1.0)


def test_a_declared_group_counts() -> None:
    answer = replace(said(named("stiction", ())), alike=(("stiction", "foot_friction"),))
    case = replace(WRONG, answer=answer)
    assert group_of(case) == {"stiction", "foot_friction"}
    assert value("effect right or", case) == (1.0, 1, True)
    assert value("effect right, of", case)[0] == 0.0


def test_an_error_counts_from_neutral() -> None:
    """Truth 0.5, neutral 1, said 0.55: 10 % of the way."""
    error, count = parameter_error([RIGHT], NEUTRAL)
    assert error == pytest.approx(0.1)
    assert count == 1
    assert math.isnan(parameter_error([OTHER_LEG, WRONG], NEUTRAL)[0])


def test_a_part_near_zero_counts_by_its_vector() -> None:
    close = Named("force_bias", ("ML",), (("x_n", 0.1), ("y_n", 0.0), ("z_n", 2.2)), 1.0)
    case = CheckedCase("x", SINGLE, (BIAS,), said(close), 5.0, 0.9)
    error, count = parameter_error([case], {})
    assert error == pytest.approx(0.05)
    assert count == 3


def test_calibration() -> None:
    """Ten causes at 0.75, six right: off by 0.15."""
    right = replace(RIGHT, answer=said(named(p=0.75)))
    wrong = replace(WRONG, answer=said(named("stiction", (), p=0.75)))
    found = calibration_error([right] * 6 + [wrong] * 4)
    assert found.error == pytest.approx(0.15)
    assert found.count == 10
    assert math.isnan(calibration_error([HEALTHY]).error)


@pytest.mark.parametrize(
    ("positive", "negative", "area"),
    [([2.0, 3.0], [0.0, 1.0], 1.0), ([1.0], [1.0], 0.5), ([0.0], [1.0], 0.0), ([2.0, 0.0], [1.0], 0.5)],
)  # fmt: skip
def test_area(positive: list[float], negative: list[float], area: float) -> None:
    assert area_under(positive, negative) == area


def test_confusions_name_what_was_said() -> None:
    found = {
        c.case: (c.truth, c.said) for c in confusions([RIGHT, WRONG, MISSED, ALARM, UNKNOWN, TWO])
    }
    assert found == {
        "c": ("foot_friction", "stiction"),
        "d": ("foot_friction", "no_gap"),
        "f": ("nothing", "foot_friction"),
        "h": ("foot_friction + force_bias", "foot_friction + stiction"),
    }


def test_simpler_ways_are_counted_on_the_same_cases() -> None:
    def told(case: CheckedCase, *effects: str) -> CheckedCase:
        return replace(case, answer=replace(case.answer, simpler=(("greedy", effects),)))

    cases = [
        told(RIGHT, "stiction", "foot_friction"),
        told(WRONG, "foot_friction"),
        told(TWO, "force_bias", "foot_friction", "drag", "drag"),
        told(HEALTHY, "drag"),
        told(UNKNOWN),
    ]
    ours, greedy = methods(cases)
    assert ours == Method(THIS, 1, 2, 1, 2, 2, 1, 1)
    assert greedy == Method("greedy", 1, 2, 2, 2, 4, 0, 1)
    assert methods([RIGHT]) == ()
    lines = "\n".join(score_lines(figures(cases, NEUTRAL), (), cases))
    assert re.search(r"greedy +50% +100% +50% +0%", lines)
    assert "| greedy | 50% | 100% | 50% | 0% |" in score_markdown(
        figures(cases, NEUTRAL), (), cases
    )


def test_a_missed_effect_below_the_size_that_the_answer_says_it_would_see_is_marked() -> None:
    sizes = (Detectable("foot_friction", "ratio", 0.25, "", 1.0, 0.05, 4.0),)
    answer = replace(NO, detectable=sizes)
    for ratio, small in ((0.8, ("foot_friction",)), (1.2, ("foot_friction",)), (0.7, ())):
        truth = Truth("foot_friction", "friction", "ML", (("ratio", ratio),))
        (one,) = confusions([CheckedCase("a", SINGLE, (truth,), answer, NAN, NAN)])
        assert one.too_small == small
    (unknown,) = confusions([CheckedCase("a", SINGLE, (truth,), NO, NAN, NAN)])
    assert unknown.too_small == (), "an answer without sizes claims nothing"
