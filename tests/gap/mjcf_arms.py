"""Small machines for MuJoCo, and runs of them that MuJoCo itself steps, apart from the code under test."""

import math
from typing import Any

import mujoco
import numpy as np

from model.values.arrays import FloatArray
from record.trial.header import TrialHeader, TrialNoise
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial

# Two links in a vertical plane; {upper} and {fore} take what the file's joints lack.
ARM = """<mujoco model="arm"><option timestep="0.001"/><worldbody>
  <body name="upper"><joint name="upper_joint" axis="0 1 0" range="-180 180" {upper}/>
    <inertial pos="0 0 -0.15" mass="1.2" diaginertia="0.01 0.01 0.001"/>
    <body name="fore" pos="0 0 -0.3"><joint name="fore_joint" axis="0 1 0" range="-180 180" {fore}/>
      <inertial pos="0 0 -0.1" mass="0.5" diaginertia="0.002 0.002 0.0002"/></body></body>
</worldbody></mujoco>"""
JOINTS = ("upper", "fore")
KP, KD = 40.0, 1.5
LOOP = f'kind = "position"\nkp_nm_rad = {KP}\nkd_nm_s_rad = {KD}\n'


def arm(upper: str = "", fore: str = "") -> str:
    return ARM.format(upper=upper, fore=fore)


def chirps(seconds: float, hz: float = 100.0, joints: int = 2) -> tuple[FloatArray, FloatArray]:
    """Times, and commands that sweep from slow to fast at every joint, (T, J)."""
    t = np.arange(round(seconds * hz)) / hz
    phase = 2 * np.pi * (0.3 * t + 0.5 * (1.5 - 0.3) / seconds * t**2)
    return t, np.column_stack([0.6 * np.sin(phase + 0.9 * k) + 0.3 for k in range(joints)])


def stepped(
    xml: str, command: FloatArray, hz: float = 100.0, kp: float = KP, kd: float = KD
) -> FloatArray:
    """Angles of a PD loop that mj_step runs, its torque as an outer one every millisecond, (T, J)."""
    model = mujoco.MjModel.from_xml_string(xml)
    data, every = mujoco.MjData(model), round(1.0 / hz / model.opt.timestep)
    data.qpos[:] = command[0]
    out = np.empty(command.shape)
    for row, wanted in enumerate(command):
        out[row] = data.qpos
        for _ in range(every):
            data.qfrc_applied[:] = kp * (wanted - data.qpos) - kd * data.qvel
            mujoco.mj_step(model, data)
    return out


def log_of(
    xml: str,
    drive: str,
    columns: dict[str, FloatArray],
    joints: tuple[str, ...] = JOINTS,
    **more: Any,
) -> Trial:
    """A trial of joints, columns by field, (T, J); ``time_s`` among them."""
    names = {"command_rad": "command_{}_rad", "shaft_rad": "shaft_{}_rad", "torque_nm": "torque_{}_nm",
             "current_a": "current_{}_a", "shaft_rad_s": "shaft_{}_rad_s"}  # fmt: skip
    header = TrialHeader(
        "mjcf",
        joints,
        "",
        math.nan,
        math.nan,
        "",
        TrialNoise(),
        "arm.xml",
        xml,
        drive=drive,
        **more,
    )
    table = [TableColumn("time_s", columns["time_s"])]
    for field, name in names.items():
        if field in columns:
            table += [
                TableColumn(name.format(joint), columns[field][:, at])
                for at, joint in enumerate(joints)
            ]
    return build_trial(header, table)


def arm_log(seconds: float = 6.0, upper: str = "", fore: str = "", drive: str = LOOP) -> Trial:
    """A log of the arm with what its joints have in truth, against the file without it."""
    t, command = chirps(seconds)
    return log_of(arm(), drive, {
        "time_s": t, "command_rad": command, "shaft_rad": stepped(arm(upper, fore), command),
    })  # fmt: skip
