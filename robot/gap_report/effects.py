"""``bigant gap effects``: the catalogue of what a simulator may lack."""

import textwrap
from collections.abc import Sequence

from gap.effect_file import read_effects
from gap.interfaces import Effect, Parameter, Scope
from model.effects.catalogue import CATALOGUE, STAGES
from model.errors import ConfigError
from record.trial.header import LEGGED
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.screen_fit import WIDTH
from robot.gap_report.trials import read_runs
from robot.requests.gap import GapEffectsRequest


def list_effects(request: GapEffectsRequest) -> ExitCode:
    """List a catalogue, with a user's own effects behind it.

    Raises:
        ConfigError: There is no such stage, or a machine is named without a run.
        GapError: The machine's file or the file of effects cannot be used.
        RecordError: The run cannot be read.
    """
    stages, effects, legged = _of_run(request) if request.trial is not None else _of_legs(request)
    if request.stage is not None:
        if request.stage not in stages:
            words = f"{request.stage!r} is none; stages are {', '.join(stages)}"
            raise ConfigError("--stage", words)
        effects = [effect for effect in effects if effect.stage == request.stage]
    result = [_as_json(effect) for effect in effects]
    print_result(result, _lines(effects, stages, legged=legged), as_json=request.json)
    return ExitCode.OK


def _of_run(request: GapEffectsRequest) -> tuple[Sequence[str], list[Effect], bool]:
    """Stages and effects of the machine of a run, and whether it has legs."""
    assert request.trial is not None
    runs = read_runs((request.trial,), machine=request.machine)
    simulator = runs.simulator(request.effects)
    return simulator.stages, list(simulator.effects), runs.kind.name == LEGGED


def _of_legs(request: GapEffectsRequest) -> tuple[Sequence[str], list[Effect], bool]:
    if request.machine:
        raise ConfigError(
            "--machine", "needs a run of that machine: bigant gap effects TRIAL --machine FILE"
        )
    effects: list[Effect] = list(CATALOGUE)
    if request.effects is not None:
        taken = tuple(effect.name for effect in effects)
        effects += [user.effect for user in read_effects(request.effects, STAGES, taken)]
    return STAGES, effects, True


def _as_json(effect: Effect) -> dict[str, object]:
    return {
        "effect": effect.name,
        "form_of": effect.form_of,
        "stage": effect.stage,
        "scopes": [scope.value for scope in effect.scopes],
        "parts": effect.parts,
        "parameters": effect.parameters,
        "physics": effect.physics,
        "remedy": effect.remedy,
        "wears": effect.wears,
    }


def _lines(effects: Sequence[Effect], stages: Sequence[str], *, legged: bool) -> list[str]:
    lines = []
    for stage in stages:
        here = [effect for effect in effects if effect.stage == stage]
        lines += [stage.upper()] if here else []
        for effect in here:
            single = "single legs" if legged else f"single {'bodies' if effect.parts else 'joints'}"
            whole = "whole robot" if legged else "whole machine"
            scopes = (whole if s is Scope.ALL else single for s in effect.scopes)
            form = f"; a form of {effect.form_of}" if effect.form_of else ""
            wears = "; may wear" if effect.wears else ""
            lines.append(f"  {effect.name}  ({', '.join(scopes)}{form}{wears})")
            lines += [f"      {_words(parameter)}" for parameter in effect.parameters]
            for text in (effect.physics, f"To do: {effect.remedy}"):
                lines += textwrap.wrap(
                    text, WIDTH, initial_indent="      ", subsequent_indent="      "
                )
    return [*lines, f"{len(effects)} effects"]


def _words(parameter: Parameter) -> str:
    unit = f" {parameter.unit}" if parameter.unit else ""
    return (
        f"{parameter.name}: {parameter.lower:g} to {parameter.upper:g}{unit}, "
        f"neutral {parameter.neutral:g}, expected within {parameter.spread:g}"
    )
