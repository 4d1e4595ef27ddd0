"""Whatever measures a gap works on the study of the diagnosis: the same simulator, the same runs."""

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap.delegate import Delegate
from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.comparison.commissioning import commissioned_study
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.diagnosis.remeasured import remeasure
from gap.experiments.open_causes import discriminating_runs, open_sets
from gap.interfaces import Cause, Drive, Proposal
from gap.residuals.hold_out import HoldOut
from gap.search.candidates import Candidate
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.toy import CONDITIONS, EFFECTS, Toy, toy_case, toy_references, toy_trial

ROOT = Path(__file__).resolve().parents[2]
LAW = Cause("square_law", (), ())
STRONG = Cause("stiffness", ("a",), (1.3,))
# what no channel of the toy would tell apart, by its own account
DELAY = replace(EFFECTS[0], alike=("lag",), tells="the command")
CATALOGUE = (DELAY, *EFFECTS[1:])
LATE = Cause("delay", (), (0.03,))
LARGE = Cause("bias", ("b",), (3.0,))


class Corrected(Delegate):
    """A machine whose file holds causes."""

    def __init__(self, causes: Sequence[Cause]) -> None:
        super().__init__(Toy())
        self.causes = tuple(causes)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        return self.inner.predict(trial, (*causes, *self.causes), drive)


def lawful(*causes: Cause, first: int = 0) -> list[Trial]:
    """Runs of a machine with a law that its simulator lacks."""
    conditions = (*CONDITIONS, *CONDITIONS[:2])
    return [
        toy_trial([LAW, *causes], hz, gait, seed=first + at)
        for at, (hz, gait) in enumerate(conditions)
    ]


def proposals() -> list[Proposal]:
    return [
        Proposal(f"{gait} {hz}", toy_trial([], hz, gait, 6.0), 1.0, "") for hz, gait in CONDITIONS
    ]


def test_a_corrected_machine_has_the_figure_of_the_diagnosis() -> None:
    trials, references = lawful(STRONG), lawful(first=50)
    d = diagnose(trials, Toy(), references)
    assert d.standing == (LAW,)
    assert [one.effect for one in d.causes] == ["stiffness"]
    causes = [one.cause for one in d.causes]
    held = HoldOut(d.held_out_trials)
    study = commissioned_study(trials, Toy(), references, hold_out=held, standing=d.standing)
    far = remeasure(study, Corrected(causes))
    found = (far.before, far.after, far.shrink, far.low, far.high)
    told = (d.far.before, d.far.after, d.far.shrink, d.far.low, d.far.high)
    assert found == pytest.approx(told, rel=1e-9)
    # the simulator without the law has another gap
    other = remeasure(make_study(trials, Toy(), references, hold_out=held), Corrected(causes))
    assert not np.isclose(other.before, far.before, rtol=0.05)


def test_a_run_that_changed_places_stays_where_it_is() -> None:
    trials = [
        toy_trial([LARGE] if at == 1 else [], *CONDITIONS[at], seed=10 + at) for at in range(4)
    ]
    references = [toy_trial([], *one, seed=50 + at) for at, one in enumerate(CONDITIONS)]
    d = diagnose(trials, Toy(), references)
    assert 1 in d.fitted_trials, "by the rule it would judge"
    for hold_out, standing in ((None, None), (HoldOut(d.held_out_trials), d.standing)):
        study = commissioned_study(trials, Toy(), references, None, hold_out, standing)
        assert sorted(one.trial for one in study.fitted) == list(d.fitted_trials)
        far = remeasure(study, Corrected([one.cause for one in d.causes]))
        assert (far.before, far.after) == pytest.approx((d.far.before, d.far.after), rel=1e-9)


def test_the_same_runs_are_proposed_from_what_a_diagnosis_wrote() -> None:
    """Beside a law that only the baseline model errors hold."""
    trials = [
        toy_trial([LAW, LATE], *one, seed=at, wander=0.02) for at, one in enumerate(CONDITIONS)
    ]
    references = [
        toy_trial([LAW], *one, seed=50 + at, wander=0.02) for at, one in enumerate(CONDITIONS * 2)
    ]
    d = diagnose(trials, Toy(CATALOGUE), references, proposer=proposals)
    assert d.standing
    assert d.next
    written = diagnosis_json(d)
    effects = {one.name: one for one in EFFECTS}
    rivals = [
        (one["cause"], Candidate(effects[one["form"]], tuple(one["legs"])))
        for one in written["open_rivals"]
    ]
    assert [one["form"] for one in written["open_rivals"]] == ["lag"]
    assert [written["causes"][of]["effect"] for of, _ in rivals] == [
        one.of[0] for one in d.ambiguous
    ]
    held = HoldOut(d.held_out_trials)
    study = commissioned_study(
        trials, Toy(CATALOGUE), references, hold_out=held, standing=d.standing
    )
    known, floor = study.predictor, study.floor(study.judging)
    causes = tuple(one.cause for one in d.causes)
    sets = open_sets(known, trials, floor, causes, rivals, study.judging)
    ranked = discriminating_runs(known, floor, sets, proposals())
    assert [one.name for one in ranked] == [one.name for one in d.next]
    for one, other in zip(ranked, d.next, strict=True):
        assert one.separation == pytest.approx(other.separation, rel=1e-6)


def test_few_references_show_no_baseline() -> None:
    study = commissioned_study(toy_case([LAW]), Toy(), toy_references()[:1])
    assert study.predictor.standing == ()


def test_there_is_one_way_to_a_study() -> None:
    """A study without its baseline model errors measures another simulator than the diagnosis."""
    makers = {
        path.relative_to(ROOT).as_posix()
        for folder in ("gap", "robot", "bigant", "benchmarks")
        for path in (ROOT / folder).rglob("*.py")
        if re.search(r"\bmake_study\(", path.read_text(encoding="utf-8"))
    }
    assert makers == {
        "gap/diagnosis/comparison/study.py",
        "gap/diagnosis/comparison/commissioning.py",
    }
