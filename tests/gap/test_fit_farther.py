"""A descent that creeps begins again farther from neutral."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest

from gap.diagnosis.comparison.study import Study
from gap.interfaces import Cause, Drive
from gap.residuals.evidence import Evidence
from gap.residuals.parts import whole_parts
from gap.residuals.predictions import Predictor
from gap.search.candidates import Candidate
from gap.search.fit import Fitted, fit_causes
from gap.search.options import fit_option
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.toy import CHANNELS, EFFECTS, Toy, toy_trial

BIAS = next(one for one in EFFECTS if one.name == "bias")
FORCE = next(i for i, one in enumerate(CHANNELS) if (one.name, one.joint) == ("force", "a"))


@dataclass(eq=False)
class Jumpy(Toy):
    """Whatever size a bias has, the force jumps by its noise, in other frames for each size.

    So do feet that begin to slip one by one: the slopes are mostly of these jumps.
    """

    rough_n: float = 0.05

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        out = super().predict(trial, causes, drive).copy()
        for one in causes:
            if one.effect == "bias":
                phase = np.random.default_rng(1).uniform(0, 2 * np.pi, len(out))
                out[:, FORCE] += self.rough_n * np.sin(200.0 * one.values[0] + phase)
        return out


def fitted(seen: Evidence, start: tuple[Cause, ...]) -> Fitted:
    standing = np.full(len(seen.starts), 1e9)
    return fit_option(seen, Candidate(BIAS, ("a",)), start, standing).fitted


def evidence(rough_n: float) -> Evidence:
    trial = toy_trial([Cause("bias", ("a",), (0.6,))], seconds=16.0, seed=3)
    jumpy = Jumpy(rough_n=rough_n)
    study = Study(Predictor(jumpy, [trial]), whole_parts(jumpy, [trial]))
    return study.evidence(study.local)


def test_a_descent_that_creeps_begins_again_farther_from_neutral() -> None:
    seen, start = evidence(0.05), (Cause("bias", ("a",), (0.05,)),)
    by_itself = fit_causes(seen, start)
    assert by_itself.stuck
    assert by_itself.causes[0].values[0] < 0.4
    again = fitted(seen, start)
    assert again.nats < by_itself.nats - 100.0
    assert again.causes[0].values[0] == pytest.approx(0.6, abs=0.1)


def test_a_descent_that_ends_where_it_should_is_left_alone() -> None:
    seen, start = evidence(0.0), (Cause("bias", ("a",), (0.05,)),)
    by_itself = fit_causes(seen, start)
    assert not by_itself.stuck
    assert fitted(seen, start).causes == by_itself.causes


@pytest.mark.parametrize("begin", [-0.9, -0.7])
def test_a_descent_that_is_stuck_on_the_wrong_side_begins_again_on_the_other(begin: float) -> None:
    seen, start = evidence(0.05), (Cause("bias", ("a",), (begin,)),)
    by_itself = fit_causes(seen, start)
    assert by_itself.stuck
    assert by_itself.causes[0].values[0] < 0.0
    assert fitted(seen, start).causes[0].values[0] == pytest.approx(0.6, abs=0.1)
