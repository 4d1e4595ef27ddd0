"""``bigant gap effects``: the catalogue of what a simulator may lack."""

import textwrap
from collections.abc import Sequence

from gap.effect_file import read_effects
from gap.interfaces import Effect, Parameter, Scope
from model.effects.catalogue import CATALOGUE, STAGES
from model.errors import ConfigError
from robot.console.exit_codes import ExitCode
from robot.console.json_output import print_result
from robot.console.screen_fit import WIDTH
from robot.requests.gap import GapEffectsRequest


def list_effects(request: GapEffectsRequest) -> ExitCode:
    """List the catalogue, with a user's own effects behind it.

    Raises:
        ConfigError: There is no such stage.
        GapError: The file of effects cannot be used.
    """
    effects: list[Effect] = list(CATALOGUE)
    if request.effects is not None:
        taken = tuple(effect.name for effect in effects)
        effects += [user.effect for user in read_effects(request.effects, STAGES, taken)]
    if request.stage is not None:
        if request.stage not in STAGES:
            words = f"{request.stage!r} is none; stages are {', '.join(STAGES)}"
            raise ConfigError("--stage", words)
        effects = [effect for effect in effects if effect.stage == request.stage]
    result = [_as_json(effect) for effect in effects]
    print_result(result, _lines(effects), as_json=request.json)
    return ExitCode.OK


def _as_json(effect: Effect) -> dict[str, object]:
    return {
        "effect": effect.name,
        "form_of": effect.form_of,
        "stage": effect.stage,
        "scopes": [scope.value for scope in effect.scopes],
        "parameters": effect.parameters,
        "physics": effect.physics,
        "remedy": effect.remedy,
        "wears": effect.wears,
    }


def _lines(effects: Sequence[Effect]) -> list[str]:
    lines = []
    for stage in STAGES:
        here = [effect for effect in effects if effect.stage == stage]
        lines += [stage.upper()] if here else []
        for effect in here:
            scopes = ("whole robot" if s is Scope.ALL else "single legs" for s in effect.scopes)
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
