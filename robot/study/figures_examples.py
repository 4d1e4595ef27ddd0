"""The motivating examples drawn: the line, the planar force field, the friction laws."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model.quasistatic.frames import FrictionLaw
from model.systems.paper_examples import (
    ansatz_error,
    balance_velocity,
    coulomb_balance,
    force_share,
    total_force,
)
from model.values.arrays import FloatArray
from robot.report.figure_style import COULOMB, NEUTRAL, VISCOUS, leg_colour, line, panel_letter

# Foot velocities relative to the body on the line [m/s]: five legs, and four of them.
LINE_FEET = np.array([-0.30, -0.22, -0.12, -0.05, 0.12])
# Four feet about a body in the plane: places [m] and velocities relative to the body [m/s].
FIELD_PLACES = np.array([[0.2, 0.15], [-0.2, 0.15], [-0.2, -0.15], [0.2, -0.15]])
FIELD_FEET = np.array([[-0.26, 0.12], [-0.30, -0.14], [-0.02, -0.10], [-0.08, 0.16]])
FIELD_GRIP = np.ones(4)  # mu N of each foot, in units of one foot's
CLOSE = 0.2  # the paper's |dv| < 0.2 |v|


def draw_line() -> tuple[Figure, str]:
    """Draw fig:1d_ex: total force over body velocity, odd and even number of legs."""
    figure = Figure(figsize=(9, 3.6), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    _line_panel(axes[0], LINE_FEET, "A  five legs: one answer")
    _line_panel(axes[1], np.delete(LINE_FEET, 2), "B  four legs: any speed in between")
    axes[0].set_ylabel("total force / (legs x mu N)")
    figure.legend(
        handles=[
            line(COULOMB, "Coulomb: minus the median", 2.0),
            line(VISCOUS, "viscous-Coulomb: minus the mean", 2.0),
            line(NEUTRAL, "a foot comes to rest", 0.8, ":"),
        ],
        loc="outside upper center",
        ncols=3,
    )
    low, high = coulomb_balance(np.delete(LINE_FEET, 2))
    caption = (
        f"Body velocity at balance on a line. Five legs: Coulomb {coulomb_balance(LINE_FEET)[0]:.3f} "
        f"m/s (minus the median), viscous-Coulomb {-LINE_FEET.mean():.3f} m/s (minus the "
        f"mean). Four legs: Coulomb's law holds at any speed from {low:.3f} to {high:.3f} m/s, the "
        f"ansatz only at {-np.delete(LINE_FEET, 2).mean():.3f} m/s. The paper states both "
        "identities without figures; they hold here exactly (tested on random legs)."
    )
    return figure, caption


def _line_panel(ax: Axes, feet: FloatArray, title: str) -> None:
    count = len(feet)
    body = np.linspace(-0.22, 0.40, 3101)
    coulomb, viscous = (
        total_force(body[:, None], feet[:, None], np.full(count, 1 / count), law)
        for law in (FrictionLaw.COULOMB, FrictionLaw.VISCOUS)
    )
    for foot in feet:
        ax.axvline(-foot, color=NEUTRAL, lw=0.8, ls=":")
    ax.axhline(0, color="black", lw=0.8)
    ax.plot(body, coulomb, color=COULOMB, lw=2.0)
    ax.plot(body, viscous / np.abs(viscous).max(), color=VISCOUS, lw=2.0)  # fills the panel
    low, high = coulomb_balance(feet)
    if high > low:
        ax.axvspan(low, high, color=COULOMB, alpha=0.15, lw=0)
        ax.plot([low, high], [0, 0], color=COULOMB, lw=5, solid_capstyle="butt")
    else:
        ax.plot(low, 0, "o", color=COULOMB, ms=9, zorder=5)
    ax.plot(-feet.mean(), 0, "o", color=VISCOUS, ms=7, zorder=6)
    ax.set_title(title, loc="left")
    ax.set_xlabel("body velocity [m/s]")


def draw_force_field() -> tuple[Figure, str]:
    """Draw fig:fxy: magnitude of the total force over the planar body velocity, both laws."""
    figure = Figure(figsize=(9, 7.2), layout="constrained")
    grid = figure.add_gridspec(2, 2, width_ratios=[1.2, 1])
    vx, vy = np.meshgrid(np.linspace(-0.25, 0.45, 351), np.linspace(-0.35, 0.35, 351))
    body = np.stack([vx, vy], axis=-1)
    stars = {}
    panels = ((FrictionLaw.COULOMB, "A  Coulomb", "[mu N]"),
              (FrictionLaw.VISCOUS, "B  viscous-Coulomb", "[mu N s/m]"))  # fmt: skip
    for row, (law, title, unit) in enumerate(panels):
        ax = figure.add_subplot(grid[row, 0])
        strength = np.linalg.norm(total_force(body, FIELD_FEET, FIELD_GRIP, law), axis=-1)
        shades = ax.contourf(vx, vy, strength, levels=14, cmap="Greys", alpha=0.8)
        ax.contour(vx, vy, strength, levels=shades.levels, colors="white", linewidths=0.5)
        figure.colorbar(shades, ax=ax, label=f"|total force| {unit}")
        for foot, velocity in enumerate(FIELD_FEET):
            ax.plot(*-velocity, "o", color=leg_colour(foot), ms=8, mec="white")
        stars[law] = balance_velocity(FIELD_FEET, FIELD_GRIP, law)
        ax.plot(*stars[law], "*", color="#E00000", ms=17, mec="white", zorder=5)
        ax.set(xlabel="body velocity vx [m/s]", ylabel="body velocity vy [m/s]", aspect="equal")
        ax.set_title(title, loc="left")
        ax.grid(visible=False)
    _four_feet(figure.add_subplot(grid[0, 1]))
    _field_cut(figure.add_subplot(grid[1, 1]))
    gap = stars[FrictionLaw.VISCOUS] - stars[FrictionLaw.COULOMB]
    jump = 2 * FIELD_GRIP[0]
    caption = (
        "Magnitude of the total force on a four-legged body that moves at (vx, vy) without turning. "
        f"Balance (stars): Coulomb ({_pair(stars[FrictionLaw.COULOMB])}) m/s, viscous-Coulomb "
        f"({_pair(stars[FrictionLaw.VISCOUS])}) m/s, {np.hypot(*gap) * 1e3:.0f} mm/s apart. Across "
        f"each dot (a foot at rest) Coulomb's force vector jumps by {jump:.0f} mu N; the ansatz is "
        "smooth: its force grows in proportion to the distance from the balance, its dissipation is "
        "a quadratic bowl. The paper gives no figures; it states point discontinuities at the dots, "
        "a simple quadratic, and similar balances, as found here."
    )
    return figure, caption


def _pair(values: FloatArray) -> str:
    return f"{values[0]:.3f}, {values[1]:.3f}"


def _four_feet(ax: Axes) -> None:
    ax.fill(*FIELD_PLACES.T, color="#DDDDDD", zorder=0)
    for foot, (place, velocity) in enumerate(zip(FIELD_PLACES, FIELD_FEET, strict=True)):
        ax.plot(*place, "o", color=leg_colour(foot), ms=8)
        tip = place + 0.6 * velocity
        ax.annotate("", xy=(tip[0], tip[1]), xytext=(place[0], place[1]),
                    arrowprops={"arrowstyle": "-|>", "color": leg_colour(foot), "lw": 2})  # fmt: skip
    ax.set(xlim=(-0.48, 0.35), ylim=(-0.33, 0.36), aspect="equal", xlabel="x [m]", ylabel="y [m]")
    ax.set_title("C  feet and their velocities in the body", loc="left")


def _field_cut(ax: Axes) -> None:
    """Cut through the Coulomb field along x at the height of the first foot's resting velocity."""
    vx = np.linspace(-0.25, 0.45, 4001)
    foot = FIELD_FEET[0]
    body = np.column_stack([vx, np.full_like(vx, -foot[1])])
    for law, colour in ((FrictionLaw.COULOMB, COULOMB), (FrictionLaw.VISCOUS, VISCOUS)):
        force = np.linalg.norm(total_force(body, FIELD_FEET, FIELD_GRIP, law), axis=-1)
        ax.plot(vx, force / force.max(), color=colour, lw=1.8)
    ax.axvline(-foot[0], ymax=0.85, color=leg_colour(0), lw=1, ls="--")
    ax.set(xlabel="body velocity vx [m/s]", ylabel="|total force| / its largest", ylim=(0, 1.22))
    ax.legend(handles=[line(COULOMB, "Coulomb", 1.8), line(VISCOUS, "viscous-Coulomb", 1.8)],
              loc="upper center", ncols=2)  # fmt: skip
    ax.set_title(f"D  cut at vy = {-foot[1]:.2f} m/s, through a dot", loc="left")


