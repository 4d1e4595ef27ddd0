"""A cause that changes in the course of a run is none of the catalogue, and it is said."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from gap.constants import CHANGE_LEVEL, JOINTS_SHARE
from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.comparison.gap_evidence import compare
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.comparison.trend import (
    UNKNOWN,
    RunChange,
    Trend,
    change_in_runs,
    difference,
    none_with,
)
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Effect
from model.effects.catalogue import CATALOGUE
from record.trial.trial import Trial
from tests.gap.toy import CONDITIONS, EFFECTS, SPEED_GAIN, Toy, toy_case, toy_references, toy_trial
from tests.soaked import THOROUGH

STIFFNESS = Cause("stiffness", ("c",), (0.8,))
CHANGES = "changes by"


def found(cause: Cause, growing: float, *, references: bool = True, seed: int = 3) -> Diagnosis:
    known = toy_references(seed) if references else []
    return diagnose(toy_case([cause], seed, growing=growing), Toy(), known)


@pytest.mark.parametrize(
    ("growing", "references"),
    [
        (0.6, True),
        (-1.0, False),
        pytest.param(0.6, False, marks=pytest.mark.soak),
        pytest.param(-1.0, True, marks=pytest.mark.soak),
    ],
)
def test_a_cause_that_grows_or_fades_is_unexplained_with_what_it_does(
    growing: float, references: bool
) -> None:
    d = found(STIFFNESS, growing, references=references)
    one = next(c for c in d.causes if c.effect == "stiffness")
    assert one.trend.growth == pytest.approx(growing, abs=0.25)
    assert d.verdict is Verdict.UNEXPLAINED, d.sentence
    assert d.none > 0.5
    assert any(words.startswith(f"stiffness at c {CHANGES}") for words in d.warnings)


def test_causes_of_one_stage_have_one_trend_and_others_their_own() -> None:
    both = [STIFFNESS, Cause("stiffness", ("a",), (1.3,)), Cause("tether", (), (0.3,))]
    d = diagnose(toy_case(both, 3, growing=-0.8), Toy(), toy_references(3))
    press = {c.joints: c.trend for c in d.causes if c.effect == "stiffness"}
    assert press.keys() == {("a",), ("c",)}
    assert press["a",] == press["c",]
    assert press["a",].growth == pytest.approx(-0.8, abs=0.25)
    assert all(c.trend != press["a",] for c in d.causes if c.stage != "press")
    steady = diagnose(toy_case(both, 3), Toy(), toy_references(3))
    assert steady.verdict is Verdict.EXPLAINED
    assert not any(CHANGES in words for words in steady.warnings)


@pytest.mark.parametrize(
    "cause", [STIFFNESS, pytest.param(Cause("delay", (), (0.05,)), marks=pytest.mark.soak)]
)
def test_a_cause_that_keeps_its_size_has_no_trend(cause: Cause) -> None:
    d = found(cause, 0.0)
    assert d.verdict is Verdict.EXPLAINED
    assert abs(d.causes[0].trend.growth) < 0.1
    assert not any(CHANGES in words for words in d.warnings)


def test_one_run_or_runs_of_two_cycles_cannot_tell() -> None:
    alone = diagnose([toy_trial([STIFFNESS])], Toy(), toy_references(3))
    assert np.isnan(alone.causes[0].trend.growth)
    short = [toy_trial([STIFFNESS], seconds=4.0, seed=k) for k in range(4)]
    known = [toy_trial((), seconds=4.0, seed=10 + k) for k in range(6)]
    assert all(np.isnan(one.trend.growth) for one in diagnose(short, Toy(), known).causes)


def test_an_effect_that_grows_by_nature_has_no_trend() -> None:
    growing = {effect.name for effect in CATALOGUE if effect.in_time}
    assert growing == {"force_drift", "clock_skew"}
    catalogue = tuple(replace(e, in_time=e.name == "stiffness") for e in EFFECTS)
    d = diagnose(toy_case([STIFFNESS], 3, growing=1.0), Toy(catalogue), toy_references(3))
    assert all(np.isnan(c.trend.growth) for c in d.causes if c.effect == "stiffness")
    assert any(c.effect == "stiffness" for c in d.causes)


WEARING = tuple(replace(e, wears=e.name in {"tether", "stiffness"}) for e in EFFECTS)


@pytest.mark.parametrize(
    ("mean", "growing", "change"),
    [
        (Cause("tether", (), (0.02,)), 20.0, 0.4),
        (Cause("tether", (), (-0.01,)), 20.0, -0.2),
        (Cause("stiffness", ("c",), (0.99,)), 20.0, -0.2),
    ],
)
def test_what_wears_is_a_gap_though_its_mean_is_nothing_new(
    mean: Cause, growing: float, change: float
) -> None:
    """On the mean it changes a twentieth of what it does in the course of a run."""
    d = diagnose(toy_case([mean], 3, growing=growing), Toy(WEARING), toy_references(3))
    assert d.verdict is Verdict.UNEXPLAINED, d.sentence
    assert d.causes == ()
    assert d.change is not None
    assert (d.change.effect, d.change.joints) == (mean.effect, mean.joints)
    assert d.change.change == pytest.approx(change, rel=0.1)
    assert d.detection is not None
    assert d.detection.p_change == d.change.chance < 0.001
    assert d.stage == d.change.stage
    assert d.none > 0.9
    assert "changes while the machine runs" in d.sentence
    assert mean.effect in d.sentence
    said = diagnosis_json(d)
    assert said["change"] is d.change
    assert said["detection"].p_change == d.change.chance


def test_what_does_not_wear_is_not_asked() -> None:
    case = toy_case([Cause("tether", (), (0.01,))], 3, growing=20.0)
    d = diagnose(case, Toy(), toy_references(3))
    assert d.verdict is Verdict.NO_GAP, d.sentence
    assert d.change is None


def test_what_references_do_as_well_is_no_change() -> None:
    mean = [Cause("tether", (), (0.01,))]
    case = toy_case(mean, 3, growing=20.0)
    known = [
        toy_trial(mean, hz, gait, seed=3500 + i, growing=20.0)
        for i, (hz, gait) in enumerate((*CONDITIONS, *CONDITIONS[:2]))
    ]
    d = diagnose(case, Toy(WEARING), known)
    assert d.verdict is Verdict.NO_GAP, d.sentence
    assert d.change is None


def asked(
    trials: list[Trial], known: list[Trial], catalogue: tuple[Effect, ...]
) -> RunChange | None:
    comparison = compare(make_study(trials, Toy(catalogue), known), lambda _: None)
    assert comparison.healthy is not None
    groups = (comparison.evidence, comparison.study.held_evidence(comparison.study.local))
    return change_in_runs(groups, comparison.healthy, comparison.candidates)


def test_longer_references_that_change_as_fast_show_the_same_change() -> None:
    """Growth is over one run's length: half as long a trial changes by half as much."""
    mean = [Cause("tether", (), (0.01,))]
    case = toy_case(mean, 3, growing=20.0, seconds=8.0)
    known = [
        toy_trial(mean, hz, gait, seed=3500 + i, growing=40.0, seconds=16.0)
        for i, (hz, gait) in enumerate((*CONDITIONS, *CONDITIONS[:2]))
    ]
    as_fast = asked(case, known, WEARING)
    assert as_fast is None or as_fast.chance > CHANGE_LEVEL
    steady = asked(case, toy_references(3, seconds=16.0), WEARING)
    assert steady is not None
    assert steady.chance < CHANGE_LEVEL
    assert steady.change == pytest.approx(0.2, rel=0.15)


