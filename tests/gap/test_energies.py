"""Energies of trials against those of references, channel by channel."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy import stats

from gap.constants import ENERGY_LEVEL
from gap.diagnosis.comparison.detection import Detection
from gap.diagnosis.comparison.study import make_study
from gap.residuals.energies import chance_of_energies
from gap.residuals.energy_tests import (
    RunEnergies,
    _pooled,
    _scatters,
    among_joints,
    gait_by_gait,
    together,
)
from gap.residuals.moderated import steadied
from model.values.arrays import FloatArray
from tests.gap.toy import Toy, toy_case, toy_references

CALM, RESTLESS = 0.05, 1.5  # scatter of logarithms of energies
KINDS = ("marker",) * 6 + ("force",) * 6
WIDTHS = np.array([CALM] * 6 + [RESTLESS] * 6)


def _runs(rng: np.random.Generator, count: int) -> FloatArray:
    return WIDTHS * rng.standard_normal((count, len(KINDS)))


def _chance(trials: FloatArray, known: FloatArray, kinds: tuple[str, ...] = KINDS) -> float:
    chance = together(kinds, trials, known, known)
    assert chance is not None
    return chance.p


def test_a_calm_channel_that_has_twice_its_energy_three_times_over_is_plain() -> None:
    """However restless others are: forces of feet that stick are another in each gait and on each day."""
    rng = np.random.default_rng(1)
    known, trials = _runs(rng, 4), _runs(rng, 3)
    healthy = _chance(trials, known)
    trials[:, 2] += np.log(8.0)
    assert healthy > 0.2
    assert _chance(trials, known) < 1e-4
    assert _chance(trials, known, ("any",) * len(KINDS)) > 0.02, "if all scattered alike"


def test_a_calm_channel_is_never_taken_for_calmer_than_channels_are() -> None:
    """A fifth more energy in a channel that no reference moves is no gap."""
    rng = np.random.default_rng(2)
    known, trials = 1e-3 * rng.standard_normal((2, 6, 12))
    trials[:, 2] += np.log(1.2)
    assert _chance(trials[:3], known, ("marker",) * 12) > 0.2


def test_a_restless_channel_has_to_stand_out_from_its_own_kind() -> None:
    rng = np.random.default_rng(3)
    known, trials = _runs(rng, 4), _runs(rng, 3)
    trials[:, 8] += np.log(8.0)
    assert _chance(trials, known) > 0.1


@pytest.mark.parametrize("references", [3, 4, 10])
def test_healthy_machines_of_unequal_channels_reach_the_level_no_more_often_than_it_says(
    references: int,
) -> None:
    rng, sets = np.random.default_rng(references), 1000
    below = [
        _chance(_runs(rng, 3), _runs(rng, references)) < float(ENERGY_LEVEL) for _ in range(sets)
    ]
    assert sum(below) <= stats.binom.ppf(0.999, sets, float(ENERGY_LEVEL))


def test_a_kind_scatters_as_its_channels_do_and_others_have_at_most_half_a_say() -> None:
    rng = np.random.default_rng(4)
    runs = _runs(rng, 5)
    centred = runs - runs.mean(axis=0)
    calm, restless = _pooled(centred[:, :6], 1), _pooled(centred[:, 6:], 1)
    found = _scatters(KINDS, centred, 1, steadied)
    assert_allclose([one.variance for one in found[:6]], found[0].variance)
    assert calm.variance < found[0].variance < (calm.variance + restless.variance) / 2
    assert calm.free < found[0].free <= 2 * calm.free
    assert _scatters(("marker",) * 6, centred[:, :6], 1, steadied)[0] == calm, (
        "there is no other kind"
    )


def test_kinds_that_scatter_alike_tell_of_each_other() -> None:
    """One roll by itself scatters with two degrees of freedom, which would hide nearly everything."""
    rng = np.random.default_rng(11)
    kinds, runs = tuple("abcdef"), 0.5 * rng.standard_normal((3, 6))
    trials = np.zeros((1, 6))
    trials[0, 2] = 5.0
    alone = together(kinds[2:3], trials[:, 2:3], runs[:, 2:3], runs[:, 2:3])
    beside = together(kinds, trials, runs, runs)
    assert alone is not None
    assert beside is not None
    assert beside.p < 0.2 * alone.p


def test_what_a_run_did_not_measure_does_not_count() -> None:
    rng = np.random.default_rng(5)
    known, trials = _runs(rng, 4), _runs(rng, 3)
    trials[:, 2] = 9.0
    known[:, 2] = np.nan
    assert _chance(trials, known) > 0.05
    assert together(KINDS, np.full((3, 12), np.nan), known, known) is None


GAITS = ("tripod", "wave", "tripod", "wave")


def _of_gaits(rng: np.random.Generator, gaits: tuple[str, ...]) -> RunEnergies:
    """A machine that leaves a hundred times as much in one gait as in the other."""
    apart = np.log(100.0) * np.array([[gait == "wave"] for gait in gaits])
    return RunEnergies(gaits, apart + 0.2 * rng.standard_normal((len(gaits), 12)))


def test_gait_by_gait_what_is_within_the_scatter_of_all_gaits_is_plain() -> None:
    rng = np.random.default_rng(9)
    trials, runs = _of_gaits(rng, GAITS[:3]), _of_gaits(rng, GAITS)
    healthy = gait_by_gait(KINDS, trials, runs)
    trials.logs[:, 8] += np.log(10.0)
    plain = gait_by_gait(KINDS, trials, runs)
    assert healthy is not None
    assert healthy.p > 0.1
    assert plain is not None
    assert (plain.p < 1e-4, plain.channel) == (True, 8)
    assert _chance(trials.logs, runs.logs) > 0.2, "all gaits together hide it"


@pytest.mark.parametrize(
    ("trial", "known"),
    [
        (("wave",), ("tripod", "tripod")),  # a gait without a reference
        (("tripod",), ("tripod", "tripod", "tripod")),  # one gait: the other test is the same
        (("tripod",), ("tripod", "wave")),  # no scatter within a gait
    ],
)
def test_gaits_that_references_do_not_tell_of_are_not_compared(
    trial: tuple[str, ...], known: tuple[str, ...]
) -> None:
    rng = np.random.default_rng(7)
    assert gait_by_gait(KINDS, _of_gaits(rng, trial), _of_gaits(rng, known)) is None


def test_healthy_gaits_reach_the_level_no_more_often_than_it_says() -> None:
    rng, sets, level = np.random.default_rng(8), 1000, float(ENERGY_LEVEL)
    chances = [
        gait_by_gait(KINDS, _of_gaits(rng, GAITS[:3]), _of_gaits(rng, GAITS)) for _ in range(sets)
    ]
    below = sum(one is not None and one.p < level for one in chances)
    assert below <= stats.binom.ppf(0.999, sets, level)


def _among(trials: FloatArray, known: FloatArray) -> float:
    gaits = tuple("gait" for _ in range(max(len(trials), len(known))))
    chance = among_joints(
        KINDS, RunEnergies(gaits[: len(trials)], trials), RunEnergies(gaits[: len(known)], known)
    )
    assert chance is not None
    return chance.p


def test_a_joint_that_leaves_more_than_its_like_is_plain_however_much_runs_differ() -> None:
    """Of three references in three conditions each is as far from the others as a gap."""
    rng = np.random.default_rng(8)
    conditions = np.log([1.0, 0.3, 3.0])[:, None]
    known, trials = (conditions[:n] + _runs(rng, n) for n in (3, 2))
    healthy = _among(trials, known)
    trials[:, 2] += np.log(4.0)
    assert healthy > 0.2
    assert _among(trials, known) < 1e-4
    assert _chance(trials, known) > 0.1


@pytest.mark.parametrize("references", [3, 4, 10])
def test_healthy_joints_reach_the_level_no_more_often_than_it_says(references: int) -> None:
    rng, sets, level = np.random.default_rng(20 + references), 1000, float(ENERGY_LEVEL)
    below = [_among(_runs(rng, 3), _runs(rng, references)) < level for _ in range(sets)]
    assert sum(below) <= stats.binom.ppf(0.999, sets, level)


def test_two_joints_have_nobody_to_stand_out_from() -> None:
    logs = np.zeros((3, 2))
    runs = RunEnergies(("gait",) * 3, logs)
    assert among_joints(("marker",) * 2, runs, runs) is None


def test_next_to_nothing_varies_by_chance() -> None:
    """Six times next to nothing in every run is no gap, and twice what is expected is one."""
    rng = np.random.default_rng(9)
    trials, references = toy_case(seed=4), toy_references(4)
    study = make_study(trials, Toy(), references)
    evidence = study.evidence(study.local)
    calm = [
        replace(one, excess=np.exp(rng.normal(-7.0, 0.3, one.excess.shape)))
        for one in study.healthy_runs(study.local)
    ]
    little, much = (
        chance_of_energies(evidence, np.full(evidence.base.shape, size), calm).p
        for size in (np.sqrt(0.006), np.sqrt(2.0))
    )
    assert little > 0.2
    assert much < float(ENERGY_LEVEL)


@pytest.mark.parametrize(
    ("chances", "said"),
    [
        ((0.004, 1.0, 0.3), "0.4 % of healthy sets of trials have so large a cause of some kind"),
        ((0.3, 0.002, 0.3), "0.2 % of healthy sets of trials change as much in the course of runs"),
        (
            (0.3, 1.0, 1e-7),
            "less than 0.001 % of healthy sets of trials leave as much energy in speed a that differs "
            "from cycle to cycle",
        ),
    ],
)
def test_a_report_says_why_there_is_a_gap(chances: tuple[float, float, float], said: str) -> None:
    p_cause, p_change, p_energy = chances
    shown = Detection(True, 0.001, p_cause, p_energy, p_change, 0.2, 4, "speed a", True)
    by_count = (
        "if they scatter as estimated from 4 references (20% by counting these alone); "
        "each run counts as a day of its own, as no file says its day"
    )
    assert shown.why_words == f"why a gap: {said}, {by_count}"
