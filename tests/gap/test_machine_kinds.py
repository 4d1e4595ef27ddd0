"""Machines come in by entry points or as FILE.py:make, and what is wrong with one is said in a sentence."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gap.delegate import MachineOfEach
from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Drive
from gap.machine_kinds import kind_named, kind_of_file, machine_kinds, simulator_of
from gap.machines.servo_bench.simulator import servo_bench
from model.errors import GapError
from record.trial.trial import Trial
from tests.gap.bench_trials import MOTOR, servo_trial

EXAMPLE = Path(__file__).resolve().parents[2] / "examples" / "own_machine.py"
T = np.arange(600) / 50
SWING = 0.8 * np.sin(2 * np.pi * 0.4 * T) + 0.3 * np.sin(2 * np.pi * 1.1 * T)


def moved(robot: str, *causes: Cause, hertz: float = 50.0) -> Trial:
    """A run of a servo with causes in it, and the noise of its encoder and duty."""
    trial = servo_trial(robot, SWING, hz=hertz)
    predicted = servo_bench([trial]).predict(trial, causes, Drive.COMMAND)
    noise = np.random.default_rng(len(robot)).normal(0, 0.001, len(SWING))
    shaft = (SWING + predicted[:, 0] + noise)[:, None]
    return replace(trial, shaft_rad=shaft, pwm=predicted[:, 1:2] + 5 * noise[:, None])


def test_ours_are_registered_as_a_lab_s_own_would_be() -> None:
    assert {"legged", "servo_bench", "sliding_body"} <= set(machine_kinds())
    trial = servo_trial(MOTOR, SWING)
    assert simulator_of(kind_named("servo_bench"), [trial]).joints == ("arm",)
    with pytest.raises(
        GapError, match=r"no kind of machine is called 'crane'.*--machine FILE\.py:make"
    ):
        kind_named("crane")


def test_a_lab_s_own_machine_is_one_file() -> None:
    assert len(EXAMPLE.read_text().splitlines()) < 100
    kind = kind_of_file(f"{EXAMPLE}:make")
    assert kind.name == "own_machine"
    trial = servo_trial(MOTOR, SWING, torque=np.cos(T))
    simulator = simulator_of(kind, [trial])
    assert [effect.name for effect in simulator.effects] == ["tendon_stretch", "slack"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", r"it needs a function make\(trials\) that returns the machine$"),
        ("def build(trials): ...", r"needs a function make\(trials\).*; it has build"),
        ("make = 3", r"is no function and no MachineKind, but int"),
        ("import nothing_of_this_name", r"cannot be run: ModuleNotFoundError: No module"),
        ("def make(trials):\n    return trials[0]", r"makes a Trial without name, stages"),
        (
            "def make(trials):\n    return 1 / 0",
            r"own.py:make raises ZeroDivisionError: division by zero",
        ),
    ],
)
def test_a_file_that_makes_no_machine_says_why(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "own.py"
    file.write_text(text)
    with pytest.raises(GapError, match=words) as refused:
        simulator_of(kind_of_file(f"{file}:make"), [servo_trial(MOTOR, SWING)])
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("name", "words"),
    [("own.py", "name the function behind the file"), ("nowhere.py:make", "there is no file")],
)
def test_a_machine_that_is_not_there(name: str, words: str) -> None:
    with pytest.raises(GapError, match=words):
        kind_of_file(name)


def test_each_trial_is_simulated_with_its_own_file_and_a_common_cause_is_fitted_over_all() -> None:
    weak = MOTOR.replace("kp_duty_per_rad = 4.0", "kp_duty_per_rad = 1.0")
    halved = Cause("controller_gain", ("arm",), (0.5,))
    trials = [moved(one, halved) for one in (MOTOR, weak, MOTOR, weak)]
    simulator = simulator_of(kind_named("servo_bench"), trials)
    for one in trials:
        own = servo_bench([one]).predict(one, (), Drive.COMMAND)
        assert np.array_equal(simulator.predict(one, (), Drive.COMMAND), own)
    answer = diagnose(trials, simulator)
    assert answer.verdict is Verdict.EXPLAINED
    assert [cause.effect for cause in answer.causes] == ["controller_gain"]
    assert answer.causes[0].values[0].value == pytest.approx(0.5, abs=0.01)


def test_constants_of_the_log_stand_in_for_those_of_the_file() -> None:
    trial = servo_trial(MOTOR, SWING)
    logged = replace(trial.header, constants=(("kp_duty_per_rad", (1.0,)),))
    other = replace(trial, header=logged)
    simulator = simulator_of(kind_named("servo_bench"), [trial, other])
    assert isinstance(simulator, MachineOfEach)
    weak = MOTOR.replace("kp_duty_per_rad = 4.0", "kp_duty_per_rad = 1.0")
    expected = servo_bench([servo_trial(weak, SWING)]).predict(trial, (), Drive.COMMAND)
    assert np.array_equal(simulator.predict(other, (), Drive.COMMAND), expected)


def test_machines_of_one_diagnosis_may_not_differ_in_what_is_compared() -> None:
    ideal = servo_trial('kind = "servo_bench"\n[joint.arm]\n', SWING)
    renamed = replace(ideal, header=replace(ideal.header, robot_file="ideal.toml"))
    with pytest.raises(
        GapError, match=r"channels may not differ .* bench\.toml and ideal\.toml .*duty"
    ):
        simulator_of(kind_named("servo_bench"), [servo_trial(MOTOR, SWING), renamed])


def test_a_log_of_another_robot_s_joints_is_refused() -> None:
    trial = servo_trial(MOTOR, SWING)
    other = replace(trial, header=replace(trial.header, joints=("elbow",)))
    with pytest.raises(GapError, match="the machine's file has joints arm, the log has elbow"):
        simulator_of(kind_named("servo_bench"), [other])
