"""``bigant gap effects``: the catalogue of what a simulator may lack.

Each effect with its stage, what it can touch, its numbers with units and bounds, its physics and what a
person would do about it. With --effects FILE.py a user's own effects are listed behind them, which also
checks the file (it is run as Python: open only files that you trust).
"""

import argparse
import json
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gap.interfaces import Effect, Parameter

WIDTH = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("--effects", type=Path, metavar="FILE.py", help="effects of your own")
    parser.add_argument("--stage", metavar="STAGE", help="only those of one stage")
    parser.add_argument("--json", action="store_true", help="print JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """List the catalogue.

    Raises:
        ConfigError: There is no such stage.
        GapError: The file of effects cannot be used.
    """
    from gap.effect_file import read_effects
    from gap.machines.legged.catalogue import CATALOGUE
    from model.effects.catalogue import STAGES
    from model.errors import ConfigError

    effects = list(CATALOGUE)
    if options.effects is not None:
        taken = tuple(effect.name for effect in effects)
        effects += [user.effect for user in read_effects(options.effects, STAGES, taken)]
    if options.stage is not None:
        if options.stage not in STAGES:
            raise ConfigError(
                "--stage", f"{options.stage!r} is none; stages are {', '.join(STAGES)}"
            )
        effects = [effect for effect in effects if effect.stage == options.stage]
    if options.json:
        print(json.dumps([_plain(effect) for effect in effects], indent=2))
    else:
        print("\n".join(_lines(effects, STAGES)))
    return ExitCode.OK


def _plain(effect: "Effect") -> dict[str, object]:
    from dataclasses import asdict

    return {
        "effect": effect.name,
        "stage": effect.stage,
        "scopes": [scope.value for scope in effect.scopes],
        "parameters": [asdict(parameter) for parameter in effect.parameters],
        "physics": effect.physics,
        "remedy": effect.remedy,
    }


def _lines(effects: "Sequence[Effect]", stages: tuple[str, ...]) -> list[str]:
    lines = []
    for stage in stages:
        here = [effect for effect in effects if effect.stage == stage]
        if not here:
            continue
        lines += [stage.upper()]
        for effect in here:
            scopes = ", ".join(
                "whole robot" if s.value == "all" else "single legs" for s in effect.scopes
            )
            lines.append(f"  {effect.name}  ({scopes})")
            lines += [f"      {_words(parameter)}" for parameter in effect.parameters]
            for text in (effect.physics, f"To do: {effect.remedy}"):
                lines += textwrap.wrap(
                    text, WIDTH, initial_indent="      ", subsequent_indent="      "
                )
    lines.append(f"{len(effects)} effects")
    return lines


def _words(parameter: "Parameter") -> str:
    unit = f" {parameter.unit}" if parameter.unit else ""
    return (
        f"{parameter.name}: {parameter.lower:g} to {parameter.upper:g}{unit}, "
        f"neutral {parameter.neutral:g}, expected within {parameter.spread:g}"
    )
