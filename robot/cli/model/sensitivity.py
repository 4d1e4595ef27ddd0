"""``bigant model sensitivity``: naive against fitted parameters on logs (the paper's sec:tripod)."""

import argparse
import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from robot.study.sensitivity_frames import WalkFrames
    from robot.study.sensitivity_table import Fits, Sensitivity


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.description = (
        "Fit stiffness and friction to the earlier half of a log (of several logs: to the first of "
        "them), and judge fitted against naive parameters on the rest."
    )
    parser.add_argument("logs", type=Path, nargs="+", metavar="LOG")
    parser.add_argument("--form", type=int, choices=(18, 24), default=18,
        help="18 parameters, w fore and aft, or 24, w free (default: 18)")  # fmt: skip
    parser.add_argument("--law", choices=("viscous", "coulomb"), default="viscous",
        help="the paper's viscous ansatz or Coulomb's law (default: viscous)")  # fmt: skip
    parser.add_argument("--rest-mm-s", type=_speed, default=1.0, metavar="V",
        help="leave feet no faster than this out of the friction fit (default: 1)")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE.png", help="draw the changes as well")
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def _speed(text: str) -> float:
    value = float(text)
    if not 0 <= value < math.inf:
        raise argparse.ArgumentTypeError(f"must be a speed, not {text}")
    return value


def run(options: argparse.Namespace) -> ExitCode:
    """Run the action.

    Raises:
        RecordError: A log cannot be read or used, or the picture cannot be written.
        ConfigError: ``--out`` names no PNG, or the logs are of different robots.
        ModelError: There is nothing to fit to.
    """
    from model.errors import ConfigError
    from model.quasistatic.frames import FrictionLaw
    from robot.study.sensitivity_frames import halves, joined
    from robot.study.sensitivity_table import NAIVE_STIFFNESS, compare, fit_contact

    if options.out is not None and options.out.suffix != ".png":
        raise ConfigError("--out", f"must end in .png, not {options.out.name!r}")
    names, walks = _read(options.logs)
    first = len(walks) // 2
    if first:
        fitted_to, judged_by = joined(walks[:first]), joined(walks[first:])
        parts = tuple(
            ", ".join(path.name for path in some)
            for some in (options.logs[:first], options.logs[first:])
        )
    else:
        fitted_to, judged_by = halves(walks[0])
        parts = (f"earlier half of {options.logs[0].name}", "its later half")
    fits = fit_contact(
        fitted_to,
        names,
        free_w=options.form == 24,
        rest_m_s=options.rest_mm_s * 1e-3,
        law=FrictionLaw(options.law),
    )
    found = compare(judged_by, fits)
    if options.json:
        from robot.study.sensitivity_json import as_json

        print(json.dumps(as_json(fits, found, fitted_to.count, parts), indent=2))
    else:
        print(f"fitted to {parts[0]}, {fitted_to.count} frames; weight {fits.weight_n:.2f} N")
        print(f"judged by {parts[1]}, {found.frames} frames; none of them fitted to")
        print(
            f"naive: K {NAIVE_STIFFNESS * fits.weight_n:.0f} N/m (10 for a weight of 1), mu 1, w 0"
        )
        print(*_table(found), "", *_parameters(fits), sep="\n")
    if options.out is not None:
        _draw(found, options.out)
        if not options.json:
            print(f"picture: {options.out}")
    return ExitCode.OK


def _read(paths: list[Path]) -> tuple[tuple[str, ...], "list[WalkFrames]"]:
    from model.errors import ConfigError
    from record.log.reader import read_log
    from robot.study.sensitivity_frames import walk_frames

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


def _table(found: "Sensitivity") -> list[str]:
    from robot.study.sensitivity_table import PAPER_CHANGE, QUANTITIES, UNITS

    lines = [f"{'RMSE':<10}{'':<8}{'fitted':>10}{'naive':>10}{'change':>10}{'paper':>10}"]
    lines += [
        f"{name:<10}{unit:<8}{fitted:>10.3f}{naive:>10.3f}{change:>+9.1f}%{paper:>+9.1f}%"
        for name, unit, fitted, naive, change, paper in zip(
            QUANTITIES, UNITS, found.fitted, found.naive, found.change, PAPER_CHANGE, strict=True
        )
    ]
    lines.append("change: from fitted to naive; + means that fitting helped")
    if found.without_answer:
        lines.append(f"{found.without_answer} frames left out: the model has no answer there")
    if any(found.clamped):
        lines.append(
            "frames with the predicted forces against the measured: "
            f"{found.clamped[0]} fitted, {found.clamped[1]} naive (scale 0)"
        )
    return lines


def _parameters(fits: "Fits") -> list[str]:
    from model.quasistatic.frames import FrictionLaw

    mu = "relative, mean 1 by convention" if fits.law is FrictionLaw.VISCOUS else "Coulomb's"
    lines = [f"fitted parameters (K in N/m; mu {mu}), standard error"]
    for result in (fits.stiffness, fits.friction):
        lines += [
            f"  {name:<8}{value:>10.4g}  "
            + (f"+- {error:.2g}" if math.isfinite(error) else "   not told by these data")
            for name, value, error in zip(
                result.names, result.values, result.standard_errors, strict=True
            )
        ]
    lines.append("standard errors take frames for independent; those of a log are not")
    lines.append(
        f"residual RMS: {fits.stiffness.residual_rms:.2g} of the weight, "
        f"{fits.friction.residual_rms:.2g} N horizontally"
    )
    results = (("stiffness", fits.stiffness), ("friction", fits.friction))
    for what, result in results:
        lines += [f"left out of the {what} fit: {why}, {count}" for why, count in result.left_out]
        lines += [f"note: {warning}" for warning in result.warnings]
        if not result.converged:
            lines.append(f"note: the search for the {what} did not end by itself")
    return lines


def _draw(found: "Sensitivity", out: Path) -> None:
    import matplotlib as mpl
    import numpy as np
    from matplotlib.figure import Figure

    from model.errors import RecordError
    from robot.report.plots import PREDICTED, STYLE, TRUE
    from robot.study.sensitivity_table import PAPER_CHANGE, QUANTITIES

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
                ax.annotate(
                    f"{percent:+.0f} %" if abs(percent) >= 10 else f"{percent:+.1f} %",
                    (x, max(y, 1.0)),
                    (0, 3),
                    textcoords="offset points",
                    ha="center",
                    fontsize=7,
                )
        ax.set_yscale("log")
        ax.axhline(1, color="k", lw=0.8)
        ax.margins(y=0.15)
        ax.set_xticks(at, QUANTITIES)
        ax.set_ylabel("RMSE, naive / fitted")
        ax.set_title("naive against fitted parameters, on frames not fitted to", loc="left")
        ax.legend()
        try:
            figure.savefig(out, dpi=130)
        except OSError as error:
            raise RecordError(
                f"{out} cannot be written: {error.strerror}; choose another --out"
            ) from error
