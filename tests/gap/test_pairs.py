"""Causes that only explain together, effects with nothing measured between them, causes worse than none."""

from dataclasses import replace

import numpy as np
import pytest

from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Drive
from gap.machines.servo_bench.simulator import servo_bench
from record.trial.trial import Trial
from tests.gap.bench_trials import MOTOR, servo_trial

T = np.arange(500) / 50
WAVES = (0.3, 0.5, 0.8)


def runs(robot: str, *there: Cause, duty: bool = True) -> list[Trial]:
    made = []
    for number, hertz in enumerate(WAVES):
        command = 1.2 * np.sin(2 * np.pi * hertz * T) + 0.4 * np.sin(5.1 * hertz * T)
        trial = servo_trial(robot, command)
        predicted = servo_bench([trial]).predict(trial, there, Drive.COMMAND)
        noise = np.random.default_rng(number).normal(0, 0.001, (len(T), 2))
        shaft = (command + predicted[:, 0] + noise[:, 0])[:, None]
        pwm = predicted[:, 1:2] + 5 * noise[:, 1:] if duty else trial.pwm
        made.append(replace(trial, shaft_rad=shaft, pwm=pwm))
    return made


@pytest.mark.parametrize(
    ("duty", "verdict"), [(True, Verdict.EXPLAINED), (False, Verdict.AMBIGUOUS)]
)
def test_gain_and_motor_are_told_apart_by_the_duty_alone(duty: bool, verdict: Verdict) -> None:
    trials = runs(MOTOR, Cause("controller_gain", ("arm",), (0.5,)), duty=duty)
    answer = diagnose(trials, servo_bench(trials))
    assert answer.verdict is verdict
    first = answer.causes[0]
    motor = {"supply_voltage", "torque_constant", "winding_resistance"}
    if duty:
        assert first.effect == "controller_gain"
        assert not answer.ambiguous
        return
    group = {"controller_gain", *motor}
    assert {one.effect for one in answer.ambiguous if one.of[0] == first.effect} >= group - {
        first.effect
    }
    # nothing tells the four apart; a droop and a scale come near them
    near = {"gravity_droop", "encoder_scale", "payload"}
    others = sum(one.probability for one in answer.rivals if one.effect in near)
    assert others < 0.15
    assert first.probability == pytest.approx((1 - answer.none - others) / 4, rel=0.01)
    tells = [one.why for one in answer.ambiguous if one.tells]
    assert tells[0] == "nothing was measured between them: log the duty (pwm_J) or the current"


def test_friction_that_was_fitted_into_the_motor_is_named_with_the_constant_that_hid_it() -> None:
    """Coulomb friction and a weak motor of the file imitate a friction that grows with the load."""
    true = MOTOR.replace("coulomb_nm = 0.02", "coulomb_nm = 0.0")
    trials = runs(true, Cause("load_friction", ("arm",), (0.4,)))
    nominal = true.replace("resistance_ohm = 4.0", "resistance_ohm = 5.6")
    nominal = nominal.replace("coulomb_nm = 0.0", "coulomb_nm = 0.05")
    trials = [replace(one, header=replace(one.header, robot_text=nominal)) for one in trials]
    answer = diagnose(trials, servo_bench(trials))
    names = {one.effect for one in answer.causes}
    assert names & {"load_friction", "stribeck_load_friction"}
    assert answer.far.after < 0.5 * answer.far.before


def test_nothing_is_named_that_held_out_runs_deny() -> None:
    """One motion lacks something else than the others, and judges: what is named may not make it worse."""
    trials = runs(MOTOR, Cause("encoder_offset", ("arm",), (0.05,)))
    other = runs(MOTOR, Cause("encoder_offset", ("arm",), (-0.05,)))[-1]
    answer = diagnose([*trials[:2], other], servo_bench(trials))
    assert not answer.far.after > answer.far.before
