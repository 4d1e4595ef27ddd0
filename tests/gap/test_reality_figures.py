"""Figures of realities, and constants fitted on all but one, against plain cases and known truths."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats
from scipy.special import expit, logit

from gap.check.calibration import (
    CaseRows,
    ConstantPrior,
    binned_error,
    calibration_of,
    fit_constants,
    leave_one_out,
)
from gap.check.cases import (
    CONTROL,
    OUTSIDE,
    PAIR,
    SINGLE,
    CaseAnswer,
    CheckedCase,
    Named,
    Remainder,
    Truth,
    probabilities_given,
)
from gap.check.evidence_rows import cause_prior, cause_rows, none_prior, none_rows
from gap.check.realities import figures_alone, figures_of_reality, worst_reality
from gap.check.score import numbers_within
from gap.detectable import Detectable
from gap.diagnosis.alternatives.probability import Fit, none_of_them

NAN = math.nan
FRICTION = Truth("foot_friction", "friction", "FL", (("ratio", 0.5),))
LAG = Truth("servo_lag", "actuation", "", (("time_constant_s", 0.1),))
NAMED = Named("foot_friction", ("FL",), (("ratio", 0.53),), 0.9, (("ratio", 0.02),))
RIGHT = CheckedCase(
    "a", SINGLE, (FRICTION,), CaseAnswer("explained", "friction", (NAMED,), (), 0.02, 0.9, 30.0), NAN, NAN
)  # fmt: skip


def answered(case: CheckedCase, *named: Named, **changes: object) -> CheckedCase:
    return replace(case, answer=replace(case.answer, named=named, **changes))  # type: ignore[arg-type]


OTHER_LEG = answered(RIGHT, replace(NAMED, joints=("FR",)))
SILENT = answered(RIGHT, verdict="no_gap", stage="")
LIKE = answered(
    RIGHT, replace(NAMED, effect="stiction", joints=()), alike=(("stiction", "foot_friction"),)
)
HEALTHY = CheckedCase("h", CONTROL, (), SILENT.answer, NAN, NAN)
BOTH = replace(RIGHT, kind=PAIR, truths=(FRICTION, LAG))
ODD = replace(answered(RIGHT, NAMED, verdict="unexplained", none=0.8), kind=OUTSIDE)


def value(name: str, *cases: CheckedCase) -> tuple[float, int, bool | None]:
    one = next(f for f in figures_of_reality("r", cases).figures if f.name == name)
    return one.value, one.cases, one.met


def test_every_single_case_counts_whether_its_gap_was_declared_or_not() -> None:
    cases = (RIGHT, OTHER_LEG, SILENT, LIKE)
    assert value("first cause right, with leg", *cases) == (0.25, 4, False)
    assert value("or in its declared group", *cases) == (0.5, 4, False)
    assert value("stage right, of detected", *cases) == (1.0, 3, True)
    assert value("healthy called no_gap", HEALTHY, *cases) == (1.0, 1, True)


def test_a_pair_is_right_when_both_are_named() -> None:
    lag = Named("servo_lag", (), (), 0.8)
    assert value("both causes of a pair", answered(BOTH, NAMED))[0] == 0.0
    assert value("both causes of a pair", answered(BOTH, lag, NAMED))[0] == 1.0
    assert value("both causes of a pair", answered(BOTH, NAMED, NAMED))[0] == 0.0
    elsewhere = replace(NAMED, joints=("FR",))
    assert value("both causes of a pair", answered(BOTH, lag, elsewhere))[0] == 0.0


def test_a_pair_counts_once_more_if_both_are_as_large_as_the_answer_lists() -> None:
    name = "of pairs that are both large enough to be seen"
    sizes = tuple(
        Detectable(effect, parameter, size, "", neutral, 0.0, 2.0, "")
        for effect, parameter, size, neutral in (
            ("foot_friction", "ratio", 0.3, 1.0), ("servo_lag", "time_constant_s", 0.2, 0.0)
        )
    )  # fmt: skip
    assert value(name, answered(BOTH, NAMED))[:2] == (0.0, 1), "no size is listed"
    lag_too_small = answered(BOTH, NAMED, detectable=sizes)
    assert value(name, lag_too_small)[1] == 0
    assert value("both causes of a pair", lag_too_small)[1] == 1


def test_a_number_is_within_one_or_two_of_its_error() -> None:
    """0.53 for 0.5 with +- 0.02 is 1.5 of them away; another leg's number does not count."""
    assert numbers_within([RIGHT, OTHER_LEG], 1.0) == (False,)
    assert numbers_within([RIGHT, OTHER_LEG], 2.0) == (True,)
    assert numbers_within([answered(RIGHT, replace(NAMED, errors=()))], 1.0) == ()
    near = answered(RIGHT, replace(NAMED, values=(("ratio", 0.51),)))
    name = "number within one of its +-"
    assert value(name, near, near, near, RIGHT)[0] == 0.75
    assert value(name, near, near, near, RIGHT)[2] is True
    assert value(name, near)[2] is False, "always within one is too wide"


