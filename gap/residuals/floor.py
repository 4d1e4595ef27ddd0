"""What differs without any new cause: noise, repeatability, and the misfit that reference runs show.

The misfit of references is described by its first harmonics in the phase of the gait, each a number that
varies smoothly over conditions (gait and frequency): what is expected at a condition, and how surely,
follows from the references near it. A condition that none of them has gets a wide expectation, not none.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.constants import (
    FEW_RATIO,
    GAIT_CORRELATION,
    LOG_FREQUENCY,
    LOW_HARMONICS,
    OWN_POWER,
    TRAPPED_RATIO,
)
from gap.interfaces import Channel
from gap.residuals.part_error import PartError, columns_alike, most_dependent, phase_basis, rms
from gap.residuals.parts import RunCondition, TrialPart
from gap.residuals.starting import Starting, starting_noise
from model.values.arrays import BoolArray, FloatArray, IntArray

STARTING_TURNS = 2  # the noise of a start is in what seems to repeat, until it is known
WHOLE_CYCLES = 2  # of a run whose cycles are compared with each other
POWERS = np.concatenate([[0.0], np.geomspace(1e-3, 1e4, 24)])  # of a misfit, in units of noise
SMALLEST = 1e-300
RATIOS = (0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0)  # repeat variance over misfit variance
ENOUGH_REFERENCES = 3  # from which their extremes say what is usual, and repeats how alike they are


@dataclass(frozen=True, slots=True, eq=False)
class ExpectedMisfit:
    """Coefficients that a condition is expected to show, and their variance, (K, C) each."""

    mean: FloatArray
    variance: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Floor:
    """Noise and expected misfit of C channels.

    Attributes:
        source: ``references``, ``cycles`` or ``sensors``.
        sigma: Standard deviation of a frame about the misfit, (C,).
        dependence: Integrated autocorrelation time in frames, (C,).
        conditions: Conditions of R references.
        coefficients: Their misfits, (R, K, C).
        power: Prior variance of a coefficient, (K, C).
        ratio: Repeat variance over ``power``, (K, C).
        lasting: Channels whose misfits are alike at all frequencies of a gait, (C,).
        noise: Variance of a coefficient by noise, (C,).
        starting: How much noisier machines are as they start; None is not at all.
    """

    source: str
    sigma: FloatArray
    dependence: FloatArray
    conditions: tuple[RunCondition, ...]
    coefficients: FloatArray
    power: FloatArray
    ratio: FloatArray
    lasting: BoolArray
    noise: FloatArray
    starting: Starting | None = None

    @property
    def compared(self) -> BoolArray:
        """Channels that are compared, (C,): what lasts only with references.

        A foot that never slips shows less than its grip, and only other runs tell how much less.
        """
        return np.asarray(~self.lasting | bool(self.conditions))

    def expect(self, condition: RunCondition) -> ExpectedMisfit:
        """Return the misfit expected at a condition."""
        count = len(self.conditions)
        if count == 0:
            empty = np.zeros((0, len(self.sigma)))
            return ExpectedMisfit(empty, empty)
        mean, variance = np.empty_like(self.power), np.empty_like(self.power)
        for lasting in np.unique(self.lasting).tolist():
            correlation = _correlation(self.conditions, self.conditions, lasting)
            near = _correlation([condition], self.conditions, lasting)[0]
            for ratio in np.unique(self.ratio[:, self.lasting == lasting]).tolist():
                on = (self.ratio == ratio) & (self.lasting == lasting)
                spread, turn = np.linalg.eigh(correlation + ratio * np.eye(count))
                power, noise = self.power[on], np.broadcast_to(self.noise, on.shape)[on]
                toward = (near @ turn)[:, None]
                share = toward * power / np.fmax(spread[:, None] * power + noise, SMALLEST)
                mean[on] = (share * (turn.T @ self.coefficients[:, on])).sum(axis=0)
                variance[on] = power * (1.0 + ratio - (share * toward).sum(axis=0))
        return ExpectedMisfit(mean, variance * (1.0 + 2.0 / count))


def make_floor(
    channels: Sequence[Channel], references: Sequence[PartError], trials: Sequence[PartError]
) -> Floor:
    """Measure the floor.

    Args:
        channels: C of them.
        references: What the simulator leaves of each reference.
        trials: Of the trials to fit to; their own scatter counts if there is no reference.
    """
    known = references or [
        PartError(one.part, without_drift(one.part, one.error)) for one in trials
    ]
    noise = np.median([one.noise for one in known], axis=0)
    # a run alone does not tell what of a motion it would repeat
    widths = [one.measurable if references or not one.part.once else 1 for one in known]
    if references:
        widths = [min(widths)] * len(known)
    fits = [one.repeating(width) for one, width in zip(known, widths, strict=True)]
    dependence, c = np.median([fit.dependence for fit in fits], axis=0), len(channels)
    lasting = np.array([channel.lasting for channel in channels])
    # frames of a window are all alike, also where windows are, too
    longest = np.median([most_dependent(one.part.frames) for one in known])
    dependence = np.where(lasting, longest, dependence)
    if not references:
        sigma = np.fmax(noise, _pooled([_scatter(one.part, one.error) for one in known]))
        source = "cycles" if max(widths) > 1 else "sensors"
        return Floor(
            source,
            sigma,
            dependence,
            (),
            np.zeros((0, 0, c)),
            np.zeros((0, c)),
            np.zeros((0, c)),
            lasting,
            np.zeros(c),
        )
    rests, coefficients = [fit.rest for fit in fits], np.array([fit.coefficients for fit in fits])
    if lasting.any():  # it has no phase: all that repeats is its mean
        means = [one.repeating(1) for one in known]
        rests = [np.where(lasting, one.rest, own) for one, own in zip(means, rests, strict=True)]
        coefficients[:, :, lasting] = 0.0
        coefficients[:, 0, lasting] = np.array([one.coefficients[0, lasting] for one in means])
    sigma = np.fmax(_pooled(rests), noise * np.ones(c))
    conditions = tuple(one.part.condition for one in references)
    frames = np.mean([one.part.frames for one in references])
    by_noise = sigma**2 * dependence / frames
    power, ratio = _spread(channels, coefficients, conditions, by_noise)
    # a misfit cannot be known better than noise lets it be measured
    least = np.tile(by_noise, (len(power), 1))
    least[1:, lasting] = 0.0
    power = np.fmax(power, least)
    return Floor(
        "references", sigma, dependence, conditions, coefficients, power, ratio, lasting, by_noise,
        references[0].starting,
    )  # fmt: skip


def with_starting(channels: Sequence[Channel], references: Sequence[PartError]) -> list[PartError]:
    """Return references with how much noisier they are as they start."""
    known = list(references)
    width = min((one.measurable for one in known), default=0)
    if width <= 1:  # what repeats is not told from the rest
        return known
    parts = [one.part for one in known]
    for _ in range(STARTING_TURNS):
        starting = starting_noise(channels, parts, [one.repeating(width).left for one in known])
        known = [PartError(one.part, one.error, starting) for one in known]
    return known


def _spread(
    channels: Sequence[Channel], coefficients: FloatArray, conditions: Sequence[RunCondition],
    noise: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Prior variance and repeat ratio of each coefficient, (K, C), by marginal likelihood.

    Variances are pooled over legs, ratios over a band of harmonics, too: what is noise, or repeats well,
    in high ones says nothing of low ones.
    """
    harmonics, c = coefficients.shape[1:]
    names = [channel.name for channel in channels]
    power, ratio = np.zeros((harmonics, c)), np.full((harmonics, c), RATIOS[-1])
    unit = np.sqrt(np.fmax(noise, SMALLEST))
    enough = len(conditions) >= ENOUGH_REFERENCES
    for channel in {one.name: one for one in channels}.values():
        own = np.flatnonzero([one == channel.name for one in names])
        correlation = _correlation(conditions, conditions, channel.lasting)
        least = TRAPPED_RATIO if channel.trapped else 0.0
        ratios = [one for one in RATIOS if one >= least] if enough else [max(FEW_RATIO, least)]
        for band in _bands(1 if channel.lasting else harmonics):
            on = np.ix_(band, own)
            seen = coefficients[:, on[0], on[1]] / unit[own]
            tried = [_likeliest(seen, correlation + one * np.eye(len(seen))) for one in ratios]
            best = int(np.argmax([nats for nats, _ in tried]))
            power[on], ratio[on] = tried[best][1] * unit[own] ** 2, ratios[best]
    return power, ratio


