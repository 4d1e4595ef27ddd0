"""Whether there is a gap above what references show, and what size of a cause would have shown.

Energies of the trials are compared with those of references by Student's t. The size that would have shown
comes from a null of synthetic runs: each reference in units of what the others predict is cut into
blocks, blocks are laid over the trials with random signs, and the largest first-order gain of any candidate
on them (all weights 1, no bounds) is what a cause must exceed.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy import stats

from gap.interfaces import Channel
from gap.residuals.evidence import Evidence, mean_energy
from gap.residuals.floor import make_floor
from gap.residuals.parts import RunCondition, TrialPart, block_starts
from gap.residuals.whitening import Whitener, make_whitener
from gap.search.screen import Signature, Signatures, plain_gains
from model.values.arrays import FloatArray, IntArray

BATCHES = (50, 50, 50, 49)  # synthetic sets, so many at a time
# As a cause must stand out (gap.search.selection.CAUSE_LEVEL) in one of three tests.
GAP_LEVEL = 0.003
TESTS = 3
SAME_CONDITION, NEW_FREQUENCY, NEW_GAIT = 0, 1, 2  # how far two conditions are apart
SAME_FREQUENCY = 0.08  # natural log
FEWEST_OTHERS = 2
CHANNELS_APART = 6  # channels of one run that count as independent when their scatter is pooled
LEAST_SCATTER = 0.05  # of a mean logarithm between runs


@dataclass(frozen=True, slots=True, eq=False)
class Healthy:
    """One reference in units of what the others predict.

    Attributes:
        whitener: The map into these units.
        residual: Whitened, (F, C).
        excess: Energy over expectation of each channel, (C,); NaN where unused.
        blocks: First frame of each block.
    """

    part: TrialPart
    whitener: Whitener
    residual: FloatArray
    excess: FloatArray
    blocks: IntArray

    def scaled(self, factor: FloatArray) -> "Healthy":
        """Return it in units of an expectation whose variance is ``factor``, (C,), times as large."""
        whitener = replace(self.whitener, gain=self.whitener.gain / np.sqrt(factor))
        residual, excess = self.residual / np.sqrt(factor), self.excess / factor
        return replace(self, whitener=whitener, residual=residual, excess=excess)


@dataclass(frozen=True, slots=True)
class Detectable:
    """Smallest size of a parameter that would have shown.

    Attributes:
        size: Distance from neutral, in the parameter's unit; infinite if these runs cannot show it.
        neutral: Value at which nothing happens.
        lower: Smallest value that makes sense.
        upper: Largest value that makes sense.
    """

    effect: str
    parameter: str
    size: float
    unit: str
    neutral: float
    lower: float
    upper: float

    @property
    def values(self) -> tuple[float, ...]:
        """The values at that distance that make sense, the lower one first; none if it is out of range."""
        both = (self.neutral - self.size, self.neutral + self.size)
        return tuple(value for value in both if self.lower <= value <= self.upper)


@dataclass(frozen=True, slots=True)
class Detection:
    """Whether there is a gap.

    Attributes:
        p: Chance of so much without one; NaN without references.
        p_cause: The same by the best candidate alone, among all that were tried.
        p_energy: By the mean energy alone.
        p_channel: By the worst channel alone.
        threshold: Gain [nats] that no candidate exceeds on healthy runs; sizes that would have shown are
            computed from it.
    """

    each: bool
    p: float
    p_cause: float
    p_energy: float
    p_channel: float
    threshold: float

    @property
    def by_energy(self) -> bool:
        """Whether energies alone show a gap, whatever the candidates."""
        return TESTS * min(self.p_energy, self.p_channel) < GAP_LEVEL


def healthy_runs(
    channels: Sequence[Channel],
    references: Sequence[tuple[TrialPart, FloatArray]],
    conditions: Sequence[RunCondition] = (),
) -> tuple[Healthy, ...]:
    """Compare each reference with others that are as far from it as they are from the trials.

    Where a trial has a gait or a frequency that no reference has, each reference is predicted by those of
    other gaits or frequencies alone: so what is not known there is measured and not assumed.

    Args:
        channels: C of them.
        references: Each with measured minus predicted, (F, C).
        conditions: Those of the trials.
    """
    if len(references) < 2:
        return ()
    own = [part.condition for part, _ in references]
    distance = max((_distance(one, own) for one in conditions), default=SAME_CONDITION)
    each = []
    for i, (part, error) in enumerate(references):
        others = [
            r for k, r in enumerate(references) if k != i and _apart(own[i], own[k]) >= distance
        ]
        if len(others) < FEWEST_OTHERS:
            others = [*references[:i], *references[i + 1 :]]
        floor = make_floor(channels, others, ())
        base = np.where(np.isfinite(error), 0.0, np.nan)
        whitener = make_whitener(part, floor, base)
        residual = whitener.whiten(error)
        excess = mean_energy((residual**2).sum(axis=0), whitener.count.sum(axis=0))
        each.append(Healthy(part, whitener, residual, excess, block_starts(part.observation)))
    return tuple(each)


def _apart(a: RunCondition, b: RunCondition) -> int:
    """How far two conditions are apart: the same, another frequency, another gait."""
    if a.gait != b.gait:
        return NEW_GAIT
    return SAME_CONDITION if abs(a.log_ratio(b)) < SAME_FREQUENCY else NEW_FREQUENCY


def _distance(one: RunCondition, known: Sequence[RunCondition]) -> int:
    return min(_apart(one, other) for other in known)


def detect(
    evidence: Evidence,
    signatures: Signatures,
    healthy: Sequence[Healthy],
    p_cause: float,
    seed: int,
) -> Detection:
    """Decide with references.

    ``p_cause`` is the chance that a healthy machine shows any candidate as large as the best one.
    """
    rng = np.random.default_rng(seed)
    edges = [np.append(block_starts(p.observation), p.frames) for p in evidence.parts]
    null = np.concatenate([
        plain_gains(
            signatures,
            np.array([_synthetic(evidence, edges, healthy, rng).ravel() for _ in range(size)]),
        )
        for size in BATCHES
    ])  # fmt: skip
    p_energy, p_channel = energies(evidence, evidence.base, healthy)
    p = min(1.0, TESTS * min(p_cause, p_energy, p_channel))
    threshold = float(np.quantile(null, 1 - GAP_LEVEL / TESTS))
    return Detection(p < GAP_LEVEL, p, p_cause, p_energy, p_channel, threshold)


def _synthetic(
    evidence: Evidence,
    edges: Sequence[IntArray],
    healthy: Sequence[Healthy],
    rng: np.random.Generator,
) -> FloatArray:
    """Lay blocks of references over the trials, (F, C)."""
    rows = []
    for part, whitener, at in zip(evidence.parts, evidence.whiteners, edges, strict=True):
        same = [one for one in healthy if one.part.gait == part.gait]
        choice = same or list(healthy)
        source = choice[int(rng.integers(len(choice)))]
        sign = 1.0 if rng.random() < 0.5 else -1.0
        starts = source.blocks
        ends = np.append(starts[1:], source.part.frames)
        picks = rng.integers(len(starts), size=len(at) - 1)
        frames = np.empty(part.frames, dtype=np.int64)
        for block, first, last in zip(picks, at[:-1], at[1:], strict=True):
            size, count = ends[block] - starts[block], last - first
            frames[first:last] = starts[block] + np.arange(count) * size // count
        rows.append(sign * source.residual[frames] * (whitener.gain > 0))
    return np.concatenate(rows)


def energies(
    evidence: Evidence, residual: FloatArray, healthy: Sequence[Healthy]
) -> tuple[float, float]:
    """Chance of the mean energy and of the worst channel's, by Student's t over references.

    The residual of the trials is whitened, (F, C), with or without causes.
    """
    energy = evidence.per_block(residual**2)
    blocks = [evidence.block_part == i for i in range(len(evidence.parts))]
    trials = np.array(
        [mean_energy(energy[on].sum(axis=0), evidence.count[on].sum(axis=0)) for on in blocks]
    )
    runs = np.array([one.excess for one in healthy])
    trial_logs, run_logs = np.log(trials + 1e-9), np.log(runs + 1e-9)
    n, m = len(run_logs), len(trial_logs)
    known = np.isfinite(trial_logs).all(axis=0) & np.isfinite(run_logs).all(axis=0)
    if not known.any() or n < 2:
        return 1.0, 1.0
    trial_logs, run_logs = trial_logs[:, known], run_logs[:, known]
    mean = run_logs.mean(axis=1)
    scatter = max(float(mean.std(ddof=1)), LEAST_SCATTER)
    t = (trial_logs.mean() - mean.mean()) / (scatter * np.sqrt(1 / n + 1 / m))
    p_energy = float(stats.t.sf(t, n - 1))
    centred = run_logs - run_logs.mean(axis=0)
    width = max(float(np.sqrt((centred**2).sum() / (centred.size - known.sum()))), LEAST_SCATTER)
    worst = float(np.max(trial_logs.mean(axis=0) - run_logs.mean(axis=0)))
    free = (n - 1) * min(int(known.sum()), CHANNELS_APART)
    p_channel = float(stats.t.sf(worst / (width * np.sqrt(1 / n + 1 / m)), free))
    return p_energy, min(1.0, p_channel * int(known.sum()))


def detectable(signatures: Signatures, threshold: float) -> tuple[Detectable, ...]:
    """Return the smallest size of each effect's parameters that would have shown, at its blindest joint."""
    worst: dict[tuple[str, str], Detectable] = {}
    for one in signatures.each:
        for size in _sizes(one, signatures, max(threshold, 2.0)):
            key = (size.effect, size.parameter)
            if key not in worst or size.size > worst[key].size:
                worst[key] = size
    return tuple(worst[key] for key in sorted(worst))


def _sizes(one: Signature, signatures: Signatures, threshold: float) -> Iterator[Detectable]:
    if one.offset >= 0:
        return
    for i, row in zip(one.live, one.rows, strict=True):
        energy = float(signatures.matrix[row] @ signatures.matrix[row])
        p = one.candidate.effect.parameters[i]
        size = p.spread * float(np.sqrt(2 * threshold / energy))
        name = one.candidate.effect.name
        yield Detectable(name, p.name, size, p.unit, p.neutral, p.lower, p.upper)
