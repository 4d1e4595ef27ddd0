"""Diagnose your own robot: an MJCF, a lab's CSV, a map of its columns (docs/tutorial_own_robot.md).

Writes arm.xml, arm_log.csv and arm_map.toml into this folder, as if two joints had been logged, then runs
the two commands of the page. The "real" arm is MuJoCo with dry friction and a rotor at its elbow, of which
arm.xml knows nothing; put your own three files in their place.
"""

from pathlib import Path

import mujoco
import numpy as np

from robot.cli import main as cli

MODEL = """<mujoco model="arm"><option timestep="0.001"/><worldbody>
  <body name="upper"><joint name="shoulder" axis="0 1 0"/>
    <inertial pos="0 0 -0.15" mass="1.2" diaginertia="0.01 0.01 0.001"/>
    <body name="fore" pos="0 0 -0.3"><joint name="elbow" axis="0 1 0"/>
      <inertial pos="0 0 -0.1" mass="0.5" diaginertia="0.002 0.002 0.0002"/></body></body>
</worldbody></mujoco>
"""
MAP = """[trial]
robot = "arm.xml"                                     # MJCF or URDF, beside the log

[drive]                                               # how the joints are driven
kind = "position"                                     # torque = kp (command - angle) - kd speed
kp_nm_rad = 40.0
kd_nm_s_rad = 1.5
base = "fixed"                                        # the base is bolted down
contact = "none"                                      # nothing touches anything

[columns]                                             # ours = theirs, with their unit
time_s = { from = "stamp_ms", unit = "ms" }
command_shoulder_rad = { from = "goal_1", unit = "deg" }
command_elbow_rad = { from = "goal_2", unit = "deg" }
shaft_shoulder_rad = { from = "angle_1", unit = "deg" }
shaft_elbow_rad = { from = "angle_2", unit = "deg" }
"""
REAL = MODEL.replace('name="elbow"', 'name="elbow" frictionloss="0.35" armature="0.02"')
KP, KD, HZ, SECONDS = 40.0, 1.5, 100, 12


def log_of_the_real_arm() -> list[str]:
    """Lines of a CSV: every 10 ms the time, what was asked for, and what the encoders read."""
    model = mujoco.MjModel.from_xml_string(REAL)
    data, rng = mujoco.MjData(model), np.random.default_rng(1)
    lines = ["stamp_ms,goal_1,goal_2,angle_1,angle_2"]
    for row in range(SECONDS * HZ):
        t = row / HZ
        sweep = 2 * np.pi * (0.3 * t + 0.05 * t**2)
        goal = np.array([0.5 * np.sin(sweep), 0.7 * np.sin(1.3 * sweep + 1.0)])
        angle = np.degrees(data.qpos) + 0.02 * rng.standard_normal(2)
        numbers = (1000 * t, *np.degrees(goal), *angle)
        lines.append(",".join(f"{number:.3f}" for number in numbers))
        for _ in range(1000 // HZ):
            data.qfrc_applied[:] = KP * (goal - data.qpos) - KD * data.qvel
            mujoco.mj_step(model, data)
    return lines


if __name__ == "__main__":
    Path("arm.xml").write_text(MODEL, encoding="utf-8")
    Path("arm_map.toml").write_text(MAP, encoding="utf-8")
    Path("arm_log.csv").write_text("\n".join(log_of_the_real_arm()) + "\n", encoding="utf-8")
    cli.run(["import", "arm_log.csv", "--map", "arm_map.toml", "--out", "arm.parquet"])
    cli.run(["gap", "diagnose", "arm.parquet", "--json", "arm.json", "--html", "arm.html"])
    cli.run(["gap", "apply", "arm.json", "--out", "arm_corrected.xml"])
