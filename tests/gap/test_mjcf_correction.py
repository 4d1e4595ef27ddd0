"""A corrected model predicts what the diagnosis predicted with its causes; what no model holds is said."""

from dataclasses import replace

import numpy as np
import pytest

from gap.interfaces import Cause, Drive
from gap.machine_kinds import kind_named
from gap.machines.mujoco.correction import corrected_text, left_by_text
from gap.machines.mujoco.machine import MjcfMachine, make_machine
from model.errors import GapError
from record.trial.trial import Trial
from tests.gap.mjcf_arms import arm, arm_log

URDF = """<robot name="arm"><link name="base"/><link name="upper"><inertial>
  <mass value="1.2"/><origin xyz="0 0 -0.15"/>
  <inertia ixx="0.01" iyy="0.01" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><mesh filename="package://nowhere/upper.dae"/></geometry></visual>
  <collision><geometry><mesh filename="package://nowhere/upper.stl"/></geometry></collision></link>
  <joint name="upper_joint" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" effort="30" velocity="6"/></joint></robot>"""


@pytest.fixture(scope="module")
def trial() -> Trial:
    return arm_log(3.0)


@pytest.fixture(scope="module")
def machine(trial: Trial) -> MjcfMachine:
    return make_machine([trial])


def corrected(trial: Trial, text: str) -> MjcfMachine:
    return make_machine([replace(trial, header=replace(trial.header, robot_text=text))])


@pytest.mark.parametrize(
    "cause",
    [
        Cause("joint_friction", ("fore",), (0.3, 0.1, 0.02)),
        Cause("coulomb_friction_at_every_joint", (), (0.2, 0.4)),
        Cause("body_mass", ("upper",), (1.3,)),
        Cause("body_centre", ("fore",), (0.01, 0.0, -0.02)),
        Cause("payload", ("fore",), (0.2, 0.03, 0.0, -0.05)),
        Cause("gravity_direction", (), (0.0, 0.1)),
    ],
)
def test_a_corrected_file_predicts_what_the_cause_predicted(
    machine: MjcfMachine, trial: Trial, cause: Cause
) -> None:
    text = corrected_text(arm(), (cause,), machine.effects)
    wanted = machine.predict(trial, (cause,), Drive.COMMAND)
    assert not np.allclose(wanted, machine.predict(trial, (), Drive.COMMAND), atol=1e-4)
    there = corrected(trial, text).predict(trial, (), Drive.COMMAND)
    assert np.allclose(there, wanted, atol=2e-5)


def test_what_is_of_the_drive_is_refused_alone_and_listed_beside(machine: MjcfMachine) -> None:
    late, dry = Cause("command_delay", (), (0.02,)), Cause("coulomb_friction", ("fore",), (0.3,))
    with pytest.raises(GapError, match=r"command_delay acts on the drive .* change it in .drive."):
        corrected_text(arm(), (late,), machine.effects)
    text = corrected_text(arm(), (late, dry), machine.effects)
    assert left_by_text((late, dry), machine.effects) == ("command_delay",)
    assert text.startswith("<!-- not written: of the drive or the log: command_delay -->")
    assert 'frictionloss="0.3"' in text


def test_a_urdf_whose_meshes_are_elsewhere_is_a_machine_and_becomes_an_mjcf(trial: Trial) -> None:
    one = trial.only(("upper",))
    header = replace(one.header, robot_text=URDF, robot_file="arm.urdf")
    machine = make_machine([replace(one, header=header)])
    assert machine.parts.rigid.limit_nm.tolist() == [30.0]
    assert machine.parts.rigid.in_file == ("upper_joint",)
    assert np.isfinite(machine.predict(one, (), Drive.COMMAND)).all()
    cause = Cause("armature", ("upper",), (0.02,))
    text = corrected_text(URDF, (cause,), machine.effects)
    assert "<mujoco" in text
    assert 'armature="0.02"' in text


def test_the_kind_is_registered_and_says_what_it_cannot() -> None:
    kind = kind_named("mjcf")
    assert kind.apply is corrected_text
    assert kind.propose is None
    assert "slowly and fast" in kind.no_propose
