"""``bigant force calibrate``: poses of logs through the fit, its residuals as lines and as a picture."""

import sys
import time
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from model.errors import ConfigError
from model.fit.in_situ import InSituResult, SensorResidual, calibrate_in_situ
from model.values.force_calibration import CalibrationOrigin
from record.whole_file import whole_file
from robot.bringup.force.still_poses import read_pose_logs
from robot.config.calibration import write_calibration
from robot.config.robot_file import load_robot
from robot.console.arguments import DEFAULT_ROBOT_FILE
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.progress import ProgressBar
from robot.console.table import Column, table_lines
from robot.requests.force import ForceCalibrateRequest
from robot.run.force_unit import require_sensors
from robot.virtual.walk import record_poses

# Left-out poses are few: sensors that need no correction come out a few per cent better or worse.
WORSE = 1.1
RESOLUTION_N = 0.025  # of a Gamma SI-130-10 (ATI); below it better and worse mean nothing
STAGES = ("offsets only", "and leg gravity", "and cross-talk")
COLOURS = ("#999999", "#56B4E9", "#D55E00")
KINDS = (
    ("standing_n", "standing, force", "N"),
    ("standing_nm", "standing, moment", "N m"),
    ("air_n", "in the air, force", "N"),
    ("air_nm", "in the air, moment", "N m"),
)


def calibrate(request: ForceCalibrateRequest) -> ExitCode:
    """Calibrate.

    Returns:
        OK, or VERDICT_FAILED when left-out poses got worse; then no file is written.

    Raises:
        BigantError: A log or file cannot be used, or the poses are too few.
    """
    _check(request)
    logs = list(request.logs)
    if request.hardware is not None:
        _record(request)
        logs.append(request.log)
    poses = read_pose_logs(logs, request.hung, request.robot)
    result = calibrate_in_situ(
        poses.poses,
        poses.places,
        poses.legs,
        max_harmonics=request.harmonics,
        cross_talk=not request.no_cross_talk,
        point_feet=not request.no_point_feet,
        origin=CalibrationOrigin(
            poses.serials,
            time.strftime("%Y-%m-%dT%H:%M:%S%z"),
            tuple(dict.fromkeys(path.name for path in [*logs, *request.hung])),
        ),
    )
    allowed = WORSE * overall(result.before, "standing_n") + RESOLUTION_N
    worse = overall(result.after, "standing_n") > allowed
    if not worse:
        write_calibration(request.out, result.calibration)
    if request.report is not None:
        with whole_file(request.report, "--report") as part:
            draw_report(result).savefig(part, dpi=100)
    lines = report_lines(result)
    if not worse:
        lines.append(f"calibration: {request.out}   (bigant drive --calibration {request.out})")
    print_result(_as_json(result, None if worse else request.out), lines, as_json=request.json)
    if worse:
        print("bigant force calibrate: held-out poses got worse; nothing written", file=sys.stderr)
        return ExitCode.VERDICT_FAILED
    return ExitCode.OK


def _check(request: ForceCalibrateRequest) -> None:
    if not request.logs and request.hardware is None:
        raise ConfigError("LOG", "name one or more logs, or --hardware virtual")
    if request.report is not None and request.report.suffix != ".png":
        raise ConfigError("--report", f"must end in .png, not {request.report.name!r}")


def _record(request: ForceCalibrateRequest) -> None:
    config = load_robot(request.robot or DEFAULT_ROBOT_FILE)
    require_sensors(config.force_sensor)
    with ProgressBar("recording poses") as bar:
        record_poses(
            config,
            request.log,
            rounds=request.rounds,
            heights=4,
            seed=request.seed,
            progress=bar.show,
        )


def _as_json(result: InSituResult, out: Path | None) -> dict[str, object]:
    legs = result.calibration.legs
    parts = dict(zip(("before", "stage_one", "after"), stages(result), strict=True))
    return {
        "held_out_poses": result.held_out,
        "residuals": {name: dict(zip(legs, part, strict=True)) for name, part in parts.items()},
        "warnings": result.warnings,
        "calibration": out,
    }


def stages(result: InSituResult) -> tuple[tuple[SensorResidual, ...], ...]:
    """Return the residuals of the three stages."""
    return result.before, result.stage_one, result.after


def overall(residuals: tuple[SensorResidual, ...], kind: str) -> float:
    """Return the RMS over the sensors; NaN if none has one."""
    values = np.array([getattr(each, kind) for each in residuals])
    values = values[np.isfinite(values)]
    return float(np.sqrt((values**2).mean())) if len(values) else float("nan")


def report_lines(result: InSituResult) -> list[str]:
    """Return the report as lines."""
    columns = (Column("leg"), Column(""), *(Column(stage, ".4f") for stage in STAGES), Column(""))
    sensors = [(name, slice(at, at + 1)) for at, name in enumerate(result.calibration.legs)]
    rows = [
        (name, words, *(float(overall(part[which], kind)) for part in stages(result)), unit)
        for name, which in (*sensors, ("all", slice(None)))
        for kind, words, unit in KINDS
    ]
    lines = [
        f"residuals on {result.held_out} held-out standing poses, RMS, seen from each sensor",
        *table_lines(columns, rows),
    ]
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
    figure.suptitle(f"Force sensors on {result.held_out} held-out standing poses", fontsize=11)
    return figure
