"""The engine on a tiny machine of known truth."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy import stats

from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.answer.findings import Diagnosis, Verdict
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Scope
from gap.residuals.pool import prediction_pool
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from robot.console.json_output import json_text
from tests.gap.toy import (
    CONDITIONS,
    EFFECTS,
    Toy,
    number,
    toy_case,
    toy_effect,
    toy_references,
    toy_trial,
)
from tests.soaked import THOROUGH, soaked

ONE = {
    "offset": Cause("offset", ("b",), (0.03,)),
    "stiffness": Cause("stiffness", ("c",), (0.8,)),
    "bias": Cause("bias", ("a",), (-0.3,)),
    "grip": Cause("grip", ("b",), (0.4,)),
    "square_law": Cause("square_law", (), ()),
    "tether": Cause("tether", (), (0.5,)),
    "delay": Cause("delay", (), (0.05,)),
    "lag": Cause("lag", (), (0.05,)),
}


def found(
    causes: Sequence[Cause] = (),
    *,
    references: bool = True,
    seed: int = 3,
    toy: Toy | None = None,
    **more: float,
) -> Diagnosis:
    known = toy_references(seed, **more) if references else []
    strange = more.pop("strange", 0.0)
    return diagnose(toy_case(causes, seed=seed, strange=strange, **more), toy or Toy(), known)


@cache
def known_to_all(*causes: Cause, references: bool = True) -> Diagnosis:
    """As ``found``; several tests ask for the same, and nobody can write to it."""
    return found(causes, references=references)


# With and without references; without, one of each stage in make test, and the others in make soak.
EACH = [
    pytest.param(
        name,
        references,
        marks=() if references or name in {"offset", "bias", "tether"} else pytest.mark.soak,
    )
    for name in ONE
    for references in (True, False)
]


@pytest.mark.parametrize(("name", "references"), EACH)
def test_one_cause_is_named_at_its_joint_with_its_size(name: str, references: bool) -> None:
    d = known_to_all(ONE[name], references=references)
    assert d.verdict is Verdict.EXPLAINED, d.sentence
    assert [(c.effect, c.joints) for c in d.causes] == [(name, ONE[name].joints)]
    assert d.stage == next(e.stage for e in EFFECTS if e.name == name)
    for value, true in zip(d.causes[0].values, ONE[name].values, strict=True):
        assert abs(value.value - true) < max(5 * value.error, 0.1 * abs(true - value.neutral))
    assert d.causes[0].probability > 0.9
    if name != "grip":  # too small end to end to measure by what fraction it is closed
        assert d.far.shrink > 0.9


def test_two_causes_of_different_stages() -> None:
    d = known_to_all(ONE["delay"], ONE["stiffness"])
    assert {(c.effect, c.joints) for c in d.causes} == {("delay", ()), ("stiffness", ("c",))}
    assert sum(c.shrink for c in d.causes) == pytest.approx(d.far.shrink)
    assert d.far.after < 1.2


def test_what_the_references_have_too_is_nothing_new() -> None:
    common = [Cause("square_law", (), ())]
    conditions = (*CONDITIONS, *CONDITIONS[:2])
    known = [toy_trial(common, hz, g, seed=70 + i) for i, (hz, g) in enumerate(conditions)]
    same = diagnose(toy_case(common, seed=5), Toy(), known)
    assert same.verdict is Verdict.NO_GAP
    new = diagnose(toy_case([*common, ONE["tether"]], seed=5), Toy(), known)
    assert [c.effect for c in new.causes] == ["tether"]


def test_no_gap_names_nothing_and_says_what_would_have_shown() -> None:
    d = known_to_all()
    assert d.verdict is Verdict.NO_GAP
    assert not d.causes
    assert not d.stage
    sizes = {(s.effect, s.parameter): s.size for s in d.detectable}
    assert 0 < sizes["tether", "x_n"] < 0.5
    big = Cause("tether", (), (3 * sizes["tether", "x_n"],))
    assert found([big]).verdict is not Verdict.NO_GAP


def test_where_nothing_is_found_and_no_reference_was_repeated_it_is_said() -> None:
    def told(references: list[Trial]) -> bool:
        d = diagnose(toy_case(seed=5), Toy(), references)
        assert d.verdict is Verdict.NO_GAP
        return any("no two references were commanded alike" in one for one in d.warnings)

    each_its_own = toy_references(5)[: len(CONDITIONS)]
    assert told(each_its_own)
    assert not told(toy_references(5))


def test_two_references_are_compared_with_each_other() -> None:
    known = toy_references(10, wander=0.01)[:2]
    d = diagnose(toy_case(seed=10, wander=0.01), Toy(), known)
    assert d.verdict is Verdict.NO_GAP
    assert d.detection is not None
    assert d.detection.references == 2
    assert "guarantee no less than 33%" in d.false_alarm_words
    assert any("two references hardly show" in one for one in d.warnings)
    faulty = diagnose(toy_case([Cause("lag", (), (0.1,))], seed=10, wander=0.01), Toy(), known)
    assert faulty.verdict is Verdict.EXPLAINED
    assert [one.effect for one in faulty.causes] == ["lag"]


def test_one_reference_tells_no_scatter_nor_do_two_for_one_trial_or_with_a_channel_in_one() -> None:
    trials, known = toy_case(seed=10, wander=0.01), toy_references(10, wander=0.01)[:2]
    blind = replace(known[1], force_n=np.full_like(known[1].force_n, np.nan))
    for own, references in ((trials, known[:1]), (trials[:1], known), (trials, [known[0], blind])):
        study = make_study(own, Toy(), references)
        assert not study.calibrated
        assert study.healthy_evidence(study.local) is None
    deaf = [replace(one, force_n=np.full_like(one.force_n, np.nan)) for one in trials]
    assert make_study(deaf, Toy(), [known[0], blind]).calibrated
    d = diagnose(trials, Toy(), known[:1])
    assert d.detection is None
    assert "cannot be estimated" in d.false_alarm_words


def test_a_gap_in_a_channel_that_one_reference_lacks_is_seen() -> None:
    """And one in a channel that a trial lacks: the others are compared."""
    known = toy_references(10, wander=0.01)[:4]
    known[1] = replace(known[1], force_n=np.full_like(known[1].force_n, np.nan))
    odd = [
        replace(one, force_n=one.force_n + 3.0 * np.sin(7.0 * one.time_s)[:, None, None])
        for one in toy_case(seed=10, wander=0.01)
    ]
    odd[2] = replace(odd[2], force_n=np.full_like(odd[2].force_n, np.nan))
    d = diagnose(odd, Toy(), known)
    assert d.detection is not None
    assert d.detection.p_energy < 0.01
    assert d.verdict is Verdict.UNEXPLAINED
    assert diagnose(toy_case(seed=10, wander=0.01), Toy(), known).verdict is Verdict.NO_GAP


@pytest.mark.thorough
@pytest.mark.parametrize("of_them", [(0, 1), (0, 3), (0, 4)])
def test_false_alarms_with_two_references_keep_the_aim(of_them: tuple[int, int]) -> None:
    """Of other conditions than the trials', too, and twice the same one."""
    alarms = 0
    for seed in range(6000, 6100):
        known = toy_references(seed, seconds=8.0, wander=0.01)
        trials = toy_case(seed=seed, seconds=8.0, wander=0.01)
        found = diagnose(trials, Toy(), [known[i] for i in of_them])
        alarms += found.verdict is not Verdict.NO_GAP
    assert alarms <= stats.binom.ppf(0.975, 100, 0.05)


