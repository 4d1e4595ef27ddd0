"""Faults of servo data: what play, flicker and periodic motions do by themselves is none."""

from dataclasses import replace

import numpy as np
import pytest

from gap.interfaces import DataFault, Drive
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


def test_a_reading_that_freezes_for_good_while_the_shaft_was_moved_by_less_is_frozen() -> None:
    command = np.sin(2 * np.pi * 0.2 * T)
    shaft = command.copy()
    shaft[1000:] = shaft[1000]
    assert faults(command, shaft)["frozen", "shaft_arm_rad"].severe


@pytest.mark.parametrize("gain", [0.3, 0.6])
def test_a_weak_loop_whose_shaft_sticks_at_rest_has_no_faults(gain: float) -> None:
    """Stiction holds it bit for bit while the command goes on; its duty reaches the real limit."""
    robot = MOTOR.replace("coulomb_nm = 0.02", "coulomb_nm = 0.15")
    robot = robot.replace("kp_duty_per_rad = 4.0", f"kp_duty_per_rad = {gain}")
    command = 1.5 * np.sin(2 * np.pi * 0.2 * T)
    trial = servo_trial(robot, command)
    predicted = servo_bench([trial]).predict(trial, (), Drive.COMMAND)
    shaft = np.round((command + predicted[:, 0]) / COUNT) * COUNT
    longest = max(map(len, "".join("=" if d == 0 else "x" for d in np.diff(shaft)).split("x")))
    assert longest > 25, "half a second at rest"
    duty = np.clip(3.0 * predicted[:, 1], -1.0, 1.0)
    measured = replace(trial, shaft_rad=shaft[:, None], pwm=duty[:, None])
    assert servo_bench([trial]).check(measured) == ()


@pytest.mark.parametrize(
    ("factor", "words"), [(1e3, "time is not in seconds"), (1e-4, "2e-06 s apart")]
)
def test_time_in_another_unit_is_said(factor: float, words: str) -> None:
    command = np.sin(2 * np.pi * 0.2 * T)
    trial = servo_trial(IDEAL, command)
    header = replace(trial.header, sample_rate_hz=np.nan)
    scaled = replace(trial, header=header, time_s=trial.time_s * factor)
    found = servo_bench([trial]).check(scaled)[0]
    assert (found.kind, found.channel, found.severe) == ("unit", "time_s", True)
    assert words in found.evidence


def test_angles_that_are_not_in_radians_are_said() -> None:
    command = np.sin(2 * np.pi * 0.5 * T)
    found = faults(1e3 * command, 1e3 * command)
    assert found["unit", "shaft_arm_rad"].severe


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
