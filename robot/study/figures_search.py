"""The search for the contacts drawn: a robot in a plane, and a hexapod in space."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection
from mpl_toolkits.mplot3d.axes3d import Axes3D

from model.support.path import NO_FOOT, SupportPath, search_path
from model.values.arrays import FloatArray
from robot.report.figure_style import NEUTRAL, SUPPORT, leg_colour

# Unloaded feet [m]: heights are made uneven so that the search has something to do.
FLAT_FEET = np.array([[-0.28, 0.0, -0.180], [-0.20, 0.0, -0.163],
                      [-0.08, 0.0, -0.152], [0.04, 0.0, -0.153]])  # fmt: skip
HEXAPOD_FEET = np.array([[-0.2, 0.25, -0.125], [0.0, 0.25, -0.125], [0.2, 0.25, -0.149],
                         [-0.2, -0.25, -0.137], [0.0, -0.25, -0.182], [0.2, -0.25, -0.166]])  # fmt: skip
STIFFNESS_N_M, WEIGHT_N = 2500.0, 63.7
GREEN = "#1B9E3A"


def draw_search_line() -> tuple[Figure, str]:
    """Draw fig:robot_2d: the search over slope and height of a robot in the x-z plane."""
    path = search_path(FLAT_FEET, np.full(len(FLAT_FEET), STIFFNESS_N_M), WEIGHT_N)
    stops = len(path.pose)
    figure = Figure(figsize=(10, 5.6), layout="constrained")
    columns = (stops + 1) // 2
    grid = figure.add_gridspec(2, columns + 2)
    _line_space(figure.add_subplot(grid[:, :2]), path)
    for stop in range(stops):
        _flat_robot(figure.add_subplot(grid[stop // columns, 2 + stop % columns]), path, stop)
    caption = (
        f"Search for the contacts of a flat robot with {len(FLAT_FEET)} legs: level start (0), a leg "
        f"switches at each dot on a coloured line, balance at the star after {stops - 2} switches. "
        "Dashed: the rest of each step, which the new contacts make void. Right: the robot at each "
        "stop; the circle marks the leg that switches. The paper's example ends at step 3."
    )
    return figure, caption


def _line_space(ax: Axes, path: SupportPath) -> None:
    slope, height = 1e3 * path.pose[:, 0], 1e3 * path.pose[:, 2]
    pad_x, pad_y = 0.25 * max(np.ptp(slope), 20.0), 0.3 * max(np.ptp(height), 2.0)
    left, right = slope.min() - pad_x, slope.max() + pad_x
    x = np.array([left, right])
    for leg, foot in enumerate(FLAT_FEET):
        ax.plot(x, x * foot[0] - 1e3 * foot[2], color=leg_colour(leg), lw=1.8,
                label=f"leg {leg + 1} touches")  # fmt: skip
    for stop in range(len(slope) - 1):
        ax.plot(slope[stop : stop + 2], height[stop : stop + 2], color="black", lw=1.5)
        aim = 1e3 * path.target[stop]  # not drawn where it is NaN
        ax.plot([slope[stop + 1], aim[0]], [height[stop + 1], aim[2]], "k--", lw=0.9)
    ax.plot(slope[:-1], height[:-1], "ko", ms=5)
    ax.plot(slope[-1], height[-1], "*", color=SUPPORT, ms=16, zorder=5)
    for stop in range(len(slope)):
        ax.annotate(str(stop), (slope[stop], height[stop]), (7, 6), textcoords="offset points",
                    fontweight="bold")  # fmt: skip
    ax.set(xlim=(left, right), ylim=(height.min() - pad_y, height.max() + pad_y))
    ax.set(xlabel="slope_x (pitch) [mrad]", ylabel="height of the body [mm]")
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.11), ncols=2)


def _flat_robot(ax: Axes, path: SupportPath, stop: int) -> None:
    slope, _, height = path.pose[stop]
    span = np.array([-0.33, 0.33])
    ax.plot(span, height - slope * span, color=NEUTRAL, lw=3)
    ax.axhline(0, color="black", lw=1)
    for leg, foot in enumerate(FLAT_FEET):
        hip = height - slope * foot[0]
        tip = max(hip + foot[2], 0.0)  # a loaded spring is pressed up to the ground
        zigzag = foot[0] + 0.012 * np.array([0, 0, 1, -1, 1, -1, 1, 0, 0])
        ax.plot(zigzag, np.linspace(hip, tip, 9), color=leg_colour(leg), lw=1.8)
        if leg == path.switched[stop]:
            ax.plot(foot[0], tip, "o", mfc="none", mec=GREEN, mew=2, ms=13)
    ax.set_title(_stop_title(path, stop), loc="left", fontsize=9)
    ax.set(xlim=(-0.36, 0.36), ylim=(-0.03, 0.22), xticks=[], yticks=[])
    ax.spines[:].set_visible(False)
    ax.grid(visible=False)


def _stop_title(path: SupportPath, stop: int) -> str:
    down = " ".join(str(leg + 1) for leg in np.flatnonzero(path.contact[stop]))
    return f"{stop}: down {down}"


def draw_search_space() -> tuple[Figure, str]:
    """Draw fig:search_3d: the search over both slopes and height of a hexapod."""
    path = search_path(HEXAPOD_FEET, np.full(len(HEXAPOD_FEET), STIFFNESS_N_M), WEIGHT_N)
    stops = len(path.pose)
    figure = Figure(figsize=(11, 5), layout="constrained")
    columns = (stops + 1) // 2
    grid = figure.add_gridspec(2, columns + 2, width_ratios=[1.4, 1.4] + [1] * columns)
    space = figure.add_subplot(grid[:, :2], projection="3d")
    assert isinstance(space, Axes3D)
    _pose_space(space, path)
    for stop in range(stops):
        small = figure.add_subplot(grid[stop // columns, 2 + stop % columns], projection="3d")
        assert isinstance(small, Axes3D)
        _hexapod(small, path, stop)
    slope_x, slope_y, height = path.pose[-1]
    legs = ", ".join(str(leg + 1) for leg in path.switched[1:-1])
    caption = (
        f"Search for the contacts of a hexapod on uneven legs, {stops - 2} switches (legs {legs}), "
        f"ending at pitch {slope_x * 1e3:.1f} mrad, roll {slope_y * 1e3:.1f} mrad, height "
        f"{height * 1e3:.1f} mm on {int(path.contact[-1].sum())} feet. Coloured planes: where a leg "
        "that switches touches the ground; dashed: the direction of each balance beyond the stop; "
        "circles: the leg that switches. Loads at the end are those of the model's own search. The "
        "paper's example takes 3 steps."
    )
    return figure, caption


def _pose_space(ax: Axes3D, path: SupportPath) -> None:
    pose = path.pose * [1e3, 1e3, 1e3]
    low, high = pose.min(axis=0), pose.max(axis=0)
    pad = np.maximum(0.25 * (high - low), [4.0, 4.0, 1.0])
    low, high = low - pad, high + pad
    for leg in np.unique(path.switched[path.switched != NO_FOOT]):
        _plane(ax, HEXAPOD_FEET[leg], low, high, leg_colour(int(leg)))
    ax.plot(*pose.T, color="black", lw=1.8)
    for stop in range(len(pose) - 1):
        aim = path.target[stop] * 1e3
        if not np.isfinite(aim).all():
            continue
        # the aim may lie far outside: draw the line to it up to the edge of the box
        step = aim - pose[stop + 1]
        room = np.where(step > 0, high - pose[stop + 1], low - pose[stop + 1])
        share = min(1.0, float(np.min(room / np.where(step == 0, np.nan, step))))
        beyond = np.array([pose[stop + 1], pose[stop + 1] + share * step])
        ax.plot(*beyond.T, color=NEUTRAL, ls="--", lw=1)
    ax.plot(*pose[:-1].T, "ko", ms=4)
    ax.plot(*pose[-1:].T, "*", color=SUPPORT, ms=14)
    for stop, (x, y, z) in enumerate(pose):
        ax.text(x, y, z, f" {stop}", fontweight="bold", fontsize=10)
    ax.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    ax.set(xlabel="slope_x (pitch) [mrad]", ylabel="slope_y (roll) [mrad]")
    ax.set_zlabel("height [mm]")
    for axis in (ax.xaxis, ax.yaxis, ax.zaxis):
        axis.set_major_locator(MaxNLocator(5))
    ax.view_init(elev=22, azim=-60)
    ax.set_box_aspect(None, zoom=0.86)


def _plane(ax: Axes3D, foot: FloatArray, low: FloatArray, high: FloatArray, colour: str) -> None:
    """Draw the plane on which a foot touches the ground, cut to the box (slopes [mrad], height [mm])."""
    normal, offset = np.array([-foot[0], foot[1], 1.0]), 1e3 * foot[2]  # normal . pose + offset = 0
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    box = low + corners * (high - low)
    level = box @ normal + offset
    cuts = [
        box[i] + (box[j] - box[i]) * level[i] / (level[i] - level[j])
        for i in range(8)
        for j in range(i)
        if np.abs(corners[i] - corners[j]).sum() == 1 and level[i] * level[j] < 0
    ]
    if len(cuts) < 3:
        return
    polygon = np.array(cuts)
    # around the middle, in coordinates of the plane made comparable by the box
    flat = (polygon - polygon.mean(axis=0)) / (high - low)
    _, _, axes = np.linalg.svd(flat)
    order = np.argsort(np.arctan2(flat @ axes[1], flat @ axes[0]))
    ax.add_collection3d(
        Poly3DCollection([polygon[order]], facecolor=colour, edgecolor=colour, alpha=0.25)
    )


def _hexapod(ax: Axes3D, path: SupportPath, stop: int) -> None:
    slope_x, slope_y, height = path.pose[stop]
    hips = height - slope_x * HEXAPOD_FEET[:, 0] + slope_y * HEXAPOD_FEET[:, 1]
    tips = np.maximum(hips + HEXAPOD_FEET[:, 2], 0.0)
    ring = [0, 1, 2, 5, 4, 3, 0]
    ax.plot(*HEXAPOD_FEET[ring, :2].T, hips[ring], color=NEUTRAL, lw=2)
    for leg, (x, y, _) in enumerate(HEXAPOD_FEET):
        colour = leg_colour(leg)
        ax.plot([x, x], [y, y], [hips[leg], tips[leg]], color=colour, lw=2.5)
        face = colour if path.contact[stop][leg] else "white"
        ax.plot([x], [y], [tips[leg]], "o", mfc=face, mec=colour, ms=5)
        if leg == path.switched[stop]:
            ax.plot([x], [y], [tips[leg]], "o", mfc="none", mec=GREEN, mew=2, ms=13)
    ax.plot(*HEXAPOD_FEET[ring, :2].T, np.zeros(len(ring)), color="black", lw=0.6)
    ax.set(xlim=(-0.25, 0.25), ylim=(-0.28, 0.28), zlim=(0, 0.22), xticks=[], yticks=[], zticks=[])
    ax.set_title(_stop_title(path, stop), fontsize=9)
    ax.view_init(elev=18, azim=-65)
