"""What a chance is worth after references were searched, and how joints that differ are pooled."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from gap.diagnosis.comparison.detection import detect, detectable
from gap.diagnosis.comparison.gap_evidence import GapEvidence, compare
from gap.diagnosis.comparison.study import make_study
from gap.interfaces import Cause
from gap.residuals.chances import HeldOutChances, promised
from gap.search.candidates import shares_of
from gap.search.fit import fit_causes
from gap.search.healthy_search import View
from gap.search.novelty import chance_of
from gap.search.options import CAUSE_LEVEL
from gap.search.scatter import Usual, UsualScatter, pooled
from gap.search.selection import select
from tests.gap.sizes_of_runs import walked
from tests.gap.toy import CONDITIONS, JOINTS, LIKE, UNLIKE, Toy, walked_day


def _share_below(level: float, scale: float, seed: int, count: int = 1200) -> float:
    """How often a joint with so many times the others' scatter gets a chance below a level."""
    rng = np.random.default_rng(seed)
    hits = 0
    for _ in range(count):
        seen, known = (walked(scale * rng.standard_normal(runs)) for runs in (3, 6))
        others = [walked(rng.standard_normal(6)) for _ in range(5)]
        hits += chance_of(seen, known, others, 1) < level
    return hits / count


def test_chances_of_joints_that_scatter_alike_are_kept() -> None:
    """One side of a two-sided test: half the level; and no more careful than it must be."""
    assert 0.05 < _share_below(0.2, 1.0, seed=1) < 0.12


def test_a_joint_that_scatters_three_times_as_much_is_not_pooled_away() -> None:
    """By the five others alone, alike and known well, a level of 0.01 would be passed in 20 %."""
    assert _share_below(0.01, 3.0, seed=2) < 0.035


@pytest.mark.parametrize(("unlike", "least", "most"), [(1.0, 13, 14), (30.0, 7, 11)])
def test_what_other_joints_are_worth_follows_how_alike_they_are(
    unlike: float, least: float, most: float
) -> None:
    rng = np.random.default_rng(3)
    sizes = [walked(scale * rng.standard_normal(6)) for scale in (1, 1, unlike, 1 / unlike, 1)]
    own = [walked([0.1, -0.2, 0.3]), walked(rng.standard_normal(6))]
    assert least <= pooled(own, sizes).free <= most


@given(st.lists(st.floats(1e-9, 1.0), max_size=20), st.floats(1e-250, 1.0), st.floats(0.01, 0.2))
def test_a_calibrated_chance_is_never_below_the_tests_own(
    held_out: list[float], p: float, level: float
) -> None:
    chances = HeldOutChances(tuple(held_out))
    assert p <= chances.calibrated(p) <= 1.0
    assert chances.calibrated(chances.needed(level)) == pytest.approx(level, rel=1e-6)


def test_references_that_look_new_by_themselves_make_chances_worth_less() -> None:
    usual, odd = HeldOutChances((0.9, 0.5, 0.2) * 2), HeldOutChances((1e-3, 1e-4, 0.2) * 2)
    assert usual.calibrated(1e-6) < 1e-4
    assert odd.calibrated(1e-6) > 1e-2
    assert promised(0.05, 6) == pytest.approx(1 / 7)
    assert promised(0.05, 99) == pytest.approx(0.05)


def test_an_effect_has_the_same_share_of_a_level_at_one_place_as_at_all_joints() -> None:
    whole, both = ("lag", ()), ("friction", ())
    at_a_joint = [("friction", (joint,)) for joint in "abc"]
    shares = shares_of([whole, both, *at_a_joint])
    assert shares == pytest.approx({whole: 1 / 3, both: 1 / 3, **dict.fromkeys(at_a_joint, 1 / 9)})


def test_the_level_is_shared_by_all_causes_that_are_tried() -> None:
    known = _comparison(31, LIKE).known
    assert known is not None
    search = known.search
    assert sum(search.shares.values()) == pytest.approx(1.0)
    at_a_joint, whole = ("stiffness", ("b",)), ("lag", ())
    assert search.shares[whole] == pytest.approx(len(JOINTS) * search.shares[at_a_joint])
    chance = 1e-4
    worth = [search.among_all(chance, one) for one in (whole, at_a_joint, ("unheard of", ()))]
    assert chance < worth[0] < worth[1] == pytest.approx(worth[2])


