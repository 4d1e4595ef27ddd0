"""``bigant model run``: a named system through the model, as a table and a picture."""

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from gaits.names import GAIT_NAMES
from model.errors import ConfigError
from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from collections.abc import Sequence

    from model.systems.predict import Prediction

# spelled out here so that the parser imports nothing heavy; robot.study.systems knows how to build
SYSTEM_NAMES = ("bigant", "disk", "multipod", "quadruped", "stairs", "slither")
LAW_NAMES = ("viscous", "coulomb", "both")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("system", choices=SYSTEM_NAMES, metavar="SYSTEM",
                        help=", ".join(SYSTEM_NAMES))  # fmt: skip
    parser.add_argument(
        "--legs", type=int, metavar="N", help="legs of a disk or multipod, contacts of slither"
    )
    parser.add_argument("--gait", choices=GAIT_NAMES, help="of bigant (tripod)")
    parser.add_argument("--robot", type=Path, metavar="FILE", help="robot file of bigant")
    parser.add_argument("--cycles", type=float, metavar="N", help="length of the motion")
    parser.add_argument("--law", choices=LAW_NAMES, default="viscous", help="friction (viscous)")
    parser.add_argument("--tilt-coupling", action="store_true",
                        help="feet's vertical speed pushes a tilted body sideways")  # fmt: skip
    parser.add_argument("--out", type=Path, metavar="FILE", help=".png or .html (model_SYSTEM.png)")
    parser.add_argument("--json", action="store_true",
                        help="print JSON; no picture without --out")  # fmt: skip


def run(options: argparse.Namespace) -> ExitCode:
    """Predict, print, draw.

    Raises:
        ConfigError: An option that makes no sense, or a picture that cannot be written.
        ModelError: A system that cannot be built.
    """
    out: Path | None = options.out
    if out is not None and out.suffix not in {".html", ".png"}:
        raise ConfigError("--out", f"must end in .html or .png, not {out.suffix or out.name!r}")
    from model.quasistatic.frames import FrictionLaw
    from model.systems.predict import predict
    from robot.study.model_summary import summarise_prediction
    from robot.study.systems import build_system

    names = ("viscous", "coulomb") if options.law == "both" else (options.law,)
    predictions: list[Prediction] = []
    for name in names:
        law = FrictionLaw(name)
        system = build_system(
            options.system,
            legs=options.legs,
            gait=options.gait,
            cycles=options.cycles,
            robot_file=options.robot,
            law=law,
            tilt_coupling=options.tilt_coupling,
        )
        predictions.append(predict(system, law=law, tilt_coupling=options.tilt_coupling))
    if options.json:
        summaries = [asdict(summarise_prediction(one)) for one in predictions]
        print(json.dumps({"system": options.system, "laws": summaries}, indent=2))
        if out is not None:
            _write(predictions, out)
        return ExitCode.OK
    from robot.console.table import row_lines
    from robot.study.model_summary import prediction_rows

    for line in row_lines(prediction_rows(predictions)):
        print(line)
    out = out if out is not None else Path(f"model_{options.system}.png")
    _write(predictions, out)
    print(f"picture: {out}")
    return ExitCode.OK


def _write(predictions: "Sequence[Prediction]", out: Path) -> None:
    from robot.report.page import render_page
    from robot.study.model_plots import draw_predictions
    from robot.study.model_summary import prediction_rows

    system = predictions[0].system
    figure = draw_predictions(predictions)
    try:
        if out.suffix == ".png":
            figure.savefig(out, dpi=80)
        else:
            rows = prediction_rows(predictions)
            page = render_page(system.description, "bigant model run", rows, {"Motion": figure})
            out.write_text(page, encoding="utf-8")
    except OSError as error:
        raise ConfigError("--out", f"{out} cannot be written: {error.strerror}") from error
