"""Draw the foot's path over a turn of the shaft: docs/figures/foot_path.png."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from model.kinematics.four_bar import linkage_pose
from robot.config.robot_file import load_robot

OUT = Path(__file__).resolve().parent / "figures" / "foot_path.png"


def main() -> None:
    """Draw it."""
    robot = load_robot().parameters
    link, half = robot.leg, float(robot.gaits[0].stance_sweep[0]) / 2
    turn = np.linspace(-np.pi, np.pi, 721)
    pose = linkage_pose(link, turn)
    stance = np.abs(turn) <= half
    with mpl.rc_context({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9}):
        figure = Figure(figsize=(9, 4.4), layout="constrained")
        left, right = figure.subplots(1, 2)
        left.plot(*(1e3 * pose.foot.T), color="#555555", lw=1, label="return")
        left.plot(*(1e3 * pose.foot[stance].T), color="#0072B2", lw=3, label="tripod stance")
        middle = pose.foot.mean(axis=0)
        for angle in np.radians([-150, -120, -90, -60, -30, 0, 30, 60, 90, 120, 150, 180]):
            one = linkage_pose(link, np.array(angle))
            left.plot(*(1e3 * one.foot), "o", ms=3, color="black")
            outwards = one.foot - middle
            outwards = outwards / np.linalg.norm(outwards)
            left.annotate(
                f"{np.degrees(angle):.0f}°",
                (1e3 * one.foot[0], 1e3 * one.foot[1]),
                fontsize=7,
                textcoords="offset points",
                xytext=tuple(11 * outwards),
                ha="center",
                va="center",
            )
        here = linkage_pose(link, np.array(0.0))
        bars = np.stack([np.zeros(2), here.crank_pin, here.rocker_pin, link.ground_pivot])
        left.plot(*(1e3 * bars.T), "-o", color="#D55E00", lw=1.5, ms=4, label="linkage at 0°")
        left.plot(*(1e3 * np.stack([here.crank_pin, here.foot]).T), color="#D55E00", lw=1.5)
        left.plot(*(1e3 * np.stack([here.rocker_pin, here.foot]).T), color="#D55E00", lw=1.5)
        left.set_aspect("equal")
        left.margins(0.2, 0.12)
        left.set_xlabel("x from the shaft [mm]")
        left.set_ylabel("z from the shaft [mm]")
        left.legend(frameon=False, loc="center left", fontsize=8)
        degrees = np.degrees(turn)
        right.plot(degrees, 1e3 * pose.foot_slope[:, 0], color="#0072B2", label="forward, x")
        right.plot(degrees, 1e3 * pose.foot_slope[:, 1], color="#D55E00", label="up, z")
        right.axvspan(
            -np.degrees(half),
            np.degrees(half),
            color="black",
            alpha=0.06,
            lw=0,
            label="tripod stance",
        )
        right.set_xlabel("shaft angle [deg]")
        right.set_ylabel("foot's way for a turn of the shaft [mm/rad]")
        right.legend(frameon=False)
        OUT.parent.mkdir(exist_ok=True)
        figure.savefig(OUT, dpi=120)
    print(OUT.name)


if __name__ == "__main__":
    main()
