"""Pictures of a reviewed robot: from above and from the side, and each gait over its cycle."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from model.kinematics.chain import ChainKinematics
from model.kinematics.crank import crank_outline
from model.kinematics.four_bar import linkage_pose
from model.support.static_margin import hull_edges
from model.values.arrays import FloatArray
from model.values.parameters import ChainParameters, FourBarParameters
from robot.design.gait_figures import WalkedGait
from robot.design.review import RobotReview
from robot.design.standing import STANDING
from robot.report.figure_style import NEUTRAL, TRUTH, leg_colour
from robot.report.plots import STYLE

SNAPSHOTS = 6  # stance polygons of a gait
STANCE = "#009E73"
LIMIT = "#555555"
GROUND = "#333333"


def draw_review(review: RobotReview) -> dict[str, Figure]:
    """Return all pictures of a review, by title."""
    with mpl.rc_context(STYLE):
        pictures = {"Robot": _robot(review)}
        for one in review.gaits:
            gait = one.figures.gait
            pictures[f"{gait} feet in stance"] = _polygons(one)
            if gait != STANDING:
                pictures[f"{gait} over one cycle"] = _curves(review, one)
        return pictures


def _robot(review: RobotReview) -> Figure:
    """The robot from above (x to the right, y up) and from the side, with the paths of its feet."""
    figure = Figure(figsize=(9, 4.4), layout="constrained")
    above, side = figure.subplots(1, 2)
    robot = review.config.parameters
    shafts, names = robot.legs.shaft_position * 1e3, robot.legs.names
    paths = shafts + review.path_m * 1e3
    standing = paths[0]
    for ax, across in ((above, 1), (side, 2)):
        _body(ax, shafts, across)
        for leg, name in enumerate(names):
            colour = leg_colour(leg)
            ax.plot(paths[:, leg, 0], paths[:, leg, across], color=colour, lw=1)
            ax.plot(standing[leg, 0], standing[leg, across], "o", color=colour, ms=6, label=name)
            ax.plot(*shafts[leg, [0, across]], "s", color=colour, ms=4, mfc="none")
        ax.plot([], [], "s", color=NEUTRAL, ms=4, mfc="none", label="shaft")
        ax.plot(0, 0, "+", color=TRUTH, ms=12, mew=2, label="centre of mass")
        ax.set_aspect("equal", adjustable="datalim")
        ax.set_xlabel("x, forward [mm]")
    _leg_bars(above, side, review)
    heights = [one.figures.height_m for one in review.gaits if np.isfinite(one.figures.height_m)]
    if heights:
        side.axhline(-1e3 * heights[0], color=GROUND, lw=1.2)
    above.set(ylabel="y, left [mm]", title="from above")
    side.set(ylabel="z, up [mm]", title="from the side, joints at zero")
    handles, labels = above.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=9, frameon=False)
    return figure


def _body(ax: Axes, shafts_mm: FloatArray, across: int) -> None:
    """A box over the shafts: the file has no shape of the body."""
    low, high = shafts_mm[:, [0, across]].min(axis=0), shafts_mm[:, [0, across]].max(axis=0)
    low, high = np.minimum(low, 0), np.maximum(high, 0)
    corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]]])
    ax.add_patch(Polygon(corners, closed=True, fc=NEUTRAL, ec=NEUTRAL, alpha=0.12, lw=1))


def _leg_bars(above: Axes, side: Axes, review: RobotReview) -> None:
    """All legs with their joints at zero."""
    for k, lines in enumerate(leg_lines(review)):
        for line in lines:
            x, y, z = 1e3 * line.T
            above.plot(x, y, color=leg_colour(k), lw=2, alpha=0.6)
            side.plot(x, z, color=leg_colour(k), lw=1.4, alpha=0.7)


def leg_lines(review: RobotReview) -> list[list[FloatArray]]:
    """Return what each leg consists of with its joints at zero: lines of K places, (K, 3) [m]."""
    robot = review.config.parameters
    leg, shafts = robot.leg, robot.legs.shaft_position
    feet = shafts + review.path_m[0]
    if isinstance(leg, ChainParameters):
        places = ChainKinematics(leg).joint_places(np.zeros(leg.count))
        return [[np.stack([*places[list(leg.joints_of(k))], foot])] for k, foot in enumerate(feet)]
    if isinstance(leg, FourBarParameters):
        pose, here = linkage_pose(leg, np.zeros(1)), np.zeros(2)
        crank, rocker, foot = pose.crank_pin[0], pose.rocker_pin[0], pose.foot[0]
        flat = [[here, crank], [leg.ground_pivot, rocker], [crank, rocker, foot, crank]]
    else:
        sole = crank_outline(leg, 0.0)
        flat = [[np.zeros(2), sole[0]], [*sole]]
    return [[shaft + np.array([[x, 0.0, z] for x, z in line]) for line in flat] for shaft in shafts]


def _polygons(one: WalkedGait) -> Figure:
    """The feet in stance and the centre of mass at some phases."""
    figure = Figure(figsize=(9, 2.1), layout="constrained")
    number = 1 if one.figures.gait == STANDING else SNAPSHOTS
    axes = np.atleast_1d(figure.subplots(1, number, sharex=True, sharey=True))
    cycle = one.cycle
    frames = (np.arange(number) * len(cycle.phase)) // number + len(cycle.phase) // 12
    feet = cycle.feet.position_m[..., :2] * 1e3
    for ax, frame in zip(axes, frames, strict=True):
        down = cycle.stance[frame]
        load = cycle.answer.load_n[frame]
        _hull(ax, feet[frame], down)
        for leg, place in enumerate(feet[frame]):
            # from above with x upward, as a walker sees itself; y to the left
            share = load[leg] / max(float(np.nansum(load)), 1e-9)
            size = 3 + 12 * (share if np.isfinite(share) else 0.0)
            face = leg_colour(leg) if down[leg] else "none"
            ax.plot(-place[1], place[0], "o", ms=size, color=leg_colour(leg), mfc=face)
        ax.plot(0, 0, "+", color=TRUTH, ms=9, mew=1.8)
        margin = cycle.margin.margin_m[frame] * 1e3
        words = f"{margin:.0f} mm" if np.isfinite(margin) else "no feet"
        ax.set_title(f"{cycle.phase[frame]:.2f}: {words}")
        ax.set_aspect("equal", adjustable="box")
        ax.margins(0.15)
        ax.grid(visible=False)
    axes[0].set_ylabel("x, forward [mm]")
    figure.supxlabel(
        "phase and static margin; filled: in stance, size: share of the load, +: centre of mass",
        size=9,
    )
    return figure


def _hull(ax: Axes, feet_mm: FloatArray, down: FloatArray) -> None:
    edges = hull_edges(feet_mm[None], down.astype(bool)[None])
    standing = feet_mm[down.astype(bool)]
    if len(edges.frame) == 0:
        return
    # corners in the order of their edges' directions
    middle = standing.mean(axis=0)
    corners = [
        place
        for place in standing
        if (np.abs(edges.normal @ place - edges.reach_m) < 1e-6 * np.abs(standing).max()).any()
    ]
    corners.sort(key=lambda place: float(np.arctan2(*(place - middle)[::-1])))
    shape = np.array([[-place[1], place[0]] for place in corners])
    ax.add_patch(Polygon(shape, closed=True, fc=STANCE, ec=STANCE, alpha=0.18, lw=1.5))


def _curves(review: RobotReview, one: WalkedGait) -> Figure:
    """Margin, loads, tilt, speed and slip, shaft torques over a cycle."""
    figure = Figure(figsize=(9, 6.6), layout="constrained")
    axes = figure.subplots(3, 2, sharex=True)
    cycle, robot = one.cycle, review.config.parameters
    phase, names = cycle.phase, robot.legs.names
    weight = float(np.nanmax(np.nansum(cycle.answer.load_n, axis=1), initial=1e-9))
    margin, loads, tilt, height, speed, torque = axes.ravel()
    margin.plot(phase, cycle.margin.margin_m * 1e3, color=STANCE, lw=1.5)
    margin.axhline(0, color=TRUTH, lw=1)
    margin.set(ylabel="static margin [mm]")
    low, high = margin.get_ylim()
    margin.set_ylim(min(low, -0.1 * abs(high)), high)
    shares = np.nan_to_num(cycle.answer.load_n) / weight * 100
    colours = [leg_colour(leg) for leg in range(len(names))]
    loads.stackplot(phase, shares.T, colors=colours, labels=names, lw=0, alpha=0.85)
    loads.set(ylabel="load [% of weight]", ylim=(0, 100))
    pose = cycle.answer.pose
    tilt.plot(phase, np.degrees(pose[:, 0]), color="#0072B2", lw=1.2, label="about y")
    tilt.plot(phase, np.degrees(pose[:, 1]), color="#D55E00", lw=1.2, ls="--", label="about x")
    tilt.set(ylabel="slope [deg]")
    tilt.set_ylim(top=1.35 * tilt.get_ylim()[1])
    tilt.legend(ncols=2, loc="upper right")
    for leg, colour in enumerate(colours):
        height.plot(phase, cycle.height_m[:, leg] * 1e3, color=colour, lw=1)
        torque.plot(phase, cycle.torque_nm[:, leg], color=colour, lw=1)
    height.axhline(0, color=GROUND, lw=1)
    height.set(ylabel="foot over ground [mm]")
    speed.plot(phase, cycle.answer.velocity_B[:, 0] * 1e3, color="#0072B2", lw=1.2, label="speed")
    speed.plot(
        phase, cycle.forced.rms_m_s * 1e3, color="#D55E00", lw=1.2, ls="--", label="forced slip"
    )
    speed.set(ylabel="[mm/s]", xlabel="phase")
    speed.set_ylim(top=1.25 * speed.get_ylim()[1])
    speed.legend(ncols=2, loc="upper right")
    limit = robot.servo.rated_torque_limit
    torque.set(ylabel="shaft torque [N m]", xlabel=f"phase; limit {limit:g} N m")
    if float(np.nanmax(np.abs(cycle.torque_nm), initial=0.0)) > 0.5 * limit:
        for side in (-1, 1):
            torque.axhline(side * limit, color=LIMIT, lw=1, ls=":")
    for ax in axes.ravel():
        ax.set_xlim(0, 1)
    figure.legend(
        *loads.get_legend_handles_labels(), loc="outside upper center", ncols=8, frameon=False
    )
    return figure
