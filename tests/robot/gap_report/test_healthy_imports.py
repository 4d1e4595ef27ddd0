"""Healthy runs of a lab's own robot without force sensors come in without a severe fault of their data."""

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import tomlkit

from gap.data.time_lag import lag
from gap.interfaces import Drive
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.machine import parse_machine
from record.trial.trial import Trial
from robot.config.robot_file import RobotConfig, load_robot, parse_robot
from robot.gap_report.imports import data_faults
from robot.virtual.twin_run import make_twin, plan_of, walk_fast
from tests.soaked import THOROUGH, soaked

SECONDS = 20.0
STREAMS = ("foot_m", "force_n", "body_position_m", "body_angles_rad", "command_rad", "shaft_rad")


@cache
def own_robot() -> RobotConfig:
    """Legs symmetrical about the body, as many labs draw them; no force sensors."""
    file = tomlkit.parse(load_robot().text)
    places = file["legs"]["shaft_position"]
    middle = float(np.mean([place[0] for place in places]))
    for place in places:
        place[0] = round(float(place[0]) - middle, 4)
    file["legs"]["transducer"] = [0] * len(places)
    return parse_robot(tomlkit.dumps(file))


@cache
def healthy(seed: int) -> Trial:
    config = own_robot()
    plan = plan_of(config, "tripod", None, SECONDS, 0.0)
    walked = walk_fast(config, make_twin(config, (), seed), plan, lambda _: None)
    return replace(walked, force_n=np.full_like(walked.force_n, np.nan))


@pytest.mark.parametrize("seed", soaked(range(10), lambda seed: seed == 0, mark=THOROUGH))
def test_a_healthy_run_has_no_severe_fault_and_its_clock_is_right(seed: int) -> None:
    """The lag once followed the loudest steps: a tenth of a second off, near enough to a severe fault."""
    trial = healthy(seed)
    assert [fault for fault in data_faults(trial) if fault.severe] == []
    simulator = LeggedSimulator(parse_machine(own_robot().text))
    inputs = simulator._inputs(trial)
    walk = simulator._chain.read(inputs, simulator._settings(()), Drive.MEASURED)
    third = len(inputs.time_s) // 3
    for part in (slice(0, third), slice(-third, None)):
        late = lag(inputs.time_s[part], walk.foot_m[part, :, 0], inputs.foot_m[part, :, 0])
        assert abs(late.seconds) < 0.02
        assert late.correlation <= 1


@pytest.mark.parametrize("absent", STREAMS)
@pytest.mark.parametrize(
    "legs",
    [
        pytest.param(slice(None), id="all"),
        pytest.param(slice(0, 1), id="one leg", marks=pytest.mark.soak),
    ],
)
def test_what_was_not_measured_is_checked_without_a_warning(absent: str, legs: slice) -> None:
    trial = healthy(0)
    values = getattr(trial, absent).copy()
    values[:, legs] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        faults = data_faults(replace(trial, **{absent: values}))
    assert [fault for fault in faults if fault.severe] == []
