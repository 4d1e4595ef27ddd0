"""Odometry of a walk, with what it is sure of, beside the truth that only a virtual robot has.

python examples/odometry.py
"""

import math
from pathlib import Path
from tempfile import TemporaryDirectory

from robot.cli.main import run
from robot.odometry.compare import compare_methods
from robot.odometry.table import displacement_and_sd
from robot.odometry.track import track_log

with TemporaryDirectory() as folder:
    log = Path(folder) / "walk.mcap"
    run(["drive", "--cycles", "0.3", "--virtual-time", "--seed", "1", "--log", str(log)])
    tracked = track_log(log)

comparison = compare_methods(tracked)
(x_m, y_m, yaw_rad), sd = displacement_and_sd(comparison)
print(
    f"ahead {1e3 * x_m:.1f} +- {1e3 * sd[0]:.1f} mm, aside {1e3 * y_m:.1f} +- {1e3 * sd[1]:.1f} mm"
)
print(
    f"turned {math.degrees(yaw_rad):.2f} deg, health {comparison.track.estimates[-1].health.value}"
)
for errors in comparison.errors:
    print(f"{errors.name:<20} off by {errors.end_percent:.1f} % of the path at its end")
