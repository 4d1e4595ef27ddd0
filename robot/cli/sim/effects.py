"""``bigant sim effects``: what can be made wrong with the virtual robot.

A table of all effects with their parameters, units and ranges, and where each acts. Sizes are a mild and
a strong one; `bigant sim run --effect NAME` takes the strong one. Effects marked * are not among those
that a gap diagnosis knows by name.
"""

import argparse
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from sim_hw.twin.effects import EffectKind, EffectParameter


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.add_argument("--json", action="store_true", help="the list as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Print the effects."""
    import json

    from sim_hw.twin.catalog import EFFECTS

    if options.json:
        print(json.dumps([_plain(kind) for kind in EFFECTS], indent=2))
        return ExitCode.OK
    stage = ""
    for kind in EFFECTS:
        heading = kind.stage if kind.catalogued else "not catalogued"
        if heading != stage:
            stage = heading
            print(f"\n{stage}")
        name = kind.name + ("" if kind.catalogued else " *")
        print(f"  {name:22s} {_scope(kind):11s} {kind.acts}")
        for parameter in kind.parameters:
            print(f"    {_line(parameter)}")
    return ExitCode.OK


def _scope(kind: "EffectKind") -> str:
    return {"leg": "@LEG", "all": "", "all, leg": "[@LEG]"}[kind.scope]


def _line(p: "EffectParameter") -> str:
    unit = f" {p.unit}" if p.unit else ""
    return f"{p.name:20s} {p.low:g} to {p.high:g}{unit}; mild {p.mild:g}, strong {p.strong:g}"


def _plain(kind: "EffectKind") -> dict[str, object]:
    from dataclasses import asdict

    return {
        "name": kind.name,
        "stage": kind.stage,
        "scope": kind.scope,
        "catalogued": kind.catalogued,
        "switchable": kind.apply is not None,
        "acts": kind.acts,
        "parameters": [asdict(parameter) for parameter in kind.parameters],
    }