def test_numbers_of_either_sign_are_compared_with_the_nearer() -> None:
    """Friction is stronger along w and along -w alike."""
    values = (("w_x", 0.6), ("w_y", -0.2))
    truth = Truth("friction_anisotropy", "friction", "", values)
    found = Named(
        "friction_anisotropy",
        (),
        (("w_x", -0.61), ("w_y", 0.24)),
        0.9,
        (("w_x", 0.02), ("w_y", 0.02)),
    )
    case = answered(replace(RIGHT, truths=(truth,)), found)
    assert numbers_within([case], 1.0) == (True, False)
    assert numbers_within([case], 2.0) == (True, True)


def test_of_effects_that_the_answer_says_it_would_have_seen_the_first_cause_counts_once_more() -> (
    None
):
    """It lists 0.4 of friction, half of which was lost: a loss of a tenth may be missed."""
    said = Detectable("foot_friction", "ratio", 0.4, "", 1.0, 0.05, 4.0)
    mild = replace(FRICTION, values=(("ratio", 0.9),))
    large = answered(SILENT, verdict="no_gap", detectable=(said,))
    small = replace(large, truths=(mild,))
    name = "of those large enough to be seen"
    assert value(name, RIGHT, small) == (1.0, 1, True)
    assert value(name, RIGHT, large) == (0.5, 2, False)
    assert value("first cause right, with leg", RIGHT, small) == (0.5, 2, False)


def test_what_was_said_beforehand_to_be_hidden_does_not_count() -> None:
    hidden = answered(OTHER_LEG, hidden=("foot_friction",))
    row = figures_of_reality("r", (RIGHT, hidden))
    assert (row.cases, row.hidden) == (2, 1)
    assert value("first cause right, with leg", RIGHT, hidden)[:2] == (1.0, 1)


def test_the_worst_is_that_with_most_bars_missed() -> None:
    rows = [
        figures_of_reality("good", (RIGHT, ODD)),
        figures_of_reality("bad", (OTHER_LEG, replace(ODD, answer=RIGHT.answer))),
        figures_of_reality("crashing", (RIGHT,), ("c1",)),
    ]
    assert worst_reality(rows).name == "bad"
    assert "crashed" in rows[2].missed
    assert "crashed" not in rows[0].missed


# Constants.

PRIOR = ConstantPrior(("a", "b"), np.array([0.0, 1.0]), np.array([3.0, 3.0]), np.zeros(2))


def drawn(constants: tuple[float, float], count: int, seed: int) -> CaseRows:
    random = np.random.default_rng(seed)
    features = np.column_stack([np.ones(count), random.normal(0, 2, count)])
    chance = expit(features @ np.array(constants))
    return CaseRows(features, random.random(count) < chance)


def test_constants_that_made_the_outcomes_are_recovered() -> None:
    fitted = fit_constants(drawn((-1.0, 0.5), 20000, 1), PRIOR)
    assert fitted == pytest.approx([-1.0, 0.5], abs=0.06)


def test_few_rows_do_not_lead_far_and_none_nowhere() -> None:
    nothing = CaseRows(np.zeros((0, 2)), np.zeros(0, dtype=bool))
    assert fit_constants(nothing, PRIOR) == pytest.approx([0.0, 1.0])
    tight = replace(PRIOR, spread=np.array([0.1, 0.0]))
    moved = fit_constants(drawn((-4.0, -2.0), 30, 2), tight)
    assert -0.5 < moved[0] < 0.0
    assert moved[1] == 1.0, "no spread: it stays"
    held = replace(PRIOR, signs=np.array([0.0, 1.0]))
    assert fit_constants(drawn((0.0, -2.0), 2000, 3), held)[1] == pytest.approx(0.0, abs=1e-6)


def test_a_reality_left_out_has_no_say_in_its_own_constants() -> None:
    rows = {name: drawn((-1.0, 0.5), 400, seed) for seed, name in enumerate("abc")}
    before = {one.name: one for one in leave_one_out(rows, PRIOR)}
    flipped = {**rows, "a": CaseRows(rows["a"].features, ~rows["a"].outcomes)}
    after = {one.name: one for one in leave_one_out(flipped, PRIOR)}
    assert after["a"].constants == before["a"].constants
    assert after["b"].constants != before["b"].constants
    assert before["a"].loss < before["a"].loss_now
    assert after["a"].loss > before["a"].loss


