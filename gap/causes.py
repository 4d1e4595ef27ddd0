"""Whether causes fit a catalogue."""

import math
from collections.abc import Sequence

from gap.interfaces import Cause, Effect, Scope
from model.errors import GapError


def match_causes(
    causes: Sequence[Cause], effects: Sequence[Effect], joints: Sequence[str]
) -> tuple[Effect, ...]:
    """Return the effect of each cause.

    Raises:
        GapError: A cause is not of the catalogue, or its joints or values do not fit.
    """
    known = {effect.name: effect for effect in effects}
    found = []
    for cause in causes:
        effect = known.get(cause.effect)
        if effect is None:
            raise GapError(
                f"{cause.effect} is no effect of this simulator; there are {', '.join(known)}"
            )
        if len(cause.values) != len(effect.parameters):
            raise GapError(
                f"{cause.effect} has {len(effect.parameters)} values, not {len(cause.values)}"
            )
        if not all(math.isfinite(value) for value in cause.values):
            raise GapError(f"{cause.effect} needs finite values, not {cause.values}")
        strange = [joint for joint in cause.joints if joint not in joints]
        if strange:
            raise GapError(f"{', '.join(strange)} is no joint; there are {', '.join(joints)}")
        if not cause.joints and Scope.ALL not in effect.scopes:
            raise GapError(f"{cause.effect} needs joints; there are {', '.join(joints)}")
        found.append(effect)
    return tuple(found)
