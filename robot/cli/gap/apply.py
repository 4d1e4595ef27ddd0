"""``bigant gap apply``: a diagnosis into a corrected robot file, and the gap measured again through it.

What is otherwise than drawn (links, mounts, springs, friction) changes its key; for everything else the
robot file gets a table [effects], which drive, odom, sim, replay and gap read. All comments stay. Then
the corrected file is read back, and the runs that the diagnosis kept back are predicted with it: before
and after are printed. Exit code 1: the gap did not shrink.
"""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from gap.diagnosis.how_far import HowFar
    from record.trial.trial import Trial
    from robot.config.edit import Edited
    from robot.gap_report.answer import ReadDiagnosis

MOST_CHANNELS = 8


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("diagnosis", type=Path, metavar="DIAGNOSIS.json")
    parser.add_argument("--robot", type=Path, metavar="FILE",
        help="robot file to correct (default: the one that the runs name)")  # fmt: skip
    parser.add_argument(
        "--out", type=Path, required=True, metavar="FILE", help="the corrected file"
    )
    parser.add_argument("--anyway", action="store_true",
        help="apply the causes of a diagnosis that does not explain the gap, too")  # fmt: skip
    parser.add_argument("--json", action="store_true", help="what was done as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Correct the robot file and measure again.

    Raises:
        RecordError: A file cannot be read or written.
        GapError: There is nothing to apply, or a robot file cannot hold it.
        ConfigError: The robot file cannot be used.
    """
    import json

    from gap.machines.legged.catalogue import CATALOGUE
    from model.errors import ConfigError
    from robot.gap_report.answer import read_diagnosis
    from robot.gap_report.trials import read_trials

    if options.out.suffix != ".toml":
        raise ConfigError("--out", f"must end in .toml, not {options.out.name!r}")
    if options.out.exists():  # it may be the file that the runs themselves name
        raise ConfigError("--out", f"{options.out} exists; choose another name")
    found = read_diagnosis(options.diagnosis, tuple(entry.effect for entry in CATALOGUE))
    _check(found, anyway=options.anyway)
    everything = read_trials((*found.trials, *found.references)) if found.trials else ()
    trials, references = everything[: len(found.trials)], everything[len(found.trials) :]
    text = _robot(options, found, trials)
    edited = _edited(found, text, options.diagnosis.name)
    _write(options.out, edited.text)
    far = _measured(text, edited.text, trials, references) if trials else None
    if options.json:
        print(json.dumps(_as_json(options.out, edited, far), indent=2))
    else:
        print("\n".join(_lines(options.out, found, edited, far)))
    closed = far is None or far.after < far.before
    return ExitCode.OK if closed else ExitCode.VERDICT_FAILED


def _check(found: "ReadDiagnosis", *, anyway: bool) -> None:
    from gap.diagnosis.findings import Verdict
    from model.errors import GapError

    path = found.path
    if found.simulator not in {"legged", "mujoco"}:
        raise GapError(
            f"{path} is of the {found.simulator} simulator, whose machine is no robot of ours; apply its "
            "numbers to your own file"
        )
    if not found.causes:
        raise GapError(
            f"{path} names no cause (verdict {found.verdict}): there is nothing to apply"
        )
    bound = [one.cause.effect for one in found.causes if one.on_bound]
    if bound and not anyway:
        raise GapError(
            f"{', '.join(bound)} is on its bound, so it is not an effect of this form; look for another "
            "cause, or add --anyway"
        )
    if found.verdict == Verdict.UNEXPLAINED.value and not anyway:
        raise GapError(
            f"{path} says that its causes do not explain the gap; apply them all the same with --anyway"
        )


def _robot(options: argparse.Namespace, found: "ReadDiagnosis", trials: "tuple[Trial, ...]") -> str:
    from model.errors import GapError
    from robot.gap_report.trials import robot_text

    path: Path | None = options.robot or found.robot
    if path is not None:
        return robot_text(path)
    if not trials:
        raise GapError(
            f"the runs of {found.path} are not where they were, so their robot file is not known; give "
            "it with --robot"
        )
    text: str = trials[0].header.robot_text
    if not text:
        raise GapError("the runs name no robot file; give it with --robot")
    return text


def _edited(found: "ReadDiagnosis", text: str, origin: str) -> "Edited":
    from gap.machines.legged.correction import correction_of
    from model.parameters.tables import parse_table, read_legs
    from robot.config.edit import check_edited, edit_robot

    legs = read_legs(parse_table(text).table("legs")).names
    edited = edit_robot(text, correction_of([one.cause for one in found.causes], legs), origin)
    check_edited(edited.text, text)
    return edited


def _measured(
    before: str, after: str, trials: "tuple[Trial, ...]", references: "tuple[Trial, ...]"
) -> "HowFar":
    """Measure with both files; what ``after`` says is read from its text, as every command does."""
    from gap.diagnosis.remeasured import remeasure
    from gap.machines.legged.machine import parse_machine
    from gap.machines.legged.simulator import LeggedSimulator
    from robot.console.progress import ProgressBar

    old, new = (LeggedSimulator(parse_machine(text)) for text in (before, after))
    with ProgressBar("measuring again") as bar:
        return remeasure(trials, references, old, new, progress=bar.show)


def _write(path: Path, text: str) -> None:
    from model.errors import RecordError

    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise RecordError(f"{path} cannot be written: {error.strerror}; choose another") from error


def _lines(out: Path, found: "ReadDiagnosis", edited: "Edited", far: "HowFar | None") -> list[str]:
    from robot.control.effect_uses import USES

    lines = [f"written: {out}"]
    lines += [f"  {e.key:<28} {e.before:>10.4g} -> {e.after:<10.4g} {e.why}" for e in edited.edits]
    for one in edited.effects:
        numbers = ", ".join(f"{name} = {value:.4g}" for name, value in one.values) or "a law"
        lines.append(f"  [{one.key}]  {numbers}")
        lines.append(f"      drive, odom, replay: {USES[one.name].value}")
    if found.verdict == "ambiguous":
        others = ", ".join(dict.fromkeys(other for _, other, _ in found.rivals))
        lines.append(
            f"note: the runs left open whether it is {others} instead; see bigant gap next"
        )
    if far is None:
        return [*lines, "not measured again: the runs of the diagnosis are not where they were"]
    lines += ["", f"measured again through {out.name}, on the runs that the diagnosis kept back:"]
    lines.append(f"  RMS over all channels {far.before:.3g} -> {far.after:.3g} of the floor")
    if far.shrink == far.shrink:
        lines.append(
            f"  {far.shrink:.0%} [{far.low:.0%}, {far.high:.0%}] of the gap is closed"
            + ("" if found.shrink != found.shrink else f" (the diagnosis said {found.shrink:.0%})")
        )
    else:
        lines.append("  on these runs the gap is too small to measure what is closed")
    changed = [c for c in far.channels if abs(c.before - c.after) > 1e-3 * c.floor]
    changed.sort(key=lambda c: -abs(c.before - c.after) / max(c.floor, 1e-12))
    lines += [
        f"  {f'{c.channel} {c.joint}'.strip():<24} {c.before:9.3g} -> {c.after:9.3g} {c.unit:<6} "
        f"floor {c.floor:.3g}"
        for c in changed[:MOST_CHANNELS]
    ]
    if not far.after < far.before:
        lines.append("NOT SMALLER: do not use this file; diagnose again with more runs")
    return lines


def _as_json(out: Path, edited: "Edited", far: "HowFar | None") -> object:
    from dataclasses import asdict

    from robot.console.json_output import plain
    from robot.control.effect_uses import USES

    gap = None
    if far is not None:
        gap = {
            "before": far.before, "after": far.after, "shrink": far.shrink,
            "shrink_interval": [far.low, far.high],
            "channels": [asdict(one) for one in far.channels],
        }  # fmt: skip
    return plain(
        {
            "file": str(out),
            "keys": [asdict(edit) for edit in edited.edits],
            "effects": [
                {
                    "effect": e.name,
                    "leg": e.leg,
                    "parameters": dict(e.values),
                    "use": USES[e.name].value,
                }
                for e in edited.effects
            ],
            "gap": gap,
        }
    )