def _comparison(
    seed: int, wander: tuple[float, ...], causes: tuple[Cause, ...] = ()
) -> GapEvidence:
    trials = [walked_day(i, 1000 * seed + i, wander, causes) for i in range(4)]
    known = [walked_day(i, 1000 * seed + 500 + i, wander) for i in range(6)]
    return compare(make_study(trials, Toy(), known), lambda share: None)


def _alarm(comparison: GapEvidence) -> bool:
    selection = select(
        comparison.evidence, comparison.candidates, comparison.signatures, lambda share: None,
        comparison.known,
    )  # fmt: skip
    by_energy = detect(comparison.evidence, comparison.runs, selection.p).by_energy
    return bool(selection.steps) or by_energy


def _alarms(count: int, wander: tuple[float, ...]) -> int:
    return sum(_alarm(_comparison(seed, wander)) for seed in range(1, count + 1))


def test_healthy_sets_with_one_joint_unlike_the_others_raise_few_alarms() -> None:
    assert _alarms(6, UNLIKE) <= 1


@pytest.mark.thorough
@pytest.mark.parametrize("wander", [LIKE, UNLIKE])
def test_false_alarms_keep_the_printed_level(wander: tuple[float, ...]) -> None:
    assert _alarms(300, wander) <= stats.binom.ppf(0.975, 300, 0.05)


def _with_gaits(view: View, differ: float) -> View:
    usual = view.usual
    kinds = (
        Usual(replace(one.together, gaits_differ=differ), one.in_gaits)
        for one in (usual.whole, usual.joint)
    )
    return replace(view, usual=UsualScatter(*kinds))


def test_a_size_is_harder_to_see_in_a_gait_that_no_reference_has_where_gaits_differ() -> None:
    references = _comparison(31, LIKE).known
    assert references is not None
    search, count = references.search, len(references.search.trials)
    known, new = ([gait] * count for gait in (CONDITIONS[0][1], "a gait that is new"))

    def ratio(gaits_differ: float) -> float:
        alone, beside = (_with_gaits(one, gaits_differ) for one in (search.alone, search.beside))
        one, own = replace(search, alone=alone, beside=beside), search.with_trials
        references = own.gaits[: len(search.references)]
        every = [
            one.visible_sizes(CAUSE_LEVEL, replace(own, gaits=(*references, *gaits)))
            for gaits in (known, new)
        ]
        sizes = [[size for _, _, size in each] for each in every]
        return float(np.median(np.array(sizes[1]) / np.array(sizes[0])))

    assert ratio(0.0) == pytest.approx(
        1.0, abs=0.1
    )  # gait by gait it is compared only with known ones
    assert ratio(10.0) > 1.5


def test_a_size_said_to_be_visible_is_found() -> None:
    healthy = _comparison(31, LIKE)
    assert healthy.known is not None
    evidence = healthy.evidence
    sizes = detectable(evidence, healthy.signatures, healthy.known, fit_causes(evidence, ()))
    size = next(s.size for s in sizes if (s.effect, s.parameter) == ("stiffness", "ratio"))
    assert 0.1 < size < 0.5  # days scatter by 0.05, and a joint has a part of its effect's share
    soft = Cause("stiffness", ("b",), (1 - size,))
    found = sum(_alarm(_comparison(seed, LIKE, (soft,))) for seed in (31, 32, 33))
    assert found >= 2


def test_no_size_is_said_to_be_visible_below_the_least_that_is_named() -> None:
    healthy = _comparison(31, LIKE)
    evidence = healthy.evidence
    loose = tuple(
        replace(one, candidate=replace(one.candidate, effect=replace(one.candidate.effect, least_size=9.0)))
        for one in healthy.signatures.each
    )  # fmt: skip
    for signatures in (healthy.signatures, replace(healthy.signatures, each=loose)):
        sizes = detectable(evidence, signatures, None, fit_causes(evidence, ()))
        lag = next(one for one in sizes if one.effect == "lag")
        least = 0.27 if signatures.each is loose else 0.0  # its spread is 0.03 s
        assert least <= lag.size < 0.271
