"""Answers that are known, with probabilities and verdicts made again with the constants as they are here.

An answer has how far each alternative was behind, and what the causes left; constants of probabilities act
on nothing before that. Importing this imports the diagnosis with its constants.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

from benchmarks.gap.constants.figures import JudgedCase
from gap.check.cases import NO_GAP, UNEXPLAINED, CaseAnswer, CheckedCase
from gap.constants import MOSTLY, NONE_LIKELY
from gap.diagnosis.alternatives.probability import (
    Fit,
    blur_of,
    none_if_nothing,
    none_of_them,
    weight_of,
)
from gap.diagnosis.comparison.trend import Trend, none_with
from gap.search.cross_validation import Advantage
from robot.campaign.answers import files_of, read_labels
from robot.campaign.case import read_answer

Found = Mapping[str, Any]  # a diagnosis, as JSON


def saved(campaigns: Sequence[Path]) -> list[JudgedCase]:
    """Return every answer of these campaigns, whose labels are open."""
    return [case for campaign in campaigns for case in _cases(campaign)]


def _cases(campaign: Path) -> Iterator[JudgedCase]:
    files = files_of(campaign, no_references=False)
    labels = read_labels(campaign, None, files)
    for one in files:
        path = campaign / "answers" / f"{one.name}.json"
        label, found = labels[one.name], json.loads(path.read_text(encoding="utf-8"))
        truths, nan = label.truths, math.nan
        checked = CheckedCase(one.name, label.kind, truths, read_answer(path), nan, nan)
        yield JudgedCase(checked, found, {})


def again(case: JudgedCase) -> JudgedCase:
    """Return a case with new probabilities, and the verdict that follows from them."""
    answer = _again(case.checked.answer, case.found)
    return replace(case, checked=replace(case.checked, answer=answer))


def _again(answer: CaseAnswer, found: Found) -> CaseAnswer:
    if answer.verdict == NO_GAP:
        return answer
    known = {field.name for field in fields(Fit)}  # answers of earlier engines have others, too
    fit = Fit(**{name: value for name, value in found["fit"].items() if name in known})
    none = none_of_them(fit, len(answer.named), answer.referenced)
    none = none_with(_trends(found), none, _p_change(found))
    if not answer.named:
        none = 1.0
    clear = [float(one.get("clear", 1.0)) for one in found["causes"]]
    named = tuple(
        replace(one, probability=_probability(found, one.effect, list(one.joints), none, fit))
        for one in answer.named
    )
    none = none_if_nothing(none, clear)
    verdict = answer.verdict
    if none > NONE_LIKELY:
        verdict = UNEXPLAINED
    elif verdict == UNEXPLAINED and _would_do(answer, found):
        verdict = "explained"
    return replace(answer, verdict=verdict, none=none, named=named)


def _trends(found: Found) -> list[Trend]:
    """Trends of the causes; answers of earlier engines have none."""
    given = [one.get("trend") or {} for one in found["causes"]]
    return [Trend(*(_number(one.get(key)) for key in ("growth", "error", "free"))) for one in given]


def _p_change(found: Found) -> float:
    """Chance of what changes in the course of the runs; answers of earlier engines have none."""
    return float((found.get("detection") or {}).get("p_change", 1.0))


def _hunts(found: Found) -> bool:
    """Whether a joint hunts for which no cause does."""
    named = {tuple(one["legs"]) for one in found["causes"] if one["effect"] == "gear_backlash"}
    return any((one["joint"],) not in named for one in found.get("hunting", ()))


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _would_do(answer: CaseAnswer, found: Found) -> bool:
    """Whether nothing but the probability of "none of these" keeps causes from being an explanation."""
    on_bound = any(one["on_bound"] for one in found["causes"])
    shrink = found["gap"]["shrink"]
    mostly = not _hunts(found) and (answer.referenced or shrink is None or shrink >= MOSTLY)
    return bool(answer.named) and mostly and not on_bound


def _probability(found: Found, effect: str, joints: list[str], none: float, fit: Fit) -> float:
    """Probability of a named cause, as ``gap.diagnosis.alternatives.probability.chances`` gives it."""
    cause = next(one for one in found["causes"] if [one["effect"], one["legs"]] == [effect, joints])
    before, gained, p = (float(cause.get(name, 0.0)) for name in ("probability", "nats", "p"))
    clear = float(cause.get("clear", 1.0))
    rivals = [one for one in found["rivals"] if one["of"] == [effect, joints]]
    weights = [
        1.0 if one["probability"] == before
        else _weight(Advantage(one["behind"], one["behind_error"]), fit.nats_after, gained)
        for one in rivals
    ]  # fmt: skip
    # effects that nothing tells from it have as much, and were not fitted
    given = before + sum(one["probability"] for one in rivals)
    every = [float(one.get("clear", 1.0)) for one in found["causes"]]
    nothing = math.prod(1.0 - one for one in every)
    catalogue = (1.0 - found["none_of_these"]) / (1.0 - nothing) if nothing < 1.0 else 0.0
    whole = (1.0 - p) * clear * catalogue
    alike = max(0, round((whole - given) / before)) if before else 0
    return (1.0 - p) * clear * (1.0 - none) / (1.0 + sum(weights) + alike)


def _weight(behind: Advantage, left_nats: float, gained_nats: float) -> float:
    return weight_of(behind, blur_of(behind, left_nats, gained_nats))
