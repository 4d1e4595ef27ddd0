"""``bigant model run``: a named system through the model, as a table and a picture."""

from dataclasses import dataclass
from pathlib import Path

from model.quasistatic.frames import FrictionLaw
from model.systems.predict import predict
from record.whole_file import check_room, write_text, writing
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.table import row_lines
from robot.report.page import Section, report_page
from robot.report.pictures import pictures
from robot.study.model_plots import draw_predictions
from robot.study.model_summary import prediction_rows, summarise_prediction
from robot.study.systems import build_system

BOTH = "both"
DOTS_PER_INCH = 80


@dataclass(frozen=True, slots=True)
class ModelRunRequest:
    """What ``bigant model run`` was asked for."""

    system: str
    legs: int | None
    gait: str | None
    robot: Path | None
    cycles: float | None
    law: str
    tilt_coupling: bool
    out: Path | None
    json: bool


def run_model(request: ModelRunRequest) -> ExitCode:
    """Predict, print, draw.

    Raises:
        ConfigError: An option that makes no sense.
        ModelError: A system that cannot be built.
        RecordError: A picture that cannot be written.
    """
    check_room(request.out, "--out", ".html", ".png")
    laws = tuple(FrictionLaw) if request.law == BOTH else (FrictionLaw(request.law),)
    predictions = []
    for law in laws:
        system = build_system(
            request.system,
            legs=request.legs,
            gait=request.gait,
            cycles=request.cycles,
            robot_file=request.robot,
            law=law,
            tilt_coupling=request.tilt_coupling,
        )
        predictions.append(predict(system, law=law, tilt_coupling=request.tilt_coupling))
    rows = prediction_rows(predictions)
    out = request.out
    if request.json:
        print_json({"system": request.system, "laws": list(map(summarise_prediction, predictions))})
    else:
        print(*row_lines(rows), sep="\n")
        out = out or Path(f"model_{request.system}.png")
    if out is None:
        return ExitCode.OK
    figure = draw_predictions(predictions)
    if out.suffix == ".png":
        with writing(out):
            figure.savefig(out, dpi=DOTS_PER_INCH)
    else:
        parts = [Section("", rows), *pictures({"Motion": figure})]
        write_text(out, report_page(predictions[0].system.description, "bigant model run", parts))
    if not request.json:
        print(f"picture: {out}")
    return ExitCode.OK