def _bands(columns: int) -> list[IntArray]:
    """Columns of ``phase_basis`` that share a ratio: its low harmonics, and its high ones."""
    every = np.arange(columns)
    number = (every + 1) // 2  # of the harmonic
    return [
        band
        for band in (every[number <= LOW_HARMONICS], every[number > LOW_HARMONICS])
        if len(band)
    ]


def _likeliest(seen: FloatArray, covariance: FloatArray) -> tuple[float, FloatArray]:
    """Log likelihood of R coefficients, (R, K, C), in units of noise, and the variances, (K, C).

    They are these variances times a covariance, (R, R), and noise of variance 1.
    """
    spread, turn = np.linalg.eigh(covariance)
    squares = np.einsum("ri,rkc->ikc", turn, seen) ** 2
    variances = POWERS[:, None] * spread + 1.0
    nats = -0.5 * np.einsum("ikc,gi->gkc", squares, 1.0 / variances)
    nats -= 0.5 * np.log(variances).sum(axis=1)[:, None, None]
    together = nats.sum(axis=2)
    each, pooled = POWERS[nats.argmax(axis=0)], POWERS[together.argmax(axis=0)]
    return float(together.max(axis=0).sum()), OWN_POWER * each + (1.0 - OWN_POWER) * pooled[:, None]


