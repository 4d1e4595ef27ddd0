"""``bigant model sensitivity``: naive against fitted parameters on logs (the paper's sec:tripod)."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from model.errors import ConfigError, ModelError
from model.fit.result import FitResult
from model.quasistatic.frames import FrictionLaw, solve_frames
from model.traction.force_scale import force_scale
from model.values.arrays import BoolArray, FloatArray
from model.values.parameters import ContactParameters
from record.log.blocks.read import read_log
from record.whole_file import check_room, whole_file
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.table import Column, table_lines
from robot.report.pictures import DOTS_PER_INCH
from robot.report.plots import PREDICTED, STYLE, TRUE
from robot.report.walk_frames import (
    NAIVE_MU,
    NAIVE_STIFFNESS,
    Fits,
    WalkFrames,
    fit_contact,
    halves,
    joined,
    walk_frames,
)
from robot.requests.model import ModelSensitivityRequest

QUANTITIES = ("heading", "side", "turning", "roll", "pitch", "Fx", "Fy", "Fz")
UNITS = ("mm/s", "mm/s", "mrad/s", "mrad", "mrad", "N", "N", "N")
TO_UNITS = np.array([1e3, 1e3, 1e3, 1e3, 1e3, 1.0, 1.0, 1.0])
# How the paper's errors changed from fitted to naive parameters [%] (sec:tripod).
PAPER_CHANGE = (14.0, -5.5, 1.5, -22.0, 24.0, 4.0, 3.0, 2.0)
TABLE = (
    Column("RMSE"), Column(""), Column("fitted", ".3f", 8), Column("naive", ".3f", 8),
    Column("change, %", "+.1f"), Column("paper, %", "+.1f"),
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class Sensitivity:
    """Errors of the model on frames that it was not fitted to, in the units of ``UNITS``.

    Attributes:
        fitted: RMSE under fitted parameters, (8,), in the order of ``QUANTITIES``.
        naive: Under naive parameters, (8,).
        frames: Frames judged.
        without_answer: Frames left out because either model had none.
        clamped: Frames whose force scale would have been negative, fitted and naive.
    """

    fitted: FloatArray
    naive: FloatArray
    frames: int
    without_answer: int
    clamped: tuple[int, int]

    @property
    def change(self) -> FloatArray:
        """Change from fitted to naive, (8,) [%]; NaN where the fitted error is 0."""
        there = self.fitted > 0
        ratio = np.divide(self.naive, self.fitted, out=np.full(8, np.nan), where=there)
        percent: FloatArray = 100 * (ratio - 1)
        return percent

    @property
    def rows(self) -> list[tuple[object, ...]]:
        """Each quantity: its name, unit, fitted and naive RMSE, change and the paper's change [%]."""
        columns = (QUANTITIES, UNITS, self.fitted, self.naive, self.change, PAPER_CHANGE)
        return list(zip(*columns, strict=True))


def judge_sensitivity(request: ModelSensitivityRequest) -> ExitCode:
    """Fit to the first half, judge on the rest, print and draw.

    Raises:
        RecordError: A log cannot be read or used, or the picture cannot be written.
        ConfigError: ``--out`` names no PNG, or the logs are of different robots.
        ModelError: There is nothing to fit to.
    """
    check_room(request.out, "--out", ".png")
    names, walks = _read(request.logs)
    first = len(walks) // 2
    if first:
        fitted_to, judged_by = joined(walks[:first]), joined(walks[first:])
        file_names = [path.name for path in request.logs]
        parts = [", ".join(file_names[:first]), ", ".join(file_names[first:])]
    else:
        fitted_to, judged_by = halves(walks[0])
        parts = [f"earlier half of {request.logs[0].name}", "its later half"]
    fits = fit_contact(
        fitted_to,
        names,
        free_w=request.form == 24,
        rest_m_s=request.rest_mm_s * 1e-3,
        law=FrictionLaw(request.law),
    )
    sensitivity = compare(judged_by, fits)
    if request.json:
        print_json(_as_json(fits, sensitivity, fitted_to.count, parts))
    else:
        print(f"fitted to {parts[0]}, {fitted_to.count} frames; weight {fits.weight_n:.2f} N")
        print(f"judged by {parts[1]}, {sensitivity.frames} frames; none of them fitted to")
        stiffness = NAIVE_STIFFNESS * fits.weight_n
        print(f"naive: K {stiffness:.0f} N/m (10 for a weight of 1), mu 1, w 0")
        print(*_table(sensitivity), "", *_parameters(fits), sep="\n")
    if request.out is not None:
        with whole_file(request.out) as part:
            _drawing(sensitivity).savefig(part, dpi=DOTS_PER_INCH)
        if not request.json:
            print(f"picture: {request.out}")
    return ExitCode.OK


