"""``bigant model run``: a named system through the model, as a table and a picture."""

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from model.errors import ModelError
from model.quasistatic.frames import FrictionLaw, Reason
from model.systems.predict import SystemPrediction, predict
from record.whole_file import check_room, whole_file, write_text
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.table import row_lines
from robot.report.page import Section, report_page
from robot.report.pictures import page_picture
from robot.requests.model import ModelRunRequest
from robot.study.model_plots import draw_predictions
from robot.study.systems import build_system

DOTS_PER_INCH = 80


def run_model(request: ModelRunRequest) -> ExitCode:
    """Predict, print, draw.

    Raises:
        ConfigError: An option that makes no sense.
        ModelError: A system that cannot be built.
        RecordError: A picture that cannot be written.
    """
    check_room(request.out, "--out", ".html", ".png")
    laws = tuple(FrictionLaw) if request.law == "both" else (FrictionLaw(request.law),)
    predictions = []
    for law in laws:
        system = build_system(
            request.system, legs=request.legs, gait=request.gait, cycles=request.cycles,
            robot_file=request.robot, law=law, tilt_coupling=request.tilt_coupling,
        )  # fmt: skip
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
        with whole_file(out) as part:
            figure.savefig(part, dpi=DOTS_PER_INCH)
    else:
        page = report_page(
            predictions[0].system.description, "bigant model run", [Section("Numbers", rows)],
            lead=page_picture(figure, "Motion", "0"), verdict=moved_sentence(predictions),
        )  # fmt: skip
        write_text(out, page)
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


def summarise_prediction(prediction: SystemPrediction) -> dict[str, Any]:
    """Return the figures of a prediction, with their units in their names.

    Forward is along the first heading; ``without_answer`` counts frames by reason, most frequent first,
    and ``not_unique`` those where forces or velocity are one choice among many.

    Raises:
        ModelError: No frame has an answer.
    """
    system, solutions = prediction.system, prediction.solutions
    valid = solutions.valid
    reasons = Counter(int(value) for value in solutions.reason[~valid])
    missing = [(REASON_WORDS[Reason(key)], count) for key, count in reasons.most_common()]
    if not valid.any():
        words = "; ".join(reason for reason, _ in missing)
        raise ModelError(f"{system.name}: no frame has an answer: {words}")
    duration_s = system.frames * system.step_s
    x, y, turn = (prediction.poses[-1] - prediction.poses[0]).tolist()
    loaded = solutions.contact & valid[:, None]
    height = solutions.pose[valid, 2]
    return {
        "law": prediction.law.value,
        "frames": system.frames,
        "duration_s": duration_s,
        "distance_m": np.hypot(x, y),
        "forward_m": x,
        "mean_speed_m_s": x / duration_s,
        "turn_rad": turn,
        "slip_percentiles_m_s": np.percentile(solutions.slip_B[..., 0][loaded], SLIP_PERCENTILES),
        "loaded_feet": loaded.sum() / valid.sum(),
        "climb_m": height[-1] - height[0],
        "without_answer": missing,
        "not_unique": int((valid & ~solutions.unique).sum()),
    }


def moved_sentence(predictions: Sequence[SystemPrediction]) -> str:
    """Return how far a system moves, by each friction law, in one sentence.

    Raises:
        ModelError: No frame has an answer.
    """
    figures = [summarise_prediction(one) for one in predictions]
    moved = " and ".join(f"{s['distance_m']:.3f} m by the {s['law']} law" for s in figures)
    return f"In {figures[0]['duration_s']:.1f} s it moves {moved}."


def prediction_rows(predictions: Sequence[SystemPrediction]) -> list[tuple[str, str]]:
    """Return label and text of each row, for one friction law or several of the same system."""
    system = predictions[0].system
    rows = [
        ("system", system.description),
        ("frames", f"{system.frames} in {system.frames * system.step_s:.1f} s, {system.legs} feet"),
    ]
    for prediction in predictions:
        s = summarise_prediction(prediction)
        low, high = s["slip_percentiles_m_s"]
        missing = ", ".join(f"{count}: {words}" for words, count in s["without_answer"])
        rows += [
            ("friction law", s["law"]),
            ("mean speed", f"{s['mean_speed_m_s'] * 1e3:.1f} mm/s forward"),
            ("distance", f"{s['distance_m']:.3f} m, forward {s['forward_m']:.3f} m"),
            ("turned", f"{np.degrees(s['turn_rad']):z.1f} deg"),
            ("forward slip of loaded feet", f"5% {low * 1e3:.1f}  95% {high * 1e3:.1f} mm/s"),
            ("loaded feet", f"{s['loaded_feet']:.2f} on average"),
        ]
        if system.ground_m is not None:
            rows.append(("climbed", f"{s['climb_m'] * 1e3:.1f} mm"))
        rows.append(("frames without an answer", missing or "none"))
        if s["not_unique"]:
            rows.append(("frames with forces or velocity not unique", str(s["not_unique"])))
    return rows
