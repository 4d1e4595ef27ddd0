"""Torque that a measured motion needs: its work is the energy gained, and causes are recovered by it."""

import mujoco
import numpy as np
import pytest

from gap.diagnosis.diagnose import diagnose
from gap.interfaces import Cause, Drive
from gap.machines.mujoco.machine import make_machine
from model.values.arrays import FloatArray
from record.trial.trial import Trial
from tests.gap.mjcf_arms import JOINTS, arm, log_of

CONSTANT = 0.5
HZ = 200.0


def moving(seconds: float) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Times, and angle, speed, acceleration of both joints, worked out by hand, (T, 2) each."""
    t = np.arange(round(seconds * HZ)) / HZ
    own = (
        ((0.9, 2 * np.pi * 0.31, 0.0), (0.15, 2 * np.pi * 1.3, 0.3)),
        ((0.7, 2 * np.pi * 0.53, 0.4), (0.2, 2 * np.pi * 1.7, 0.0)),
    )
    angle, speed, acceleration = np.zeros((3, len(t), 2))
    for at, waves in enumerate(own):
        for size, rate, phase in waves:
            turning = rate * t + phase
            angle[:, at] += size * np.sin(turning)
            speed[:, at] += size * rate * np.cos(turning)
            acceleration[:, at] -= size * rate**2 * np.sin(turning)
    return t, angle + 0.2, speed, acceleration


def torques(upper: str, fore: str, motion: tuple[FloatArray, ...]) -> FloatArray:
    """What both joints need, by Newton and Euler in MuJoCo, dry friction as its sign, (T, 2)."""
    model = mujoco.MjModel.from_xml_string(arm(upper, fore))
    dry, model.dof_frictionloss[:] = model.dof_frictionloss.copy(), 0.0
    data, out = mujoco.MjData(model), []
    for q, v, a in zip(*motion, strict=True):
        data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
        mujoco.mj_inverse(model, data)
        out.append(data.qfrc_inverse + dry * np.sign(v))
    return np.array(out)


def felt(fore: str = "", *, seconds: float = 8.0, current: bool = False, upper: str = "") -> Trial:
    """A log without commands: angles to a tenth of a milliradian, and a noisy torque or current."""
    t, *motion = moving(seconds)
    rng = np.random.default_rng(3)
    torque = torques(upper, fore, tuple(motion)) + 0.01 * rng.standard_normal((len(t), 2))
    angle = motion[0] + 1e-4 * rng.standard_normal((len(t), 2))
    field, drive = ("torque_nm", 'kind = "torque"')
    if current:
        torque, field = torque / CONSTANT, "current_a"
        drive = f'kind = "current"\ntorque_constant_nm_a = {CONSTANT}'
    return log_of(arm(), drive, {"time_s": t, "shaft_rad": angle, field: torque})


def test_work_of_the_torque_is_the_energy_gained() -> None:
    trial = felt()
    machine = make_machine([trial])
    needed = machine.predict(trial, (), Drive.MEASURED)
    t, angle, speed, _ = moving(8.0)
    at_s = machine.observe(trial).time_s
    speed = np.column_stack([np.interp(at_s, t, column) for column in speed.T])
    angle = np.column_stack([np.interp(at_s, t, column) for column in angle.T])
    model = mujoco.MjModel.from_xml_string(arm())
    model.opt.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    data, energy = mujoco.MjData(model), []
    for q, v in zip(angle, speed, strict=True):
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(model, data)
        energy.append(float(sum(data.energy)))
    inside = slice(30, -30)  # smoothing is one-sided at the ends
    power = (needed * speed).sum(axis=1)[inside]
    work = np.concatenate(
        [[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(at_s[inside]))]
    )
    gained = np.array(energy)[inside] - energy[30]
    assert float(np.abs(work - gained).max()) < 0.02 * float(np.ptp(gained))


def test_what_a_motion_needs_is_what_newton_and_euler_say() -> None:
    trial = felt('frictionloss="0.3" damping="0.2" armature="0.05"')
    machine = make_machine([trial])
    observed = machine.observe(trial)
    cause = Cause("joint_friction", ("fore",), (0.3, 0.2, 0.05))
    error = (observed.values - machine.predict(trial, (cause,), Drive.COMMAND)) * observed.weight
    before = (observed.values - machine.predict(trial, (), Drive.COMMAND)) * observed.weight
    assert float(np.sqrt(np.mean(error**2))) < 0.05
    assert float(np.sqrt(np.mean(before**2))) > 0.1


def test_stages_are_those_that_torque_can_speak_of() -> None:
    machine = make_machine([felt(seconds=2.0)])
    assert "controller" not in machine.stages
    assert {channel.name for channel in machine.channels} == {"torque"}
    names = {effect.name for effect in machine.effects}
    assert not names & {"command_delay", "servo_lag", "controller_gain", "play", "compliance"}
    assert {"coulomb_friction", "torque_scale", "body_mass", "gravity_direction"} <= names


@pytest.mark.parametrize("current", [False, True])
def test_friction_of_a_joint_is_named_from_torque_or_current_alone(current: bool) -> None:
    trial = felt('frictionloss="0.4" armature="0.05"', current=current)
    diagnosis = diagnose([trial], make_machine([trial]))
    named = diagnosis.causes[0]
    at_fore = [value for value in named.values if named.joints == ("fore",) or "fore" in value.name]
    coulomb = next(value.value for value in at_fore if value.name.startswith("coulomb_nm"))
    assert coulomb == pytest.approx(0.4, abs=0.1)
    assert diagnosis.far.shrink > 0.9


def test_a_weak_motor_is_a_constant_and_no_friction() -> None:
    trial = felt(current=True)
    weak = log_of(trial.header.robot_text, trial.header.drive.replace("0.5", "0.6"), {
        "time_s": trial.time_s, "shaft_rad": trial.shaft_rad, "current_a": trial.current_a,
    }, JOINTS)  # fmt: skip
    machine = make_machine([weak])
    cause = Cause("torque_constant", (), (0.5 / 0.6,))
    observed = machine.observe(weak)
    left = (observed.values - machine.predict(weak, (cause,), Drive.MEASURED)) * observed.weight
    assert float(np.sqrt(np.mean(left**2))) < 0.05


def test_speeds_of_the_motors_side_are_said_and_named() -> None:
    t, *motion = moving(12.0)
    torque = torques("", "", tuple(motion))
    gear = 9.1
    trial = log_of(arm(), 'kind = "torque"', {
        "time_s": t, "shaft_rad": motion[0], "shaft_rad_s": gear * motion[1], "torque_nm": torque,
    })  # fmt: skip
    machine = make_machine([trial])
    said = [fault for fault in machine.check(trial) if fault.channel == "shaft_fore_rad_s"]
    assert "is 9.1" in said[0].evidence
    diagnosis = diagnose([trial], machine)
    assert diagnosis.causes[0].effect == "speed_scale"
    assert diagnosis.causes[0].values[0].value == pytest.approx(gear, rel=0.01)