def _read(paths: Sequence[Path]) -> tuple[tuple[str, ...], list[WalkFrames]]:
    walks: list[WalkFrames] = []
    names: tuple[str, ...] = ()
    for path in paths:
        log = read_log(path)
        if names and log.names != names:
            words = f"{path.name} has legs {log.names}, {paths[0].name} has {names}"
            raise ConfigError("LOG", words)
        names = log.names
        walks.append(walk_frames(log, path.name))
    return names, walks


def _table(sensitivity: Sensitivity) -> list[str]:
    lines = table_lines(TABLE, sensitivity.rows)
    lines.append("change: from fitted to naive; + means that fitting helped")
    if sensitivity.without_answer:
        lines.append(f"{sensitivity.without_answer} frames left out: the model has no answer there")
    if any(sensitivity.clamped):
        lines.append(
            "frames with the predicted forces against the measured: "
            f"{sensitivity.clamped[0]} fitted, {sensitivity.clamped[1]} naive (scale 0)"
        )
    return lines


def _parameters(fits: Fits) -> list[str]:
    mu = "relative, mean 1 by convention" if fits.law is FrictionLaw.VISCOUS else "Coulomb's"
    lines = [f"fitted parameters (K in N/m; mu {mu}), standard error"]
    results = (("stiffness", fits.stiffness), ("friction", fits.friction))
    rows = [
        (name, value, f"+- {error:.2g}" if np.isfinite(error) else "not determined by these data")
        for _, result in results
        for name, value, error in _values(result)
    ]
    lines += table_lines((Column(""), Column("", ".4g"), Column("")), rows, "  ")
    lines.append("standard errors take frames for independent; those of a log are not")
    lines.append(
        f"residual RMS: {fits.stiffness.residual_rms:.2g} of the weight, "
        f"{fits.friction.residual_rms:.2g} N horizontally"
    )
    for what, result in results:
        lines += [f"left out of the {what} fit: {why}, {count}" for why, count in result.left_out]
        lines += [f"note: {warning}" for warning in result.warnings]
        if not result.converged:
            lines.append(f"note: the search for the {what} did not end by itself")
    return lines


def _as_json(
    fits: Fits, sensitivity: Sensitivity, fitted_to: int, parts: Sequence[str]
) -> dict[str, object]:
    keys = ("quantity", "unit", "fitted", "naive", "change_percent", "paper_change_percent")
    return {
        "law": fits.law.value,
        "fitted_to": {"what": parts[0], "frames": fitted_to, "weight_n": fits.weight_n},
        "judged_by": {
            "what": parts[1],
            "frames": sensitivity.frames,
            "without_answer": sensitivity.without_answer,
        },
        "rmse": [dict(zip(keys, row, strict=True)) for row in sensitivity.rows],
        "stiffness": _result(fits.stiffness),
        "friction": _result(fits.friction),
    }


def _result(result: FitResult) -> dict[str, object]:
    keys = ("name", "value", "standard_error")
    return {
        "parameters": [dict(zip(keys, row, strict=True)) for row in _values(result)],
        "residual_rms": result.residual_rms,
        "frames_used": result.frames_used,
        "left_out": [{"why": why, "count": count} for why, count in result.left_out],
        "undetermined": result.undetermined,
        "warnings": result.warnings,
        "converged": result.converged,
    }


