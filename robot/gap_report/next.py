"""``bigant gap next``: which run settles what a diagnosis left open."""

from collections.abc import Mapping, Sequence

from gap.diagnosis.comparison.study import Study
from gap.diagnosis.diagnose import SURELY_NONE, Proposer, diagnose_study
from gap.experiments.next_run import MOST_RUNS, NextRun
from gap.experiments.open_causes import discriminating_runs, open_sets
from gap.interfaces import Cause, Effect, Scope
from gap.search.candidates import Candidate
from model.errors import ConfigError, GapError
from record.trial.header import LEGGED
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json
from robot.console.program_output import complain
from robot.console.progress import ProgressBar
from robot.console.screen_fit import terminal_width, wrapped
from robot.console.table import Column, table_lines
from robot.gap_report.answer import Open, ReadDiagnosis, diagnosed_runs, read_diagnosis
from robot.gap_report.legged import proposer_of
from robot.gap_report.study import study_of
from robot.gap_report.trials import Runs, read_runs, runs_of_diagnosis
from robot.gap_report.words import ENOUGH, common_pair, pair_words, parameters_of
from robot.requests.gap import GapNextRequest

SHOWN = 5
NAME, FIGURES = 56, 32  # columns of the name of a run, and of its figures
Causes = tuple[Cause, ...]


def propose_runs(request: GapNextRequest) -> ExitCode:
    """Propose runs.

    Raises:
        RecordError: A file cannot be read.
        GapError: There is nothing left open, or no run can be proposed.
        ConfigError: Options that do not go together.
    """
    runs = _runs(request)
    simulator = runs.simulator(request.effects)
    diagnosis = None
    if request.paths[0].suffix == ".json":
        diagnosis = read_diagnosis(request.paths[0], simulator.effects)
    propose = _proposer(runs, request.gait)
    effects = {effect.name: effect for effect in simulator.effects}
    # of another simulator (--sim mujoco), the baseline model errors are other ones
    known = diagnosis is not None and diagnosis.simulator == simulator.name
    standing = diagnosis.standing if diagnosis is not None and known else None
    study = study_of(runs, simulator, standing, own=request.effects is not None)
    causes, rivals, none = _left_open(diagnosis, study)
    if not causes:
        raise GapError("the diagnosis names no cause, so there is nothing to distinguish")
    rivals += [(0, *_place(text, effects, causes[0])) for text in request.against]
    sets: list[Causes] = [causes]
    ranked: tuple[NextRun, ...] = ()
    if rivals and none >= SURELY_NONE:  # then the diagnosis itself proposes no run
        complain(f"note: it is most likely none of these causes (probability {none:.2f})")
    if rivals := list(dict.fromkeys(rivals)):
        each, predictor = _candidates(rivals, effects), study.predictor
        with ProgressBar("sizes of the candidates") as bar:
            floor = study.floor(study.judging)
            sets = open_sets(predictor, study.trials, floor, causes, each, study.judging, bar.show)
        with ProgressBar("trying runs in the simulator") as bar:
            ranked = discriminating_runs(predictor, floor, sets, propose(), bar.show)
    if request.json:
        print_json(_as_json(sets, ranked, effects))
    else:
        width = terminal_width()
        shown = ranked if request.all else ranked[:SHOWN]
        for line in _lines(sets, shown, effects, width):
            print("\n".join(wrapped(line, width)))
    return ExitCode.OK if ranked or not rivals else ExitCode.VERDICT_FAILED


def _runs(request: GapNextRequest) -> Runs:
    """The runs that were given, or those of the diagnosis that was given."""
    first = request.paths[0]
    if first.suffix != ".json":
        return read_runs(request.paths, request.reference, request.robot)
    if len(request.paths) > 1 or request.reference:
        raise ConfigError("DIAGNOSIS.json", "names its runs and references itself; give it alone")
    return runs_of_diagnosis(diagnosed_runs(first), request.robot)


def _proposer(runs: Runs, gait: str | None) -> Proposer:
    """What makes the runs that the machine could make.

    Raises:
        GapError: It does not say which; with what to do by hand.
        ConfigError: A gait for a machine that has none, or one that cannot be used.
    """
    kind = runs.kind
    if kind.name == LEGGED:
        proposer, note = proposer_of(runs.robot_text, runs.robot, gait)
        if note:
            complain(f"note: {note}")
        return proposer.proposals
    if gait is not None:
        raise ConfigError("--gait", f"is for legged robots; the runs are of kind {kind.name}")
    propose = kind.propose
    if propose is None:
        raise GapError(f"a machine of kind {kind.name} {kind.no_propose}")
    return lambda: propose(runs.trials)


def _left_open(diagnosis: ReadDiagnosis | None, study: Study) -> tuple[Causes, list[Open], float]:
    """Causes, what the runs could not distinguish from each, and how likely it is none of them."""
    if diagnosis is not None:
        return diagnosis.causes, list(diagnosis.rivals), diagnosis.none
    with ProgressBar("diagnosis") as bar:
        d = diagnose_study(study, bar.tell)
    keys = [(one.effect, one.joints) for one in d.causes]
    left_open = [(keys.index(one.of), one.form, one.joints) for one in d.ambiguous]
    return tuple(one.cause for one in d.causes), left_open, d.none


def _candidates(
    rivals: Sequence[Open], effects: Mapping[str, Effect]
) -> list[tuple[int, Candidate]]:
    for _, effect, _ in rivals:
        if effect not in effects:
            raise GapError(
                f"{effect} is left open, and the catalogue of the machine does not have it; an effect of "
                "your own needs --effects FILE.py"
            )
    return [(of, Candidate(effects[effect], legs)) for of, effect, legs in rivals]


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
        if one.command:
            lines.append(f"   {one.command}")
    hint = (
        "on the robot add: --hardware PORT --armed    " if any(one.command for one in shown) else ""
    )
    lines.append(f"{hint}(a separation of {ENOUGH} is enough: 1 wrong in 100)")
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
