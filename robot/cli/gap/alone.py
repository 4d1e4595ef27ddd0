"""``bigant gap alone``: how far an explanation comes by itself, for example a delay.

Fits effects of the catalogue by least squares to the runs that the diagnosis would fit to, each by itself
(or several joined with +), and judges them on the runs that it would keep back. It says nothing of what is
the cause: it shows what a decoy could have claimed, beside what ``bigant gap diagnose`` names.
"""

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from gap.diagnosis.alone import Alone
    from gap.interfaces import Simulator


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("trials", type=Path, nargs="+", metavar="TRIAL")
    parser.add_argument("--effect", action="append", default=[], metavar="NAME[+NAME...]",
        help="an effect, or several together; may be given again (default: every effect)")  # fmt: skip
    parser.add_argument("--joint", action="append", default=[], metavar="NAME",
        help="only this joint of a bench of servos; may be given again")  # fmt: skip
    parser.add_argument("--json", action="store_true", help="the result as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Fit and judge.

    Raises:
        RecordError: A trial cannot be read.
        GapError: The trials cannot be compared with a simulator, or an effect is not known.
    """
    from gap.diagnosis.alone import each_alone
    from robot.console.progress import ProgressBar
    from robot.gap_report.trials import read_trials, simulator_for

    trials = read_trials(options.trials, tuple(options.joint))
    simulator = simulator_for(trials, None)
    sets = [tuple(text.split("+")) for text in options.effect] or [
        (effect.name,) for effect in simulator.effects
    ]
    with ProgressBar("alone") as bar:
        found = each_alone(
            trials, simulator, sets, lambda words, share: bar.show(share, words)
        )  # fmt: skip
    if options.json:
        print(json.dumps([_plain(one, simulator) for one in found], indent=2))
    else:
        print("\n".join(_lines(found, simulator)))
    return ExitCode.OK


def _lines(found: "Sequence[Alone]", simulator: "Simulator") -> "Iterator[str]":
    channels = [(c.channel, c.joint) for c in found[0].channels]
    for at, (name, joint) in enumerate(channels):
        first = found[0].channels[at]
        low, high = first.before_range
        yield (
            f"{name} {joint}".rstrip() + f": RMS {first.before:.4g} [{low:.4g}, {high:.4g}] {first.unit} "
            "on the runs kept back"
        )  # fmt: skip
        for one in sorted(found, key=lambda a: a.channels[at].after):
            c = one.channels[at]
            low, high = c.after_range
            yield (
                f"  {'+'.join(one.effects):<40} {c.after:9.4g} [{low:.4g}, {high:.4g}]  cut {c.cut:4.0%}  "
                f"{_sizes(one, simulator, joint)}"
            )  # fmt: skip


def _sizes(one: "Alone", simulator: "Simulator", joint: str) -> str:
    effects = {effect.name: effect for effect in simulator.effects}
    return ", ".join(
        f"{p.name} {value:.3g}"
        for cause in one.causes
        if joint in cause.joints or not cause.joints
        for p, value in zip(effects[cause.effect].parameters, cause.values, strict=True)
    )


def _plain(one: "Alone", simulator: "Simulator") -> dict[str, object]:
    from dataclasses import asdict

    from robot.console.json_output import plain

    effects = {effect.name: effect for effect in simulator.effects}
    return {
        "effects": list(one.effects),
        "causes": [
            {
                "effect": cause.effect,
                "joints": list(cause.joints),
                "parameters": {
                    p.name: value
                    for p, value in zip(effects[cause.effect].parameters, cause.values, strict=True)
                },
            }
            for cause in one.causes
        ],
        "channels": [plain({**asdict(c), "cut": c.cut}) for c in one.channels],
    }
