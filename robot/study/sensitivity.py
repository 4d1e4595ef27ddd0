"""``bigant model sensitivity``: naive against fitted parameters on logs (the paper's sec:tripod)."""

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from model.errors import ConfigError
from model.fit.result import FitResult
from model.quasistatic.frames import FrictionLaw
from record.log.reader import read_log
from record.whole_file import check_room, writing
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.table import Column, table_lines
from robot.report.contact_fit import NAIVE_STIFFNESS, Fits, fit_contact
from robot.report.pictures import DOTS_PER_INCH
from robot.report.plots import PREDICTED, STYLE, TRUE
from robot.report.walk_frames import WalkFrames, halves, joined, walk_frames
from robot.requests.model import ModelSensitivityRequest
from robot.study.sensitivity_table import PAPER_CHANGE, QUANTITIES, UNITS, Sensitivity, compare

TABLE = (
    Column("RMSE"), Column(""), Column("fitted", ".3f", 8), Column("naive", ".3f", 8),
    Column("change, %", "+.1f"), Column("paper, %", "+.1f"),
)  # fmt: skip


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
        parts = [
            ", ".join(path.name for path in some)
            for some in (request.logs[:first], request.logs[first:])
        ]
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
    found = compare(judged_by, fits)
    if request.json:
        print_json(as_json(fits, found, fitted_to.count, parts))
    else:
        print(f"fitted to {parts[0]}, {fitted_to.count} frames; weight {fits.weight_n:.2f} N")
        print(f"judged by {parts[1]}, {found.frames} frames; none of them fitted to")
        stiffness = NAIVE_STIFFNESS * fits.weight_n
        print(f"naive: K {stiffness:.0f} N/m (10 for a weight of 1), mu 1, w 0")
        print(*_table(found), "", *_parameters(fits), sep="\n")
    if request.out is not None:
        with writing(request.out):
            _drawing(found).savefig(request.out, dpi=DOTS_PER_INCH)
        if not request.json:
            print(f"picture: {request.out}")
    return ExitCode.OK


def _read(paths: Sequence[Path]) -> tuple[tuple[str, ...], list[WalkFrames]]:
    walks: list[WalkFrames] = []
    names: tuple[str, ...] = ()
    for path in paths:
        log = read_log(path)
        if names and log.names != names:
            raise ConfigError(
                "LOG", f"{path.name} has legs {log.names}, {paths[0].name} has {names}"
            )
        names = log.names
        walks.append(walk_frames(log, path.name))
    return names, walks


def _table(found: Sensitivity) -> list[str]:
    rows = zip(
        QUANTITIES, UNITS, found.fitted, found.naive, found.change, PAPER_CHANGE, strict=True
    )
    lines = table_lines(TABLE, list(rows))
    lines.append("change: from fitted to naive; + means that fitting helped")
    if found.without_answer:
        lines.append(f"{found.without_answer} frames left out: the model has no answer there")
    if any(found.clamped):
        lines.append(
            "frames with the predicted forces against the measured: "
            f"{found.clamped[0]} fitted, {found.clamped[1]} naive (scale 0)"
        )
    return lines


def _parameters(fits: Fits) -> list[str]:
    mu = "relative, mean 1 by convention" if fits.law is FrictionLaw.VISCOUS else "Coulomb's"
    lines = [f"fitted parameters (K in N/m; mu {mu}), standard error"]
    results = (("stiffness", fits.stiffness), ("friction", fits.friction))
    rows = [
        (name, value, f"+- {error:.2g}" if np.isfinite(error) else "not determined by these data")
        for _, result in results
        for name, value, error in zip(
            result.names, result.values, result.standard_errors, strict=True
        )
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


def as_json(
    fits: Fits, found: Sensitivity, fitted_to: int, parts: Sequence[str]
) -> dict[str, object]:
    """Return everything the command found, for ``print_json``.

    Args:
        fits: Fitted parameters.
        found: Errors of both.
        fitted_to: Number of frames fitted to.
        parts: Names of what was fitted to and what was judged by.
    """
    rows = zip(
        QUANTITIES, UNITS, found.fitted, found.naive, found.change, PAPER_CHANGE, strict=True
    )
    keys = ("quantity", "unit", "fitted", "naive", "change_percent", "paper_change_percent")
    return {
        "law": fits.law.value,
        "fitted_to": {"what": parts[0], "frames": fitted_to, "weight_n": fits.weight_n},
        "judged_by": {
            "what": parts[1],
            "frames": found.frames,
            "without_answer": found.without_answer,
        },
        "rmse": [dict(zip(keys, row, strict=True)) for row in rows],
        "stiffness": _result(fits.stiffness),
        "friction": _result(fits.friction),
    }


def _result(result: FitResult) -> dict[str, object]:
    keys = ("name", "value", "standard_error")
    values = zip(result.names, result.values, result.standard_errors, strict=True)
    return {
        "parameters": [dict(zip(keys, row, strict=True)) for row in values],
        "residual_rms": result.residual_rms,
        "frames_used": result.frames_used,
        "left_out": [{"why": why, "count": count} for why, count in result.left_out],
        "undetermined": result.undetermined,
        "warnings": result.warnings,
        "converged": result.converged,
    }


def _drawing(found: Sensitivity) -> Figure:
    at = np.arange(len(QUANTITIES))
    bars = (
        (at - 0.2, found.change, PREDICTED, "these logs"),
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
