"""Whether causes fit a catalogue: the effect, its joints, and values within their bounds."""

import math
from collections.abc import Sequence

from gap.interfaces import Cause, Effect, Scope, Simulator
from model.errors import GapError


def check_causes(causes: Sequence[Cause], simulator: Simulator, part: str = "joint") -> None:
    """Check causes against a simulator's catalogue.

    Args:
        causes: The causes.
        simulator: The simulator.
        part: What its joints are called in messages.

    Raises:
        GapError: A cause is not of the catalogue, or its joints or values do not fit.
    """
    known = {effect.name: effect for effect in simulator.effects}
    for cause in causes:
        if cause.effect not in known:
            names = ", ".join(known) or "none"
            raise GapError(f"{cause.effect!r} is no effect of {simulator.name}; known are {names}")
        check_cause(cause, known[cause.effect], simulator.joints, part)


def check_cause(
    cause: Cause, effect: Effect, joints: Sequence[str], part: str = "leg"
) -> tuple[bool, ...]:
    """Return which joints a cause touches, (N,).

    Args:
        cause: The cause.
        effect: Its effect.
        joints: Names of all N joints.
        part: What they are called in messages.

    Raises:
        GapError: Its joints or values do not fit the effect.
    """
    if len(cause.values) != len(effect.parameters):
        names = ", ".join(parameter.name for parameter in effect.parameters) or "no values"
        raise GapError(f"{effect.name} takes {names}, not {len(cause.values)} values")
    if not all(map(math.isfinite, cause.values)):
        raise GapError(f"{effect.name}: values must be finite numbers, not {cause.values}")
    for value, parameter in zip(cause.values, effect.parameters, strict=True):
        if not parameter.lower <= value <= parameter.upper:
            unit = f" {parameter.unit}" if parameter.unit else ""
            raise GapError(
                f"{effect.name}: {parameter.name} must be from {parameter.lower:g} to "
                f"{parameter.upper:g}{unit}, not {value:g}"
            )
    unknown = [joint for joint in cause.joints if joint not in joints]
    if unknown:
        names = ", ".join(joints) or "none"
        raise GapError(f"{effect.name}: {unknown[0]!r} is no {part}; {part}s are {names}")
    if cause.joints and Scope.JOINT not in effect.scopes:
        raise GapError(f"{effect.name} touches the whole robot; leave its {part}s out")
    if not cause.joints and Scope.ALL not in effect.scopes:
        raise GapError(f"{effect.name} touches single {part}s; name them")
    return tuple(not cause.joints or joint in cause.joints for joint in joints)
