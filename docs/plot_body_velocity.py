"""Draw forward speed, true and predicted, of both gaits: docs/figures/body_velocity.png."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from robot.config.robot_file import load_robot
from robot.report.figure_style import COULOMB, TRUTH, VISCOUS, model_legend
from robot.study.walk_comparison import WalkComparison, compare_walk
from robot.virtual.walk import walk_in_memory

OUT = Path(__file__).resolve().parent / "figures" / "body_velocity.png"
CYCLES = 2.0


def rmse(walk: WalkComparison, velocity: np.ndarray) -> float:
    """Root mean square error of the forward speed [mm/s]."""
    error = (velocity - walk.velocity_B)[:, 0]
    return float(np.sqrt(np.nanmean(error**2))) * 1e3


def main() -> None:
    """Walk and draw."""
    with mpl.rc_context({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9}):
        figure = Figure(figsize=(9, 4.2), layout="constrained")
        for ax, gait in zip(figure.subplots(2, 1), ("tripod", "metachronal"), strict=True):
            log = walk_in_memory(load_robot(), gait, cycles=CYCLES, seed=0, progress=lambda _: None)
            walk = compare_walk(log)
            ax.plot(walk.t_s, walk.velocity_B[:, 0] * 1e3, color=TRUTH, lw=2.2)
            for colour, law in ((VISCOUS, walk.viscous), (COULOMB, walk.coulomb)):
                ax.plot(walk.t_s, law.velocity_B[:, 0] * 1e3, color=colour, lw=1.3)
            errors = [rmse(walk, law.velocity_B) for law in (walk.viscous, walk.coulomb)]
            ax.set_title(
                f"{gait}: error of viscous-Coulomb {errors[0]:.1f}, of Coulomb {errors[1]:.1f} mm/s",
                loc="left",
                fontsize=9,
            )
            ax.set_ylabel("forward speed [mm/s]")
            ax.margins(x=0.01)
        ax.set_xlabel("time walked [s]")
        model_legend(figure, support=False)
        figure.savefig(OUT, dpi=130)


if __name__ == "__main__":
    main()
