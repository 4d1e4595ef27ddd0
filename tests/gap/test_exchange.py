"""A gap that only a held-out run shows, and causes that held-out runs do not show."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.comparison.commissioning import commissioned_study
from gap.diagnosis.comparison.exchange import with_gap_fitted
from gap.diagnosis.comparison.study import Exchange, Study, make_study
from gap.diagnosis.diagnose import diagnose, diagnose_study
from gap.interfaces import Cause, Drive, Effect, Parameter, Scope
from gap.residuals.hold_out import HoldOut
from gap.search.fit import fit_causes
from gap.search.standard_errors import standard_errors
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.toy import CONDITIONS, EFFECTS, Toy, toy_effect, toy_trial

HELD = 1  # by the rule, the last of its gait
LARGE = Cause("bias", ("b",), (3.0,))
REFERENCES = [toy_trial([], *CONDITIONS[at % 4], seed=50 + at) for at in range(4)]


def trials(only: int | None, cause: Cause = LARGE) -> list[Trial]:
    """Four runs, of which one has a cause."""
    return [
        toy_trial([cause] if at == only else [], *CONDITIONS[at], seed=10 + at) for at in range(4)
    ]


def study(only: int | None, hold_out: HoldOut | None = None) -> Study:
    return make_study(trials(only), Toy(), REFERENCES, hold_out=hold_out)


def fitted_and_held(one: Study) -> tuple[list[int], list[int]]:
    return [part.trial for part in one.fitted], [part.trial for part in one.held]


def test_the_run_that_alone_shows_a_gap_is_fitted_to() -> None:
    before = study(HELD)
    (part,) = before.held
    assert part.trial == HELD
    after = with_gap_fitted(before)
    fitted, (held,) = fitted_and_held(after)
    assert HELD in fitted
    assert after.held[0].gait == part.gait
    assert after.exchange == Exchange(HELD, held)
    assert sorted([*fitted, held]) == [0, 1, 2, 3]


def test_a_reader_learns_of_it() -> None:
    d = diagnose(trials(HELD), Toy(), REFERENCES)
    assert HELD in d.fitted_trials
    (note,) = (one for one in d.warnings if "held out in its place" in one)
    assert note.startswith(f"run {HELD + 1} shows a gap")


@pytest.mark.parametrize("only", [None, 0])
def test_nothing_is_exchanged_where_fitted_runs_show_as_much(only: int | None) -> None:
    one = study(only)
    assert with_gap_fitted(one) is one


def test_runs_that_a_person_holds_out_stay_held_out() -> None:
    one = study(HELD, HoldOut((HELD,)))
    assert with_gap_fitted(one) is one


def test_without_references_nothing_is_exchanged() -> None:
    one = make_study(trials(HELD), Toy())
    assert with_gap_fitted(one) is one


class Stopped(Toy):
    """Its forces have an end stop, which one of two gaits reaches."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        limit = Parameter("limit_n", "N", 90.0, 0.2, 90.0, 30.0)
        return (*EFFECTS, toy_effect("stop", "press", Scope.ALL, limit))

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        stops = [cause.values[0] for cause in causes if cause.effect == "stop"]
        rest = [cause for cause in causes if cause.effect != "stop"]
        return with_stop(super().predict(trial, rest, drive), min([np.inf, *stops]))


def with_stop(values: FloatArray, limit_n: float) -> FloatArray:
    out = values.copy()
    out[:, 3:6] = np.minimum(out[:, 3:6], limit_n)
    return out


def stopped_run(at: int, limit_n: float) -> Trial:
    hz, gait = CONDITIONS[at % 4]
    one = toy_trial([Cause("offset", ("c",), (0.1,))], hz, gait, seed=20 + at)
    force = one.force_n.copy()
    force[..., 2] = np.minimum(force[..., 2], limit_n)
    return replace(one, force_n=force)


def test_a_number_that_one_run_shows_is_not_judged_without_that_run() -> None:
    """Without it the number would be what it is where nothing happens, and its error as large as that."""
    runs = [stopped_run(at, 4.6) for at in (0, 2, 3, 6)]
    study = make_study(runs, Stopped(), REFERENCES, hold_out=HoldOut((3,)))
    evidence = study.evidence(study.local)
    start = (Cause("offset", ("c",), (0.1,)), Cause("stop", (), (4.5,)))
    fitted = fit_causes(evidence, start)
    _, stop = standard_errors(evidence, None, fitted)
    spread = Stopped().effects[-1].parameters[0].spread
    assert fitted.causes[1].values[0] == pytest.approx(4.6, rel=0.02)
    assert stop * spread < 0.5


def test_a_cause_that_held_out_runs_do_not_show_stays_and_it_is_written() -> None:
    runs = [stopped_run(at, 4.6) for at in range(8)]
    reached = [bool((one.force_n[..., 2] >= 4.6).any()) for one in runs]
    assert reached == [gait == "walk" for _, gait in CONDITIONS] * 2
    held_out = HoldOut((6, 7))
    d = diagnose_study(commissioned_study(runs, Stopped(), REFERENCES, hold_out=held_out))
    named = {one.effect: one for one in d.causes}
    assert set(named) == {"stop", "offset"}
    assert named["stop"].values[0].value == pytest.approx(4.6, rel=0.02)
    assert np.isnan(named["stop"].shrink)
    assert named["offset"].shrink > 0.5
    assert any("do not show stop" in one for one in d.warnings)
    (written,) = (one for one in diagnosis_json(d)["causes"] if one["effect"] == "stop")
    assert written["shrink_last"] is None or np.isnan(written["shrink_last"])
