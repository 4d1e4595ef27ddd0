"""The hexapod that somebody else wrote: repeatable, heavier with a payload, blind to a joint's own zero."""

from dataclasses import fields

import numpy as np
import pytest

from benchmarks.gap.apart.answers import questions_of
from benchmarks.gap.apart.cases import CASES, REFERENCE_RUNS
from benchmarks.gap.apart.fault import HEALTHY, Fault, Payload
from benchmarks.gap.apart.layout import JOINTS, LEGS, FloatArray
from benchmarks.gap.apart.run import GRAVITY_M_S2, simulated_run
from benchmarks.gap.apart.run_table import RunTable
from benchmarks.gap.apart.score import Answered, counts
from gap.check.cases import CaseAnswer, Named

PERIOD_S, SEED, SHORT_S = 1.6, 11, 0.2  # it still stands: nothing but weights on its feet


def run(fault: Fault = HEALTHY, seed: int = SEED) -> RunTable:
    return simulated_run(PERIOD_S, seed, fault, SHORT_S)


@pytest.fixture(scope="module")
def healthy() -> RunTable:
    return run()


def loads_n(table: RunTable) -> FloatArray:
    """Mean vertical force of each foot, without the first sample, which holds the fall on the floor."""
    mean: FloatArray = table.foot_force_n[1:, :, 2].mean(axis=0)
    return mean


def test_the_same_seed_makes_the_same_run_and_another_one_does_not(healthy: RunTable) -> None:
    again, other = run(), run(seed=SEED + 1)
    assert all(
        np.array_equal(getattr(again, f.name), getattr(healthy, f.name)) for f in fields(healthy)
    )
    assert not np.array_equal(other.foot_force_n, healthy.foot_force_n)
    assert not np.array_equal(other.position_m, healthy.position_m)


def test_a_payload_adds_its_weight_to_the_vertical_forces(healthy: RunTable) -> None:
    ahead = run(Fault(payload=Payload(0.8, 0.09, -0.04)))
    more_n = loads_n(ahead) - loads_n(healthy)
    assert more_n.sum() == pytest.approx(0.8 * GRAVITY_M_S2, rel=0.02)
    assert LEGS[int(np.argmax(more_n))] == "R1"  # the nearest


def test_a_zero_of_a_joint_shows_in_the_foot_forces_and_not_in_the_encoder(
    healthy: RunTable,
) -> None:
    turned = run(Fault("R2_lift", joint_zero_rad=0.05))
    joint, leg = JOINTS.index("R2_lift"), LEGS.index("R2")
    off_rad = abs((turned.encoder_rad - healthy.encoder_rad)[:, joint]).max()
    assert off_rad < 0.02  # what the loop gives under another load, less than half of the zero
    assert loads_n(turned)[leg] < 0.5 * loads_n(healthy)[leg]  # the foot is lifted


def test_the_cases_are_those_of_the_page() -> None:
    assert len(CASES) == 31
    assert len(questions_of(CASES)) == 34
    seeds = [one.seed for one in (*REFERENCE_RUNS, *(run for case in CASES for run in case.runs))]
    assert len(set(seeds)) == len(seeds) == 130
    assert [case.name for case in CASES if not case.effect] == ["c03", "c08", "d03", "d07"]
    broken = [case for case in CASES if case.fault != HEALTHY]
    assert all(case.effect for case in broken)
    assert len(broken) == 27


def test_a_cause_counts_at_its_joint_only_and_a_missing_answer_as_wrong() -> None:
    case = CASES[0]
    assert (case.effect, case.fault.place) == ("servo_lag", "L3_yaw")
    lag = Named("servo_lag", ("L3_yaw",), (), 0.9)
    elsewhere = Named("servo_lag", ("L2_yaw",), (), 0.9)
    named = [(lag,), (lag, elsewhere), (elsewhere, lag)]
    answered = [
        Answered(case, True, CaseAnswer("explained", "actuation", one, (), 0.0, 1.0, 60.0))
        for one in named
    ]
    first, more, *_, unanswered = counts([*answered, Answered(case, True, None)])
    assert (first.hits, first.cases) == (2, 4)
    assert (more.hits, more.cases) == (1, 2)
    assert (unanswered.hits, unanswered.cases) == (1, 4)
    assert first.words == "2 of 4 (15 to 85 %)"
