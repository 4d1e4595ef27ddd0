"""What a set of effects can do at best by itself: fitted by least squares, judged on held-out runs.

The diagnosis names causes; this asks the other way round how far a given explanation would have come
(a delay alone, an offset alone). It shares with the diagnosis the simulator and which runs are held out,
and nothing else: no prior, no floor, no selection.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gap.diagnosis.comparison.how_far import ChannelRms, channel_rms
from gap.interfaces import Cause, Drive, Scope, Simulator, places_for
from gap.residuals.evidence import errors, judging_drive, local_drive
from gap.residuals.hold_out import HoldOut
from gap.residuals.part_error import rms
from gap.residuals.parts import TrialPart, block_starts, split
from gap.residuals.predictions import Misfit, Predictor
from gap.search.candidates import Candidate
from gap.search.fit import Rules, fit_causes, free_values, moved
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial

SEED = 0  # of the intervals
STARTS = (0.5, 2.0, -0.5)  # in spreads from neutral
MOST_STEPS = 20
RULES = Rules((1.0,) * 6, 1e-3, 0.1, 1.0, 0.0, 1e-8, prior=False, difference=0.001)


@dataclass(frozen=True, slots=True)
class Alone:
    """A set of effects by itself, with the values that fit best, and every channel that was compared."""

    effects: tuple[str, ...]
    causes: tuple[Cause, ...]
    channels: tuple[ChannelRms, ...]


@dataclass(frozen=True, eq=False)
class _Squares(Misfit):
    """Measured minus predicted end to end, on the scale of what the unchanged simulator leaves."""

    parts: tuple[TrialPart, ...]

    @cached_property
    def scale(self) -> FloatArray:
        """RMS of each channel, (C,); NaN where nothing is compared, and of what only references tell."""
        size = rms(np.concatenate(self.errors(())))
        lasting = [channel.lasting for channel in self.simulator.channels]
        return np.where((size > 0) & ~np.array(lasting), size, np.nan)

    def errors(self, causes: tuple[Cause, ...]) -> list[FloatArray]:
        """Measured minus predicted, (F, C) a part; NaN where nothing is compared."""
        return errors(self.predictor, self.parts, Drive.COMMAND, causes)

    def residuals(self, sets: Sequence[tuple[Cause, ...]]) -> list[FloatArray]:
        return [np.nan_to_num(np.concatenate(self.errors(one)) / self.scale) for one in sets]


def each_alone(
    trials: Sequence[Trial],
    simulator: Simulator,
    sets: Sequence[tuple[str, ...]],
    progress: Callable[[str, float], None] | None = None,
    hold_out: HoldOut | None = None,
) -> tuple[Alone, ...]:
    """Fit sets of effects, each by itself.

    Args:
        trials: Measured runs of one machine.
        simulator: Its simulator.
        sets: Names of effects that act together; a set of one is an effect alone.
        progress: Gets the set at work and the share that is done.
        hold_out: Which of the trials judge; None holds out evenly.

    Raises:
        GapError: An effect is not of the catalogue, runs have no commands, or nothing can be compared.
    """
    fitted, held = split(simulator, trials, hold_out)
    predictor = Predictor(simulator, trials)
    if (
        judging_drive(predictor, (*fitted, *held), lambda: local_drive(predictor, fitted))
        is not Drive.COMMAND
    ):
        raise GapError(
            "these runs have no commands, and effects by themselves are fitted end to end, from commands "
            "alone; bigant gap diagnose without --alone feeds each stage what was measured"
        )
    squares, judge = _Squares(predictor, fitted), _Squares(predictor, held)
    if not np.isfinite(squares.scale).any():
        raise GapError("no measured channel can be compared with the simulator; check the columns")
    out = []
    for number, names in enumerate(sets):
        if progress is not None:
            progress("+".join(names), number / len(sets))
        causes = _fit(squares, _causes(simulator, names))
        out.append(Alone(tuple(names), causes, _channels(judge, causes)))
    return tuple(out)


def _causes(simulator: Simulator, names: Sequence[str]) -> tuple[Cause, ...]:
    effects = {effect.name: effect for effect in simulator.effects}
    causes: list[Cause] = []
    for name in names:
        if name not in effects:
            known = ", ".join(effects)
            raise GapError(f"{name!r} is no effect that fits these trials; there are {known}")
        whole = Scope.ALL in effects[name].scopes
        places = [()] if whole else [(one,) for one in places_for(effects[name], simulator)]
        neutral = Candidate(effects[name], ()).neutral
        causes += [Cause(name, place, neutral) for place in places]
    return tuple(causes)


def _fit(squares: _Squares, causes: tuple[Cause, ...]) -> tuple[Cause, ...]:
    """The best of fits from several starts."""
    free = free_values(causes, squares.effects)
    begin = [moved(causes, free, [start] * len(free)) for start in STARTS]
    fits = [fit_causes(squares, one, MOST_STEPS, RULES) for one in begin]
    return min(fits, key=lambda one: one.nats).causes


def _channels(judge: _Squares, causes: tuple[Cause, ...]) -> tuple[ChannelRms, ...]:
    """Every channel before and after, over the blocks of the held-out runs."""
    energies: list[list[FloatArray]] = [[], [], []]
    pairs = zip(judge.parts, judge.errors(()), judge.errors(causes), strict=True)
    for part, before, after in pairs:
        known = np.isfinite(before) & np.isfinite(after)
        rows = (np.where(known, before, 0.0) ** 2, np.where(known, after, 0.0) ** 2, known * 1.0)
        for kept, one in zip(energies, rows, strict=True):
            kept.append(np.add.reduceat(one, block_starts(part.observation), axis=0))
    before, after, weight = (np.concatenate(kept) for kept in energies)
    channels = judge.simulator.channels
    return tuple(row for _, row in channel_rms(channels, before, after, weight, SEED))
