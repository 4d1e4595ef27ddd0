"""Draw a C-leg through its stance, and its foot's motion: docs/figures/crank.png."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from model.kinematics.crank import crank_outline, crank_pose
from model.values.parameters import CrankParameters
from robot.config.robot_file import load_robot

HERE = Path(__file__).resolve().parent
OUT = HERE / "figures" / "crank.png"
ROBOT = HERE.parent / "examples" / "wheel_hexapod.toml"


def main() -> None:
    """Draw it."""
    robot = load_robot(ROBOT).parameters
    leg = robot.leg
    if not isinstance(leg, CrankParameters):
        raise TypeError(f"{ROBOT} has no cranks")
    angle = np.linspace(-np.pi / 2, np.pi / 2, 361)
    pose = crank_pose(leg, angle)
    with mpl.rc_context({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9}):
        figure = Figure(figsize=(9, 4.0), layout="constrained")
        left, right = figure.subplots(1, 2)
        for degrees, colour in ((-40, "#0072B2"), (0, "#555555"), (40, "#D55E00")):
            at = np.radians(degrees)
            outline = 1e3 * np.concatenate([np.zeros((1, 2)), crank_outline(leg, at, 61)])
            left.plot(*outline.T, color=colour, lw=2.5, label=f"{degrees:+d}°" if degrees else "0°")
            left.plot(*(1e3 * crank_pose(leg, np.array(at)).foot), "o", color=colour, ms=6)
        left.plot(0, 0, "o", color="black", ms=5)
        left.set_aspect("equal")
        left.set_xlabel("x from the shaft, forward [mm]")
        left.set_ylabel("z from the shaft [mm]")
        left.legend(frameon=False, title="shaft angle, dot: foot")
        degrees_axis = np.degrees(angle)
        right.plot(degrees_axis, 1e3 * pose.foot_slope[:, 0], color="#0072B2", label="forward, x")
        right.plot(degrees_axis, 1e3 * pose.foot_slope[:, 1], color="#D55E00", label="up, z")
        place = np.gradient(pose.foot[:, 0], angle)
        right.plot(degrees_axis, 1e3 * place, "--", color="#999999", label="place of contact, x")
        right.set_xlabel("shaft angle [deg]")
        right.set_ylabel("foot's motion for a turn of the shaft [mm/rad]")
        right.legend(frameon=False)
        figure.savefig(OUT, dpi=120)
    print(OUT.name)


if __name__ == "__main__":
    main()
