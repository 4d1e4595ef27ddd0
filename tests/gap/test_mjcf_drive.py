"""What drives lack is found in the angles of loops that MuJoCo steps, apart from the code under test."""

import numpy as np
import pytest

from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Drive, Simulator
from gap.machines.mujoco.machine import make_machine
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.mjcf_arms import KD, KP, LOOP, arm, chirps, log_of, stepped

WIDTH = 0.03
SHAFT_OF_FORE = ("shaft_error", "fore")


def test_a_loop_that_mujoco_steps_with_a_weaker_motor_is_named_so() -> None:
    t, command = chirps(8.0)
    weak = stepped(arm(), command, kp=0.7 * KP, kd=0.7 * KD)
    trial = log_of(arm(), LOOP, {"time_s": t, "command_rad": command, "shaft_rad": weak})
    answer = diagnose([trial], make_machine([trial]))
    assert answer.causes[0].effect == "motor_strength", answer.sentence
    assert answer.causes[0].joints == ()
    assert answer.causes[0].values[0].value == pytest.approx(0.7, abs=0.01)


@pytest.mark.parametrize(("slow", "where"), [((0, 1), ()), ((1,), ("fore",))])
def test_a_speed_limit_in_the_servos_is_found(
    slow: tuple[int, ...], where: tuple[str, ...]
) -> None:
    t, command = chirps(16.0)
    limited, most = command.copy(), 2.2 / 100.0  # rad a sample; the commands reach 5.6 rad/s
    for row in range(1, len(t)):
        step = command[row] - limited[row - 1]
        for at in slow:
            limited[row, at] = limited[row - 1, at] + np.clip(step[at], -most, most)
    columns = {"time_s": t, "command_rad": command, "shaft_rad": stepped(arm(), limited)}
    trial = log_of(arm(), LOOP, columns)
    answer = diagnose([trial], make_machine([trial]))
    assert (answer.causes[0].effect, answer.causes[0].joints) == ("speed_limit", where)
    assert answer.causes[0].values[0].value == pytest.approx(2.2, rel=0.02)


def test_play_of_a_gear_lets_the_joint_lie_at_the_flank_that_its_torque_pushes_to() -> None:
    """Where little rubs, inertia and weight decide it, and not which way the joint moves."""
    t, command = chirps(12.0)
    motor = stepped(arm(), command)
    pushed = np.sign(KP * (command - motor) - KD * np.gradient(motor, 0.01, axis=0))[:, 1]
    crossing = np.convolve(pushed, np.full(5, 0.2), mode="same")
    shaft = motor.copy()
    shaft[:, 1] -= 0.5 * WIDTH * crossing
    trial = log_of(arm(), LOOP, {"time_s": t, "command_rad": command, "shaft_rad": shaft})
    machine = make_machine([trial])
    (wanted,) = (k for k, c in enumerate(machine.channels) if (c.name, c.joint) == SHAFT_OF_FORE)
    seen = machine.observe(trial).values[:, wanted]
    left = {
        form: float(np.sqrt(np.nanmean((seen - _predicted(machine, trial, form)[:, wanted]) ** 2)))
        for form in ("", "play", "backlash")
    }
    assert left["backlash"] < 0.5 * min(left[""], left["play"])


def _predicted(machine: Simulator, trial: Trial, form: str) -> FloatArray:
    causes = [Cause(form, ("fore",), (WIDTH,))] if form else []
    return machine.predict(trial, causes, Drive.MEASURED)
