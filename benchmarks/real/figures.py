"""Pictures of docs/real: what was named against the decoys, and each machine's data with its cause."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from record.trial.trial import read_trial
from robot.report.plots import DIFFERENCE, PREDICTED, STYLE, TRUE

AFTER = "#009E73"
COLOURS = ("#E69F00", "#56B4E9", "#CC79A7", "#999999", "#D55E00", "#0072B2", AFTER)
GRAVITY = 9.80665


def draw_arm(
    joints: Sequence[tuple[str, Sequence[float]]], decoys: Sequence[str], out: Path
) -> None:
    """Draw by how much each explanation cuts the RMS on the held-out motions."""
    names = [*(f"{name.replace('+', ' + ')}" for name in decoys), "what was named"]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 3.6), layout="constrained")
        ax: Axes = figure.subplots()
        at = np.arange(len(joints))
        width = 0.8 / len(names)
        for i, (name, colour) in enumerate(zip(names, COLOURS, strict=True)):
            cuts = [100 * max(values[i], 0.0) for _, values in joints]
            ax.bar(at + (i - (len(names) - 1) / 2) * width, cuts, width, color=colour, label=name)
        ax.axhline(70, color="k", lw=0.8, ls="--")
        ax.set_xticks(at, [joint for joint, _ in joints])
        ax.set_ylabel("RMS cut on held-out motions, %")
        ax.set_ylim(0, 100)
        figure.legend(loc="outside upper center", ncols=4, fontsize=8)
        figure.savefig(out, dpi=110)


def draw_rig(trial: Path, width_rad: float, out: Path) -> None:
    """Draw the held shaft, the side it is pulled to, and the two flanks of its play."""
    one = read_trial(trial)
    counts = 4096 / (2 * np.pi)
    error = (one.shaft_rad - one.command_rad)[:, 0] * counts
    pull = one.torque_nm[:, 0]
    held = np.abs(error) < 40
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 3.2), layout="constrained")
        ax: Axes = figure.subplots()
        for side, colour, words in (
            (pull > 0, PREDICTED, "pulled forward"),
            (pull < 0, TRUE, "pulled back"),
            (pull == 0, "#BBBBBB", "neither: not compared"),
        ):
            at = side & held
            ax.plot(one.time_s[at], error[at], ".", ms=4, color=colour, label=words)
        middle = np.median(error[held & (pull > 0)]) + np.median(error[held & (pull < 0)])
        for sign in (-1, 1):
            ax.axhline(middle / 2 + sign * width_rad * counts / 2, color=AFTER, lw=1.2, ls="--")
        ax.set_xlabel("time, s")
        ax.set_ylabel("shaft - command, counts")
        figure.legend(loc="outside upper center", ncols=3)
        figure.savefig(out, dpi=110)


def draw_cube(trials: Sequence[Path], values: Mapping[str, float], out: Path) -> None:
    """Draw deceleration against speed of all slides, and both laws."""
    bins = np.arange(0.05, 2.5, 0.1)
    speeds, slowing = [], []
    for path in trials:
        one = read_trial(path)
        middle, speed, rate = _slowing(one.time_s, one.body_position_m[:, :2])
        if middle:
            speeds.append(speed)
            slowing.append(rate)
    v, a = np.concatenate(speeds), np.concatenate(slowing)
    at = np.digitize(v, bins)
    full = [k for k in range(1, len(bins)) if (at == k).sum() > 30]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 3.4), layout="constrained")
        ax: Axes = figure.subplots()
        centre = np.array([(bins[k - 1] + bins[k]) / 2 for k in full])
        quart = np.array([np.percentile(a[at == k], (25, 50, 75)) for k in full])
        ax.fill_between(
            centre, quart[:, 0], quart[:, 2], color="#CCCCCC", label="measured, half of it"
        )
        ax.plot(centre, quart[:, 1], color="k", lw=1.8, label="measured, median")
        mu, per = values["mu"], values.get("per_m_s", 0.0)
        ax.plot(
            centre,
            0.2 * GRAVITY * centre,
            color=PREDICTED,
            ls=":",
            label="nominal: viscous, mu 0.2",
        )
        ax.plot(
            centre, mu * (1 + per * centre) * GRAVITY, color=AFTER, ls="--", label="what was named"
        )
        ax.axhline(0.18 * GRAVITY, color=DIFFERENCE, lw=0.8, label="Coulomb, mu 0.18 (published)")
        ax.set_xlabel("speed, m/s")
        ax.set_ylabel("deceleration, m/s^2")
        ax.set_ylim(0, None)
        figure.legend(loc="outside upper center", ncols=3, fontsize=8)
        figure.savefig(out, dpi=110)


def _slowing(time_s: np.ndarray, xy: np.ndarray) -> tuple[int, np.ndarray, np.ndarray]:
    """Speed and deceleration along the path from differences over 10 frames."""
    k = 10
    if len(time_s) < 3 * k:
        return 0, time_s[:0], time_s[:0]
    v = (xy[k:] - xy[:-k]) / (time_s[k:] - time_s[:-k])[:, None]
    speed = np.linalg.norm(v, axis=1)
    rate = -(speed[k:] - speed[:-k]) / (time_s[k : len(speed)] - time_s[: len(speed) - k])
    return len(rate), speed[k // 2 : k // 2 + len(rate)], rate
