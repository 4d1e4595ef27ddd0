"""References in units of what the other references predict, to compare a gap with."""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from gap.constants import SAME_FREQUENCY
from gap.interfaces import Channel
from gap.residuals.evidence import Evidence, mean_energy
from gap.residuals.floor import make_floor
from gap.residuals.part_error import PartError
from gap.residuals.parts import RunCondition, TrialPart, block_starts
from gap.residuals.same_day import same_day
from gap.residuals.unrepeated import unrepeated
from gap.residuals.whitening import Whitener, make_whitener
from model.values.arrays import FloatArray, IntArray

SAME_CONDITION, NEW_FREQUENCY, NEW_GAIT = 0, 1, 2  # how far two conditions are apart
FEWEST_OTHERS = 2


@dataclass(frozen=True, slots=True, eq=False)
class WhitenedRun:
    """One run in units of what is expected of it.

    Attributes:
        residual: Whitened, (F, C).
        blocks: First frame of each block.
    """

    part: TrialPart
    residual: FloatArray
    blocks: IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Healthy(WhitenedRun):
    """One reference in units of what the others predict.

    Attributes:
        whitener: The map into these units.
        excess: Energy over expectation of each channel, (C,); NaN where unused.
        unrepeated: What is another in each cycle (``gap.residuals.unrepeated``), (C,).
    """

    whitener: Whitener
    excess: FloatArray
    unrepeated: FloatArray

    def scaled(self, factor: FloatArray) -> "Healthy":
        """Return it in units of an expectation whose variance is ``factor``, (C,), times as large."""
        whitener = replace(self.whitener, gain=self.whitener.gain / np.sqrt(factor))
        return replace(
            self,
            whitener=whitener,
            residual=self.residual / np.sqrt(factor),
            excess=self.excess / factor,
            unrepeated=self.unrepeated / factor,
        )


def healthy_runs(
    channels: Sequence[Channel],
    references: Sequence[PartError],
    conditions: Sequence[RunCondition] = (),
    share: float = 1.0,
) -> tuple[Healthy, ...]:
    """Compare each reference with others that are as far from it as they are from the trials.

    Where a trial has a gait or a frequency that no reference has, each reference is predicted by those of
    other gaits or frequencies alone: so what is not known there is measured and not assumed.

    Args:
        channels: C of them.
        references: What the simulator leaves of each.
        conditions: Those of the trials.
        share: Of each run, from its start, that the trials are fitted to: energies are of that much of a
            reference, because a machine that starts walking shows more than one that walks.
    """
    if len(references) < 2:
        return ()
    own = [one.part.condition for one in references]
    distance = farthest(conditions, own)
    each = []
    for i, one in enumerate(references):
        part, error = one.part, one.error
        # runs of its own day differ from a trial's as it does itself
        rest = [k for k, r in enumerate(references) if k != i and not same_day(part, r.part)]
        rest = rest or [k for k in range(len(references)) if k != i]
        others = [references[k] for k in rest if apart(own[i], own[k]) >= distance]
        if len(others) < FEWEST_OTHERS:
            others = [references[k] for k in rest]
        floor = make_floor(channels, others, ())
        base = np.where(np.isfinite(error), 0.0, np.nan)
        whitener = make_whitener(part, floor, base)
        residual = whitener.whiten(error)
        fitted = slice(0, max(1, round(share * part.frames)))
        excess = mean_energy(
            (residual[fitted] ** 2).sum(axis=0), whitener.count[fitted].sum(axis=0)
        )
        blocks, another = block_starts(part.observation), unrepeated(part, residual[fitted])
        each.append(Healthy(part, residual, blocks, whitener, excess, another))
    return tuple(each)


def whitened_runs(evidence: Evidence, residual: FloatArray) -> tuple[WhitenedRun, ...]:
    """Return each run of some evidence with what is left of it, whitened, (F, C)."""
    edges = np.cumsum([part.frames for part in evidence.parts])[:-1]
    return tuple(
        WhitenedRun(part, own, block_starts(part.observation))
        for part, own in zip(evidence.parts, np.split(residual, edges), strict=True)
    )


def apart(a: RunCondition, b: RunCondition) -> int:
    """Return how far two conditions are apart: the same, another frequency, another gait."""
    if a.gait != b.gait:
        return NEW_GAIT
    return SAME_CONDITION if abs(a.log_ratio(b)) < SAME_FREQUENCY else NEW_FREQUENCY


def nearest(one: RunCondition, known: Sequence[RunCondition]) -> int:
    """Return how far a condition is from the nearest of those that are known."""
    return min(apart(one, other) for other in known)


def farthest(some: Sequence[RunCondition], known: Sequence[RunCondition]) -> int:
    """Return how far any of some conditions is from the nearest of those that are known."""
    return max((nearest(one, known) for one in some), default=SAME_CONDITION)


def laid_over(part: TrialPart, run: WhitenedRun) -> FloatArray:
    """Lay another run over a part of a trial, cycle by cycle, and over again where it is shorter, (F, C).

    So it can be held against what a cause would change in the trial.
    """
    edges = np.append(block_starts(part.observation), part.frames)
    starts = run.blocks
    ends = np.append(starts[1:], run.part.frames)
    frames = np.empty(part.frames, dtype=np.int64)
    for number, (first, last) in enumerate(itertools.pairwise(edges)):
        block = number % len(starts)
        size, count = ends[block] - starts[block], last - first
        frames[first:last] = starts[block] + np.arange(count) * size // count
    return np.asarray(run.residual[frames])
