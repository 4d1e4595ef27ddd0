"""Faults of servo data: what play, flicker and periodic motions do by themselves is none."""

import numpy as np
import pytest

from gap.interfaces import DataFault
from gap.machines.servo_bench.simulator import servo_bench
from gap.machines.sliding_body.simulator import sliding_body
from model.motion.filters import play
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.bench_trials import IDEAL, MOTOR, servo_trial, slide_trial

COUNT = 2 * np.pi / 4096
T = np.arange(1500) / 50


def faults(command: FloatArray, shaft: FloatArray) -> dict[tuple[str, str], DataFault]:
    trial: Trial = servo_trial(IDEAL, command, np.round(shaft / COUNT) * COUNT)
    return {(one.kind, one.channel): one for one in servo_bench([trial]).check(trial)}


def test_a_shaft_that_rests_in_its_play_is_not_frozen_and_its_clock_is_right() -> None:
    command = 0.3 * np.sin(2 * np.pi * 0.05 * T)
    assert faults(command, play(command, 0.15, 0.0)) == {}


def test_a_periodic_motion_is_not_late_by_a_period() -> None:
    command = 0.4 * np.sin(2 * np.pi * 1.0 * T)
    assert faults(command, 0.4 * np.sin(2 * np.pi * 1.0 * (T - 0.12))) == {}


def test_an_encoder_that_flickers_by_a_count_has_no_spikes() -> None:
    command = np.zeros(len(T))
    shaft = np.where(np.arange(len(T)) % 97 == 0, COUNT, 0.0)
    assert faults(command, shaft) == {}


def test_a_clock_that_is_a_second_off_is_found_where_no_servo_is_so_late() -> None:
    rng = np.random.default_rng(0)
    steps = np.repeat(rng.uniform(-1.0, 1.0, 60), 25)
    command = np.convolve(steps, np.ones(15) / 15, "same")
    late = np.concatenate([np.full(50, command[0]), command[:-50]])
    assert ("clock_offset", "shaft") in faults(command, late)


def test_a_shaft_that_repeats_while_its_command_leaves_any_play_is_frozen() -> None:
    command = np.sin(2 * np.pi * 0.2 * T)
    shaft = command.copy()
    shaft[300:500] = shaft[300]
    found = faults(command, shaft)["frozen", "shaft_arm_rad"]
    assert found.evidence.startswith("repeats bit for bit for 4.0 s in 1 stretch")
    assert found.severe


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_a_torque_without_sign_is_a_fault_and_not_a_severe_one_where_it_is_not_used(
    noise: float,
) -> None:
    command = np.sin(2 * np.pi * 0.4 * T)
    torque = np.abs(np.cos(2 * np.pi * 0.4 * T)) + noise
    trial = servo_trial(IDEAL, command, command, torque=torque)
    (found,) = [f for f in servo_bench([trial]).check(trial) if f.kind == "magnitude_only"]
    assert found.channel == "torque_arm_nm"
    assert not found.severe


@pytest.mark.parametrize("samples", [0, 1, 2])
def test_a_table_of_hardly_any_rows_has_no_faults(samples: int) -> None:
    servo = servo_trial(MOTOR, np.zeros(samples))
    assert servo_bench([servo]).check(servo) == ()
    body = slide_trial(np.zeros((samples, 2)))
    assert sliding_body([body]).check(body) == ()
