"""What a trial could show to a diagnosis: channels that were measured, effects that would stand out."""

from collections.abc import Sequence
from dataclasses import dataclass

from gap.coverage.blind_spots import blind_spots
from gap.coverage.shown_changes import look_at
from gap.interfaces import Channel, Simulator
from model.values.arrays import BoolArray
from record.trial.trial import Trial


@dataclass(frozen=True, slots=True)
class Coverage:
    """What is measured, and what could be seen.

    Attributes:
        measured: Channels with measured values.
        missing: Names of those without at any joint, or ``command``.
        visible: Effects that would show in a measured channel, in the mean of a run if not at any one time,
            at one standard deviation of what a builder of such machines expects, somewhere along the way or
            at a limit that is reached, whether their stage is fed what was measured or what is predicted.
        hidden: Those that would not, in no length of such runs.
    """

    measured: tuple[Channel, ...]
    missing: tuple[str, ...]
    visible: tuple[str, ...]
    hidden: tuple[str, ...]


def coverage_of(simulator: Simulator, trial: Trial) -> Coverage:
    """Predict every effect of the catalogue alone, and compare with the noise of what was measured.

    Raises:
        GapError: The trial does not fit the simulator, or is too short.
    """
    live = look_at(simulator, trial).measured
    spots = blind_spots(simulator, [trial])
    hidden = {one.effect for one in spots.effects if not one.joints}
    return Coverage(
        measured=tuple(c for c, known in zip(simulator.channels, live, strict=True) if known),
        missing=spots.missing,
        visible=tuple(e.name for e in simulator.effects if e.name not in hidden),
        hidden=tuple(e.name for e in simulator.effects if e.name in hidden),
    )


def unwatched_stages(channels: Sequence[Channel], measured: BoolArray) -> tuple[str, ...]:
    """Return the stages none of whose channels was measured, in the order of the channels.

    Args:
        channels: Of the simulator, C of them.
        measured: Which of them were measured, (C,).
    """
    watched = {channel.stage for channel, known in zip(channels, measured, strict=True) if known}
    return tuple(dict.fromkeys(one.stage for one in channels if one.stage not in watched))
