"""``bigant gap next``: which run settles what a diagnosis left open."""

from collections.abc import Mapping, Sequence

from gap.diagnosis.diagnose import diagnose
from gap.diagnosis.study import make_study
from gap.effect_file import UserEffect
from gap.experiments.imitation import imitate
from gap.experiments.next_run import MOST_RUNS, NextRun, next_runs
from gap.interfaces import Cause, Drive, Effect, Scope, Simulator
from gap.search.candidates import Candidate
from model.effects.catalogue import CATALOGUE
from model.errors import ConfigError, GapError
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.program_output import complain
from robot.console.progress import ProgressBar
from robot.console.screen_fit import terminal_width, wrapped
from robot.console.table import Column, table_lines
from robot.gap_report.answer import ReadDiagnosis, read_diagnosis
from robot.gap_report.legged import proposer_of, users_effects
from robot.gap_report.trials import Runs, read_runs
from robot.gap_report.words import ENOUGH, common_pair, pair_words, parameters_of
from robot.requests.gap import GapNextRequest

SHOWN = 5
NAME, FIGURES = 56, 32  # columns of the name of a run, and of its figures
Causes = tuple[Cause, ...]
Open = tuple[int, str, tuple[str, ...]]  # a rival: number of its cause, its effect, its legs


def propose_runs(request: GapNextRequest) -> ExitCode:
    """Propose runs.

    Raises:
        RecordError: A file cannot be read.
        GapError: There is nothing left open, or no run can be proposed.
        ConfigError: Options that do not go together.
    """
    diagnosis = _read(request, users_effects(request.effects))
    if diagnosis is None:
        runs = read_runs(request.paths, request.reference, request.robot)
    else:
        runs = read_runs(diagnosis.trials, diagnosis.references, request.robot or diagnosis.robot)
    simulator = runs.simulator(request.effects)
    if simulator.name != "legged":
        raise GapError(
            f"bigant gap next knows the runs of legged robots, not of a {simulator.name}; vary its load "
            "and its speed by hand"
        )
    proposer, note = proposer_of(runs.robot_text, runs.robot, request.gait)
    if note:
        complain(f"note: {note}")
    effects = {effect.name: effect for effect in simulator.effects}
    causes, rivals = _left_open(diagnosis, runs, simulator)
    if not causes:
        raise GapError("the diagnosis names no cause, so there is nothing to distinguish")
    rivals += [(0, *_place(text, effects, causes[0])) for text in request.against]
    sets: list[Causes] = [causes]
    ranked: tuple[NextRun, ...] = ()
    if rivals := list(dict.fromkeys(rivals)):
        floor = make_study(runs.trials, simulator, runs.references).floor(Drive.COMMAND)
        with ProgressBar("sizes of the candidates") as bar:
            for number, (of, effect, legs) in enumerate(rivals, 1):
                rival = Candidate(effects[effect], legs)
                sets.append(imitate(simulator, runs.trials[:2], causes, of, rival, floor))
                bar.show(number / len(rivals), effect)
        with ProgressBar("trying runs in the simulator") as bar:
            ranked = next_runs(proposer.proposals(), simulator, sets, floor, bar.show)
    if request.json:
        print_json(_as_json(sets, ranked, effects))
    else:
        width = terminal_width()
        shown = ranked if request.all else ranked[:SHOWN]
        for line in _lines(sets, shown, effects, width):
            print("\n".join(wrapped(line, width)))
    return ExitCode.OK if ranked or not rivals else ExitCode.VERDICT_FAILED


def _read(request: GapNextRequest, users: tuple[UserEffect, ...]) -> ReadDiagnosis | None:
    """The diagnosis in the file that was given; None where runs were given."""
    if request.paths[0].suffix != ".json":
        return None
    if len(request.paths) > 1 or request.reference:
        raise ConfigError("DIAGNOSIS.json", "names its runs and references itself; give it alone")
    effects = (*CATALOGUE, *(user.effect for user in users))
    diagnosis = read_diagnosis(request.paths[0], effects)
    if not diagnosis.trials:
        raise GapError(
            f"the runs of {diagnosis.path} are not where they were; give them: bigant gap next TRIAL..."
        )
    return diagnosis


