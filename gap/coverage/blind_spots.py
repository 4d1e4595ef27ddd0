"""What runs cannot show, whatever is wrong with the machine, and what would have to be measured for it."""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.coverage.shown_changes import (
    BLIND,
    ObservedRun,
    Spot,
    can_be_compared,
    look_at,
    not_shown,
    wherever,
)
from gap.interfaces import Scope, Simulator, places_for
from model.values.arrays import BoolArray, FloatArray
from record.trial.trial import Trial

STRONG = 1.0  # RMS change of a channel over its noise, from which it would surely show an effect
COMMANDS = "command"  # in place of a channel: what it lacks is not the sensor, but commands


@dataclass(frozen=True, slots=True)
class BlindSpot:
    """An effect that the measured channels cannot show.

    Attributes:
        effect: Its name.
        channels: Names of channels that were not measured and would show it, or ``command``; none where
            these runs do not excite it.
        joints: Joints or legs at which nothing shows it; empty where nothing shows it anywhere.
    """

    effect: str
    channels: tuple[str, ...]
    joints: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class MissingAt:
    """Names of channels, or ``command``, that no run has at these joints, though some has at others."""

    channels: tuple[str, ...]
    joints: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BlindSpots:
    """What runs cannot show, whatever is in them.

    Attributes:
        missing: Names of channels that no run has at any joint, or ``command``.
        effects: Effects that none of the measured channels shows, in the order of the catalogue, and then
            those that are not shown at some joints.
        at_joints: What is missing at some joints only.
        comparable: Whether the simulator has an answer to anything that was measured.
    """

    missing: tuple[str, ...]
    effects: tuple[BlindSpot, ...]
    at_joints: tuple[MissingAt, ...] = ()
    comparable: bool = True


def blind_spots(simulator: Simulator, trials: Sequence[Trial]) -> BlindSpots:
    """Say before any judgement what runs cannot show, from what each effect does to each channel.

    An effect is hidden when, by one standard deviation of what a builder of such machines expects, no
    measured channel of any run changes by more than a tenth of its noise, whether its stage is fed what was
    measured or what is predicted. Where no commands were recorded, joint angles in their place tell what
    runs with commands would show.

    Raises:
        GapError: A trial does not fit the simulator, or is too short.
    """
    runs = [look_at(simulator, trial) for trial in trials]
    commanded = [
        look_at(simulator, full) for trial in trials if (full := _with_commands(trial)) is not trial
    ]
    gaps = _gaps_of(simulator, runs, commanded)
    asked = {
        (effect.name, ""): (effect, wherever(effect, places_for(effect, simulator)))
        for effect in simulator.effects
    }
    nowhere = not_shown(simulator, runs, asked)
    at_joints = {
        (effect.name, joint): (effect, ((joint,),))
        for effect in simulator.effects
        if (effect.name, "") not in nowhere and Scope.JOINT in effect.scopes
        for joint in places_for(effect, simulator)
        if joint in gaps.at
    }
    hidden = nowhere | not_shown(simulator, runs, at_joints)
    both = asked | at_joints
    without = not_shown(simulator, commanded, {spot: both[spot] for spot in hidden})
    with_commands = hidden.keys() - without.keys() if commanded else set()
    shown_by = {
        spot: (*gaps.showing(most, spot[1]), *([COMMANDS] if spot in with_commands else []))
        for spot, most in hidden.items()
    }
    missing = (*gaps.missing, *(COMMANDS for name, joint in with_commands if not joint))
    return BlindSpots(
        tuple(dict.fromkeys(missing)),
        (
            *(
                BlindSpot(name, channels)
                for (name, joint), channels in shown_by.items()
                if not joint
            ),
            *_by_joints(shown_by),
        ),
        gaps.grouped(),
        len(nowhere) < len(asked) or any(can_be_compared(simulator, one) for one in runs),
    )


def _by_joints(shown_by: Mapping[Spot, tuple[str, ...]]) -> list[BlindSpot]:
    """Effects that are hidden at joints for want of what is missing there, each with its joints."""
    joints: defaultdict[tuple[str, tuple[str, ...]], list[str]] = defaultdict(list)
    for (name, joint), channels in shown_by.items():
        if joint and channels:
            joints[name, channels].append(joint)
    return [BlindSpot(name, channels, tuple(at)) for (name, channels), at in joints.items()]


@dataclass(frozen=True, slots=True, eq=False)
class _Gaps:
    """What no run measured.

    Attributes:
        labels: Of each channel its name, or ``command`` if it only lacks commands.
        measured: Which channels some run has, (C,).
        missing: Labels of those that no run has at any joint.
        at: Labels of what is missing at each joint, and not at all of them.
    """

    labels: tuple[str, ...]
    measured: BoolArray
    missing: tuple[str, ...]
    at: dict[str, tuple[str, ...]]

    def showing(self, most: FloatArray, joint: str) -> tuple[str, ...]:
        """Return names of channels that are missing and would show what changes them by so much, (C,).

        Those that surely would; if there are none, those that would in long runs. ``joint`` is where it is,
        empty for wherever that may be.
        """
        names = [*self.missing, *self.at.get(joint, ())]
        ours = ~self.measured & np.isin(self.labels, names) & (np.array(self.labels) != COMMANDS)
        on = ours & (most > STRONG)
        on = on if on.any() else ours & (most > BLIND)
        return tuple(dict.fromkeys(self.labels[i] for i in np.flatnonzero(on)))

    def grouped(self) -> tuple[MissingAt, ...]:
        """Return what is missing at some joints, those with the same together."""
        joints: defaultdict[tuple[str, ...], list[str]] = defaultdict(list)
        for joint, labels in self.at.items():
            joints[labels].append(joint)
        return tuple(MissingAt(labels, tuple(at)) for labels, at in joints.items())


def _gaps_of(
    simulator: Simulator, runs: Sequence[ObservedRun], commanded: Sequence[ObservedRun]
) -> _Gaps:
    channels = simulator.channels
    measured = np.any([one.measured for one in runs], axis=0)
    full = np.any([measured, *(one.measured for one in commanded)], axis=0)
    labels = tuple(
        COMMANDS if more and not own else channel.name
        for channel, own, more in zip(channels, measured, full, strict=True)
    )
    somewhere = {channel.name for channel, own in zip(channels, measured, strict=True) if own}
    missing, at = [], defaultdict(list)
    for channel, label, own in zip(channels, labels, measured, strict=True):
        if own:
            continue
        if channel.name in somewhere:
            at[channel.joint].append(label)
        else:
            missing.append(label)
    joints = {joint: tuple(dict.fromkeys(own)) for joint, own in at.items()}
    return _Gaps(labels, measured, tuple(dict.fromkeys(missing)), joints)


def _with_commands(trial: Trial) -> Trial:
    """The trial with joint angles for the commands of joints that have none; itself if all have some."""
    without = ~np.isfinite(trial.command_rad).any(axis=0)
    read = np.isfinite(trial.shaft_rad).any(axis=0)
    if not (without & read).any():
        return trial
    return replace(trial, command_rad=np.where(without, trial.shaft_rad, trial.command_rad))
