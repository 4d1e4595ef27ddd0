"""``bigant model run``: a named system through the model, as a table and a picture."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from model.errors import ModelError
from model.quasistatic.frames import FrictionLaw, Reason
from model.systems.predict import Prediction, predict
from record.whole_file import check_room, write_text, writing
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.table import row_lines
from robot.report.page import Section, report_page
from robot.report.pictures import pictures
from robot.requests.model import ModelRunRequest
from robot.study.model_plots import draw_predictions
from robot.study.systems import build_system

BOTH = "both"
DOTS_PER_INCH = 80


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


SLIP_PERCENTILES = (5, 95)
REASON_WORDS = {
    Reason.NOT_A_NUMBER: "a number is missing",
    Reason.NO_FEET: "no feet",
    Reason.TIPS: "the robot tips",
    Reason.NO_CONVERGENCE: "no convergence",
    Reason.TOO_FEW_FEET: "fewer than two loaded feet",
    Reason.ONE_POINT: "the loaded feet stand in one point",
    Reason.NEGATIVE: "load or stiffness not positive",
}


@dataclass(frozen=True, slots=True)
class PredictionSummary:
    """Figures of one prediction.

    Attributes:
        law: Friction law.
        frames: Number of frames.
        duration_s: Length of the motion.
        distance_m: Straight from the first to the last point.
        forward_m: The same along the first heading.
        mean_speed_m_s: Forward way over the duration.
        turn_rad: Change of heading.
        slip_percentiles_m_s: 5 and 95 % of the forward slip of loaded feet.
        loaded_feet: Mean number of loaded feet.
        climb_m: Change of the body's height from the first to the last frame with an answer.
        without_answer: Number of frames by reason, most frequent first.
        not_unique: Frames where forces or velocity are one choice among many.
    """

    law: str
    frames: int
    duration_s: float
    distance_m: float
    forward_m: float
    mean_speed_m_s: float
    turn_rad: float
    slip_percentiles_m_s: tuple[float, ...]
    loaded_feet: float
    climb_m: float
    without_answer: tuple[tuple[str, int], ...]
    not_unique: int


def summarise_prediction(prediction: Prediction) -> PredictionSummary:
    """Work out the figures.

    Raises:
        ModelError: No frame has an answer.
    """
    system, solutions = prediction.system, prediction.solutions
    valid = solutions.valid
    reasons = Counter(int(value) for value in solutions.reason[~valid])
    missing = tuple((REASON_WORDS[Reason(key)], count) for key, count in reasons.most_common())
    if not valid.any():
        words = "; ".join(reason for reason, _ in missing)
        raise ModelError(f"{system.name}: no frame has an answer: {words}")
    duration = system.frames * system.step_s
    way = prediction.poses[-1] - prediction.poses[0]
    loaded = solutions.contact & valid[:, None]
    slip = np.percentile(solutions.slip_B[..., 0][loaded], SLIP_PERCENTILES)
    height = solutions.pose[valid, 2]
    return PredictionSummary(
        law=prediction.law.value,
        frames=system.frames,
        duration_s=duration,
        distance_m=float(np.hypot(way[0], way[1])),
        forward_m=float(way[0]),
        mean_speed_m_s=float(way[0]) / duration,
        turn_rad=float(way[2]),
        slip_percentiles_m_s=tuple(float(value) for value in slip),
        loaded_feet=float(loaded.sum() / valid.sum()),
        climb_m=float(height[-1] - height[0]),
        without_answer=missing,
        not_unique=int((valid & ~solutions.unique).sum()),
    )


def prediction_rows(predictions: Sequence[Prediction]) -> list[tuple[str, str]]:
    """Return label and text of each row, for one friction law or several of the same system."""
    system = predictions[0].system
    rows = [
        ("system", system.description),
        ("frames", f"{system.frames} in {system.frames * system.step_s:.1f} s, {system.legs} feet"),
    ]
    for prediction in predictions:
        s = summarise_prediction(prediction)
        low, high = s.slip_percentiles_m_s
        missing = ", ".join(f"{count}: {words}" for words, count in s.without_answer)
        rows += [
            ("friction law", s.law),
            ("mean speed", f"{s.mean_speed_m_s * 1e3:.1f} mm/s forward"),
            ("distance", f"{s.distance_m:.3f} m, forward {s.forward_m:.3f} m"),
            ("turned", f"{np.degrees(s.turn_rad):z.1f} deg"),
            ("forward slip of loaded feet", f"5% {low * 1e3:.1f}  95% {high * 1e3:.1f} mm/s"),
            ("loaded feet", f"{s.loaded_feet:.2f} on average"),
        ]
        if system.ground_m is not None:
            rows.append(("climbed", f"{s.climb_m * 1e3:.1f} mm"))
        rows.append(("frames without an answer", missing or "none"))
        if s.not_unique:
            rows.append(("frames with forces or velocity not unique", str(s.not_unique)))
    return rows