def draw_friction_error() -> tuple[Figure, str]:
    """Draw fig:Fv-Fc: relative error of the ansatz against Coulomb's law around a slip of (1, 0)."""
    figure = Figure(figsize=(9, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[1.25, 1])
    along, across = np.meshgrid(np.linspace(-0.5, 0.5, 401), np.linspace(-0.5, 0.5, 401))
    error = 100 * ansatz_error(np.stack([along, across], axis=-1))
    shades = left.contourf(along, across, error, levels=np.linspace(0, 60, 13), cmap="YlOrBr")
    contours = left.contour(along, across, error, levels=[2, 5, 10, 20, 40], colors="black",
                            linewidths=0.8)  # fmt: skip
    # contours are circles about dv = -v: labels where they stand apart and inside the panel
    spots = [
        (float(np.sqrt((1 + share) ** 2 - y**2)) - 1, y)
        for share, y in ((-0.4, 0.1), (-0.2, 0.35), (-0.1, 0.35), (0.05, -0.35), (0.1, -0.35),
                         (0.2, -0.35), (0.4, -0.35), (0.02, 0.35))
    ]  # fmt: skip
    left.clabel(contours, fmt="%g %%", fontsize=8, manual=spots)
    angle = np.linspace(0, 2 * np.pi, 200)
    left.plot(CLOSE * np.cos(angle), CLOSE * np.sin(angle), color=COULOMB, lw=2)
    figure.colorbar(shades, ax=left, label="error of the force [%]")
    left.set(xlabel="dv along the slip / |v|", ylabel="dv across the slip / |v|", aspect="equal")
    panel_letter(left, "A")
    left.grid(visible=False)
    r = np.linspace(0, 0.5, 501)
    right.plot(r, 100 * ansatz_error(np.column_stack([r, 0 * r])), color=VISCOUS, lw=2)
    right.plot(r, 100 * ansatz_error(np.column_stack([0 * r, r])), color=VISCOUS, lw=2, ls="--")
    right.axvline(CLOSE, color=COULOMB, lw=2)
    worst_across = 100 * float(ansatz_error(np.array([0.0, CLOSE])))
    worst_along = 100 * float(ansatz_error(np.array([CLOSE, 0.0])))
    right.annotate(f"along: {worst_along:.0f} %", (CLOSE, worst_along), (0.05, 28),
                   arrowprops={"arrowstyle": "->"})  # fmt: skip
    right.annotate(f"across: {worst_across:.2f} %", (CLOSE, worst_across), (0.27, 12),
                   arrowprops={"arrowstyle": "->"})  # fmt: skip
    right.set(xlabel="|dv| / |v|", ylabel="error of the force [%]", xlim=(0, 0.5), ylim=(0, 50))
    panel_letter(right, "B")
    radius, turn = np.meshgrid(CLOSE * np.sqrt((np.arange(400) + 0.5) / 400), angle[:-1])
    disc = np.stack([radius * np.cos(turn), radius * np.sin(turn)], axis=-1)
    share = 100 * float(np.mean(ansatz_error(disc) <= 0.02))
    caption = (
        "Relative error of the viscous-Coulomb force, matched to Coulomb's at slip v, when the slip "
        f"is v + dv. On the circle |dv| = 0.2 |v| it is {worst_across:.2f} % across the sliding "
        f"direction (sqrt(1.04) - 1) and {worst_along:.0f} % along it. The paper states 2 % for the "
        f"whole disc; that holds only across, and in {share:.0f} % of the disc's area."
    )
    return figure, caption


def draw_friction_family() -> tuple[Figure, str]:
    """Draw the family of eqn:h2 between both laws."""
    figure = Figure(figsize=(6.5, 3.8), layout="constrained")
    ax = figure.subplots()
    speed = np.linspace(0, 2, 4001)
    epsilons = (1e-4, 1e-2, 1e-1, 1.0, 10.0)
    ax.plot(speed[1:], force_share(speed[1:], 0.0), color=COULOMB, lw=2.4, label="Coulomb, eps = 0")
    for number, eps in enumerate(epsilons):
        ax.plot(speed, force_share(speed, eps), color=str(0.15 + 0.13 * number), lw=1,
                label=f"eps = {eps:g}")  # fmt: skip
    ax.plot(speed, force_share(speed, np.inf), color=VISCOUS, lw=2.4,
            label="viscous-Coulomb, eps = inf")  # fmt: skip
    ax.set(xlabel="slip speed [m/s]", ylabel="force / (mu N)", xlim=(0, 2), ylim=(0, 2))
    figure.legend(loc="outside right center")
    creep = 100 * float(force_share(0.01, 1e-5))
    caption = (
        "The laws between Coulomb's (eps to 0) and the ansatz (eps to infinity), eqn:h2. All agree at "
        "0 and at 1 m/s, and every member lies between the two. The paper's first approximation, "
        f"eps = 1e-5, gives {creep:.0f} % of Coulomb's force at a slip of 10 mm/s (speeds in m/s): "
        "it is still soft at this robot's slips, so the paper goes on to smaller eps."
    )
    return figure, caption
