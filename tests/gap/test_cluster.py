"""Predictions on a cluster: each worker makes the simulator once, answers are those of one process."""

import pickle
from concurrent.futures import Executor, ThreadPoolExecutor
from functools import partial
from threading import Event

import numpy as np
import pytest

from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Drive
from gap.machines.mujoco.machine import make_machine
from gap.residuals import cluster
from gap.residuals.cluster import ClusterPredictions, Installation, Made
from gap.residuals.pool import PredictionRequest
from gap.residuals.predictions import Predictor
from model.errors import GapError
from robot.console.json_output import json_text
from tests.gap.mjcf_arms import arm_log
from tests.gap.toy import Toy, toy_case

OFFSET = Cause("offset", ("b",), (0.03,))
made_here: list[str] = []


def make_toy(seed: int) -> Made:
    made_here.append("toy")
    return Toy(), tuple(toy_case([OFFSET], seed=seed))


def make_arm() -> Made:
    trial = arm_log(2.0)
    return make_machine([trial]), (trial,)


@pytest.fixture
def pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(2)


def elsewhere(pool: Executor, installed: Installation, workers: int = 2) -> ClusterPredictions:
    return ClusterPredictions(pool, installed, lambda: workers)


def test_a_diagnosis_on_a_cluster_is_that_of_one_process_and_the_simulator_is_made_once(
    pool: ThreadPoolExecutor,
) -> None:
    sent = pickle.loads(pickle.dumps(Installation(partial(make_toy, 8))))
    made_here.clear()
    trials = toy_case([OFFSET], seed=8)
    here = diagnose(trials, Toy())
    there = diagnose(trials, Toy(), elsewhere=elsewhere(pool, sent))
    assert json_text(diagnosis_json(here)) == json_text(diagnosis_json(there))
    assert made_here == ["toy"]


def test_a_machine_that_predicts_many_at_once_gets_batches(pool: ThreadPoolExecutor) -> None:
    machine, trials = make_arm()
    causes = [(Cause("coulomb_friction", ("fore",), (0.01 * n,)),) for n in range(1, 10)]
    asked = [PredictionRequest(0, one, Drive.COMMAND) for one in causes]
    here = Predictor(machine, trials).predict(asked)
    there = Predictor(machine, trials, elsewhere(pool, Installation(make_arm))).predict(asked)
    for one, other in zip(here, there, strict=True):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-9)


def test_a_cluster_without_workers_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "WATCH_S", 0.01)
    stuck = ThreadPoolExecutor(1)
    release = Event()
    stuck.submit(release.wait)  # nothing behind it begins
    try:
        lost = elsewhere(stuck, Installation(partial(make_toy, 1)), workers=0)
        with pytest.raises(GapError, match="the cluster lost all its workers"):
            lost.predict([PredictionRequest(0, (), Drive.COMMAND)] * 3)
    finally:
        release.set()


def test_what_a_worker_cannot_predict_is_raised_here(pool: ThreadPoolExecutor) -> None:
    there = elsewhere(pool, Installation(partial(make_toy, 1)))
    wrong = PredictionRequest(0, (Cause("nonsense", (), ()),), Drive.COMMAND)
    with pytest.raises(GapError, match="nonsense"):
        there.predict([wrong, wrong])
