"""The faults and the effects of the virtual robot as lists, for a person and for a program."""

from dataclasses import asdict
from textwrap import fill

from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_json, print_result
from robot.console.table import Column, table_lines
from robot.requests.sim import SimEffectsRequest, SimFaultsRequest, SimRealitiesRequest
from sim_hw.faults.reference import Setting, common_settings, kinds_of_fault, tables
from sim_hw.realities.catalogue import REALITIES, why_not_in
from sim_hw.twin.catalog import EFFECTS
from sim_hw.twin.effects import EffectKind

WIDTH = 100
SCOPES = {"leg": "@LEG", "all": "", "all, leg": "[@LEG]"}


def list_faults(request: SimFaultsRequest) -> ExitCode:
    """Print every fault and setting of a scenario file."""
    listed = {
        "tables": tables(),
        "every_fault": common_settings(),
        "faults": kinds_of_fault(),
    }
    print_result(listed, _fault_lines(), as_json=request.json)
    return ExitCode.OK


def _fault_lines() -> list[str]:
    lines = ["FAULTS: a [[fault]] table each, with its kind; every one has", ""]
    lines += [_setting_line(setting) for setting in common_settings()]
    lines += [
        "",
        "(rate and count only where marked with *: what hits single requests, replies or datagrams)",
    ]
    acts_on = ""
    for kind in sorted(kinds_of_fault(), key=lambda k: not k.acts_on.startswith(("serv", "plant"))):
        if kind.acts_on != acts_on:
            acts_on = kind.acts_on
            lines += ["", f"acts on {acts_on}"]
        title = f"{kind.kind}{' *' if kind.chance else ''}: {kind.text}"
        lines.append(fill(title, WIDTH, initial_indent="  ", subsequent_indent="    "))
        lines += [_setting_line(setting) for setting in kind.settings]
    for table in tables():
        title = f"[{table.name}]" if table.name else "TOP OF THE FILE"
        lines += ["", f"{title}: {table.text}"]
        lines += [_setting_line(setting) for setting in table.settings]
    return lines


def _setting_line(setting: Setting) -> str:
    unit = f" [{setting.unit}]" if setting.unit else ""
    default = "needed" if setting.needed else f"default: {setting.default}"
    text = f"{setting.name + unit:<26} {setting.text} ({setting.allowed}; {default})"
    return fill(text, WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 33)


def list_effects(request: SimEffectsRequest) -> ExitCode:
    """Print every effect that the virtual robot can have."""
    if request.json:
        print_json([_plain_effect(kind) for kind in EFFECTS])
        return ExitCode.OK
    stage = ""
    for kind in EFFECTS:
        heading = kind.stage if kind.catalogued else "not catalogued"
        if heading != stage:
            stage = heading
            print(f"\n{stage}")
        name = kind.name + ("" if kind.catalogued else " *")
        print(f"  {name:22s} {SCOPES[kind.scope]:11s} {kind.acts}")
        for p in kind.parameters:
            unit = f" {p.unit}" if p.unit else ""
            sizes = f"{p.low:g} to {p.high:g}{unit}; mild {p.mild:g}, strong {p.strong:g}"
            print(f"    {p.name:20s} {sizes}")
    return ExitCode.OK


def list_realities(request: SimRealitiesRequest) -> ExitCode:
    """Print every way in which the virtual robot can be built."""
    skipped = {
        one.name: tuple(k.name for k in EFFECTS if why_not_in(one, k.name)) for one in REALITIES
    }
    if request.json:
        print_json([{**asdict(one), "without_effects": skipped[one.name]} for one in REALITIES])
        return ExitCode.OK
    rows = [(one.name, one.differs) for one in REALITIES]
    print("\n".join(table_lines((Column("reality"), Column("what differs")), rows)))
    return ExitCode.OK


def _plain_effect(kind: EffectKind) -> dict[str, object]:
    return {
        "name": kind.name,
        "stage": kind.stage,
        "scope": kind.scope,
        "catalogued": kind.catalogued,
        "switchable": kind.apply is not None,
        "acts": kind.acts,
        "parameters": kind.parameters,
    }
