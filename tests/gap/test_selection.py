"""Candidates that are worth a fit, edges in the ground, and what a second cause must close."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

import gap.search.look as look_module
import gap.search.options as options_module
import gap.search.selection as selection_module
from gap.constants import OPEN_LEVEL, VIBRATES_LEAST
from gap.diagnosis.comparison.commissioning import standing_of
from gap.diagnosis.comparison.study import Study
from gap.interfaces import Cause, Simulator, reach_of
from gap.machines.servo_bench.catalogue import CATALOGUE as BENCH
from gap.machines.sliding_body.catalogue import CATALOGUE as SLIDING
from gap.residuals.evidence import Evidence
from gap.residuals.parts import whole_parts
from gap.residuals.predictions import Predictor
from gap.search.candidates import STEP, Candidate, candidates_of, starts_of, stepped
from gap.search.cross_validation import Advantage
from gap.search.fit import Fitted, fit_causes
from gap.search.healthy_search import HealthySearch, search_healthy
from gap.search.look import Look
from gap.search.newest import newest_left
from gap.search.options import (
    CAUSE_LEVEL,
    Option,
    ends_on_bound,
    energy_share_of,
    fit_option,
    share_of,
    shortlist,
    usual_score,
)
from gap.search.screen import Gain, gains, make_signatures
from gap.search.selection import select
from gap.search.steps import Known, Search, Selection, Step
from model.effects.causes import Scope, check_cause
from record.trial.trial import Trial
from tests.gap.toy import CONDITIONS, EFFECTS, Toy, toy_case, toy_references, toy_trial
from tests.gap.walks import cause, simulator, walk


def evidences(
    toy: Simulator, trials: list[Trial], references: list[Trial]
) -> tuple[Evidence, Known | None]:
    """Trials and references as a diagnosis sees them, all trials fitted to."""
    parts, known = whole_parts(toy, trials), whole_parts(toy, references, len(trials))
    study = Study(Predictor(toy, [*trials, *references]), parts, references=known)
    found, runs = study.evidence(study.local), study.healthy_evidence(study.local)
    if runs is None:
        return found, None
    signatures = make_signatures(found, candidates_of(toy), (), lambda share: None)
    each = study.healthy_runs(study.local)
    return found, Known(runs, each, lambda: search_healthy(found, signatures, each))


def select_all(found: Evidence, healthy: Known | None, toy: Simulator, search: Search) -> Selection:
    candidates = candidates_of(toy)
    signatures = make_signatures(found, candidates, (), lambda share: None)
    return select(found, candidates, signatures, lambda share: None, healthy, search)


def test_an_edge_is_sought_where_the_feet_went() -> None:
    trial = walk("tripod", 0.2, 6.0)
    low, high = reach_of([simulator().observe(trial)])
    path = trial.body_position_m[:, 0]
    assert low < np.nanmin(path)
    assert high > np.nanmax(path)
    step = next(e for e in simulator().effects if e.name == "ground_step")
    places = [start[1] for start in starts_of(step, [False, True], (low, high))]
    assert np.diff([low, *places, high]).max() < 0.06
    far = [start[1] for start in starts_of(step, [False, True], (2.0, 3.0))]
    assert 2.0 < min(far) < max(far) < 3.0


def test_no_fit_begins_twice_at_the_same_place_or_outside_the_bounds() -> None:
    for effect in (*simulator().effects, *BENCH, *SLIDING):
        for silent in product((False, True), repeat=len(effect.parameters)):
            starts = starts_of(effect, silent, (0.0, 30.0))
            assert len(starts) == len(set(starts))
            for start in starts:
                check_cause(
                    Candidate(effect, ()).cause(start), replace(effect, scopes=(Scope.ALL,)), ()
                )
                for i, p in enumerate(effect.parameters):
                    moved = stepped(effect.parameters, start, i, STEP)[i]
                    assert p.lower <= moved <= p.upper
                    assert moved != start[i]


def test_a_step_in_the_ground_is_found_to_two_centimetres() -> None:
    true = cause("ground_step", 0.005, 0.27)
    trials = [
        walk("tripod", 0.2, 10.0, [true], noise_seed=1),
        walk("metachronal", 0.2, 10.0, [true], noise_seed=2),
    ]
    found, _ = evidences(simulator(), trials, [])
    effects = {effect.name: effect for effect in simulator().effects}
    step = Candidate(effects["ground_step"], ())
    signatures = make_signatures(found, [step], (), lambda share: None)
    start = gains(signatures, found.base, found.weights(found.base))[0].values
    standing = found.score(found.base).sum(axis=1)
    option = fit_option(found, step, (step.cause(start),), standing)
    height_m, x_m = option.fitted.causes[0].values
    assert height_m == pytest.approx(0.005, rel=0.05)
    assert x_m == pytest.approx(0.27, abs=0.02)


def test_where_all_of_the_first_list_differs_between_days_a_second_is_fitted(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Stiffness differs by a fifth from day to day; a shaft that is 5 mrad off does not."""
    small = Cause("offset", ("b",), (0.005,))
    toy = Toy()
    found, healthy = evidences(
        toy, toy_case([small], seed=5, wander=0.2), toy_references(5, wander=0.2)
    )

    def crowded(ranked: list[Gain], most: int, near: float, least: float) -> list[Gain]:
        usual = [one for one in ranked if one.signature.candidate.effect.name == "stiffness"]
        return usual if near > 0 else shortlist(ranked, most, near, least)

    monkeypatch.setattr(look_module, "shortlist", crowded)
    both = select_all(found, healthy, toy, Search())
    assert [(c.effect, c.joints) for c in both.fitted.causes] == [("offset", ("b",))]
    monkeypatch.setattr(look_module, "LISTS", look_module.LISTS[:1])
    newest = select_all(found, healthy, toy, Search())  # it is new to first order, too
    assert [(c.effect, c.joints) for c in newest.fitted.causes] == [("offset", ("b",))]
    monkeypatch.setattr(look_module, "NEWEST", 0)
    assert select_all(found, healthy, toy, Search()).fitted.causes == ()


