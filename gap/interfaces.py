"""What a simulator, its catalogue of effects and the engine of the diagnosis know of each other.

The engine (detection, selection, probabilities, report) sees a machine only through ``Simulator``;
BigANT's chain, the servo bench and the sliding body are simulators, and so is a lab's own
(``gap.machine_kinds`` says how it gets in). Names of stages and effects are those that reports print.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Protocol

import numpy as np

from model.effects.causes import Cause, Effect, Parameter, Scope, check_cause
from model.errors import GapError
from model.values.arrays import BoolArray, FloatArray
from record.trial.trial import Trial

__all__ = (
    "NOWHERE", "Cause", "Channel", "DataFault", "Drive", "Effect", "Observation", "Parameter", "Proposal",
    "Scope", "Simulator", "check_causes", "place_words", "reach_of", "used",
)  # fmt: skip

NOWHERE = (math.nan, math.nan)  # between which places: not known


class Drive(Enum):
    """What feeds the stages of a simulator."""

    # each stage is fed what was measured before it: residuals are local to a stage
    MEASURED = "measured"
    # the commands alone; every stage is fed by the one before: the end-to-end gap
    COMMAND = "command"


def place_words(effect: str, joints: Sequence[str]) -> str:
    """Name a cause with its place."""
    return f"{effect} at {', '.join(joints)}" if joints else effect


@dataclass(frozen=True, slots=True)
class Channel:
    """One measured quantity as the diagnosis compares it.

    Attributes:
        name: As reports print it, for example ``force_z`` or ``body_vx``.
        joint: Joint or leg; empty for the body.
        stage: The stage whose output it is.
        unit: Of its values.
        lasting: Whether it is no signal, but something that lasts, read once in each window of a run: what
            a simulator has wrong of it is alike at all frequencies of a gait.
        trapped: Whether what it shows at a phase depends on what was before, as forces that feet which
            stick hold against each other: healthy runs may agree on it, and a changed machine has another.
    """

    name: str
    joint: str
    stage: str
    unit: str
    lasting: bool = False
    trapped: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """What was measured in one trial, on a simulator's channels and on its own grid of F frames.

    Attributes:
        time_s: Seconds from the start of the trial, (F,).
        cycle: Cycles of the gait (or excitation), continuous, (F,); NaN if none. Equal parts of a cycle are
            equal phases, wherever in it a run begins.
        values: (F, C) in the order of ``Simulator.channels``; NaN where nothing was measured.
        noise: Standard deviation of a value from the sensors alone, after every filter, (F, C).
        weight: 0 to 1, (F, C): less where the simulator cannot be held to it (a contact switch).
        reach_m: Between which places along the world's x the machine touched its world; NaN if unknown.
    """

    time_s: FloatArray
    cycle: FloatArray
    values: FloatArray
    noise: FloatArray
    weight: FloatArray
    reach_m: tuple[float, float] = NOWHERE


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A run that could be made.

    Attributes:
        name: What to do, in words.
        trial: Its commands; nothing measured.
        limits: What to mind, in words; empty if nothing.
        known: What is done to the machine on purpose, such as a weight put on it.
        command: Command line that makes it; empty if there is none.
        unseen: Names of channels that it would not measure.
    """

    name: str
    trial: Trial
    minutes: float
    limits: str
    known: tuple[Cause, ...] = ()
    command: str = ""
    unseen: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class DataFault:
    """Something wrong with the data, before any physics is blamed.

    Attributes:
        kind: ``unit``, ``sign``, ``wrap``, ``magnitude_only``, ``swapped``, ``frozen``, ``spikes``,
            ``gap``, ``clock_offset``, ``saturated`` or ``other_machine``.
        channel: Column of the trial table, or a group such as ``body``.
        evidence: One sentence with figures.
        severe: Whether what follows cannot be trusted until it is fixed.
        share: Of the samples, that it concerns; None where they are not counted.
    """

    kind: str
    channel: str
    evidence: str
    severe: bool
    share: float | None = None


class Simulator(Protocol):
    """A simulator under diagnosis, pure: the same arguments always give the same answer."""

    @property
    def name(self) -> str:
        """Name, for example ``legged``."""

    @property
    def stages(self) -> tuple[str, ...]:
        """Names of the stages in the order of the chain."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of joints or legs."""

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the rigid bodies that effects can touch one of; empty if there are none."""

    @property
    def effects(self) -> tuple[Effect, ...]:
        """The catalogue: every effect that the simulator can add to itself."""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """What is compared, C channels. The same for both drives."""

    def observe(self, trial: Trial) -> Observation:
        """Put the measured data of a trial on the simulator's channels and grid.

        Filters and decimation here are exactly those of ``predict``.
        """

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Return what the channels would read with these causes added, (F, C); NaN where unknown.

        Effects of the sensing stage act on what is predicted, so that the data are never altered.

        Raises:
            GapError: A cause is not of the catalogue, or its joints or values do not fit.
        """

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Look for faults of the data themselves."""


def places_for(effect: Effect, simulator: Simulator) -> tuple[str, ...]:
    """Return the joints or legs, whichever an effect of single ones touches, by name."""
    return effect.parts or simulator.joints


def reach_of(observations: Sequence[Observation]) -> tuple[float, float]:
    """Return between which places all of them together touched their world; NaN if none knows."""
    known = [one.reach_m for one in observations if all(map(math.isfinite, one.reach_m))]
    if not known:
        return NOWHERE
    return (min(low for low, _ in known), max(high for _, high in known))


def used(observation: Observation) -> BoolArray:
    """Return which values take part in the comparison, (F, C)."""
    return np.asarray((observation.weight > 0.0) & np.isfinite(observation.values))


def check_causes(causes: Sequence[Cause], simulator: Simulator, part: str = "joint") -> None:
    """Check causes against a simulator's catalogue; ``part`` is what its joints are called in messages.

    Raises:
        GapError: A cause is not of the catalogue, or its joints or values do not fit.
    """
    known = {effect.name: effect for effect in simulator.effects}
    for cause in causes:
        if cause.effect not in known:
            names = ", ".join(known) or "none"
            raise GapError(f"{cause.effect!r} is no effect of {simulator.name}; known are {names}")
        effect = known[cause.effect]
        check_cause(cause, effect, places_for(effect, simulator), part)
