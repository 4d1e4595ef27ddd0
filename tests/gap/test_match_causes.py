"""Causes that do not fit are refused by every simulator in the same words."""

import numpy as np
import pytest

from gap.delegate import Without
from gap.interfaces import Cause, Drive, Simulator
from gap.machines.servo_bench.simulator import servo_bench
from gap.machines.sliding_body.simulator import sliding_body
from model.errors import GapError
from record.trial.trial import Trial
from tests.gap.bench_trials import MOTOR, servo_trial, slide_trial
from tests.gap.walks import command_trial, simulator

BENCH = servo_trial(MOTOR, np.sin(np.arange(200) / 20.0))
SLIDE = slide_trial(np.linspace(0.0, 1.0, 180).reshape(90, 2))


@pytest.mark.parametrize(
    ("cause", "words"),
    [
        (Cause("friction_level", (), (99.0,)), "ratio must be from 0.05 to 10, not 99"),
        (Cause("coulomb_friction", (), (99.0,)), "mu must be from 0 to 2, not 99"),
        (Cause("ground_slope", (), (0.1,)), "takes slope_x, slope_y, not 1 values"),
        (Cause("friction_level", ("arm",), (1.0,)), "'arm' is no joint; joints are none"),
        (Cause("gremlins", (), ()), "'gremlins' is no effect of sliding_body; known are"),
    ],
)
def test_a_sliding_body_refuses(cause: Cause, words: str) -> None:
    refused(sliding_body([SLIDE]), SLIDE, cause, words)


@pytest.mark.parametrize(
    ("cause", "words"),
    [
        (Cause("play", ("arm",), (0.5,)), "width_rad must be from 0 to 0.4 rad, not 0.5"),
        (Cause("play", ("arm",), (float("inf"),)), "must be finite"),
        (Cause("play", ("leg",), (0.1,)), "'leg' is no joint; joints are arm"),
        (Cause("play", (), (0.1,)), "touches single joints; name them"),
    ],
)
def test_a_servo_bench_refuses(cause: Cause, words: str) -> None:
    refused(servo_bench([BENCH]), BENCH, cause, words)


def test_legs_are_called_legs() -> None:
    walk = command_trial("tripod", 0.2, 3.0)
    refused(simulator(), walk, Cause("force_gain", ("XX",), (1.1,)), "'XX' is no leg; legs are HL")


def test_an_effect_that_was_taken_away_is_not_known() -> None:
    walk, whole = command_trial("tripod", 0.2, 3.0), simulator()
    less = Without(whole, ("force_gain", "of_another_catalogue"))
    assert {one.name for one in whole.effects} - {one.name for one in less.effects} == {
        "force_gain"
    }
    refused(less, walk, Cause("force_gain", ("ML",), (1.1,)), "'force_gain' is no effect of legged")
    late = [Cause("command_delay", (), (0.05,))]
    own, other = (one.predict(walk, late, Drive.COMMAND) for one in (less, whole))
    assert np.array_equal(own, other, equal_nan=True)


def refused(simulator: Simulator, trial: Trial, cause: Cause, words: str) -> None:
    with pytest.raises(GapError, match=words):
        simulator.predict(trial, [cause], Drive.COMMAND)
