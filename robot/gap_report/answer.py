"""A diagnosis read back from its JSON: its causes, and the runs that it was made from."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from gap.interfaces import Cause, Effect, Scope
from gap.residuals.hold_out import HoldOut
from model.errors import GapError
from record.json_text import parse_json
from record.trial.header import KIND_OF_SUFFIX
from record.trial.header_file import read_text

T = TypeVar("T")
# An alternative: the number of its cause, its effect, its legs.
Open = tuple[int, str, tuple[str, ...]]
RUN_SUFFIXES = (".parquet", ".csv", ".toml", ".mcap")


@dataclass(frozen=True, slots=True)
class DiagnosedRuns:
    """Which runs a diagnosis in a file is of.

    Attributes:
        trials: Runs, as far as their files are still there; all or none.
        references: Healthy runs.
        robot: Machine's file that was used instead of the one beside the runs; None for that.
        machine: What ``--machine`` named; empty for the kind of the machine's file.
        hold_out: Which of the trials judged; None if that is not known.
        joints: What ``--joint`` named; empty for all joints.
    """

    path: Path
    simulator: str
    trials: tuple[Path, ...]
    references: tuple[Path, ...]
    robot: Path | None
    machine: str
    hold_out: HoldOut | None
    joints: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ReadDiagnosis:
    """What is needed of the diagnosis in a file to act on it.

    Attributes:
        on_bound: Effects of those that have a number on its bound.
        ill_data: Channels whose data have a severe fault.
        standing: Baseline model errors, which its simulator had; None if the file does not say, or if they
            are not all of the catalogue.
        rivals: What the runs could not distinguish from a cause.
        none: Probability that it is none of the catalogue; NaN if not known.
        before: RMS over all channels without causes, in units of the baseline; NaN if not measured.
        shrink: Share of the gap that the causes close; NaN if not measured.
        interval: Its 95 % interval; NaN if not known.
        seed: Of the random draws.
    """

    path: Path
    verdict: str
    simulator: str
    causes: tuple[Cause, ...]
    on_bound: tuple[str, ...]
    ill_data: tuple[str, ...]
    standing: tuple[Cause, ...] | None
    rivals: tuple[Open, ...]
    none: float
    before: float
    shrink: float
    interval: tuple[float, float]
    seed: int


def diagnosed_runs(path: Path) -> DiagnosedRuns:
    """Read of which runs a diagnosis is; see ``read_diagnosis``.

    Raises:
        RecordError: It cannot be read.
        GapError: It is no diagnosis.
    """
    return _from_json(path, lambda answer: _runs(answer, path))


def read_diagnosis(path: Path, effects: tuple[Effect, ...]) -> ReadDiagnosis:
    """Read the JSON of ``bigant gap diagnose``, or of any program that writes its shape.

    The effects are those of the catalogue, which gives the order of the parameters.

    Raises:
        RecordError: It cannot be read.
        GapError: It is no diagnosis, or names an effect that the catalogue does not have.
    """
    return _from_json(path, lambda answer: _read(answer, path, {one.name: one for one in effects}))


def _from_json(path: Path, make: Callable[[dict[str, Any]], T]) -> T:
    if path.suffix in RUN_SUFFIXES:
        raise GapError(f"{path} is a run; give the file of: bigant gap diagnose --json")
    text = read_text(path)
    try:
        answer = parse_json(text)
    except ValueError as error:
        raise GapError(
            f"{path} is no JSON ({error}); give the file of: bigant gap diagnose --json"
        ) from error
    try:
        return make(answer)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        why = f"it has no {error}" if isinstance(error, KeyError) else str(error)
        raise GapError(
            f"{path} is no diagnosis ({why}); give the file of: bigant gap diagnose --json"
        ) from error


def _runs(answer: dict[str, Any], path: Path) -> DiagnosedRuns:
    files = [_file(str(name), path) for name in answer.get("files", ())]
    judged = answer.get("trials", {})
    numbers = [*judged.get("fitted", ()), *judged.get("held_out", ())]
    known = max(map(int, numbers)) + 1 if numbers else len(files)
    count = len(files) - int(answer.get("references", len(files) - known))
    there = bool(files) and all(one.is_file() for one in files)
    robot = answer.get("robot")
    fitted, held = ({int(at) for at in judged.get(key, ())} for key in ("fitted", "held_out"))
    hold_out = HoldOut(last_third=True) if fitted & held else HoldOut(tuple(sorted(held)))
    return DiagnosedRuns(
        path=path,
        simulator=str(answer.get("simulator", "legged")),
        trials=tuple(files[:count]) if there else (),
        references=tuple(files[count:]) if there else (),
        robot=None if robot is None else _file(str(robot), path),
        machine=_machine(str(answer.get("machine") or ""), path),
        hold_out=hold_out if fitted and held else None,
        joints=tuple(map(str, answer.get("joints", ()))),
    )


def _read(answer: dict[str, Any], path: Path, effects: dict[str, Effect]) -> ReadDiagnosis:
    gap, causes = answer["gap"], tuple(_cause(one, path, effects) for one in answer["causes"])
    low, high = gap.get("shrink_interval") or (None, None)
    return ReadDiagnosis(
        path=path,
        verdict=str(answer["verdict"]),
        simulator=str(answer.get("simulator", "legged")),
        causes=causes,
        on_bound=tuple(str(one["effect"]) for one in answer["causes"] if one.get("on_bound")),
        ill_data=tuple(map(str, answer.get("severe_data_faults", ()))),
        standing=_standing(answer, effects),
        rivals=_rivals(answer, causes, effects),
        none=_number(answer.get("none_of_these")),
        before=_number(gap.get("before_over_floor")),
        shrink=_number(gap.get("shrink")),
        interval=(_number(low), _number(high)),
        seed=int(answer.get("seed", 0)),
    )


def _number(value: object) -> float:
    return float(value) if isinstance(value, int | float) else math.nan


def _standing(answer: dict[str, Any], effects: dict[str, Effect]) -> tuple[Cause, ...] | None:
    if "standing" not in answer:
        return None
    causes = tuple(
        Cause(str(one["effect"]), tuple(one["joints"]), tuple(map(float, one["values"])))
        for one in answer["standing"]
    )
    return causes if all(one.effect in effects for one in causes) else None


def _rivals(
    answer: dict[str, Any], causes: tuple[Cause, ...], effects: dict[str, Effect]
) -> tuple[Open, ...]:
    if "open_rivals" in answer:
        return tuple(
            (int(one["cause"]), str(one["form"]), tuple(one["legs"]))
            for one in answer["open_rivals"]
            if int(one["cause"]) < len(causes)  # without a gap none is written
        )
    names = [effects[one.effect].family for one in causes]
    rivals = []
    for named, other in answer.get("ambiguous_with", ()):
        of, effect, legs = _pair(answer, named, other)
        if of in names:
            at = names.index(of)
            # of an effect of single joints: where its cause is, if the file does not say
            single = effect in effects and Scope.ALL not in effects[effect].scopes
            rivals.append((at, effect, legs or (causes[at].joints if single else ())))
    return tuple(rivals)


def _pair(answer: dict[str, Any], named: str, other: str) -> tuple[str, str, tuple[str, ...]]:
    """A pair of names, with legs if both are one effect, else as in the list of alternatives."""
    effect, *legs = other.split(" ")
    listed = sorted(answer.get("rivals", ()), key=lambda one: -float(one["probability"] or 0.0))
    own = [one for one in listed if one["effect"] == effect and (not legs or one["joints"] == legs)]
    if own:
        legs, effect = list(own[0]["joints"]), str(own[0].get("form", effect))
    return named.split(" ")[0], effect, tuple(legs)


def _file(name: str, beside: Path) -> Path:
    """The file as it was named, or beside the diagnosis if both were moved together."""
    own = Path(name)
    return own if own.exists() or not (beside.parent / own).exists() else beside.parent / own


def _machine(named: str, beside: Path) -> str:
    """What ``--machine`` named; a model may have moved together with the diagnosis."""
    return str(_file(named, beside)) if Path(named).suffix in KIND_OF_SUFFIX else named


def _cause(one: dict[str, Any], path: Path, effects: dict[str, Effect]) -> Cause:
    name = str(one.get("form", one["effect"]))
    if name not in effects:
        raise GapError(
            f"{path} names {name!r}, which the catalogue of its machine does not have; a user's own effect "
            "needs --effects FILE.py, and no machine's file can hold it"
        )
    given = one.get("parameters", {})
    values = tuple(float(given.get(p.name, p.neutral)) for p in effects[name].parameters)
    return Cause(name, tuple(one.get("legs", ())), values)
