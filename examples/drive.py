"""A third of a tripod cycle on the virtual robot: the real drivers, in memory and without waiting.

python examples/drive.py
"""

import numpy as np

from model.values.tick import Mode
from robot.config.robot_file import load_robot
from robot.virtual.walk import walk_in_memory

robot = load_robot()  # load_robot(Path("lab.toml")) for your own
log = walk_in_memory(robot, "tripod", cycles=0.3, seed=1, progress=lambda share: None)

walking = log.mode == Mode.WALK.value
forward = log.truth_velocity_B[walking, 0] * 1e3
error = (log.predicted_velocity_B - log.truth_velocity_B)[walking, 0] * 1e3
print(f"{len(log.t_s)} ticks, {walking.sum()} of them walking")
print(
    f"forward speed {forward.mean():.1f} mm/s; predicted with an error of {np.std(error):.1f} mm/s RMS"
)
for name, force in zip(log.names, np.nanmax(log.force_n[walking, :, 2], axis=0), strict=True):
    print(f"{name} carries up to {force:.1f} N")
