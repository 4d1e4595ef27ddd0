"""``bigant gap next``: which run would tell apart the causes that a diagnosis left open.

Takes the JSON of a diagnosis (its runs must still be where they were), or runs, which are diagnosed
first. Each gait at several frequencies, straight and turning, and with a weight on the body, is played
through the simulator with each candidate; what is left of their difference after one is adjusted to the
other, in units of the noise, is the separation that the run would show. 22 makes the choice sure to one
in a hundred.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gap.effect_file import UserEffect
    from gap.experiments.next_run import NextRun
    from gap.interfaces import Cause, Effect, Simulator
    from gap.proposals import Proposal
    from gap.residuals.floor import Floor
    from record.trial.trial import Trial
    from robot.gap_report.answer import ReadDiagnosis

SHOWN = 5
NAME, FIGURES = 58, 26  # columns of the name of a run, and of its figures


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("paths", type=Path, nargs="+", metavar="DIAGNOSIS.json|TRIAL")
    parser.add_argument("--reference", type=Path, nargs="+", default=[], metavar="TRIAL",
        help="with TRIAL: healthy runs of the same machine")  # fmt: skip
    parser.add_argument("--against", action="append", default=[], metavar="EFFECT[@LEG]",
        help="a candidate in place of the first cause, besides those left open")  # fmt: skip
    parser.add_argument("--robot", type=Path, metavar="FILE",
        help="robot file to believe (default: the one that the runs name)")  # fmt: skip
    parser.add_argument("--effects", type=Path, metavar="FILE.py",
        help="effects of your own (run as Python: open only files that you trust)")  # fmt: skip
    parser.add_argument("--all", action="store_true", help=f"show all runs, not only {SHOWN}")
    parser.add_argument("--json", action="store_true", help="all runs as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Propose runs.

    Raises:
        RecordError: A file cannot be read.
        GapError: There is nothing to tell apart, or no run can be proposed.
        ConfigError: Options that do not go together.
    """
    import json
    import sys

    from robot.console.lines import terminal_width, wrapped
    from robot.gap_report.runs import proposer_of
    from robot.gap_report.trials import read_trials, robot_text, simulator_for, users_effects

    found, trial_paths, reference_paths = _asked(options, users_effects(options.effects))
    everything = read_trials((*trial_paths, *reference_paths))
    trials, references = everything[: len(trial_paths)], everything[len(trial_paths) :]
    robot = options.robot or (found.robot if found is not None else None)
    simulator = simulator_for(everything, options.effects, robot, references)
    _check_kind(simulator)
    text = trials[0].header.robot_text if robot is None else robot_text(robot)
    proposer, note = proposer_of(text, robot)
    if note:
        print(f"note: {note}", file=sys.stderr)
    sets = _sets(found, options, trials, references, simulator)
    told = len(sets) == 1
    runs = () if told else _ranked(sets, trials, references, simulator, proposer.proposals())
    if options.json:
        print(json.dumps(_as_json(sets, runs, simulator), indent=2))
    else:
        width = terminal_width()
        for line in _lines(sets, runs, simulator, everything=options.all, width=width):
            print("\n".join(wrapped(line, width)))
    return ExitCode.OK if runs or told else ExitCode.VERDICT_FAILED


def _asked(
    options: argparse.Namespace, users: "tuple[UserEffect, ...]"
) -> "tuple[ReadDiagnosis | None, tuple[Path, ...], tuple[Path, ...]]":
    from gap.machines.legged.catalogue import CATALOGUE
    from model.errors import ConfigError, GapError
    from robot.gap_report.answer import read_diagnosis

    if options.paths[0].suffix != ".json":
        return None, tuple(options.paths), tuple(options.reference)
    if len(options.paths) > 1 or options.reference:
        raise ConfigError("DIAGNOSIS.json", "names its runs and references itself; give it alone")
    effects = (*(entry.effect for entry in CATALOGUE), *(user.effect for user in users))
    found = read_diagnosis(options.paths[0], effects)
    if not found.trials:
        raise GapError(
            f"the runs of {found.path} are not where they were; give them: bigant gap next TRIAL..."
        )
    return found, found.trials, found.references


def _check_kind(simulator: "Simulator") -> None:
    from model.errors import GapError

    if simulator.name != "legged":
        raise GapError(
            f"bigant gap next knows the runs of legged robots, not of a {simulator.name}; vary its load "
            "and its speed by hand"
        )


def _sets(
    found: "ReadDiagnosis | None",
    options: argparse.Namespace,
    trials: "Sequence[Trial]",
    references: "Sequence[Trial]",
    simulator: "Simulator",
) -> "list[tuple[Cause, ...]]":
    """What was found, and what could be in its place, each at the size that fits the runs best."""
    from gap.experiments.imitation import imitate
    from gap.search.candidates import Candidate
    from model.errors import GapError
    from robot.console.progress import ProgressBar

    causes, open_ones = _found(found, trials, references, simulator)
    effects = {effect.name: effect for effect in simulator.effects}
    if not causes:
        raise GapError("the diagnosis names no cause, so there is nothing to tell apart")
    asked = [(0, *_place(text, effects, causes[0])) for text in options.against]
    rivals = list(dict.fromkeys([*open_ones, *asked]))
    if not rivals:
        return [causes]
    floor = _floor(trials, references, simulator)
    sets = [causes]
    with ProgressBar("sizes of the candidates") as bar:
        for number, (of, effect, legs) in enumerate(rivals):
            rival = Candidate(effects[effect], legs)
            sets.append(imitate(simulator, trials[:2], causes, of, rival, floor))
            bar.show((number + 1) / len(rivals), effect)
    return sets


