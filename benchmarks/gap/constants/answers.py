"""All known cases with their answers. Importing this imports the diagnosis with its constants."""

import json
import warnings
from collections.abc import Sequence

from benchmarks.gap.constants.figures import JudgedCase
from benchmarks.gap.constants.servo_cases import servo_cases
from benchmarks.gap.constants.toy_cases import toy_cases
from gap.check.cases import CheckedCase, Truth
from gap.diagnosis.answer.as_json import diagnosis_json
from gap.diagnosis.answer.findings import Diagnosis
from gap.diagnosis.diagnose import diagnose
from robot.campaign.case import answer_of
from robot.console.json_output import json_text


def answered() -> list[JudgedCase]:
    """Diagnose every case."""
    with warnings.catch_warnings(action="ignore"):
        return [
            checked(
                case.name,
                case.kind,
                case.truths,
                diagnose(case.trials, case.simulator, case.references),
            )
            for case in (*toy_cases(), *servo_cases())
        ]


def checked(name: str, kind: str, truths: Sequence[Truth], diagnosis: Diagnosis) -> JudgedCase:
    """Put an answer beside what was wrong."""
    nan = float("nan")
    sizes = {f"{one.effect} {one.parameter}": one.size for one in diagnosis.detectable}
    found = json.loads(json_text(diagnosis_json(diagnosis)))
    return JudgedCase(
        CheckedCase(name, kind, tuple(truths), answer_of(found), nan, nan), found, sizes
    )
