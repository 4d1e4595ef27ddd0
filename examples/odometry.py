"""Odometry of a walk, with what it is sure of, beside the truth that only a virtual robot has.

python examples/odometry.py
"""

import math

import numpy as np

from model.estimator.settings import EstimatorSettings
from robot.config.robot_file import load_robot
from robot.odometry.compare import compare_ways
from robot.virtual.walk import walk_in_memory

robot = load_robot()
log = walk_in_memory(robot, "tripod", cycles=0.3, seed=1, progress=lambda share: None)
found = compare_ways(log, robot, EstimatorSettings(), fitted=None, stride_m=math.nan)

run, last = found.track, found.track.estimates[-1]
x_m, y_m, yaw_rad = run.pose[-1] - run.pose[0]
sd_m = np.sqrt(np.diag(last.pose_covariance))[:2]
print(
    f"ahead {1e3 * x_m:.1f} +- {1e3 * sd_m[0]:.1f} mm, aside {1e3 * y_m:.1f} +- {1e3 * sd_m[1]:.1f} mm"
)
print(f"turned {math.degrees(yaw_rad):.2f} deg, health {last.health.value}")
for errors in found.errors:
    print(f"{errors.name:<20} off by {errors.end_percent:.1f} % of the way at its end")
