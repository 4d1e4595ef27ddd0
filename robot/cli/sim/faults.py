"""``bigant sim faults``: every fault and setting that a scenario file can hold."""

import argparse
import json
from textwrap import fill
from typing import TYPE_CHECKING

from robot.console.exit_codes import ExitCode

if TYPE_CHECKING:
    from sim_hw.faults.reference import Setting

WIDTH = 100


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments; imports nothing heavy."""
    parser.description = (
        "List the faults that a scenario file (--scenario of drive and sim serve) can put on the "
        "virtual hardware: what each does, where it acts, and its keys with unit, default and bounds. "
        "examples/faults_servo.toml and examples/faults_force.toml show them in use."
    )
    parser.add_argument("--json", action="store_true", help="the list as JSON")


def run(options: argparse.Namespace) -> ExitCode:
    """Run the action."""
    if options.json:
        print(json.dumps(_as_json(), indent=2))
    else:
        print("\n".join(_lines()))
    return ExitCode.OK


def _as_json() -> dict[str, object]:
    from dataclasses import asdict

    from sim_hw.faults.reference import common_settings, kinds_of_fault, tables

    return {
        "tables": [asdict(table) for table in tables()],
        "every_fault": [asdict(setting) for setting in common_settings()],
        "faults": [asdict(kind) for kind in kinds_of_fault()],
    }


def _lines() -> list[str]:
    from sim_hw.faults.reference import common_settings, kinds_of_fault, tables

    lines = ["FAULTS: a [[fault]] table each, with its kind; every one has", ""]
    lines += [_line(setting) for setting in common_settings()]
    lines += [
        "",
        "(rate and count only where marked with *: what hits single replies or datagrams)",
    ]
    acts_on = ""
    for kind in sorted(kinds_of_fault(), key=lambda k: not k.acts_on.startswith(("serv", "plant"))):
        if kind.acts_on != acts_on:
            acts_on = kind.acts_on
            lines += ["", f"acts on {acts_on}"]
        title = f"{kind.kind}{' *' if kind.chance else ''}: {kind.text}"
        lines.append(fill(title, WIDTH, initial_indent="  ", subsequent_indent="    "))
        lines += [_line(setting) for setting in kind.settings]
    for table in tables():
        title = f"[{table.name}]" if table.name else "TOP OF THE FILE"
        lines += ["", f"{title}: {table.text}"]
        lines += [_line(setting) for setting in table.settings]
    return lines


def _line(setting: "Setting") -> str:
    unit = f" [{setting.unit}]" if setting.unit else ""
    default = "needed" if setting.needed else f"default: {setting.default}"
    text = f"{setting.name + unit:<26} {setting.text} ({setting.allowed}; {default})"
    return fill(text, WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 33)
