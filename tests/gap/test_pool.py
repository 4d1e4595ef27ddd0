"""Predictions on processes of this computer are those of this one, however many and however large."""

from typing import Any

import numpy as np
import pytest

from gap.interfaces import Cause, Drive
from gap.residuals import pool as pools
from gap.residuals.pool import PredictionRequest, prediction_pool
from gap.residuals.predictions import Predictor
from model.errors import GapError
from tests.gap.toy import Toy, toy_case

TRIALS = toy_case([Cause("offset", ("b",), (0.03,))], seed=8)


def asked(count: int) -> list[PredictionRequest]:
    each = [(Cause("offset", ("b",), (0.001 * n,)),) for n in range(count)]
    return [PredictionRequest(n % 2, one, Drive.COMMAND) for n, one in enumerate(each)]


@pytest.mark.parametrize("slot_share", [1.0, 0.0], ids=["shared memory", "no room there"])
def test_answers_are_those_of_one_process(
    monkeypatch: pytest.MonkeyPatch, slot_share: float
) -> None:
    monkeypatch.setattr(pools, "SLOTS", 5)
    requests = asked(13)  # more than there are slots
    made: Any = pools._Shared

    def with_room(*given: Any) -> Any:
        return made(*given[:-1], max(1, int(slot_share * given[-1])))

    monkeypatch.setattr(pools, "_Shared", with_room)
    with prediction_pool(Toy(), TRIALS, (), 2) as pool:
        there = Predictor(Toy(), TRIALS, pool).predict(requests)
    here = Predictor(Toy(), TRIALS).predict(requests)
    assert all(np.array_equal(one, other) for one, other in zip(here, there, strict=True))


def test_what_a_process_cannot_predict_is_raised_here() -> None:
    wrong = [PredictionRequest(0, (Cause("gremlins", (), ()),), Drive.COMMAND) for _ in range(2)]
    with prediction_pool(Toy(), TRIALS, (), 2) as pool, pytest.raises((GapError, KeyError)):
        pool.predict(wrong)


def test_at_least_one_process_is_needed() -> None:
    with pytest.raises(GapError, match="at least one"), prediction_pool(Toy(), TRIALS, (), 0):
        pass