def _values(result: FitResult) -> list[tuple[str, float, float]]:
    """Name, value and standard error of each parameter."""
    return list(zip(result.names, result.values, result.standard_errors, strict=True))


def _drawing(sensitivity: Sensitivity) -> Figure:
    at = np.arange(len(QUANTITIES))
    bars = (
        (at - 0.2, sensitivity.change, PREDICTED, "these logs"),
        (at + 0.2, np.array(PAPER_CHANGE), TRUE, "the paper"),
    )
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(9, 3.8), layout="constrained")
        ax = figure.subplots()
        for place, change, colour, label in bars:
            known = np.isfinite(change)
            ratio = 1 + change[known] / 100
            # on a logarithmic axis twice as bad and half as bad are the same step from 1
            ax.bar(place[known], ratio - 1, 0.38, bottom=1, color=colour, label=label)
            for x, y, percent in zip(place[known], ratio, change[known], strict=True):
                words = f"{percent:+.0f} %" if abs(percent) >= 10 else f"{percent:+.1f} %"
                ax.annotate(words, (x, max(y, 1.0)), (0, 3), textcoords="offset points",
                            ha="center", fontsize=7)  # fmt: skip
        ax.set_yscale("log")
        ax.axhline(1, color="k", lw=0.8)
        ax.margins(y=0.15)
        ax.set_xticks(at, QUANTITIES)
        ax.set_ylabel("RMSE, naive / fitted")
        ax.set_title("naive against fitted parameters, on frames not fitted to", loc="left")
        ax.legend()
    return figure


def compare(walk: WalkFrames, fits: Fits) -> Sensitivity:
    """Judge fitted and naive parameters on the same frames.

    Raises:
        ModelError: The model has an answer for none of them.
    """
    legs = walk.feet.shape[1]
    naive = ContactParameters(
        np.full(legs, NAIVE_STIFFNESS * fits.weight_n),
        np.full(legs, NAIVE_MU),
        np.zeros((legs, 2)),
    )
    (fitted, known, fitted_clamped), (poor, known_too, naive_clamped) = (
        _errors(walk, contact, fits) for contact in (fits.contact, naive)
    )
    both = known & known_too
    if not both.any():
        raise ModelError("the model has no answer for any of the frames to judge by")
    rmse = [
        TO_UNITS * [np.sqrt(np.mean(error[both] ** 2)) for error in errors]
        for errors in (fitted, poor)
    ]
    return Sensitivity(
        fitted=rmse[0],
        naive=rmse[1],
        frames=int(both.sum()),
        without_answer=int((~both).sum()),
        clamped=(int(fitted_clamped[both].sum()), int(naive_clamped[both].sum())),
    )


def _errors(
    walk: WalkFrames, contact: ContactParameters, fits: Fits
) -> tuple[list[FloatArray], BoolArray, BoolArray]:
    """Error of each quantity by frame (or frame and foot), which frames have one, which were clamped."""
    solved = solve_frames(walk.motion, contact, fits.weight_n, law=fits.law)
    if fits.law is FrictionLaw.VISCOUS:
        fitted = force_scale(solved.force_xy_B, walk.force[..., :2])
        scale, clamped = fitted.scale, fitted.clamped
    else:  # Coulomb's forces are in newtons
        scale, clamped = np.ones(walk.count), np.zeros(walk.count, dtype=bool)
    velocity = solved.velocity_B - walk.velocity
    horizontal = scale[:, None, None] * solved.force_xy_B - walk.force[..., :2]
    tilt = solved.pose[:, 1::-1] - walk.slope
    vertical = solved.load_n - walk.force[..., 2]
    errors = [*velocity.T, *tilt.T, horizontal[..., 0], horizontal[..., 1], vertical]
    return errors, solved.valid & np.isfinite(scale), clamped
