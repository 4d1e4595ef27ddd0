"""A robot that nothing holds: a sledge that its arm drives over a floor, whose friction poses show.

The sledge slides because its arm swings. The "real" one has another floor than its MJCF; its position
loop is integrated as a servo would act, with the damping taken implicitly.
"""

import math

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.diagnose import diagnose
from record.trial.header import TrialHeader, TrialNoise
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial
from robot.gap_report.trials import runs_of

SLEDGE = """<mujoco model="sledge"><option timestep="0.001"/><worldbody>
  <geom type="plane" size="5 5 .1" friction="{mu} 0.005 0.0001"/>
  <body name="sledge" pos="0 0 0.03"><freejoint/>
    <geom name="hull" type="box" size="0.15 0.1 0.03" mass="2" friction="{mu} 0.005 0.0001"/>
    <body name="arm" pos="0 0 0.03">
      <joint name="arm_joint" axis="0 0 1" range="-180 180" damping="{damping}"/>
      <geom type="capsule" fromto="0 0 0 0.15 0 0" size="0.01" mass="0.1" contype="0" conaffinity="0"/>
      <geom type="sphere" pos="0.15 0 0" size="0.03" mass="0.8" contype="0" conaffinity="0"/>
    </body>
  </body>
</worldbody></mujoco>"""
KP, KD, HZ, SECONDS = 40.0, 1.0, 100.0, 8.0
DRIVE = f"""kind = "position"
kp_nm_rad = {KP}
kd_nm_s_rad = {KD}
base = "free"
contact = "full"
"""
NOMINAL_MU, TRUE_RATIO = 0.4, 0.7


def sledge_trial(seed: int) -> Trial:
    """A run on the true floor: commands, shaft, and the sledge's pose with a camera's noise."""
    text = SLEDGE.format(mu=NOMINAL_MU * TRUE_RATIO, damping=KD)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    time_s = np.arange(round(SECONDS * HZ)) / HZ
    slow = 0.6 * np.sin(2 * np.pi * 0.31 * time_s)
    command = 0.8 * np.sin(2 * np.pi * (1.6 + 0.2 * seed) * time_s + slow)
    states = np.empty((len(time_s), 8))
    for row, goal in zip(states, command, strict=True):
        row[:] = data.qpos
        for _ in range(round(1.0 / HZ / model.opt.timestep)):
            data.qfrc_applied[6] = KP * (goal - data.qpos[7])
            mujoco.mj_step(model, data)
    angles = Rotation.from_quat(states[:, 3:7], scalar_first=True).as_euler("ZYX")[:, ::-1]
    rng = np.random.default_rng(seed)
    columns = {"time_s": time_s, "command_arm_joint_rad": command}
    columns["shaft_arm_joint_rad"] = states[:, 7] + rng.normal(0.0, 5e-4, len(time_s))
    for k, axis in enumerate("xyz"):
        columns[f"body_{axis}_m"] = states[:, k] + rng.normal(0.0, 2e-4, len(time_s))
    for k, angle in enumerate(("roll", "pitch", "yaw")):
        columns[f"body_{angle}_rad"] = angles[:, k] + rng.normal(0.0, 1e-3, len(time_s))
    header = TrialHeader(
        "mjcf", ("arm_joint",), "", math.nan, math.nan, "", TrialNoise(), "sledge.xml",
        SLEDGE.format(mu=NOMINAL_MU, damping=0.0), drive=DRIVE,
    )  # fmt: skip
    return build_trial(header, [TableColumn(*one) for one in columns.items()])


@pytest.mark.thorough
def test_the_friction_of_the_floor_is_found_from_how_the_base_slides() -> None:
    runs = runs_of([sledge_trial(seed) for seed in (1, 2, 3)])
    found = diagnose(runs.trials, runs.simulator())
    assert found.verdict is Verdict.EXPLAINED
    (cause,) = found.causes
    assert cause.effect == "contact_friction"
    (ratio,) = cause.values
    assert abs(ratio.value - TRUE_RATIO) < 2.0 * ratio.error < 0.05