def _found(
    found: "ReadDiagnosis | None",
    trials: "Sequence[Trial]",
    references: "Sequence[Trial]",
    simulator: "Simulator",
) -> "tuple[tuple[Cause, ...], list[tuple[int, str, tuple[str, ...]]]]":
    """Causes, and for each open rival the number of its cause, its effect and its legs."""
    from gap.diagnosis.diagnose import diagnose
    from gap.interfaces import Cause
    from robot.console.progress import ProgressBar

    if found is not None:
        causes = tuple(one.cause for one in found.causes)
        names = [cause.effect for cause in causes]
        return causes, [
            (names.index(named), effect, legs)
            for named, effect, legs in found.rivals
            if named in names
        ]
    with ProgressBar("diagnosis") as bar:
        d = diagnose(trials, simulator, references, progress=lambda w, share: bar.show(share, w))
    causes = tuple(
        Cause(one.effect, one.joints, tuple(v.value for v in one.values)) for one in d.causes
    )
    keys = [(cause.effect, cause.joints) for cause in causes]
    return causes, [(keys.index(one.of), one.effect, one.joints) for one in d.ambiguous]


def _place(text: str, effects: "dict[str, Effect]", first: "Cause") -> tuple[str, tuple[str, ...]]:
    from gap.interfaces import Scope
    from model.errors import GapError

    name, _, leg = text.partition("@")
    if name not in effects:
        raise GapError(f"--against {name}: no such effect; bigant gap effects lists them")
    if leg:
        return name, (leg,)
    whole = Scope.ALL in effects[name].scopes
    if not whole and not first.joints:
        raise GapError(f"--against {name}: it touches single legs; write {name}@LEG")
    return name, () if whole else first.joints


def _floor(
    trials: "Sequence[Trial]", references: "Sequence[Trial]", simulator: "Simulator"
) -> "Floor":
    from gap.diagnosis.study import make_study
    from gap.interfaces import Drive

    return make_study(trials, simulator, references).floor(Drive.COMMAND)


def _ranked(
    sets: "list[tuple[Cause, ...]]",
    trials: "Sequence[Trial]",
    references: "Sequence[Trial]",
    simulator: "Simulator",
    proposals: "Sequence[Proposal]",
) -> "tuple[NextRun, ...]":
    from gap.experiments.next_run import next_runs
    from robot.console.progress import ProgressBar

    with ProgressBar("trying runs in the simulator") as bar:
        floor = _floor(trials, references, simulator)
        return next_runs(proposals, simulator, sets, floor, bar.show)


def _words(causes: "tuple[Cause, ...]", effects: "dict[str, Effect]") -> str:
    parts = []
    for cause in causes:
        names = [p.name for p in effects[cause.effect].parameters]
        numbers = ", ".join(f"{n} {v:.3g}" for n, v in zip(names, cause.values, strict=True))
        place = f" at {', '.join(cause.joints)}" if cause.joints else ""
        parts.append(cause.effect + place + (f" ({numbers})" if numbers else ""))
    return " and ".join(parts)


def _lines(
    sets: "list[tuple[Cause, ...]]",
    runs: "tuple[NextRun, ...]",
    simulator: "Simulator",
    *,
    everything: bool,
    width: int,
) -> list[str]:
    from gap.experiments.next_run import MOST_RUNS
    from robot.gap_report.words import common_pair, pair_words

    effects = {effect.name: effect for effect in simulator.effects}
    if len(sets) == 1:
        return [
            f"nothing is left open beside {_words(sets[0], effects)}: no run is needed",
            "to ask for a rival all the same: --against EFFECT[@LEG]",
        ]
    lines = ["to be told apart, each as it fits the runs best:"]
    lines += [f"  {_words(causes, effects)}" for causes in sets]
    if not runs:
        few = f"in {MOST_RUNS} runs or fewer"
        return [*lines, "", f"no run that this robot can make tells them apart {few}"]
    shown = runs if everything else runs[:SHOWN]
    pair = common_pair(shown)
    if pair:
        lines += ["", f"each tells {pair}"]
    room = min(NAME, width - FIGURES)
    lines += ["", f"{'run':<{room}}{'separation':>11}{'runs':>6}{'minutes':>9}"]
    for number, one in enumerate(shown, 1):
        lines.append(
            f"{f'{number}. {one.name}':<{room}}{one.separation:>11.3g}{one.runs:>6}{one.minutes:>9.1f}"
        )
        if not pair:
            lines.append(f"   tells least: {pair_words(one)}")
        if one.limits:
            lines.append(f"   beware: {one.limits}")
        lines.append(f"   {one.command}")
    lines.append(
        "on the robot add: --hardware PORT --armed    (a separation of 22 tells, 1 wrong in 100)"
    )
    return lines


def _as_json(
    sets: "list[tuple[Cause, ...]]", runs: "tuple[NextRun, ...]", simulator: "Simulator"
) -> object:
    from dataclasses import asdict

    from robot.console.plain_json import plain

    names = {e.name: [p.name for p in e.parameters] for e in simulator.effects}
    return plain({
        "candidates": [
            [
                {"effect": c.effect, "legs": list(c.joints),
                 "parameters": dict(zip(names[c.effect], c.values, strict=True))}
                for c in causes
            ]
            for causes in sets
        ],
        "runs": [asdict(one) for one in runs],
    })  # fmt: skip
