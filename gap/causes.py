"""Whether causes fit a catalogue: the effect, its joints, and values within their bounds."""

from collections.abc import Sequence

from gap.interfaces import Cause, Simulator
from model.effects.causes import check_cause
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
