"""A lab's own robot: an octopod, described by a file, through the same drivers, gait and model.

python examples/own_robot.py
"""

from pathlib import Path

import numpy as np

import bigant

robot = bigant.load_robot(Path(__file__).with_name("octopod.toml"))
legs = robot.parameters.legs.names
print(f"{robot.name}: {len(legs)} legs, {', '.join(legs)}")

log = bigant.walk(robot, cycles=0.3, seed=1)
distance_m = float(np.sum(log.truth_velocity_B[log.walking, 0])) / robot.loop.rate_hz
felt = np.isfinite(log.force_n[log.walking, :, 2]).any(axis=0)
with_sensor = ", ".join(name for name, one in zip(legs, felt, strict=True) if one)
print(f"walked {1e3 * distance_m:.0f} mm; with a transducer: {with_sensor}")