def test_an_error_of_calibration_by_hand() -> None:
    """Three at 0.9 of which two are right: off by 0.7 of 3; one at 0.1, wrong: by 0.1 of 4 in all."""
    chance, right = np.array([0.9, 0.9, 0.9, 0.1]), np.array([True, True, False, False])
    assert binned_error(chance, right) == pytest.approx((0.7 + 0.1) / 4)
    assert math.isnan(binned_error(np.zeros(0), np.zeros(0, dtype=bool)))


def test_ten_answers_at_three_quarters_are_off_by_chance_as_the_binomial_says() -> None:
    chance = np.full(10, 0.75)
    right = np.arange(10) < 6
    found = calibration_of(chance, right)
    hits = np.arange(11)
    share = stats.binom.pmf(hits, 10, 0.75)
    assert found.error == pytest.approx(0.15)
    assert found.by_chance == pytest.approx(float(share @ np.abs(hits / 10 - 0.75)), abs=0.005)
    far = float(share[np.abs(hits / 10 - 0.75) >= 0.15 - 1e-9].sum())
    assert found.p == pytest.approx(far, abs=0.03)
    assert found.beyond_chance == pytest.approx(found.error - found.by_chance)
    assert math.isnan(calibration_of(chance[:0], right[:0]).beyond_chance)


def test_probabilities_that_are_right_are_rarely_said_to_be_off() -> None:
    """And those that are off are found out, given enough of them."""
    random = np.random.default_rng(5)
    low = 0
    for seed in range(40):
        chance = random.random(30)
        low += calibration_of(chance, random.random(30) < chance, seed).p < 0.05
    assert low <= 6  # 2 are expected; 7 or more have a chance of 0.4 %
    doubted = random.random(100) * 0.5
    found = calibration_of(doubted, random.random(100) < doubted + 0.3)
    assert found.p < 0.01
    assert found.beyond_chance == pytest.approx(0.3, abs=0.1)


def test_rows_of_none_of_these_give_the_probability_that_is_given() -> None:
    left = Remainder(0.7, 2.5, 9.0, 1e-4)
    named = (NAMED, NAMED, NAMED)
    cases = [answered(one, *named, remainder=left) for one in (RIGHT, ODD)]
    rows = none_rows([*cases, HEALTHY, answered(RIGHT, NAMED, remainder=left, referenced=False)])
    assert rows.outcomes.tolist() == [False, True]
    given = expit(rows.features @ none_prior().values)
    assert given[0] == pytest.approx(none_of_them(Fit(0.7, 2.5, 9.0, 1e-4, 0.0), 3, True))


def test_rows_of_causes_are_the_log_odds_that_were_given() -> None:
    wrong = answered(RIGHT, replace(NAMED, effect="stiction", probability=0.2))
    rows = cause_rows([RIGHT, wrong, HEALTHY])
    assert rows.outcomes.tolist() == [True, False]
    assert rows.features[:, 1] == pytest.approx([logit(0.9), logit(0.2)])
    assert expit(rows.features @ cause_prior().values) == pytest.approx([0.9, 0.2])


def test_a_cause_at_another_leg_or_of_a_case_outside_the_catalogue_was_not_there() -> None:
    """Its probability left a share to both."""
    assert probabilities_given([RIGHT, OTHER_LEG, ODD, SILENT]) == (
        (0.9, True), (0.9, False), (0.9, False),
    )  # fmt: skip


def test_without_references_the_true_cause_is_among_the_named_and_nothing_new_in_a_healthy_robot() -> (
    None
):
    lag = Named("servo_lag", (), (), 0.8)
    known = {"servo_lag"}
    cases = [
        (answered(RIGHT, lag, NAMED), known),  # second, but there
        (OTHER_LEG, known),
        (answered(HEALTHY, lag, verdict="unexplained"), known),
        (answered(HEALTHY, lag, NAMED, verdict="explained"), known),
        (HEALTHY, known),
    ]
    row = figures_alone("r", cases, ("c1",))
    assert [one.value for one in row.figures] == [0.5, pytest.approx(2 / 3), 1.0]
    assert [one.met for one in row.figures] == [False, False, False]
    assert worst_reality([row]) is row


def test_without_a_baseline_no_healthy_robot_is_judged() -> None:
    lag = Named("servo_lag", (), (), 0.8)
    healthy = answered(HEALTHY, lag, verdict="explained")
    row = figures_alone("r", [(answered(RIGHT, NAMED), None), (healthy, None)])
    among, nothing_else, _ = row.figures
    assert (among.value, among.cases) == (1.0, 1)
    assert (math.isnan(nothing_else.value), nothing_else.cases, nothing_else.met) == (True, 0, None)