def _correlation(
    some: Sequence[RunCondition], others: Sequence[RunCondition], lasting: bool
) -> FloatArray:
    """Correlation of the misfits of conditions, (len(some), len(others))."""
    out = np.empty((len(some), len(others)))
    for i, a in enumerate(some):
        for j, b in enumerate(others):
            # what one motion shows at a moment says nothing of another motion
            apart = 0.0 if a.once or b.once else GAIT_CORRELATION
            same = 1.0 if a.gait == b.gait else apart
            away = 0.0 if lasting else a.log_ratio(b) / LOG_FREQUENCY
            out[i, j] = same * np.exp(-0.5 * away**2)
    return out


def without_drift(part: TrialPart, error: FloatArray) -> FloatArray:
    """Return errors, (F, C), without what grows evenly from cycle to cycle; their means stay.

    A sensor that drifts is no worse sensor, and what drifts is no misfit that any model would have. The
    slope is fitted together with the harmonics of the phase: over a few cycles an error that only repeats
    itself would else seem to have one, too. Shorter runs are returned as they are.
    """
    if not _repeats(part.observation.cycle):
        return error
    time = part.observation.time_s
    away = (time - time.mean()) / time.std()
    columns = np.column_stack([phase_basis(part), away])
    drift, known = np.zeros_like(error), np.isfinite(error)
    # channels that are known in the same frames, as most are, share a factorisation
    for alike in columns_alike(known):
        on = known[:, alike[0]]
        if on.sum() > 2 * columns.shape[1]:
            slopes = np.linalg.lstsq(columns[on], error[on][:, alike], rcond=None)[0][-1]
            drift[:, alike] = np.outer(away - away[on].mean(), slopes)
    return error - drift


def _repeats(cycle: FloatArray) -> bool:
    """Whether a phase is known all along, goes forward, and returns often enough to compare cycles."""
    whole = bool(np.isfinite(cycle).all()) and abs(cycle[-1] - cycle[0]) >= WHOLE_CYCLES
    return whole and bool(np.all(np.diff(cycle) > 0))


def _scatter(part: TrialPart, error: FloatArray) -> FloatArray:
    """Standard deviation from cycle to cycle at the same phase, or of neighbours, (C,)."""
    cycle = part.observation.cycle
    if _repeats(cycle):
        at = np.arange(np.ceil(cycle[0] * 64) / 64, cycle[-1], 1 / 64)
        again = np.column_stack([np.interp(at, cycle, column) for column in error.T])
        return rms((again[64:] - again[:-64]) / np.sqrt(2))
    # white noise alone: the second difference has six times its variance; steps of a command are none
    second = np.abs(np.diff(error, 2, axis=0)) / np.sqrt(6)
    middle = [np.median(column[np.isfinite(column)]) if np.isfinite(column).any() else 0.0
              for column in second.T]  # fmt: skip
    return 1.4826 * np.array(middle)


def _pooled(sigmas: Sequence[FloatArray]) -> FloatArray:
    return np.asarray(np.sqrt(np.mean(np.square(sigmas), axis=0)))