def test_signatures_are_made_again_of_those_alone_that_may_be_next(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(selection_module, "MAY_BE_NEXT", 1)
    monkeypatch.setattr(selection_module, "NOTHING_LEFT", 0.0)
    toy = Toy()
    both = [Cause("offset", ("b",), (0.08,)), Cause("tether", (), (0.4,))]
    found, known = evidences(toy, toy_case(both, seed=3), toy_references(5))
    made: list[set[str]] = []

    def noted(*given: object) -> object:
        made.append({one.effect.name for one in given[1]})  # type: ignore[attr-defined]
        return make_signatures(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(selection_module, "make_signatures", noted)
    chosen = select_all(found, known, toy, Search())
    assert {one.effect for one in chosen.fitted.causes} == {"offset", "tether"}
    assert made
    every = {one.effect.name for one in candidates_of(toy)}
    assert all(chosen.fitted.causes[0].effect in some and some < every for some in made)


def test_a_cause_closes_what_is_there_and_another_only_a_share() -> None:
    toy = Toy()
    found, healthy = evidences(
        toy, toy_case([Cause("stiffness", ("c",), (0.8,))], 3), toy_references(3)
    )
    assert healthy is not None
    effects = {effect.name: effect for effect in toy.effects}
    standing = fit_causes(found, ())
    unseen = found.score(found.base).sum(axis=1)
    usual = usual_score(found, healthy.runs)

    def share(name: str, joint: str, value: float) -> float:
        one = Candidate(effects[name], (joint,))
        option = fit_option(found, one, (one.cause((value,)),), unseen)
        return share_of(found, option, standing, usual)

    assert share("stiffness", "c", 0.9) > 0.95
    assert share("grip", "c", 0.9) < 0.7


def test_beside_a_cause_that_is_named_another_needs_less_to_be_named() -> None:
    """That there is a gap is known then; in a healthy machine and without references it is not."""
    healthy, known = evidences(Toy(), toy_case((), 3), toy_references(3))
    look, none = Look(healthy, known, Search()), fit_causes(healthy, ())
    named = fit_causes(healthy, (Cause("delay", (), (0.02,)),))
    assert look.level(none) == CAUSE_LEVEL
    assert look.level(named) == OPEN_LEVEL > CAUSE_LEVEL
    assert Look(healthy, None, Search()).level(named) == 1.0


def test_a_step_keeps_its_chance_in_a_healthy_machine() -> None:
    toy, soft = Toy(), Cause("stiffness", ("c",), (0.8,))
    found, known = evidences(toy, toy_case([soft], 3), toy_references(3))
    assert known is not None
    (step, *_), p = (one := select_all(found, known, toy, Search())).steps, one.p
    assert step.p == p < CAUSE_LEVEL
    (alone, *_) = select_all(found, None, toy, Search()).steps
    assert alone.p == 0.0


def test_of_a_large_misfit_a_cause_closes_energy_and_hardly_any_score() -> None:
    toy = Toy()
    found, healthy = evidences(
        toy, toy_case([Cause("offset", ("b",), (0.5,))], 3), toy_references(3)
    )
    assert healthy is not None
    standing = fit_causes(found, ())
    half = Candidate(next(e for e in toy.effects if e.name == "offset"), ("b",))
    fixed = replace(half.effect, parameters=(replace(half.effect.parameters[0], upper=0.25),))
    most = Candidate(fixed, ("b",))
    residual = found.residuals([(half.cause((0.25,)),)])[0]
    fitted = Fitted((half.cause((0.25,)),), residual, np.zeros((0,)), np.zeros(0), 0.0)
    option = Option(most, fitted, found.score(residual).sum(axis=1), Advantage(1.0, 1.0))
    share = share_of(found, option, standing, usual_score(found, healthy.runs))
    assert share < 0.3
    assert energy_share_of(found, option, standing, healthy.runs) == pytest.approx(0.75, abs=0.05)


def test_a_law_that_is_worth_little_alone_comes_with_its_partner() -> None:
    """Stiffer springs hide a law of friction, and the law the springs; only both are worth their price."""
    toy = Toy(
        tuple(
            replace(e, scopes=(Scope.ALL,))
            for e in EFFECTS
            if e.name in {"stiffness", "bias", "square_law"}
        )
    )

    def found_with(causes: list[Cause], search: Search) -> set[str]:
        conditions = (*CONDITIONS, *CONDITIONS[:2])
        runs = [toy_trial(causes, hz, g, seed=70 + i) for i, (hz, g) in enumerate(conditions)]
        found, _ = evidences(toy, runs, [])
        return {one.effect for one in select_all(found, None, toy, search).fitted.causes}

    both = [Cause("square_law", (), ()), Cause("stiffness", (), (1.3,))]
    assert found_with(both, Search(least_gain=0.3)) == set()
    assert found_with(both, Search(least_gain=0.3, laws=True)) == {"square_law", "stiffness"}
    assert found_with(both[1:], Search(least_gain=0.3, laws=True)) == {"stiffness"}


def test_the_delay_of_a_sensor_stands_however_small_it_is() -> None:
    """The largest misfit stands as a law; one of 2 % stands only if it is a sensor's."""
    sensing = Toy(tuple(replace(e, stage="sensing") if e.name == "tether" else e for e in EFFECTS))
    causes = [Cause("square_law", (), ()), Cause("tether", (), (0.4,))]
    conditions = (*CONDITIONS, *CONDITIONS[:2])
    known = [toy_trial(causes, hz, g, seed=70 + i) for i, (hz, g) in enumerate(conditions)]
    assert "tether" in {one.effect for one in standing_of(known, sensing)}


def test_a_cause_on_its_bound_gives_way_to_one_that_the_misfit_hides(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Scores are made up: nothing is fitted, only chosen."""
    effects = {effect.name: effect for effect in EFFECTS}
    found, healthy = evidences(Toy(), toy_case((), seed=2), toy_references(4))

    def option(name: str, value: float, nats: float, left: float) -> Option:
        added = Candidate(effects[name], ())
        nothing = np.zeros((0,))
        fitted = Fitted((cause(name, value),), found.base, nothing, nothing, 0.0)
        return Option(added, fitted, np.array([left]), Advantage(nats, 1.0))

    monkeypatch.setattr(options_module, "usual_score", lambda *_: np.array([1000.0]))
    stuck, free = option("lag", 9.0, 500.0, 2000.0), option("tether", 0.3, 460.0, 2040.0)
    far = option("tether", 0.3, 440.0, 2060.0)
    assert ends_on_bound(stuck)
    assert not ends_on_bound(free)

    monkeypatch.setattr(look_module, "chance_healthy", lambda *_: 1e-8)
    monkeypatch.setattr(look_module, "chance_beside_days", lambda *_: 1e-8)

    def choose(
        best: Option, p: float, options: list[Option], known: Known | None
    ) -> tuple[Option, float]:
        return Look(found, known, Search()).off_bound(best, p, options)

    option_taken, p = choose(stuck, 0.0, [stuck, free], healthy)
    assert option_taken is free
    assert 1e-8 < p < CAUSE_LEVEL
    assert choose(stuck, 0.0, [stuck, far], healthy) == (stuck, 0.0)
    assert choose(free, 0.0, [free, stuck], healthy) == (free, 0.0)
    assert choose(stuck, 0.0, [stuck, free], None) == (stuck, 0.0)


def test_a_cause_that_is_fitted_to_nothing_is_idle() -> None:
    effects = {effect.name: effect for effect in EFFECTS}
    idle = selection_module._idle
    assert idle(effects["lag"], cause("lag", 0.0))
    assert idle(effects["stiffness"], cause("stiffness", 1.0, legs=("a",)))
    assert not idle(effects["lag"], cause("lag", 1e-4))
    assert not idle(effects["square_law"], cause("square_law"))  # a law is all or nothing


def test_what_vibrates_is_idle_where_it_does_next_to_nothing_in_the_mean() -> None:
    lag = next(effect for effect in EFFECTS if effect.name == "lag")  # of a spread of 0.03
    idle = selection_module._idle
    assert idle(lag, cause("lag", 0.0029), VIBRATES_LEAST)
    assert not idle(lag, cause("lag", 0.0031), VIBRATES_LEAST)


@pytest.mark.parametrize(
    ("behind", "chances", "taken"),
    [
        (True, {"stiffness": 0.15, "tether": 0.06}, "tether"),  # both open: the surest
        (True, {"stiffness": 0.15, "tether": 0.01}, "tether"),
        (True, {"stiffness": 0.03, "tether": 0.01}, "stiffness"),  # both sure: what gains most
        (True, {"stiffness": 0.15, "tether": 0.5}, "stiffness"),
        (True, {"stiffness": 0.5, "tether": 0.06}, "tether"),
        (True, {"stiffness": 0.5, "tether": 0.5}, None),
        (False, {"stiffness": 0.15, "tether": 0.01}, "stiffness"),  # a first cause: what gains most
    ],
)
def test_a_further_cause_that_is_open_waits_for_a_surer_one(
    monkeypatch: pytest.MonkeyPatch, behind: bool, chances: dict[str, float], taken: str | None
) -> None:
    """The stiffness gains far more than the tether."""
    toy = Toy()
    trials = toy_case([Cause("stiffness", ("b",), (0.6,)), Cause("tether", (), (0.15,))], 3)
    found, healthy = evidences(toy, trials, toy_references(3))
    candidates = candidates_of(toy)
    signatures = make_signatures(found, candidates, (), lambda share: None)
    start = Selection(fit_causes(found, ()), found.score(found.base).sum(axis=1), ())
    if behind:
        delay = next(one for one in candidates if one.effect.name == "delay")
        first = fit_option(found, delay, (delay.cause((0.001,)),), start.unseen)
        start = Selection(first.fitted, first.unseen, (Step(first, ()),))

    def chance(look: Look, option: Option) -> float:
        there = option.added.joints in {(), ("b",)}
        return chances.get(option.added.effect.name, 1.0) if there else 1.0

    monkeypatch.setattr(Look, "chance", chance)
    monkeypatch.setattr(Look, "level", lambda self, fitted: OPEN_LEVEL)
    monkeypatch.setattr(Look, "_closes_enough", lambda self, one, selection: True)
    best = Look(found, healthy, Search()).one_more(start, signatures)
    assert best is not None
    if taken is None:
        assert best.p >= OPEN_LEVEL
    else:
        assert (best.chosen.added.effect.name, best.p) == (taken, chances[taken])
        assert best.chosen not in best.rivals


@pytest.mark.parametrize(("alone", "tried"), [(0.02, True), (0.2, False)])
def test_a_further_cause_is_fitted_if_it_may_be_new_by_itself(
    monkeypatch: pytest.MonkeyPatch, alone: float, tried: bool
) -> None:
    """To first order, among all, it is what healthy runs show as well; fitted, it may be clearly new."""
    toy = Toy()
    trials = toy_case([Cause("stiffness", ("b",), (0.6,)), Cause("tether", (), (0.15,))], 3)
    found, healthy = evidences(toy, trials, toy_references(3))
    assert healthy is not None
    candidates = candidates_of(toy)
    signatures = make_signatures(found, candidates, (), lambda share: None)
    start = Selection(fit_causes(found, ()), found.score(found.base).sum(axis=1), ())
    stiffness = next(one for one in candidates if one.key == ("stiffness", ("b",)))
    first = fit_option(found, stiffness, (stiffness.cause((0.6,)),), start.unseen)
    start = Selection(first.fitted, first.unseen, (Step(first, ()),))
    family = ("tether", ())
    monkeypatch.setattr(look_module, "newest_left", lambda *_: {
        one.family: alone if one.family == family else 0.5 for one in candidates
    })  # fmt: skip
    monkeypatch.setattr(HealthySearch, "among_all", lambda self, chance, family: 1.0)
    fitted: list[str] = []

    def chance(look: Look, option: Option) -> float:
        fitted.append(option.added.effect.name)
        return 1.0

    monkeypatch.setattr(Look, "chance", chance)
    Look(found, healthy, Search()).one_more(start, signatures)
    assert ("tether" in fitted) is tried


def test_what_is_newest_of_what_a_cause_leaves_is_that_which_is_left() -> None:
    toy = Toy()
    stiffness = Cause("stiffness", ("b",), (0.6,))
    trials = toy_case([stiffness, Cause("tether", (), (0.1,))], 3)
    found, healthy = evidences(toy, trials, toy_references(3))
    assert healthy is not None
    left = fit_causes(found, (stiffness,)).residual
    before = newest_left(healthy.search, found, found.base)
    after = newest_left(healthy.search, found, left)
    assert before["stiffness", ("b",)] < 1e-3 < 0.05 < after["stiffness", ("b",)]
    assert min(after, key=after.__getitem__) == ("tether", ())
