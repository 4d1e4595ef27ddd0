"""What a foreign engineer hands over: tables in degrees and millimetres, their maps, and a robot file."""

from pathlib import Path

import numpy as np

from benchmarks.gap.apart.layout import (
    FOOT_FRICTION,
    JOINTS,
    LEGS,
    SHANK_STIFFNESS_N_M,
)
from benchmarks.gap.apart.run_table import RunTable

POSE = ("X", "Y", "Z", "roll", "pitch", "yaw")
MASS_KG = 4.62
INERTIA_KG_M2 = (0.045, 0.09, 0.12)
ROBOT_NAME = "krabbe"


def write_table(run: RunTable, path: Path) -> None:
    """Write a run as CSV: ms, deg, mm and N, five decimals."""
    forces = [f"F{axis} {leg}" for leg in LEGS for axis in "xyz"]
    goals, angles = [f"goal {name}" for name in JOINTS], [f"pos {name}" for name in JOINTS]
    columns = [
        run.time_s * 1000,
        *np.degrees(run.command_rad.T),
        *np.degrees(run.encoder_rad.T),
        *(1000 * run.position_m.T),
        *np.degrees(run.roll_pitch_yaw_rad.T),
        *run.foot_force_n.reshape(len(run.time_s), -1).T,
    ]
    head = ",".join(["ms", *goals, *angles, *POSE, *forces])
    np.savetxt(path, np.array(columns).T, delimiter=",", header=head, comments="", fmt="%.5f")


def map_text(period_s: float) -> str:
    """Return the map of a table's columns, for ``bigant import``."""
    lines = ["[columns]", 'time_s = { from = "ms", unit = "ms" }']
    for name in JOINTS:
        lines += [
            f'command_{name}_rad = {{ from = "goal {name}", unit = "deg" }}',
            f'shaft_{name}_rad = {{ from = "pos {name}", unit = "deg" }}',
        ]
    lines += [f'force_{leg}_{axis}_n = "F{axis} {leg}"' for leg in LEGS for axis in "xyz"]
    lines += [
        "[body]", 'position = ["X", "Y", "Z"]', 'unit = "mm"',
        'euler = ["yaw", "pitch", "roll"]', 'order = "ZYX"', 'angle_unit = "deg"',
        "[trial]", f'robot = "{ROBOT_NAME}.toml"', 'gait = "tripod"', f"frequency_hz = {1 / period_s:.6f}",
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def robot_file_text() -> str:
    """Return the robot file; the legs' geometry comes from the MJCF beside it."""
    feet = ", ".join(f'"{leg}_tip"' for leg in LEGS)
    legs = ", ".join(f'"{leg}"' for leg in LEGS)
    stiffness = ", ".join([str(SHANK_STIFFNESS_N_M)] * len(LEGS))
    friction = ", ".join([str(FOOT_FRICTION)] * len(LEGS))
    even = ", ".join(["[0, 0]"] * len(LEGS))
    return f"""\
# KRABBE, 12 joints, two a leg
name = "{ROBOT_NAME}"
[body]
mass = {MASS_KG}
inertia = {list(INERTIA_KG_M2)}
[legs]
order = [{legs}]
[leg]
kind = "chain"
model = "{ROBOT_NAME}.xml"
feet = [{feet}]
[contact]
stiffness = [{stiffness}]
mu = [{friction}]
anisotropy = [{even}]
"""
