"""All known cases with their answers. Importing this imports the diagnosis with its constants."""

import json
import warnings

from benchmarks.gap.constants.cases import KnownCase
from benchmarks.gap.constants.figures import JudgedCase
from benchmarks.gap.constants.servo_cases import servo_cases
from benchmarks.gap.constants.toy_cases import toy_cases
from gap.check.cases import CheckedCase
from gap.diagnosis.as_json import diagnosis_json
from gap.diagnosis.diagnose import diagnose
from robot.campaign.case import answer_of
from robot.console.json_output import json_text


def answered() -> list[JudgedCase]:
    """Diagnose every case."""
    with warnings.catch_warnings(action="ignore"):
        return [_checked(case) for case in (*toy_cases(), *servo_cases())]


def _checked(case: KnownCase) -> JudgedCase:
    diagnosis = diagnose(case.trials, case.simulator, case.references)
    nan = float("nan")
    sizes = {f"{one.effect} {one.parameter}": one.size for one in diagnosis.detectable}
    found = json.loads(json_text(diagnosis_json(diagnosis)))
    checked = CheckedCase(case.name, case.kind, case.truths, answer_of(found), nan, nan)
    return JudgedCase(checked, found, sizes)
