"""The servo bench against physics worked out by hand; every effect at its neutral value is nothing."""

import numpy as np
import pytest

from gap.interfaces import Cause, Drive
from gap.machines.servo_bench.simulator import ServoBench, servo_bench
from model.errors import GapError
from tests.gap.bench_trials import IDEAL, MOTOR, servo_trial

G = 9.80665
STILL = np.full(400, 0.6)
T = np.arange(600) / 50.0
WAVE = 0.5 * np.sin(2 * np.pi * 0.5 * T) + 0.3


def shaft(simulator: ServoBench, trial: object, *causes: Cause) -> np.ndarray:
    return simulator.predict(trial, causes, Drive.COMMAND)[:, 0]  # type: ignore[arg-type]


def cause(effect: str, *values: float) -> Cause:
    return Cause(effect, ("arm",), values)


def test_a_held_load_hangs_below_its_goal_by_torque_over_stiffness() -> None:
    """kp V kt / R times the error carries m g l sin(angle), within dry friction."""
    trial = servo_trial(MOTOR.replace("coulomb_nm = 0.02", "coulomb_nm = 0.0"), STILL)
    error = shaft(servo_bench([trial]), trial)[-1]
    stiffness = 4.0 * 7.4 * 0.5 / 4.0
    angle = 0.6 + error
    assert -stiffness * error == pytest.approx(0.49 * G * 0.10 * np.sin(angle), rel=1e-3)


def test_dry_friction_leaves_the_shaft_within_its_torque_of_the_goal() -> None:
    robot = MOTOR.replace("mass_kg = 0.49", "mass_kg = 0.0")
    command = np.where(np.arange(400) < 20, 0.0, 0.3)
    trial = servo_trial(robot, command, shaft=np.zeros(400))
    errors = shaft(servo_bench([trial]), trial, cause("coulomb_friction", 0.2))
    stiffness = 4.0 * 7.4 * 0.5 / 4.0
    assert 0.0 < abs(errors[-1]) <= 0.22 / stiffness
    assert abs(errors[-1] - errors[-2]) < 1e-12


def test_top_speed_is_that_of_the_back_emf() -> None:
    robot = MOTOR.replace("coulomb_nm = 0.02", "coulomb_nm = 0.0").replace(
        "viscous_nm_s = 0.01", "viscous_nm_s = 0.0"
    )
    robot = robot.replace("mass_kg = 0.49", "mass_kg = 0.0")
    command = np.where(np.arange(100) < 5, 0.0, 200.0)
    trial = servo_trial(robot, command, shaft=np.zeros(100))
    angle = shaft(servo_bench([trial]), trial) + command
    assert (angle[-1] - angle[-11]) / 0.2 == pytest.approx(7.4 / 0.5, rel=1e-6)
    half = shaft(servo_bench([trial]), trial, cause("duty_limit", 0.5)) + command
    assert (half[-1] - half[-11]) / 0.2 == pytest.approx(3.7 / 0.5, rel=1e-6)


def test_delay_lag_and_play_of_an_ideal_servo() -> None:
    ramp = 0.4 * T
    trial = servo_trial(IDEAL, ramp)
    simulator = servo_bench([trial])
    assert shaft(simulator, trial, cause("command_delay", 0.05))[100:] == pytest.approx(-0.02)
    assert shaft(simulator, trial, cause("servo_lag", 0.05))[200:] == pytest.approx(-0.02)
    assert shaft(simulator, trial, cause("play", 0.04))[100:] == pytest.approx(-0.02)
    there_and_back = servo_trial(IDEAL, np.concatenate([ramp, ramp[::-1]]))
    trailing = shaft(simulator, there_and_back, cause("play", 0.04))
    assert trailing[-1] == pytest.approx(0.02)


def test_backlash_stays_where_it_was_pushed() -> None:
    torque = np.zeros(400)
    torque[50:100], torque[200:250] = 0.3, -0.3
    trial = servo_trial(IDEAL, STILL, torque=torque)
    simulator = servo_bench([trial])
    errors = shaft(simulator, trial, cause("backlash", 0.02))
    assert errors[[10, 75, 150, 225, 399]] == pytest.approx([0.0, 0.01, 0.01, -0.01, -0.01])


@pytest.mark.parametrize("robot", [MOTOR, IDEAL])
def test_neutral_effects_change_nothing(robot: str) -> None:
    trial = servo_trial(robot, WAVE, torque=0.1 * np.sin(T) - 0.05)
    simulator = servo_bench([trial])
    for drive in Drive:
        base = simulator.predict(trial, (), drive)
        for effect in simulator.effects:
            neutral = tuple(p.neutral for p in effect.parameters)
            found = simulator.predict(trial, [Cause(effect.name, ("arm",), neutral)], drive)
            assert np.array_equal(found, base, equal_nan=True), effect.name


def test_every_effect_of_a_motor_leaves_a_trace() -> None:
    trial = servo_trial(MOTOR, 3 * WAVE)
    simulator = servo_bench([trial])
    base = simulator.predict(trial, (), Drive.COMMAND)
    for effect in simulator.effects:
        lower = [
            p.neutral - p.spread >= p.lower and p.neutral == p.upper for p in effect.parameters
        ]
        values = tuple(
            p.neutral + (-3 if down else 1) * p.spread
            for p, down in zip(effect.parameters, lower, strict=True)
        )
        found = simulator.predict(trial, [Cause(effect.name, ("arm",), values)], Drive.COMMAND)
        assert np.nanmax(np.abs(found - base)) > 1e-6, effect.name


def test_a_magnitude_and_a_dead_speed_are_data_faults() -> None:
    trial = servo_trial(IDEAL, WAVE, torque=np.abs(np.cos(np.pi * T)))
    faults = {(f.kind, f.channel) for f in servo_bench([trial]).check(trial)}
    assert ("magnitude_only", "torque_arm_nm") in faults
    flipped = servo_trial(IDEAL, WAVE, shaft=-WAVE)
    assert ("sign", "shaft_arm_rad") in {
        (f.kind, f.channel) for f in servo_bench([flipped]).check(flipped)
    }
    assert not servo_bench([trial]).check(servo_trial(IDEAL, WAVE))


def test_causes_that_do_not_fit_are_refused() -> None:
    trial = servo_trial(IDEAL, WAVE)
    simulator = servo_bench([trial])
    for wrong in (cause("winding_resistance", 1.0), cause("play"), Cause("play", ("leg",), (0.1,))):
        with pytest.raises(GapError):
            simulator.predict(trial, [wrong], Drive.COMMAND)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[joint.arm]\ngears = { play = 1 }\n", "joint.arm.gears: is not a known key"),
        ("[joint.arm]\nload = { mass = 1.0 }\n", "load.mass: is not a known key; did you mean"),
        ("[joint.arm]\nload = { mass_kg = -1.0 }\n", "load.mass_kg: must be at least 0, not -1"),
        ("[joint.arm]\nload = { mass_kg = true }\n", "load.mass_kg: must be a number, not True"),
        (
            "[joint.arm]\nmotor = { supply_v = 5 }\n",
            "motor.torque_constant_nm_a: is missing; add it",
        ),
        ("[joint.arm]\nmotor = { supply_v = 0.0 }\n", "motor.supply_v: must be above 0, not 0"),
        ("joint = 3\n", "joint: must be a table"),
    ],
)
def test_a_machine_file_that_does_not_describe_servos_is_refused(text: str, words: str) -> None:
    with pytest.raises(GapError, match=words):
        servo_bench([servo_trial(text, WAVE)])
