"""Ways of dead reckoning drawn beside each other: path, error along the way, velocity, one leg's force."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from model.errors import RecordError
from robot.odometry_compare import Comparison
from robot.odometry_metrics import path_length
from robot.plots import STYLE

LAST_S = 20.0  # of velocity and friction that are drawn


def draw(found: Comparison, out: Path, *, everything: bool) -> None:
    """Draw to a PNG.

    Raises:
        RecordError: It cannot be written.
    """
    try:
        drawing(found, everything=everything).savefig(out, dpi=120)
    except OSError as trouble:
        raise RecordError(
            f"{out} cannot be written: {trouble.strerror}; choose another --out"
        ) from trouble


def drawing(found: Comparison, *, everything: bool) -> Figure:
    """Return the picture."""
    ways = found.ways if everything else found.ways[:1]
    run = found.track
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(11, 7), layout="constrained")
        (path, error), (speed, friction) = figure.subplots(2, 2)
        late = run.t_s > run.t_s[-1] - LAST_S
        for way in ways:
            path.plot(*way.pose[:, :2].T, label=way.name, lw=1)
            speed.plot(run.t_s[late], 1e3 * way.velocity_B[late, 0], lw=0.8, label=way.name)
            if found.truth is not None:
                off = np.hypot(*(way.pose - found.truth[0])[:, :2].T)
                error.plot(path_length(found.truth[0]), 1e3 * off, lw=1, label=way.name)
        if found.truth is not None:
            path.plot(*found.truth[0][:, :2].T, "k--", lw=1, label="truth")
            speed.plot(run.t_s[late], 1e3 * found.truth[1][late, 0], "k--", lw=0.8, label="truth")
            two_sd = 2e3 * np.sqrt(run.pose_covariance[:, 0, 0] + run.pose_covariance[:, 1, 1])
            error.plot(path_length(found.truth[0]), two_sd, "k:", lw=1, label="two sd")
        friction.plot(run.t_s, run.mu, lw=1)
        for ax, title, across, up in (
            (path, "path", "x, m", "y, m"),
            (error, "distance from the truth", "true path, m", "mm"),
            (speed, "heading velocity", "time, s", "mm/s"),
            (friction, "friction coefficient of each leg, estimated", "time, s", "mu"),
        ):
            ax.set_title(title, loc="left")
            ax.set_xlabel(across)
            ax.set_ylabel(up)
        path.legend(fontsize=7)
        error.legend(fontsize=7)
    return figure
