"""Runs of one day: what differs from day to day is alike in them, so they count once."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.comparison.detection import Detection
from gap.diagnosis.comparison.study import make_study
from gap.interfaces import Cause
from gap.residuals.energy_tests import RunEnergies
from gap.residuals.parts import whole_parts
from gap.residuals.same_day import (
    SILENT_TRIALS,
    days_of,
    leave_each_day_out,
    same_day,
    together_on_days,
)
from gap.search.sizes import sizes_of
from record.trial.trial import Trial
from tests.gap.predictions import LEGS
from tests.gap.walks import cause, diagnosed_among, simulator, walk

LAG = Cause("servo_lag", (), (0.05,))
KEPT = {"servo_lag", "leg_stiffness", "friction_level", "com_offset", "payload"}
GAITS = ("tripod", "metachronal")


def dated(trial: Trial, day: str) -> Trial:
    return replace(trial, header=replace(trial.header, conditions=(("day", day),)))


def undated(trials: Sequence[Trial]) -> list[Trial]:
    return [replace(one, header=replace(one.header, conditions=())) for one in trials]


def runs_of_a_day(day: str, seed: int, *causes: Cause) -> list[Trial]:
    """A run of each gait, with the springs and the friction of that day."""
    draws = np.random.default_rng(seed)
    springs = [
        cause("leg_stiffness", float(ratio), legs=(leg,))
        for leg, ratio in zip(LEGS, draws.lognormal(0.0, 0.06, len(LEGS)), strict=True)
    ]
    level = cause("friction_level", float(draws.lognormal(0.0, 0.05)))
    return [
        dated(walk(gait, 0.2, 10.0, [LAG, level, *springs, *causes], noise_seed=seed + k), day)
        for k, gait in enumerate(GAITS)
    ]


def references(seed: int, days: int) -> list[Trial]:
    return [run for k in range(days) for run in runs_of_a_day(str(k), seed + 10 * k)]


def diagnosed(trials: Sequence[Trial], healthy: Sequence[Trial]) -> Diagnosis:
    return diagnosed_among(KEPT, trials, healthy, (LAG,))


def test_runs_are_put_together_by_their_day() -> None:
    assert together_on_days(("a", "b", "a", "c"), (0, 1, 2)) == ((0, 2), (1,))
    held = leave_each_day_out(("a", "b", "a"), 3)
    assert held == [((0, 2), (1,)), ((1,), (0, 2))]
    assert leave_each_day_out((), 2) == [((0,), (1,)), ((1,), (0,))]


def test_the_size_of_a_day_is_that_of_its_runs_by_how_well_they_show_it() -> None:
    pull, energy = np.array([2.0, 9.0, 4.0, 0.0]), np.array([1.0, 3.0, 4.0, 0.0])
    gaits, days = ("walk", "trot", "walk", "walk"), ("mon", "mon", "tue", "wed")
    apart = sizes_of(pull, energy, gaits).taken(range(4))
    assert apart.values.tolist() == [2.0, 3.0, 1.0]
    sizes = sizes_of(pull, energy, gaits, days).taken(range(4))
    assert sizes.values == pytest.approx([11.0 / 4.0, 1.0]), "nothing shows on wed"
    assert sizes.gaits == ("trot+walk", "walk")


def test_the_energy_of_a_day_is_the_mean_of_its_runs_that_measured() -> None:
    logs = np.array([[1.0, np.nan], [3.0, 5.0], [7.0, np.nan]])
    energies = RunEnergies(("a", "b", "a"), logs).by_day(("mon", "mon", "tue"))
    assert energies.gaits == ("a+b", "a")
    np.testing.assert_array_equal(energies.logs, [[2.0, 5.0], [7.0, np.nan]])


def test_runs_that_do_not_say_their_day_among_others_that_do_get_one() -> None:
    runs = references(3, 2)
    parts = whole_parts(simulator(), runs)
    assert days_of(parts) == ("0", "0", "1", "1")
    assert same_day(parts[0], parts[1])
    assert not same_day(parts[1], parts[2])
    bare = whole_parts(simulator(), undated(runs))
    assert days_of(bare) == ()
    assert not same_day(bare[0], bare[1])
    study = make_study(undated(runs[:2]), simulator(), [*undated(runs[:1]), *runs[1:]])
    assert {part.day for part in (*study.fitted, *study.held)} == {SILENT_TRIALS}
    assert days_of(study.references) == ("run 2", "0", "1", "1")
    silent = make_study(undated(runs[:2]), simulator(), undated(runs))
    assert days_of((*silent.fitted, *silent.references)) == ()
    d = diagnosed(undated(runs[:2]), [*runs, *runs_of_a_day("2", 50)])
    assert any("taken to be of one day" in note for note in d.warnings)


def test_a_report_counts_days() -> None:
    shown = Detection(False, 0.5, 0.5, 0.5, 1.0, 0.33, 4, days=2)
    assert shown.references_words == "4 references of 2 days"
    assert shown.by_count == pytest.approx(1 / 3)
    assert "a day of its own" not in shown.why_words
    assert "each run counts as a day of its own" in replace(shown, days=0).why_words
    assert replace(shown, days=0).references_words == "4 references"
    assert replace(shown, days=0).by_count == pytest.approx(1 / 5)


def test_a_healthy_day_is_no_gap_where_files_say_the_day() -> None:
    """Two runs of a day differ by less than two days do, so without it they promise too much."""
    alarms = {True: 0, False: 0}
    for seed in (100, 300, 500):
        trials, healthy = runs_of_a_day("9", seed + 90), references(seed, 3)
        alarms[True] += diagnosed(trials, healthy).verdict is not Verdict.NO_GAP
        alarms[False] += diagnosed(undated(trials), undated(healthy)).verdict is not Verdict.NO_GAP
    assert alarms[True] < alarms[False]


def test_what_is_new_is_named_where_files_say_the_day() -> None:
    soft = cause("leg_stiffness", 0.55, legs=("ML",))
    d = diagnosed(runs_of_a_day("9", 190, soft), references(100, 3))
    assert [(one.effect, one.joints) for one in d.causes] == [("leg_stiffness", ("ML",))]
    assert d.causes[0].probability > 0.8


def test_two_days_hardly_show_how_much_days_differ_and_the_report_says_so() -> None:
    d = diagnosed(runs_of_a_day("9", 190), references(100, 2))
    assert d.verdict is Verdict.NO_GAP
    assert any("the references are of 2 days" in note for note in d.warnings)