def test_a_machine_of_joints_alone_has_the_whole_level_for_them() -> None:
    worn = toy_case([Cause("stiffness", ("c",), (0.99,))], 3, growing=20.0)
    only = tuple(replace(e, wears=e.name == "stiffness") for e in EFFECTS)
    alone, both = (asked(worn, toy_references(3), one) for one in (only, WEARING))
    assert alone is not None
    assert both is not None
    assert both.chance == pytest.approx(alone.chance / float(JOINTS_SHARE))


def test_small_changes_and_short_runs_are_none() -> None:
    tenth_of_a_spread = [Cause("tether", (), (0.0005,))]  # 20 times as much in the course of a run
    slight = toy_case(tenth_of_a_spread, 3, growing=20.0)
    change = asked(slight, toy_references(3), WEARING)
    assert change is None or change.effect != "tether"
    worn = [Cause("tether", (), (0.02,))]
    short = [toy_trial(worn, seconds=4.0, seed=k, growing=20.0) for k in range(4)]
    known = [toy_trial((), seconds=4.0, seed=10 + k) for k in range(6)]
    assert asked(short, known, WEARING) is None


def test_trials_that_are_cut_to_judge_by_are_not_asked() -> None:
    """One run a gait: its last third is held out, and no part is a whole run."""
    worn = [
        toy_trial([Cause("tether", (), (0.02,))], 0.5, gait, seed=i, growing=20.0, seconds=32.0)
        for i, gait in enumerate(("walk", "trot"))
    ]
    assert diagnose(worn, Toy(WEARING), toy_references(3)).change is None


