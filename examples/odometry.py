"""Odometry of a walk with its standard deviations, next to the ground truth that only a virtual robot has.

python examples/odometry.py
"""

import math

import bigant

odometry = bigant.odometry(bigant.walk(cycles=0.3, seed=1))  # odometry("walk.mcap") for your own

(x_m, y_m, yaw_rad), sd = odometry.displacement, odometry.displacement_sd
print(
    f"ahead {1e3 * x_m:.1f} +- {1e3 * sd[0]:.1f} mm, aside {1e3 * y_m:.1f} +- {1e3 * sd[1]:.1f} mm"
)
print(f"turned {math.degrees(yaw_rad):.2f} deg, health {odometry.health[-1]}")
for name, errors in odometry.errors.items():
    print(f"{name:<20} off by {errors.end_percent:.1f} % of the path at its end")
