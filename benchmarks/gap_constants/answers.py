"""All known cases with their answers. Importing this imports the diagnosis with its constants."""

import json
import warnings

from benchmarks.gap_constants.cases import KnownCase
from benchmarks.gap_constants.figures import JudgedCase
from benchmarks.gap_constants.servo_cases import servo_cases
from benchmarks.gap_constants.toy_cases import toy_cases
from gap.check.cases import CaseAnswer, CheckedCase, Named, Remainder
from gap.diagnosis.as_json import diagnosis_json
from gap.diagnosis.diagnose import diagnose
from gap.diagnosis.findings import Diagnosis
from robot.console.json_output import json_text


def answered() -> list[JudgedCase]:
    """Diagnose every case."""
    with warnings.catch_warnings(action="ignore"):
        return [_checked(case) for case in (*toy_cases(), *servo_cases())]


def _checked(case: KnownCase) -> JudgedCase:
    diagnosis = diagnose(case.trials, case.simulator, case.references)
    nan = float("nan")
    answer = _answer(diagnosis, referenced=bool(case.references))
    sizes = {f"{one.effect} {one.parameter}": one.size for one in diagnosis.detectable}
    found = json.loads(json_text(diagnosis_json(diagnosis)))
    checked = CheckedCase(case.name, case.kind, case.truths, answer, nan, nan)
    return JudgedCase(checked, found, sizes)


def _answer(diagnosis: Diagnosis, *, referenced: bool) -> CaseAnswer:
    fit = diagnosis.fit
    return CaseAnswer(
        verdict=diagnosis.verdict.value,
        stage=diagnosis.stage,
        named=tuple(
            Named(
                one.effect, one.joints, tuple((v.name, v.value) for v in one.values), one.probability,
                tuple((v.name, v.error) for v in one.values),
            )
            for one in diagnosis.causes
        ),
        alike=tuple((one.of[0], one.effect) for one in diagnosis.ambiguous),
        none=diagnosis.none,
        shrink=diagnosis.far.shrink,
        seconds=float("nan"),
        remainder=Remainder(fit.closed, fit.excess_after, fit.worst_after, fit.p_after),
        referenced=referenced,
    )  # fmt: skip
