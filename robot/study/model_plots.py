"""Pictures of a predicted motion: the robot from above, its velocity, the loads on its feet."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from model.motion.se2 import placed
from model.quasistatic.frames import FrictionLaw
from model.systems.predict import SystemPrediction
from model.values.arrays import FloatArray
from robot.report.plots import STYLE

COLOURS = {FrictionLaw.VISCOUS: "#D55E00", FrictionLaw.COULOMB: "#0072B2"}
INK, PRINT = "#333333", "#009E73"
MOST_POINTS = 1500
MOST_PRINTS = 6000
SNAPSHOT_WINDOWS = 12
SIDE_VIEWS = 6
NAMED_FEET = 16  # more rows than this are not labelled one by one


def draw_predictions(predictions: Sequence[SystemPrediction]) -> Figure:
    """Draw one system under one friction law or several.

    Args:
        predictions: Of the same system, one a law; loads and body are drawn of the first.
    """
    first = predictions[0]
    stairs = first.system.ground_m is not None
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 10.5 if stairs else 9), layout="constrained")
        heights = [3.4, 1, 1, 1, 1.5] + ([1.4] if stairs else [])
        axes = figure.subplots(len(heights), 1, height_ratios=heights)
        figure.suptitle(first.system.description)
        _above(axes[0], predictions)
        for ax in axes[2:5]:
            ax.sharex(axes[1])
        _velocity(axes[1:4], predictions)
        _loads(figure, axes[4], first)
        if stairs:
            _side(axes[5], first)
    return figure


def _above(ax: Axes, predictions: Sequence[SystemPrediction]) -> None:
    first = predictions[0]
    world = _feet_in_world(first)
    loaded = first.solutions.contact
    prints = world[loaded]
    prints = prints[:: max(1, len(prints) // MOST_PRINTS)]
    ax.plot(prints[:, 0], prints[:, 1], ".", ms=1.2, color=PRINT, alpha=0.5, zorder=1)
    for order, frame in enumerate(_snapshots(first)):
        _body(ax, first, frame, world[frame], zorder=2 + order / 10)
    for prediction in predictions:
        pose = prediction.poses[_thin(len(prediction.poses))]
        colour = COLOURS[prediction.law]
        ax.plot(pose[:, 0], pose[:, 1], color=colour, lw=1.5, label=prediction.law.value, zorder=4)
    ax.plot([], [], "o", color=INK, ms=5, label="loaded foot")
    ax.plot([], [], "o", mec=INK, mfc="white", ms=5, label="foot in the air")
    ax.plot([], [], ".", color=PRINT, ms=4, label="where feet stood")
    ax.set_aspect("equal", adjustable="datalim")
    ax.set(xlabel="x [m]", ylabel="y [m]")
    ax.legend(loc="upper center", ncols=5, fontsize=8, bbox_to_anchor=(0.5, 1.12))


def _snapshots(prediction: SystemPrediction) -> list[int]:
    """Begin, middle and end (no middle on a short path), each where most feet are in the air."""
    frames = prediction.system.frames
    feet = prediction.system.feet.position_m[0, :, 0]
    distance_m = float(np.linalg.norm(prediction.poses[-1, :2] - prediction.poses[0, :2]))
    shares = (0.0, 0.5, 1.0) if distance_m > 2.5 * np.ptp(feet) else (0.0, 1.0)
    count = prediction.solutions.contact.sum(axis=1)
    window = max(1, frames // SNAPSHOT_WINDOWS)
    begins = (int(share * (frames - window)) for share in shares)
    return [begin + int(np.argmin(count[begin : begin + window])) for begin in begins]


def _body(
    ax: Axes, prediction: SystemPrediction, frame: int, feet_W: FloatArray, zorder: float  # noqa: N803
) -> None:  # fmt: skip
    system = prediction.system
    pose = prediction.poses[frame]
    loaded = prediction.solutions.contact[frame]
    if system.outline_B is None:
        ax.plot(feet_W[:, 0], feet_W[:, 1], color=INK, lw=3, alpha=0.6, zorder=zorder)
    else:
        outline = placed(pose, system.outline_B)
        ax.fill(outline[:, 0], outline[:, 1], fc="#DDDDDD", ec=INK, lw=1, alpha=0.8, zorder=zorder)
    if system.hips_B is not None:
        hips = placed(pose, system.hips_B)
        ax.plot(*np.stack([hips, feet_W], axis=1).T, color=INK, lw=1, zorder=zorder)
    size = 5 if system.legs <= NAMED_FEET else 3
    ax.plot(*feet_W[loaded].T, "o", color=INK, ms=size, zorder=zorder)
    ax.plot(*feet_W[~loaded].T, "o", mec=INK, mfc="white", ms=size, zorder=zorder)


def _velocity(axes: Sequence[Axes], predictions: Sequence[SystemPrediction]) -> None:
    labels = ("vx [mm/s]", "vy [mm/s]", "yaw [mrad/s]")
    for component, (ax, label) in enumerate(zip(axes, labels, strict=True)):
        for prediction in predictions:
            thin = _thin(prediction.system.frames)
            time, colour = prediction.system.time_s[thin], COLOURS[prediction.law]
            if prediction.system.low_pass is not None:
                raw = prediction.solutions.velocity_B[thin, component] * 1e3
                name = "before the low pass" if prediction is predictions[0] else None
                ax.plot(time, raw, color="#AAAAAA", lw=2.2, label=name)
            ax.plot(time, prediction.velocity_B[thin, component] * 1e3, color=colour, lw=1.1,
                    label=prediction.law.value)  # fmt: skip
        ax.set_ylabel(label)
        ax.tick_params(labelbottom=False)
        low, high = ax.get_ylim()
        if high - low < 1.0:  # rounding must not look like a motion
            ax.set_ylim(-1, 1)
    if len(predictions) > 1 or predictions[0].system.low_pass is not None:
        low, high = axes[0].get_ylim()
        axes[0].set_ylim(low, high + 0.35 * (high - low))  # room for the legend
        axes[0].legend(loc="upper right", ncols=4, fontsize=8)


def _loads(figure: Figure, ax: Axes, prediction: SystemPrediction) -> None:
    system = prediction.system
    load = prediction.solutions.load_n[_thin(system.frames)]
    shown = np.where(load > 0, load, np.nan)
    mesh = ax.imshow(
        shown.T, aspect="auto", origin="lower", interpolation="nearest", cmap="viridis", vmin=0,
        extent=(0, system.frames * system.step_s, 0.5, system.legs + 0.5),
    )  # fmt: skip
    ax.grid(visible=False)
    ax.set_ylabel("foot")
    if system.legs <= NAMED_FEET:
        ax.set_yticks(np.arange(1, system.legs + 1, 1 if system.legs <= NAMED_FEET // 2 else 3))
    ax.set_xlabel("time [s]")
    figure.colorbar(mesh, ax=ax, label="load [N]", pad=0.01)


def _side(ax: Axes, prediction: SystemPrediction) -> None:
    system = prediction.system
    ground = system.ground_m
    assert ground is not None  # drawn only where there is one
    world = _feet_in_world(prediction)
    ahead = world[..., 0].ravel()
    order = np.argsort(ahead)[:: max(1, ahead.size // MOST_PRINTS)]
    profile = ground.ravel()[order] * 1e3
    ax.fill_between(
        ahead[order], profile, profile.min() - 10, color="#BBBBBB", step="mid", label="ground"
    )
    height = prediction.solutions.pose[:, 2] * 1e3
    ax.plot(prediction.poses[:-1, 0], height, color=COLOURS[prediction.law], label="body origin")
    for frame in np.linspace(0, system.frames - 1, SIDE_VIEWS).astype(int):
        if system.outline_B is None or not prediction.solutions.valid[frame]:
            continue
        half = np.ptp(system.outline_B[:, 0]) / 2
        ends = np.array([-half, half])
        # a point of the body at x stands at height - slope_x x (eqn:zpj)
        level = height[frame] - 1e3 * prediction.solutions.pose[frame, 0] * ends
        ax.plot(prediction.poses[frame, 0] + ends, level, color=INK, lw=2, alpha=0.6)
    ax.set(xlabel="x [m]", ylabel="height [mm]")
    low, high = ax.get_ylim()
    ax.set_ylim(low, high + 0.3 * (high - low))  # room for the legend
    ax.legend(loc="upper right", ncols=2, fontsize=8)


def _feet_in_world(prediction: SystemPrediction) -> FloatArray:
    """Feet in every frame seen from above, (F, N, 2)."""
    return placed(prediction.poses[:-1, None], prediction.system.feet.position_m[..., :2])


def _thin(count: int) -> slice:
    return slice(None, None, max(1, count // MOST_POINTS))
