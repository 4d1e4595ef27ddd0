"""Forces of every foot, and what the slipping gait shows of the friction law."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from robot.report.figure_style import (
    COULOMB,
    NEUTRAL,
    leg_colour,
    line,
    model_legend,
    panel_letter,
)
from robot.study.figures_walk import FOOT, FORCE_LABELS, SMOOTH_S, STUCK, plot_foot_force
from robot.study.walk_comparison import WalkComparison
from robot.study.walk_errors import component_errors

# A foot that carries less than this share of the weight has no ratio worth a point.
LIGHT_SHARE = 0.05
SLIPPING_M_S = 2e-3  # faster than this a foot counts as slipping


def draw_all_feet(walk: WalkComparison) -> tuple[Figure, str]:
    """Draw Fx, Fy and the share of Fz of every foot (fig:tripod-all, fig:slipping-all)."""
    legs = len(walk.names)
    figure = Figure(figsize=(11, 1.55 * legs + 0.8), layout="constrained")
    axes = figure.subplots(legs, 3, sharex=True, sharey="col", squeeze=False)
    for leg, name in enumerate(walk.names):
        for column in range(3):
            plot_foot_force(axes[leg, column], walk, leg, column)
            if leg == 0:
                axes[leg, column].set_title(FORCE_LABELS[column])
        axes[leg, 0].set_ylabel(name, fontweight="bold")
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
    model_legend(figure)
    errors = component_errors(walk)
    fx, fz = errors["Fx"], errors["Fz share"]
    words = ", ".join(
        f"{row.component} {row.viscous:.2f} (viscous) and {row.coulomb:.2f} N (Coulomb) "
        f"of a spread of {row.spread:.2f} N"
        for row in (fx, errors["Fy"])
    )
    note = f"{STUCK} " if fx.coulomb > fx.spread else ""
    caption = (
        f"Ground force on every foot, {walk.gait} gait. RMSE over all feet: {words}; share of Fz "
        f"{fz.support:.1f} % of a spread of {fz.spread:.1f} %. Drawn as means over {SMOOTH_S:g} s. "
        f"{note}The paper shows the same curves without figures."
    )
    return figure, caption


def draw_slipping_gait(walk: WalkComparison) -> tuple[Figure, str]:
    """Draw fig:slipping_gait: the gait, friction against slip speed, and one foot's forces."""
    figure = Figure(figsize=(11, 7), layout="constrained")
    grid = figure.add_gridspec(2, 6)
    _shafts(figure.add_subplot(grid[0, :3]), walk)
    ratio_words = _friction(figure.add_subplot(grid[0, 3:]), walk)
    foot = walk.names.index(FOOT) if FOOT in walk.names else 0
    for column in range(3):
        ax = figure.add_subplot(grid[1, 2 * column : 2 * column + 2])
        plot_foot_force(ax, walk, foot, column)
        ax.set(xlabel="time [s]", ylabel=f"{walk.names[foot]} {FORCE_LABELS[column]}")
        if column == 0:
            panel_letter(ax, "C")
    model_legend(figure)
    known = walk.slip_ahead_m_s[np.isfinite(walk.slip_ahead_m_s)]
    low, high = 1e3 * np.percentile(known, [5, 95]) if len(known) else (np.nan, np.nan)
    caption = (
        f"(A) Shaft angle over gait phase: 2/3 of the cycle on the ground, two feet a side. (B) "
        f"Friction over slip speed, all feet: {ratio_words}, a step as the paper finds on the robot. "
        f"(C) Forces of one foot. Forward slip, 5 to 95 %: ours ({low:.1f}, {high:.1f}) mm/s, the "
        "paper's robot (-51.8, 111.8) mm/s; its cubic is not published, ours is milder."
    )
    return figure, caption


def _shafts(ax: Axes, walk: WalkComparison) -> None:
    phase = np.mod(walk.phase, 1.0)
    angle = np.mod(walk.angle_rad + np.pi, 2 * np.pi) - np.pi
    for leg in range(len(walk.names)):
        ax.plot(phase, angle[:, leg], ".", ms=1.5, color=leg_colour(leg))
    ax.set(xlabel="gait phase [cycles]", ylabel="shaft angle, 0 at mid-stance [rad]", xlim=(0, 1))
    ax.set_yticks([-np.pi, -np.pi / 2, 0, np.pi / 2, np.pi], ["-pi", "-pi/2", "0", "pi/2", "pi"])
    ax.legend(
        handles=[line(leg_colour(leg), name, 2.0) for leg, name in enumerate(walk.names)],
        loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=len(walk.names),
    )  # fmt: skip
    panel_letter(ax, "A")


def _friction(ax: Axes, walk: WalkComparison) -> str:
    """Draw friction over slip; return what it shows, in words."""
    total = walk.force_n[:, :, 2].sum(axis=1, keepdims=True)
    loaded = walk.force_n[:, :, 2] > LIGHT_SHARE * total
    known = loaded & np.isfinite(walk.slip_m_s)
    ratio = np.linalg.norm(walk.force_n[..., :2], axis=-1) / np.where(
        known, walk.force_n[:, :, 2], np.nan
    )
    mu = float(np.median(walk.mu))
    for leg in range(len(walk.names)):
        ax.plot(1e3 * walk.slip_m_s[:, leg], ratio[:, leg], ".", ms=2, color=leg_colour(leg))
    ax.axhline(mu, color=COULOMB, lw=1.5, ls="--")
    ax.annotate(f"mu of the robot file, {mu:g}", (0.98, mu), xycoords=("axes fraction", "data"),
                xytext=(0, 12), textcoords="offset points", ha="right", color=COULOMB)  # fmt: skip
    ax.set(xlabel="slip speed [mm/s]", ylabel="|Fxy| / Fz", ylim=(0, 1.5 * mu))
    ax.axvline(1e3 * SLIPPING_M_S, color=NEUTRAL, lw=0.8, ls=":")
    panel_letter(ax, "B")
    fast = ratio[known & (walk.slip_m_s > SLIPPING_M_S)]
    if len(fast) == 0:
        return "no foot was seen to slip"
    quarter, middle, three = np.percentile(fast, [25, 50, 75])
    return (
        f"beyond {1e3 * SLIPPING_M_S:.0f} mm/s |Fxy|/Fz is {middle:.2f} "
        f"(quartiles {quarter:.2f}, {three:.2f})"
    )
