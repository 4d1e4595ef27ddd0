"""What ``bigant ft calibrate`` says: residuals on left-out poses, before and after, and a picture."""

import numpy as np
from matplotlib.figure import Figure

from model.fit.in_situ import InSituResult, SensorResidual
from model.values.arrays import root_mean_square

STAGES = ("offsets only", "and leg gravity", "and cross-talk")
COLOURS = ("#999999", "#56B4E9", "#D55E00")
KINDS = (
    ("standing_n", "standing, force", "N"),
    ("standing_nm", "standing, moment", "N m"),
    ("air_n", "in the air, force", "N"),
    ("air_nm", "in the air, moment", "N m"),
)


def stages(result: InSituResult) -> tuple[tuple[SensorResidual, ...], ...]:
    """Return the residuals of the three stages."""
    return result.before, result.stage_one, result.after


def overall(residuals: tuple[SensorResidual, ...], kind: str) -> float:
    """Return the RMS over the sensors; NaN if none has one."""
    return float(root_mean_square(np.array([getattr(each, kind) for each in residuals])))


def report_lines(result: InSituResult) -> list[str]:
    """Return the report as lines."""
    lines = [
        f"residuals on {result.held_out} left-out standing poses, RMS, seen from each sensor",
        f"{'leg':<5}{'':20}" + "".join(f"{stage:>18}" for stage in STAGES),
    ]
    for leg, name in enumerate(result.calibration.legs):
        for kind, words, unit in KINDS:
            values = "".join(f"{getattr(part[leg], kind):18.4f}" for part in stages(result))
            lines.append(f"{name:<5}{words:<20}{values} {unit}")
    for kind, words, unit in KINDS:
        values = "".join(f"{overall(part, kind):18.4f}" for part in stages(result))
        lines.append(f"{'all':<5}{words:<20}{values} {unit}")
    for name, fit in zip(result.calibration.legs, result.unloaded, strict=True):
        if fit is not None:
            lines.append(
                f"{name}: {fit.samples} poses in the air, {fit.harmonics} harmonics, "
                f"condition number {fit.condition:.3g}"
            )
    if result.cross_talk is not None:
        fit2 = result.cross_talk
        lines.append(
            f"cross-talk: {fit2.poses} poses, ridge {fit2.strength:.2g}, condition number "
            f"{fit2.condition:.3g}, {100 * fit2.resolution.mean():.0f} % decided by the data"
        )
    return lines + [f"warning: {text}" for text in result.warnings]


def draw_report(result: InSituResult) -> Figure:
    """Draw the residuals of each sensor as bars, three stages side by side."""
    figure = Figure(figsize=(9, 5.5), layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    at = np.arange(len(result.calibration.legs))
    for axis, (kind, words, unit) in zip(axes, KINDS, strict=True):
        for index, (part, stage) in enumerate(zip(stages(result), STAGES, strict=True)):
            heights = [getattr(each, kind) for each in part]
            axis.bar(at + (index - 1) * 0.27, heights, 0.25, color=COLOURS[index], label=stage)
        axis.set_xticks(at, result.calibration.legs)
        axis.set_ylabel(f"RMS residual, {unit}")
        axis.set_title(words, fontsize=10)
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].legend(frameon=False, fontsize=8)
    figure.suptitle(f"Force sensors on {result.held_out} left-out standing poses", fontsize=11)
    return figure
