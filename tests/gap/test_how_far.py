"""How far a gap shrinks, where a simulation breaks down or causes work against each other."""

import json
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pytest

from gap.diagnosis.answer.verdict import named_causes
from gap.diagnosis.comparison.gap_evidence import compare
from gap.diagnosis.comparison.how_far import how_far
from gap.diagnosis.comparison.study import make_study
from gap.diagnosis.diagnose import diagnose
from gap.diagnosis.held_out.drop_worse import drop_worse
from gap.interfaces import Cause, Drive
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from robot.console.json_output import json_text
from tests.gap.test_drop_worse import selected
from tests.gap.toy import Toy, toy_case, toy_references

STIFF, BIAS = Cause("stiffness", ("c",), (0.8,)), Cause("bias", ("a",), (0.1,))


@dataclass(eq=False)
class Fragile(Toy):
    """A toy whose simulation breaks down from commands as soon as there is a bias."""

    broken: float = 1e200

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        values = super().predict(trial, causes, drive)
        if drive is Drive.COMMAND and any(one.effect == "bias" for one in causes):
            values = values.copy()
            values[20:, 3:] = self.broken
        return values


@pytest.mark.parametrize("broken", [1e200, np.inf])
def test_how_far_is_not_known_where_the_simulation_breaks_down(broken: float) -> None:
    study = make_study(toy_case([STIFF], 3), Fragile(broken=broken), toy_references(3))
    held = study.held_evidence()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        far = how_far(held, (STIFF, BIAS), 0)
    assert np.isfinite([far.before, far.alone[0]]).all()
    assert np.isnan([far.after, far.shrink, far.low, far.high, far.alone[1], far.last[0]]).all()
    assert far.worse == (False, True), "the one that breaks it"
    assert far.alone[0] > 0.9
    shown = np.concatenate([one.each.ravel() for one in far.traces])
    assert np.nanmax(np.abs(shown)) < 1e3, "no curve of what is no prediction"
    assert json.loads(json_text(far))["after"] is None


def test_no_prediction_is_not_taken_for_a_right_one() -> None:
    study = make_study(toy_case([STIFF], 3), Fragile(broken=np.nan), toy_references(3))
    far = how_far(study.held_evidence(), (STIFF, BIAS), 0)
    assert far.alone[0] > 0.9
    assert far.alone[1] < 0.0
    assert far.worse == (False, True)
    assert far.after > far.before


def test_a_cause_that_breaks_the_simulation_is_not_named() -> None:
    study = make_study(toy_case([STIFF], 3), Fragile(), toy_references(3))
    comparison = compare(study, lambda _: None)
    left, far = drop_worse(comparison, selected(comparison, [STIFF, BIAS]), 0)
    assert [one.effect for one in left.fitted.causes] == ["stiffness"]
    assert far.shrink > 0.9


def test_no_cause_explains_more_than_the_gap() -> None:
    """Causes that undo each other: nobody knows the part of one."""
    study = make_study(toy_case([STIFF, BIAS], 3), Toy(), toy_references(3))
    comparison = compare(study, lambda _: None)
    selection = selected(comparison, [STIFF, BIAS])
    far = how_far(comparison.held, selection.fitted.causes, 0)
    trends = diagnose(toy_case([STIFF], 3), Toy(), toy_references(3)).causes[0].trend

    def parts(alone: tuple[float, float], last: tuple[float, float]) -> list[float]:
        other = replace(far, shrink=0.9, alone=alone, last=last)
        named = named_causes(selection, (0.9, 0.9), other, (trends,) * 2, np.ones(2), (1.0, 1.0))
        return [one.shrink for one in named]

    assert parts((0.8, 0.1), (0.8, 0.1)) == pytest.approx([0.8, 0.1])
    assert np.isnan(parts((1.5, -1.0), (1.5, -1.0))).all()
    assert parts((0.92, -0.01), (0.92, -0.01))[0] <= 1.0


def test_of_runs_below_their_baseline_no_share_is_explained() -> None:
    """They are as healthy ones; what each cause adds to the others is still of all that is closed."""
    little = Cause("stiffness", ("c",), (0.99,))
    study = make_study(toy_case([little], 2), Toy(), toy_references(2))
    far = how_far(study.held_evidence(), (little, Cause("stiffness", ("b",), (1.0,))), 0)
    assert far.before < 1.0, "or this tests nothing"
    assert far.after < far.before
    assert np.isnan([far.shrink, far.low, far.high]).all()
    assert far.alone == pytest.approx((1.0, 0.0))
    assert far.last == pytest.approx((1.0, 0.0))
