"""Trials and references on a simulator's channels: what is fitted, what judges, and what is expected.

Assembled once, and completed by ``gap.diagnosis.comparison.commissioning``, which everything that measures
a gap uses. A drive's baseline (noise, repeatability, the references' misfit) is measured when it is first
asked for.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from gap.constants import ASSUMED_MISFIT, MOST_INFLATION
from gap.interfaces import Cause, Drive, Simulator
from gap.residuals.at_once import meanwhile
from gap.residuals.evidence import (
    Evidence,
    errors,
    evidence_of,
    judging_drive,
    local_drive,
    make_evidence,
)
from gap.residuals.floor import (
    ENOUGH_REFERENCES,
    Floor,
    make_floor,
    with_starting,
    without_drift,
)
from gap.residuals.healthy import Healthy, farthest, healthy_runs, nearest
from gap.residuals.hold_out import HoldOut
from gap.residuals.hunting import Hunting, hunting_of, without_hunting
from gap.residuals.motions import in_motion, motions_of
from gap.residuals.part_error import PartError, rms
from gap.residuals.parts import TrialPart, split, whole_parts
from gap.residuals.predictions import Predictor, PredictsElsewhere
from gap.residuals.same_day import with_days
from gap.residuals.vibration import ChannelVibration, vibration_of
from model.errors import GapError
from model.values.arrays import BoolArray
from record.trial.trial import Trial


@dataclass(frozen=True, slots=True)
class Exchange:
    """Trials that changed places: one that judged is fitted to, and one that was fitted to judges."""

    fitted: int
    held: int


@dataclass(frozen=True)
class Study:
    """What a diagnosis works on.

    Attributes:
        predictor: Predicts trials and references, with the baseline model errors already in it.
        fitted: Parts that are fitted to.
        held: Parts that are held out to judge.
        references: Whole runs of the same machine assumed healthy.
        evenly: Whether a rule chose the runs that judge, and no person.
        exchange: Which changed places, None if none did.
        hunting: Joints that hunt in the trials; the parts do not count where they do.
    """

    predictor: Predictor
    fitted: tuple[TrialPart, ...]
    held: tuple[TrialPart, ...] = ()
    references: tuple[TrialPart, ...] = ()
    evenly: bool = True
    exchange: Exchange | None = None
    hunting: tuple[Hunting, ...] = ()
    _vibrating: Callable[[], dict[str, ChannelVibration]] | None = None
    _baselines: dict[Drive, tuple[Floor, tuple[Healthy, ...]]] = field(default_factory=dict)

    @property
    def simulator(self) -> Simulator:
        """The simulator under diagnosis."""
        return self.predictor.simulator

    @property
    def trials(self) -> tuple[Trial, ...]:
        """The trials without the references."""
        return self.predictor.trials[: len(self.predictor.trials) - len(self.references)]

    @property
    def fitted_share(self) -> float:
        """Share of each trial, from its start, that is fitted to; 1 where whole trials judge."""
        ends = {part.trial: part.last for part in self.held}
        return min([1.0, *(p.last / ends[p.trial] for p in self.fitted if p.trial in ends)])

    @cached_property
    def local(self) -> Drive:
        """What feeds the stages where each is compared by itself."""
        return local_drive(self.predictor, self.fitted or self.references)

    @cached_property
    def judging(self) -> Drive:
        """What feeds the stages of the runs that judge: commands, unless some run has none."""
        parts = (*self.fitted, *self.held, *self.references)
        return judging_drive(self.predictor, parts, lambda: self.local)

    @property
    def cut(self) -> bool:
        """Whether trials were cut to have something to judge by: then no whole run is held out."""
        return bool({part.trial for part in self.fitted} & {part.trial for part in self.held})

    @property
    def calibrated(self) -> bool:
        """Whether references say how much healthy runs differ.

        Three do. Two do for two trials or more, which tell their own scatter, if both measured whatever the
        trials did: a channel that one of them lacks is compared with nothing.
        """
        if len(self.references) >= ENOUGH_REFERENCES:
            return True
        if len(self.references) < 2 or len(self.trials) < 2:
            return False
        asked = np.any([_measured(part) for part in (*self.fitted, *self.held)], axis=0)
        both = np.all([_measured(part) for part in self.references], axis=0)
        return bool(np.all(both | ~asked))

    @property
    def vibrations(self) -> dict[str, ChannelVibration]:
        """What vibrates in the trials more than in references, by the name of the effect that would."""
        if self._vibrating is not None:
            return self._vibrating()
        return _vibrations(self.simulator, (*self.fitted, *self.held), self.references)

    def with_standing(self, causes: tuple[Cause, ...]) -> "Study":
        """Return the study of a simulator that has these causes in every prediction."""
        return replace(self, predictor=self.predictor.with_standing(causes), _baselines={})

    def of(self, simulator: Simulator) -> "Study":
        """Return the study of another simulator of the same channels, with the same causes in it."""
        known = self.predictor
        predictor = Predictor(simulator, known.trials, standing=known.standing)
        return replace(self, predictor=predictor, _baselines={})

    def exchanged(self, exchange: Exchange) -> "Study":
        """Return the study in which two trials have changed places."""
        parts = {part.trial: part for part in (*self.fitted, *self.held)}
        other = {exchange.held: exchange.fitted, exchange.fitted: exchange.held}
        fitted, held = (
            tuple(parts[other.get(part.trial, part.trial)] for part in own)
            for own in (self.fitted, self.held)
        )
        return replace(self, fitted=fitted, held=held, exchange=exchange, _baselines={})

    def floor(self, drive: Drive) -> Floor:
        """Return noise and expected misfit under a drive."""
        return self._baseline(drive)[0]

    def healthy_runs(self, drive: Drive) -> tuple[Healthy, ...]:
        """Return each reference in units of what the others predict; none for fewer than two."""
        return self._baseline(drive)[1]

    def evidence(self, drive: Drive) -> Evidence:
        """Return what is fitted to."""
        return make_evidence(self.predictor, self.fitted, drive, self.floor(drive))

    def loose_evidence(self, drive: Drive) -> Evidence:
        """Return what is fitted to where no reference shows the misfit that is to be expected.

        A share of the misfit there is counts as expected. Against sensor noise alone any model of a real
        machine is wrong everywhere, and the score would only care for the few blocks that can be made
        perfect.
        """
        floor = self.floor(drive)
        left = errors(self.predictor, self.fitted, drive)
        steady = [without_drift(part, one) for part, one in zip(self.fitted, left, strict=True)]
        misfit = rms(np.concatenate(steady))
        floor = replace(floor, sigma=np.fmax(floor.sigma, ASSUMED_MISFIT * misfit))
        return make_evidence(self.predictor, self.fitted, drive, floor)

    def held_evidence(self, drive: Drive | None = None) -> Evidence:
        """Return what judges under a drive; None for ``judging``."""
        drive = self.judging if drive is None else drive
        return make_evidence(self.predictor, self.held, drive, self.floor(drive))

    def whole_held(self, drive: Drive) -> Evidence | None:
        """Return the trials that are held out whole, as those that are fitted to; None without any.

        None of them is farther from all references, in gait and frequency, than those that are fitted to.
        """
        known = [one.condition for one in self.references]
        fitted = {one.trial for one in self.fitted}
        most = farthest([one.condition for one in self.fitted], known)
        parts = [
            one
            for one in self.held
            if one.trial not in fitted and nearest(one.condition, known) <= most
        ]
        return make_evidence(self.predictor, parts, drive, self.floor(drive)) if parts else None

    def healthy_evidence(self, drive: Drive) -> Evidence | None:
        """Return the references in the same units; None for too few."""
        if not self.calibrated:
            return None
        runs = self.healthy_runs(drive)
        whiteners = [one.whitener for one in runs]
        return evidence_of(self.predictor, self.references, drive, self.floor(drive), whiteners)

    def _baseline(self, drive: Drive) -> tuple[Floor, tuple[Healthy, ...]]:
        if drive not in self._baselines:
            self._baselines[drive] = self._measure(drive)
        return self._baselines[drive]

    def _left(self, parts: Sequence[TrialPart], drive: Drive) -> list[PartError]:
        left = errors(self.predictor, parts, drive)
        return [PartError(part, one) for part, one in zip(parts, left, strict=True)]

    def _measure(self, drive: Drive) -> tuple[Floor, tuple[Healthy, ...]]:
        """Where references predict each other worse than the floor has it, it is raised."""
        channels = self.simulator.channels
        known = with_starting(channels, self._left(self.references, drive))
        own = self._left(self.fitted, drive)
        floor = make_floor(channels, known, own)
        conditions = [part.condition for part in self.fitted]
        healthy = healthy_runs(channels, known, conditions, self.fitted_share)
        if not healthy:
            return floor, healthy
        excess = np.array([one.excess for one in healthy])
        factor = np.ones(len(channels))
        names = [channel.name for channel in channels]
        for name in set(names):
            on = np.array([one == name for one in names])
            seen = excess[:, on][np.isfinite(excess[:, on])]
            if len(seen):
                factor[on] = np.clip(np.mean(seen), 1.0, MOST_INFLATION)
        raised = replace(
            floor,
            sigma=floor.sigma * np.sqrt(factor),
            power=floor.power * factor,
            noise=floor.noise * factor,
        )
        return raised, tuple(one.scaled(factor) for one in healthy)


def _measured(part: TrialPart) -> BoolArray:
    """Which channels a run measured, (C,)."""
    return np.asarray((part.observation.weight > 0.0).any(axis=0))


def make_study(
    trials: Sequence[Trial],
    simulator: Simulator,
    references: Sequence[Trial] = (),
    elsewhere: PredictsElsewhere | None = None,
    hold_out: HoldOut | None = None,
) -> Study:
    """Observe trials and references, and hold some of the trials out; arguments as of ``diagnose``.

    The simulator is as it is, without baseline model errors: ``commissioned_study`` adds them.
    ``hold_out`` says which of them judge; None holds out evenly.

    Raises:
        GapError: There are no trials, or one cannot be compared with the simulator.
    """
    if not trials:
        raise GapError("there is no trial to diagnose; give at least one")
    fitted, held = split(simulator, trials, hold_out)
    known = whole_parts(simulator, references, len(trials))
    motions = motions_of(known, references, (*fitted, *held))
    fitted, held, known = (in_motion(motions, parts) for parts in (fitted, held, known))
    fitted, held, known = with_days((fitted, held), known)
    predictor = Predictor(simulator, (*trials, *references), elsewhere)
    find = partial(_vibrations, simulator, (*fitted, *held), known)
    vibrating = meanwhile(find, predictor.at_once)
    hunting, fitted, held = _hunting(simulator, trials, references, fitted, held)
    return Study(predictor, fitted, held, known, hold_out is None, None, hunting, vibrating)


def _hunting(
    simulator: Simulator,
    trials: Sequence[Trial],
    references: Sequence[Trial],
    fitted: tuple[TrialPart, ...],
    held: tuple[TrialPart, ...],
) -> tuple[tuple[Hunting, ...], tuple[TrialPart, ...], tuple[TrialPart, ...]]:
    """Joints that hunt, if an effect says what they then read, and the parts without that."""
    hidden = {effect.hunts for effect in simulator.effects if effect.hunts}
    hunting = hunting_of(trials, references) if hidden else ()
    if not hunting:
        return (), fitted, held
    calm = partial(without_hunting, simulator.channels, hidden, trials, hunting=hunting)
    return hunting, calm(fitted), calm(held)


def _vibrations(
    simulator: Simulator, parts: Sequence[TrialPart], references: Sequence[TrialPart]
) -> dict[str, ChannelVibration]:
    every = {
        effect.name: vibration_of(effect.shaking, simulator.channels, parts, references)
        for effect in simulator.effects
        if effect.shaking
    }
    return {name: one for name, one in every.items() if one is not None}
