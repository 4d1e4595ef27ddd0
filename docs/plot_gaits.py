"""Draw both gaits, shaft angle and stance against phase: docs/figures/gaits.png."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from gaits.catalog import gait_names, make_gait
from model.values.arrays import FloatArray
from robot.config.robot_file import load_robot

OUT = Path(__file__).resolve().parent / "figures" / "gaits.png"
COLOURS = ("#0072B2", "#56B4E9", "#009E73", "#D55E00", "#E69F00", "#CC79A7")


def _same(one: FloatArray, other: FloatArray) -> bool:
    apart = np.remainder(one - other + np.pi, 2 * np.pi) - np.pi
    return bool(np.abs(apart).max() < 1e-6)


def main() -> None:
    """Draw them."""
    robot = load_robot().parameters
    phase = np.linspace(0, 2, 2001)
    with mpl.rc_context({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9}):
        figure = Figure(figsize=(9, 5.2), layout="constrained")
        axes = figure.subplots(2, 2, sharex=True, height_ratios=[3, 1.6])
        for column, name in enumerate(gait_names(robot)):
            gait = make_gait(name, robot)
            angle = gait.motion(phase, 0.0).angle_rad
            stance = gait.stance(phase)
            top, bottom = axes[0, column], axes[1, column]
            alike = [
                [
                    other
                    for other in range(len(robot.legs.names))
                    if _same(angle[:, leg], angle[:, other])
                ]
                for leg in range(len(robot.legs.names))
            ]
            for leg, leg_name in enumerate(robot.legs.names):
                # legs that move together lie on one line: the one below is drawn wider
                behind = len(alike[leg]) - 1 - alike[leg].index(leg)
                wrapped = np.remainder(angle[:, leg] + np.pi, 2 * np.pi) - np.pi
                wrapped[:-1][np.abs(np.diff(wrapped)) > np.pi] = np.nan
                top.plot(
                    phase,
                    np.degrees(wrapped),
                    color=COLOURS[leg],
                    lw=1.2 + 2.4 * behind,
                    label=leg_name,
                )
                down = np.where(stance[:, leg], leg, np.nan)
                bottom.plot(phase, down, color=COLOURS[leg], lw=6, solid_capstyle="butt")
            top.set_title(name)
            top.set_ylabel("shaft angle [deg]")
            bottom.set_yticks(range(len(robot.legs.names)), robot.legs.names)
            bottom.set_ylabel("on the ground")
            bottom.set_xlabel("phase [cycles]; dotted: where walking begins")
            bottom.axvline(gait.start_phase, color="black", lw=0.8, ls=":")
        figure.legend(
            *axes[0, 1].get_legend_handles_labels(),
            frameon=False,
            ncols=6,
            loc="outside upper center",
        )
        OUT.parent.mkdir(exist_ok=True)
        figure.savefig(OUT, dpi=120)
    print(OUT.name)


if __name__ == "__main__":
    main()