def test_what_changes_nearly_as_surely_is_told_with_it() -> None:
    """A pull at the body and a gain of the speed's sensor change the speed alike."""
    catalogue = (*WEARING, replace(SPEED_GAIN, wears=True))
    worn = toy_case([Cause("tether", (), (0.02,))], 3, growing=20.0)
    change = asked(worn, toy_references(3), catalogue)
    assert change is not None
    assert {change.effect, *(effect for effect, _ in change.alike)} == {"tether", "speed_gain"}


@pytest.mark.parametrize("seed", [4, pytest.param(5, marks=pytest.mark.soak)])
def test_a_healthy_machine_does_not_wear(seed: int) -> None:
    d = diagnose(toy_case((), seed), Toy(WEARING), toy_references(seed))
    assert d.verdict is Verdict.NO_GAP, d.sentence
    assert d.change is None


@THOROUGH
def test_healthy_machines_wear_no_more_often_than_the_level_says() -> None:
    """Joints differ from run to run by five percent; every effect may wear."""
    wearing = tuple(replace(e, wears=True) for e in EFFECTS)
    alarms = 0
    for seed in range(100):
        trials, known = toy_case((), seed, wander=0.05), toy_references(seed, wander=0.05)
        change = asked(trials, known, wearing)
        alarms += change is not None and change.chance < CHANGE_LEVEL
    assert alarms <= stats.binom.ppf(0.975, 100, float(CHANGE_LEVEL))


def test_runs_of_a_gait_are_compared_with_each_other() -> None:
    """What a gait has by itself is no difference between trials and references."""
    gaits, trial = ["a", "b"] * 4, np.repeat([1.0, 0.0], 4)
    noise = np.random.default_rng(1).standard_normal(8)
    own = np.where(np.array(gaits) == "b", 50.0, 0.0)
    alone, chance = difference(noise + own, trial, gaits)
    assert (alone, chance) == pytest.approx(difference(noise, trial, gaits))
    there, small = difference(noise + own + 9.0 * trial, trial, gaits)
    assert there == pytest.approx(alone + 9.0)
    assert small < 0.001 < chance


def test_gaits_that_no_reference_has_say_nothing() -> None:
    trial = np.repeat([1.0, 0.0], 4)
    assert np.isnan(difference(np.arange(8.0), trial, ["a"] * 4 + ["b"] * 4)).all()
    blind = np.array([1.0, np.nan, np.nan, np.nan, 2.0, 3.0, np.nan, np.nan])
    assert np.isnan(difference(blind, trial, ["a"] * 8)).all(), "too few that saw it"


def test_how_sure_it_is_decides_how_much_is_left_for_the_catalogue() -> None:
    assert none_with([], 0.02, 0.01) == 0.02
    assert none_with([], 0.02, 0.001) == pytest.approx(1 - 0.98 * 0.05)
    just = Trend(1.0, 0.8 / 4.033, 5)  # 4.032 errors of five degrees of freedom: 1 % on both sides
    assert none_with([just], 0.02) == pytest.approx(1 - 0.98 / 2, abs=2e-3)
    assert none_with([just, Trend(0.0, 0.1, 5)], 0.02) == 0.02, "one of two by chance"
    assert none_with([Trend(0.15, 1e-6, 5)], 0.02) == 0.02, "sure, but too small to matter"
    assert none_with([Trend(0.4, 0.03, 5)], 0.02) > 0.5, "no large change, but surely a real one"
    assert none_with([Trend(0.6, 0.15, 5)], 0.02) == 0.02, "a larger one that may be a small one"
    assert none_with([UNKNOWN], 0.02) == 0.02
    fades = Trend(-1.0, 0.01, 5)
    assert none_with([fades], 0.02) > 0.99
    assert none_with([UNKNOWN, fades], 0.02, little={1}) == 0.02, "what a large cause leaves"
    assert none_with([fades, fades], 0.02, little={1}) > 0.99, (
        "the other of the stage is not little"
    )


@THOROUGH
def test_a_steady_cause_is_rarely_said_to_change() -> None:
    """By construction in one of a hundred; the size that is asked for as well makes it fewer."""
    said = [found(STIFFNESS, 0.0, seed=k).causes[0].trend.surely(1) for k in range(10, 50)]
    assert sum(said) <= 1
