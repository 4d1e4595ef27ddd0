"""How far the gap shrinks on held-out trials, that no fit has seen.

End to end (``Drive.COMMAND``), or where runs have no commands with each stage fed what was measured; with
what references predict subtracted, in units of the baseline. The interval is over held-out runs where there
are several: what differs between runs shows in runs only. Of one or two it is over their cycles, and says
so.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations

import numpy as np
from scipy import special

from gap.constants import HELD_OUT_WORSE, NO_ANSWER
from gap.interfaces import Cause, Channel, Drive
from gap.residuals.evidence import Evidence
from gap.residuals.parts import TrialPart
from gap.residuals.whitening import Whitener
from model.values.arrays import BoolArray, FloatArray

DRAWS = 400
TRACES = 4
TRACE_POINTS = 400
FEWEST_RUNS = 3  # from which an interval is over runs
MOST_SWITCHED = 4  # causes, up to which every set of them is predicted
FEWEST_BLOCKS = 4  # from which a difference between two sets of causes has a scatter
FED_BY_SENSORS = (
    "without commands these runs cannot be judged end to end: each stage was fed what was measured"
)
UNCHANGED = 1e-9  # of the RMS, by rounding
BROKEN = (
    1e9  # baselines off, from which a simulation has broken down: how far off it is, is no figure
)


@dataclass(frozen=True, slots=True)
class ChannelRms:
    """One channel on held-out runs: its RMS difference without causes and with them, in ``unit``.

    The ranges are 95 % intervals over blocks.
    """

    channel: str
    joint: str
    unit: str
    before: float
    after: float
    before_range: tuple[float, float]
    after_range: tuple[float, float]

    @property
    def cut(self) -> float:
        """Share by which the RMS is cut; NaN where there is none."""
        return 1.0 - self.after / self.before if self.before > 0 else np.nan


@dataclass(frozen=True, slots=True)
class ChannelShrink(ChannelRms):
    """The same, with the RMS that is expected without any gap."""

    floor: float


@dataclass(frozen=True, slots=True, eq=False)
class Trace:
    """A channel in P frames of a held-out trial: measured, and as predicted without causes and with them.

    ``compared`` is False where the simulator is not held to it; NaN is what was not measured. ``each`` has
    the prediction with each of the ``HowFar.sets``, (S, P).
    """

    channel: str
    joint: str
    unit: str
    time_s: FloatArray
    measured: FloatArray
    before: FloatArray
    after: FloatArray
    compared: BoolArray
    each: FloatArray


@dataclass(frozen=True, slots=True)
class HowFar:
    """Before and after.

    Attributes:
        before: RMS over all channels in units of the baseline.
        after: The same with the causes added.
        shrink: Share of the gap's energy above the floor that is closed; NaN if there is no gap above the
            baseline, or if the simulation with the causes broke down; then ``after`` is NaN, too.
        low: Lower end of its 95 % interval.
        runs: How many runs were held out.
        explainable: Share of the energy before that is above the floor.
        alone: What each cause closes by itself.
        last: What each cause adds to the others.
        worse: Whether the others predict held-out runs clearly better without it, or the simulation broke
            down with it.
        channels: Every channel that was compared.
        traces: The channels that changed most.
        sets: Sets of causes that were predicted, each as its causes' numbers in order; none and all among
            them. Of up to four causes, every set.
        rms: RMS over all channels in units of the baseline with each of these sets.
        end_to_end: Whether commands alone fed the stages; else each was fed what was measured.
    """

    before: float
    after: float
    shrink: float
    low: float
    high: float
    runs: int
    explainable: float
    alone: tuple[float, ...]
    last: tuple[float, ...]
    worse: tuple[bool, ...]
    channels: tuple[ChannelShrink, ...]
    traces: tuple[Trace, ...]
    sets: tuple[tuple[int, ...], ...]
    rms: tuple[float, ...]
    end_to_end: bool

    @property
    def fed_words(self) -> str:
        """Say what fed the stages if it was not the commands alone; empty otherwise."""
        return "" if self.end_to_end else FED_BY_SENSORS

    @property
    def each(self) -> FloatArray:
        """What each of N causes closes, (N,): the mean of first and last in."""
        return np.asarray(0.5 * (np.array(self.alone) + np.array(self.last)))

    def changes(self, at: int) -> bool:
        """Whether held-out runs are predicted otherwise with cause number ``at`` beside the others."""
        rms = dict(zip(self.sets, self.rms, strict=True))
        whole = tuple(range(len(self.last)))
        with_it, without_it = rms[whole], rms[(*whole[:at], *whole[at + 1 :])]
        return not abs(with_it - without_it) <= UNCHANGED * without_it  # also where one broke down

    @property
    def surely_worse(self) -> bool:
        """Whether all causes together predict held-out runs worse, beyond the interval."""
        return self.high < 0.0  # not where it is NaN

    @property
    def over_runs(self) -> bool:
        """Whether the interval is over runs, and not over the cycles of one or two."""
        return self.runs >= FEWEST_RUNS


def how_far(held: Evidence, causes: tuple[Cause, ...], seed: int) -> HowFar:
    """Measure what causes do to held-out trials under their drive; the seed is of the resampling."""
    n = len(causes)
    sets = sets_of(n)
    predicted = held.predictions([tuple(causes[i] for i in one) for one in sets])
    nothing = predicted[sets.index(())]
    energy = {one: _energy(held, each, nothing) for one, each in zip(sets, predicted, strict=True)}
    whole = tuple(range(n))
    rest = [energy[whole[:i] + whole[i + 1 :]] for i in whole]
    weight = held.per_block(np.concatenate([(w.gain > 0) * 1.0 for w in held.whiteners]))
    before, after = energy[()], energy[whole]
    both = _shrunk(before, after, after, weight)
    value, low, high = _shrink(held, before, after, weight, both, seed)
    closed = [_shrunk(before, energy[i,], after, weight) for i in whole]
    last = [both - _shrunk(before, one, after, weight) for one in rest]
    mean = _mean(before, weight)
    broken = {one: bool(np.isnan(e).any()) for one, e in energy.items()}
    breaks = [
        broken[whole] and (broken[i,] or not broken[whole[:i] + whole[i + 1 :]]) for i in whole
    ]
    return HowFar(
        before=float(np.sqrt(mean)),
        after=float(np.sqrt(_mean(after, weight))),
        shrink=value,
        low=low,
        high=high,
        runs=len(held.parts),
        explainable=max(0.0, 1.0 - 1.0 / mean) if mean > 0 else 0.0,
        alone=tuple(closed),
        last=tuple(last),
        worse=tuple(breaks[i] or _clearly_more(after - rest[i], weight) for i in whole),
        channels=_channels(held, before, after, weight, seed),
        traces=_traces(held, predicted, sets, _most_changed(before, after, rest)),
        sets=sets,
        rms=tuple(float(np.sqrt(_mean(energy[one], weight))) for one in sets),
        end_to_end=held.drive is Drive.COMMAND,
    )


def sets_of(count: int) -> tuple[tuple[int, ...], ...]:
    """Return the sets of so many causes that are predicted: every one, of many only the few that count."""
    numbers = tuple(range(count))
    sizes = numbers if count <= MOST_SWITCHED else (0, 1, count - 1)
    sets = [one for size in sizes for one in combinations(numbers, size)]
    return tuple(dict.fromkeys([(), *sets, numbers]))


def _energy(
    held: Evidence, predicted: Sequence[FloatArray], nothing: Sequence[FloatArray]
) -> FloatArray:
    """Squared difference in units of the baseline, summed over each block, (B, C); NaN if broken.

    Where causes take away the answer that the simulator has with ``nothing``, they pay as in a fit.
    """
    rows = []
    for part, whitener, one, first in zip(
        held.parts, held.whiteners, predicted, nothing, strict=True
    ):
        error = _off(part, whitener, one)
        if (lost := np.isnan(one) & ~np.isnan(first)).any():
            error = np.where(lost, np.abs(_off(part, whitener, first)) + NO_ANSWER, error)
        rows.append(
            np.where(whitener.gain > 0, np.where(_is_broken(error), np.nan, error), 0.0) ** 2
        )
    return held.per_block(np.concatenate(rows))


def _off(part: TrialPart, whitener: Whitener, predicted: FloatArray) -> FloatArray:
    """Difference in units of the baseline, (F, C); 0 where there is no prediction."""
    with np.errstate(over="ignore"):  # a broken simulation may return any number
        error = (part.observation.values - predicted - whitener.expected) / whitener.unsure
    return np.asarray(np.nan_to_num(error, nan=0.0, posinf=np.inf, neginf=-np.inf))


def _is_broken(error: FloatArray) -> BoolArray:
    return np.asarray(np.abs(error) > BROKEN)


def _mean(energy: FloatArray, weight: FloatArray) -> float:
    """Mean over frames, then over channels."""
    frames = weight.sum(axis=0)
    on = frames > 0
    return float(np.mean(energy.sum(axis=0)[on] / frames[on])) if on.any() else 0.0


def _shrunk(before: FloatArray, left: FloatArray, after: FloatArray, weight: FloatArray) -> float:
    """Share closed where ``left`` is left; what is at or below the floor counts as closed altogether.

    The floor is 1, the baseline. Runs that are below it before show a gap only by what all causes close
    (``after`` is left), so that is the floor there.
    """
    first, remains, whole = (_mean(energy, weight) for energy in (before, left, after))
    floor = min(1.0, remains) if first > 1.0 else whole
    return (first - max(remains, floor)) / (first - floor) if first > floor else np.nan


def _shrink(
    held: Evidence,
    before: FloatArray,
    after: FloatArray,
    weight: FloatArray,
    value: float,
    seed: int,
) -> tuple[float, float, float]:
    """Value, which is what all causes close, and its 95 % interval.

    NaN where the gap before is not surely above the floor.
    """
    rng = np.random.default_rng(seed)
    blocks = len(weight)
    draws, gaps = [], []
    for _ in range(DRAWS):
        pick = rng.integers(blocks, size=blocks)
        gaps.append(_mean(before[pick], weight[pick]) - min(1.0, _mean(after[pick], weight[pick])))
        draws.append(_shrunk(before[pick], after[pick], after[pick], weight[pick]))
    runs = len(held.parts)
    below = _mean(before, weight) <= 1.0  # as healthy runs are: no gap to take a share of
    if below or np.quantile(gaps, 0.025) <= 0.0 or np.isnan(value):
        return np.nan, np.nan, np.nan
    if runs < FEWEST_RUNS:
        low, high = np.nanquantile(draws, [0.025, 0.975])
        return value, float(low), float(high)
    # the jackknife over runs (Efron and Stein 1981, DOI 10.1214/aos/1176345462)
    without = [held.block_part != run for run in range(runs)]
    left = np.array([_shrunk(before[on], after[on], after[on], weight[on]) for on in without])
    error = np.sqrt((runs - 1) / runs * np.nansum((left - np.nanmean(left)) ** 2))
    reach = float(special.stdtrit(runs - 1, 0.975) * error)
    return value, value - reach, min(value + reach, 1.0)


def _clearly_more(extra: FloatArray, weight: FloatArray) -> bool:
    """Whether energy that is added, (B, C), is more than its scatter over blocks."""
    frames = np.fmax(weight, 1.0)
    on = weight.sum(axis=0) > 0
    each = np.where(weight > 0, extra / frames, 0.0)[:, on].mean(axis=1)
    if len(each) < FEWEST_BLOCKS:
        return False
    error = float(each.std(ddof=1) / np.sqrt(len(each)))
    return float(each.mean()) > HELD_OUT_WORSE * max(error, 1e-12)


def _channels(
    held: Evidence, before: FloatArray, after: FloatArray, weight: FloatArray, seed: int
) -> tuple[ChannelShrink, ...]:
    unsure = np.sqrt(np.mean([w.unsure**2 for w in held.whiteners], axis=0))
    channels = held.simulator.channels
    rows = channel_rms(channels, before * unsure**2, after * unsure**2, weight, seed)
    return tuple(ChannelShrink(**asdict(row), floor=float(unsure[i])) for i, row in rows)


def channel_rms(
    channels: Sequence[Channel],
    before: FloatArray,
    after: FloatArray,
    weight: FloatArray,
    seed: int,
) -> Iterator[tuple[int, ChannelRms]]:
    """Return every channel that was compared, with its number.

    Squared differences without causes and with them are summed over each block, (B, C); the weight is the
    frames of each block that are compared, (B, C); the seed is of the resampling.
    """
    frames = weight.sum(axis=0)
    for i, c in enumerate(channels):
        if frames[i] > 0:
            first, then = (float(np.sqrt(e[:, i].sum() / frames[i])) for e in (before, after))
            wide, left = (_rms_range(e[:, i], weight[:, i], seed) for e in (before, after))
            yield i, ChannelRms(c.name, c.joint, c.unit, first, then, wide, left)


def _rms_range(energy: FloatArray, weight: FloatArray, seed: int) -> tuple[float, float]:
    """95 % interval of an RMS, over blocks, (B,)."""
    rng = np.random.default_rng(seed)
    picks = rng.integers(len(weight), size=(DRAWS, len(weight)))
    frames = weight[picks].sum(axis=1)
    drawn = np.sqrt(energy[picks].sum(axis=1)[frames > 0] / frames[frames > 0])
    low, high = np.quantile(drawn, [0.025, 0.975])
    return float(low), float(high)


def _most_changed(before: FloatArray, after: FloatArray, rest: Sequence[FloatArray]) -> list[int]:
    """Numbers of the channels that all causes change most, and of the one that each changes most.

    Energies without causes, with all, and with all but each, (B, C). Where none changed, the channels that
    differ most.
    """
    change = _sizes(before - after)
    changed = bool(change.any())
    order: list[int] = np.argsort(-(change if changed else _sizes(before)), kind="stable").tolist()
    if not changed:
        return order[:TRACES]
    own = [int(np.argmax(_sizes(one - after))) for one in rest]
    return list(dict.fromkeys([order[0], *own, *order]))[: max(TRACES, 1 + len(rest))]


def _sizes(energy: FloatArray) -> FloatArray:
    """Size of each channel's energy, (B, C) to (C,); 0 where it is not known."""
    return np.asarray(np.abs(np.nan_to_num(energy.sum(axis=0))))


def _traces(
    held: Evidence,
    predicted: Sequence[Sequence[FloatArray]],
    sets: Sequence[tuple[int, ...]],
    order: Sequence[int],
) -> tuple[Trace, ...]:
    """Channels of the first part, by their numbers."""
    channels = held.simulator.channels
    part, whitener = held.parts[0], held.whiteners[0]
    rows = slice(None, None, max(1, part.frames // TRACE_POINTS))
    each = np.stack([
        np.where(_is_broken(_off(part, whitener, one[0])), np.nan, one[0])[rows] for one in predicted
    ])  # fmt: skip
    whole = max(range(len(sets)), key=lambda number: len(sets[number]))
    return tuple(
        Trace(
            channels[i].name,
            channels[i].joint,
            channels[i].unit,
            part.observation.time_s[rows],
            part.observation.values[rows, i] - whitener.expected[rows, i],
            each[0, :, i],
            each[whole, :, i],
            whitener.gain[rows, i] > 0,
            each[..., i],
        )
        for i in order
        if (whitener.gain[:, i] > 0).any()
    )
