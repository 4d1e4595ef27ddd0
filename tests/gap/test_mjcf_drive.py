"""What drives lack is found in the angles of loops that MuJoCo steps, apart from the code under test."""

import numpy as np
import pytest

from gap.diagnosis.diagnose import diagnose
from gap.machines.mujoco.machine import make_machine
from tests.gap.mjcf_arms import KD, KP, LOOP, arm, chirps, log_of, stepped


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
