"""A lab's own robot: an octopod, described by a file, through the same drivers, gait and model.

python examples/own_robot.py
"""

from pathlib import Path

import numpy as np

from model.values.tick import Mode
from robot.config.robot_file import load_robot
from robot.virtual.walk import walk_in_memory

robot = load_robot(Path(__file__).with_name("octopod.toml"))
legs = robot.parameters.legs.names
print(f"{robot.name}: {len(legs)} legs, {', '.join(legs)}")

log = walk_in_memory(robot, "tripod", cycles=0.3, seed=1, progress=lambda share: None)
walking = log.mode == Mode.WALK.value
way_m = float(np.sum(log.truth_velocity_B[walking, 0])) / robot.loop.rate_hz
felt = np.isfinite(log.force_n[walking, :, 2]).any(axis=0)
with_sensor = ", ".join(name for name, one in zip(legs, felt, strict=True) if one)
print(f"walked {1e3 * way_m:.0f} mm; with a transducer: {with_sensor}")
