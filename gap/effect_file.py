"""Effects of a user's own: one Python file with a list ``EFFECTS``.

See ``docs/gap_effects.md`` for an example. The file is run as Python: open only files that you trust.
"""

import runpy
from pathlib import Path

from model.effects.causes import Effect
from model.effects.settings import UserEffect
from model.errors import GapError

__all__ = ("UserEffect", "read_effects")


def read_effects(
    path: Path, stages: tuple[str, ...], taken: tuple[str, ...]
) -> tuple[UserEffect, ...]:
    """Read a file of effects.

    Args:
        path: The file.
        stages: Stages of the simulator that they are for.
        taken: Names that its own effects have.

    Raises:
        GapError: The file cannot be run, has no EFFECTS, or one of them does not fit.
    """
    if not path.is_file():
        raise GapError(f"there is no file {path}; --effects takes a Python file")
    try:
        names = runpy.run_path(str(path))
    except Exception as error:  # whatever a user's file raises is a mistake in it
        raise GapError(f"{path} cannot be run: {type(error).__name__}: {error}") from error
    effects = names.get("EFFECTS")
    if not isinstance(effects, list | tuple) or not effects:
        raise GapError(f"{path} has no list EFFECTS of UserEffect(effect, act)")
    seen = set(taken)
    for user in effects:
        if not isinstance(user, UserEffect):
            raise GapError(f"{path}: EFFECTS must hold UserEffect(effect, act), not {user!r}")
        _check(path, user.effect, stages, seen)
        seen.add(user.effect.name)
    return tuple(effects)


def _check(path: Path, effect: Effect, stages: tuple[str, ...], seen: set[str]) -> None:
    if effect.name in seen:
        raise GapError(f"{path}: there is an effect {effect.name!r} already; choose another name")
    if effect.stage not in stages:
        raise GapError(
            f"{path}: {effect.name} names the stage {effect.stage!r}; stages are {', '.join(stages)}"
        )
    if not effect.scopes:
        raise GapError(f"{path}: {effect.name} needs a scope: Scope.ALL, Scope.JOINT or both")
    for parameter in effect.parameters:
        numbers = (parameter.lower, parameter.neutral, parameter.upper, parameter.spread)
        if not all(isinstance(number, int | float) for number in numbers):
            raise GapError(f"{path}: {effect.name}: bounds of {parameter.name} must be numbers")
        if not parameter.lower <= parameter.neutral <= parameter.upper or not parameter.spread > 0:
            raise GapError(
                f"{path}: {effect.name}: {parameter.name} needs lower <= neutral <= upper "
                "and a spread above 0"
            )
