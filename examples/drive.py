"""A third of a tripod cycle on the virtual robot: the real drivers, in memory and without waiting.

python examples/drive.py
"""

import numpy as np

import bigant

log = bigant.walk(
    cycles=0.3, seed=1
)  # walk(bigant.load_robot("lab.toml"), "tripod", ...) for your own

forward = log.truth_velocity_B[log.walking, 0] * 1e3
error = (log.predicted_velocity_B - log.truth_velocity_B)[log.walking, 0] * 1e3
print(f"{len(log.t_s)} ticks, {log.walking.sum()} of them walking")
print(
    f"forward speed {forward.mean():.1f} mm/s; predicted with an error of {np.std(error):.1f} mm/s RMS"
)
for name, force in zip(log.names, np.nanmax(log.force_n[log.walking, :, 2], axis=0), strict=True):
    print(f"{name} carries up to {force:.1f} N")