def _left_open(
    diagnosis: ReadDiagnosis | None, runs: Runs, simulator: Simulator
) -> tuple[Causes, list[Open]]:
    """Causes, and what the runs could not distinguish from each."""
    if diagnosis is not None:
        names = [cause.effect for cause in diagnosis.causes]
        return diagnosis.causes, [
            (names.index(named), effect, legs)
            for named, effect, legs in diagnosis.rivals
            if named in names
        ]
    with ProgressBar("diagnosis") as bar:
        d = diagnose(runs.trials, simulator, runs.references, progress=bar.tell)
    causes = tuple(
        Cause(one.effect, one.joints, tuple(v.value for v in one.values)) for one in d.causes
    )
    keys = [(cause.effect, cause.joints) for cause in causes]
    return causes, [(keys.index(one.of), one.effect, one.joints) for one in d.ambiguous]


def _place(text: str, effects: Mapping[str, Effect], first: Cause) -> tuple[str, tuple[str, ...]]:
    name, _, leg = text.partition("@")
    if name not in effects:
        raise GapError(f"--against {name}: no such effect; bigant gap effects lists them")
    if leg:
        return name, (leg,)
    whole = Scope.ALL in effects[name].scopes
    if not whole and not first.joints:
        raise GapError(f"--against {name}: it touches single legs; write {name}@LEG")
    return name, () if whole else first.joints


def _words(causes: Causes, effects: Mapping[str, Effect]) -> str:
    parts = []
    for cause in causes:
        numbers = ", ".join(f"{n} {v:.3g}" for n, v in parameters_of(cause, effects).items())
        place = f" at {', '.join(cause.joints)}" if cause.joints else ""
        parts.append(cause.effect + place + (f" ({numbers})" if numbers else ""))
    return " and ".join(parts)


def _lines(
    sets: Sequence[Causes], shown: Sequence[NextRun], effects: Mapping[str, Effect], width: int
) -> list[str]:
    if len(sets) == 1:
        return [
            f"nothing is left open besides {_words(sets[0], effects)}: no run is needed",
            "to compare with an alternative all the same: --against EFFECT[@LEG]",
        ]
    lines = ["indistinguishable so far, each at its best fit to the runs:"]
    lines += [f"  {_words(causes, effects)}" for causes in sets]
    if not shown:
        few = f"in {MOST_RUNS} runs or fewer"
        return [*lines, "", f"no run that this robot can make distinguishes them {few}"]
    pair = common_pair(shown)
    if pair:
        lines += ["", f"each distinguishes {pair}"]
    columns = (
        Column("run", width=min(NAME, width - FIGURES)), Column("separation", ".3g"),
        Column("runs", "d"), Column("minutes", ".1f"),
    )  # fmt: skip
    rows = [
        (f"{number}. {one.name}", one.separation, one.runs, one.minutes)
        for number, one in enumerate(shown, 1)
    ]
    head, *lines_of_runs = table_lines(columns, rows)
    lines += ["", head]
    for line, one in zip(lines_of_runs, shown, strict=True):
        lines.append(line)
        if not pair:
            lines.append(f"   distinguishes least: {pair_words(one)}")
        if one.limits:
            lines.append(f"   caution: {one.limits}")
        lines.append(f"   {one.command}")
    lines.append(
        f"on the robot add: --hardware PORT --armed    (a separation of {ENOUGH} is enough: 1 wrong in 100)"
    )
    return lines


def _as_json(
    sets: Sequence[Causes], runs: Sequence[NextRun], effects: Mapping[str, Effect]
) -> dict[str, object]:
    candidates = [
        [
            {"effect": c.effect, "legs": c.joints, "parameters": parameters_of(c, effects)}
            for c in causes
        ]
        for causes in sets
    ]
    return {"candidates": candidates, "runs": runs}