def _false_alarms(count: int) -> int:
    alarms = 0
    for seed in range(count):
        trials = toy_case(seed=10 + seed, seconds=8.0, wander=0.01)
        known = toy_references(10 + seed, seconds=8.0, wander=0.01)
        alarms += diagnose(trials, Toy(), known, seed=seed).verdict is not Verdict.NO_GAP
    return alarms


@pytest.mark.parametrize(
    "sets", [pytest.param(12, marks=pytest.mark.soak), pytest.param(300, marks=THOROUGH)]
)
def test_false_alarms_lie_in_the_binomial_band(sets: int) -> None:
    assert _false_alarms(sets) <= stats.binom.ppf(0.975, sets, 0.05)


def test_a_pair_that_the_runs_cannot_tell_is_declared() -> None:
    """At one slow speed, a delay and a lag shift the angle alike."""
    trials = [
        toy_trial([Cause("delay", (), (0.02,))], 0.05, "trot", seconds=60.0, seed=i)
        for i in range(3)
    ]
    d = diagnose(trials, Toy())
    assert d.verdict is Verdict.AMBIGUOUS, d.sentence
    assert {d.causes[0].effect, d.ambiguous[0].effect} == {"delay", "lag"}
    assert [sorted(pair) for pair in diagnosis_json(d)["ambiguous_with"]] == [["delay", "lag"]]


