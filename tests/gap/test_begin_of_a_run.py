"""A log may begin at any time, and anywhere in the cycle: what is compared and predicted is the same."""

from dataclasses import replace

import numpy as np
import pytest

from gap.interfaces import Drive, Simulator
from gap.machines.mujoco.machine import make_machine
from gap.machines.servo_bench.simulator import servo_bench
from gap.machines.sliding_body.simulator import sliding_body
from gap.residuals.command_cycle import command_cycle_of
from record.trial.trial import Trial
from tests.gap.bench_trials import MOTOR, servo_trial, slide_trial
from tests.gap.mjcf_arms import LOOP, arm, chirps, log_of
from tests.gap.walks import simulator as legged
from tests.gap.walks import walk

HZ = 0.5
T = np.arange(768) / 64.0  # so that times later by 64 s are the same numbers
WAVE = 0.5 * np.sin(2 * np.pi * HZ * T + 0.4) + 0.1 * np.sin(4 * np.pi * HZ * T) + 0.3


def walked() -> tuple[Simulator, Trial]:
    return legged(), walk("tripod", seconds=10.0, noise_seed=3)


def swung() -> tuple[Simulator, Trial]:
    trial = servo_trial(MOTOR, WAVE, 0.95 * WAVE, hz=64.0, frequency=HZ)
    return servo_bench([trial]), trial


def moved() -> tuple[Simulator, Trial]:
    time_s, command = chirps(4.0, 64.0)
    columns = {"time_s": time_s, "command_rad": command, "shaft_rad": 0.95 * command}
    trial = log_of(arm(), LOOP, columns)
    return make_machine([trial]), trial


def slid() -> tuple[Simulator, Trial]:
    t = np.arange(90) / 148.0
    trial = slide_trial(np.column_stack([0.8 * t - 0.7 * t**2, 0.6 * t - 0.5 * t**2]))
    return sliding_body([trial]), trial


MACHINES = {"legged": walked, "servo bench": swung, "sliding body": slid, "MJCF": moved}


@pytest.mark.parametrize("kind", MACHINES)
def test_at_what_time_a_log_begins_changes_nothing(kind: str) -> None:
    machine, trial = MACHINES[kind]()
    later = replace(trial, time_s=trial.time_s + 64.0)
    one, other = machine.observe(trial), machine.observe(later)
    for name in ("time_s", "cycle", "values", "noise", "weight"):
        np.testing.assert_allclose(getattr(other, name), getattr(one, name), atol=1e-9)
    for drive in Drive:
        np.testing.assert_allclose(
            machine.predict(later, (), drive), machine.predict(trial, (), drive), atol=1e-7
        )
    assert machine.check(later) == machine.check(trial)
    first, second = command_cycle_of(trial, one), command_cycle_of(later, other)
    assert (first is None) == (second is None)
    if first is not None and second is not None:
        assert first.distance_rad(second) < 1e-9


def test_a_swing_has_the_same_phase_wherever_it_begins() -> None:
    machine, whole = swung()
    cycles = []
    for begin in (0, 40, 77):
        trial = whole.rows(np.arange(len(T)) >= begin)
        cycles.append(np.interp(9.0, trial.time_s, machine.observe(trial).cycle))
    off = np.mod(np.array(cycles) - cycles[0] + 0.5, 1.0) - 0.5
    assert np.abs(off).max() < 1e-3