@pytest.mark.parametrize(
    "name", soaked(("offset", "square_law", "delay"), lambda name: name == "offset")
)
def test_a_cause_that_the_catalogue_lacks_is_not_explained(name: str) -> None:
    rest = tuple(e for e in EFFECTS if e.name != name and (name != "delay" or e.name != "lag"))
    d = found([ONE[name]], toy=Toy(rest))
    assert d.verdict is Verdict.UNEXPLAINED, d.sentence
    assert d.none > 0.5


def test_a_near_equivalent_of_what_the_catalogue_lacks_is_doubted() -> None:
    """A bias imitates nine tenths of a stiffness."""
    rest = Toy(tuple(e for e in EFFECTS if e.name != "stiffness"))
    d, whole = found([ONE["stiffness"]], toy=rest), known_to_all(ONE["stiffness"])
    assert d.none > 2 * whole.none


def test_something_strange_is_not_explained() -> None:
    known = toy_references(3)
    d = diagnose(toy_case((), seed=3, strange=0.3), Toy(), known)
    assert d.verdict is Verdict.UNEXPLAINED, d.sentence
    assert d.stage == "press"
    assert any(cell.channel == "force" for cell in d.where.cells)


def _said(d: Diagnosis) -> object:
    return (
        d.verdict,
        [(c.effect, c.joints, tuple(round(v.value, 9) for v in c.values)) for c in d.causes],
        round(d.far.shrink, 9) if np.isfinite(d.far.shrink) else None,
    )


def test_order_and_names_of_the_catalogue_do_not_matter() -> None:
    causes = [ONE["delay"], ONE["stiffness"]]
    plain = known_to_all(*causes)
    assert _said(found(causes, toy=Toy(tuple(reversed(EFFECTS))))) == _said(plain)


def test_a_useless_effect_changes_nothing() -> None:
    idle = toy_effect("aaa_idle", "press", Scope.JOINT, number("nothing", 0.1))
    causes = [ONE["stiffness"]]
    assert _said(found(causes, toy=Toy((*EFFECTS, idle)))) == _said(known_to_all(*causes))


def test_the_same_seed_gives_the_same_diagnosis() -> None:
    first, second = known_to_all(ONE["lag"]), found([ONE["lag"]])
    assert json_text(diagnosis_json(first)) == json_text(diagnosis_json(second))


def test_processes_give_what_one_process_gives() -> None:
    trials, known = toy_case([ONE["offset"]], seed=8), toy_references(8)
    alone = diagnose(trials, Toy(), known)
    with prediction_pool(Toy(), trials, known, 2) as pool:
        together = diagnose(trials, Toy(), known, elsewhere=pool)
    assert json_text(diagnosis_json(alone)) == json_text(diagnosis_json(together))


def test_one_run_says_what_its_errors_do_not_hold() -> None:
    said = "+- covers only within-run noise"
    alone = diagnose(toy_case([ONE["offset"]], seed=8)[:1], Toy())
    assert any(said in one for one in alone.warnings)
    assert not any(said in one for one in known_to_all(ONE["offset"]).warnings)


@cache
def _soft_spring() -> tuple[list[Trial], list[Trial], Diagnosis]:
    """Runs, references and what is found."""
    trials, known = toy_case([ONE["stiffness"]], seed=6), toy_references(6)
    return trials, known, diagnose(trials, Toy(), known)


def _with_held_out(
    trials: list[Trial], d: Diagnosis, change: Callable[[FloatArray], FloatArray]
) -> list[Trial]:
    return [
        replace(one, force_n=change(one.force_n)) if i in d.held_out_trials else one
        for i, one in enumerate(trials)
    ]


def test_what_is_held_out_does_not_touch_the_fit() -> None:
    trials, known, plain = _soft_spring()
    assert plain.held_out_trials
    other = diagnose(_with_held_out(trials, plain, lambda f: 1.02 * f + 0.05), Toy(), known)
    assert [c.values for c in other.causes] == [c.values for c in plain.causes]
    assert other.far.after != plain.far.after


def test_a_cause_that_makes_held_out_runs_worse_is_not_named() -> None:
    """Fitted runs have a soft spring, the held-out run a hard one: no stiffness holds for all."""
    trials, known, plain = _soft_spring()
    other = diagnose(_with_held_out(trials, plain, lambda f: 3.0 * f + 1.0), Toy(), known)
    assert plain.verdict is Verdict.EXPLAINED
    assert other.verdict is Verdict.UNEXPLAINED
    assert other.causes == ()


def test_units_do_not_matter() -> None:
    scale = (1000.0, 1000.0, 1000.0, 0.001, 0.001, 0.001, 7.0)
    plain = known_to_all(ONE["bias"])
    scaled = found([ONE["bias"]], toy=Toy(scale=scale))
    assert scaled.verdict is plain.verdict
    assert scaled.causes[0].values[0].value == pytest.approx(
        plain.causes[0].values[0].value, rel=1e-4
    )
    assert scaled.far.after == pytest.approx(plain.far.after, rel=1e-4)


def test_one_trial_is_judged_by_its_own_end() -> None:
    trial = toy_case([ONE["stiffness"]], seed=4, seconds=40.0)[:1]
    d = diagnose(trial, Toy())
    assert [(c.effect, c.joints) for c in d.causes] == [("stiffness", ("c",))]
    assert d.far.shrink > 0.9
    assert any("only one run per gait" in words for words in d.warnings)


def test_data_faults_come_first() -> None:
    trials = toy_case(seed=4)
    trials[0] = replace(trials[0], shaft_rad=trials[0].shaft_rad * 57.3 * 4)
    d = diagnose(trials, Toy())
    assert d.data_faults[0].faults[0].kind == "unit"
    assert d.headline == "FIX THE DATA FIRST"
    assert d.sentence.startswith("Fix the data first (")
    assert diagnosis_json(d)["warnings"][0].startswith("fix the data first (")


def test_the_baselines_are_there_to_be_beaten() -> None:
    d = known_to_all(ONE["tether"])
    assert [b.method for b in d.baselines] == [
        "largest single-parameter fit",
        "forward selection by training error",
        "least squares on all parameters",
    ]
    assert all(b.causes for b in d.baselines)


def test_the_json_has_the_shape_that_was_agreed() -> None:
    told = json.loads(json_text(diagnosis_json(known_to_all(ONE["delay"], ONE["stiffness"]))))
    assert told["verdict"] in {"explained", "no_gap", "unexplained", "ambiguous"}
    assert told["where"]["stage"] in {"drive", "press", "move"}
    cause = told["causes"][0]
    assert set(cause) >= {"effect", "legs", "parameters", "probability", "shrink"}
    assert told["gap"]["after"] < told["gap"]["before"]
    assert set(told["gap"]) >= {"before", "after", "noise_floor"}


def test_nothing_to_diagnose_is_refused() -> None:
    with pytest.raises(GapError, match="no trial"):
        diagnose([], Toy())
