"""What a set of effects can do at best by itself: fitted by least squares, judged on runs kept back.

The diagnosis names causes; this asks the other way round how far a given explanation would have come
(a delay alone, an offset alone). It shares with the diagnosis the simulator and which runs are kept back,
and nothing else: no prior, no floor, no selection.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from gap.diagnosis.how_far import rms_range
from gap.interfaces import Cause, Drive, Effect, Scope, Simulator
from gap.residuals.parts import Part, block_starts, split
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial

STARTS = (0.5, 2.0, -0.5)  # in spreads from neutral
MOST_TRIES = 40


@dataclass(frozen=True, slots=True)
class ChannelAlone:
    """One channel on the runs kept back.

    Attributes:
        channel: Name.
        joint: Its joint.
        unit: Unit of what follows.
        before: RMS difference of the simulator as it stands.
        after: RMS difference with the effects added.
        before_range: 95 % interval of ``before``, over blocks.
        after_range: The same of ``after``.
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
        """Share by which the RMS is cut."""
        return 1.0 - self.after / self.before if self.before > 0 else float("nan")


@dataclass(frozen=True, slots=True)
class Alone:
    """A set of effects by itself.

    Attributes:
        effects: Their names.
        causes: With the values that fit the other runs best.
        channels: Every channel that was compared.
    """

    effects: tuple[str, ...]
    causes: tuple[Cause, ...]
    channels: tuple[ChannelAlone, ...]


@dataclass(frozen=True, slots=True)
class _Free:
    cause: int
    place: int
    neutral: float
    lower: float
    upper: float
    spread: float


def each_alone(
    trials: Sequence[Trial],
    simulator: Simulator,
    sets: Sequence[tuple[str, ...]],
    progress: Callable[[str, float], None] | None = None,
    seed: int = 0,
) -> tuple[Alone, ...]:
    """Fit sets of effects, each by itself.

    Args:
        trials: Measured runs of one machine.
        simulator: Its simulator.
        sets: Names of effects that act together; a set of one is an effect alone.
        progress: Told the set at work and the share that is done.
        seed: Of the intervals.

    Raises:
        GapError: An effect is not of the catalogue, or nothing can be compared.
    """
    observations = [simulator.observe(one) for one in trials]
    fitted, held = split(trials, observations)
    scale = _rms_before(simulator, trials, fitted)
    if not np.isfinite(scale).any():
        raise GapError("no measured channel can be compared with the simulator; check the columns")
    out = []
    for number, names in enumerate(sets):
        if progress is not None:
            progress("+".join(names), number / len(sets))
        causes = _fit(simulator, trials, fitted, _causes(simulator, names), scale)
        channels = tuple(_channels(simulator, trials, held, causes, seed))
        out.append(Alone(tuple(names), causes, channels))
    return tuple(out)


def _causes(simulator: Simulator, names: Sequence[str]) -> tuple[Cause, ...]:
    effects = {effect.name: effect for effect in simulator.effects}
    causes = []
    for name in names:
        if name not in effects:
            known = ", ".join(effects)
            raise GapError(f"{name!r} is no effect that fits these trials; there are {known}")
        one = effects[name]
        neutral = tuple(p.neutral for p in one.parameters)
        places = [()] if Scope.ALL in one.scopes else [(joint,) for joint in simulator.joints]
        causes += [Cause(name, place, neutral) for place in places]
    return tuple(causes)


def _free(causes: Sequence[Cause], effects: Sequence[Effect]) -> list[_Free]:
    by_name = {effect.name: effect for effect in effects}
    return [
        _Free(i, k, p.neutral, p.lower, p.upper, p.spread)
        for i, cause in enumerate(causes)
        for k, p in enumerate(by_name[cause.effect].parameters)
    ]


def _fit(
    simulator: Simulator,
    trials: Sequence[Trial],
    parts: Sequence[Part],
    causes: tuple[Cause, ...],
    scale: FloatArray,
) -> tuple[Cause, ...]:
    free = _free(causes, simulator.effects)
    if not free:
        return causes
    lower, upper = (np.array([getattr(f, end) for f in free]) for end in ("lower", "upper"))
    spread, neutral = (np.array([getattr(f, key) for f in free]) for key in ("spread", "neutral"))

    def misfit(x: FloatArray) -> FloatArray:
        moved = _moved(causes, free, x * spread)
        rows = [_errors(simulator, trials, part, moved) / scale for part in parts]
        return np.nan_to_num(np.concatenate(rows)).ravel()

    best = None
    for start in STARTS:
        inside = 1e-6 * (upper - lower)
        x0 = np.clip(neutral + start * spread, lower + inside, upper - inside) / spread
        found = least_squares(
            misfit,
            x0,
            bounds=(lower / spread, upper / spread),
            diff_step=[1e-3],
            max_nfev=MOST_TRIES,
        )
        if best is None or found.cost < best.cost:
            best = found
    assert best is not None
    return _moved(causes, free, best.x * spread)


def _moved(causes: Sequence[Cause], free: Sequence[_Free], values: FloatArray) -> tuple[Cause, ...]:
    numbers = [list(cause.values) for cause in causes]
    for f, value in zip(free, values, strict=True):
        numbers[f.cause][f.place] = float(np.clip(value, f.lower, f.upper))
    return tuple(Cause(c.effect, c.joints, tuple(n)) for c, n in zip(causes, numbers, strict=True))


def _errors(
    simulator: Simulator, trials: Sequence[Trial], part: Part, causes: tuple[Cause, ...]
) -> FloatArray:
    """Measured minus predicted end to end, (F, C); NaN where nothing is compared."""
    predicted = part.cut(simulator.predict(trials[part.trial], causes, Drive.COMMAND))
    error = part.observation.values - predicted
    return np.where(part.observation.weight > 0, error, np.nan)


def _rms_before(simulator: Simulator, trials: Sequence[Trial], parts: Sequence[Part]) -> FloatArray:
    total = np.concatenate([_errors(simulator, trials, part, ()) for part in parts])
    known = np.isfinite(total)
    power = np.where(known, total, 0.0) ** 2
    count = known.sum(axis=0)
    rms = np.sqrt(power.sum(axis=0) / np.fmax(count, 1))
    return np.where((count > 0) & (rms > 0), rms, np.nan)


def _channels(
    simulator: Simulator,
    trials: Sequence[Trial],
    parts: Sequence[Part],
    causes: tuple[Cause, ...],
    seed: int,
) -> Iterator[ChannelAlone]:
    ways: list[list[FloatArray]] = [[], []]
    weights = []
    for part in parts:
        starts = block_starts(part.observation)
        pair = [_errors(simulator, trials, part, one) for one in ((), causes)]
        known = np.isfinite(pair[0]) & np.isfinite(pair[1])
        weights.append(np.add.reduceat(known * 1.0, starts, axis=0))
        for way, error in zip(ways, pair, strict=True):
            way.append(np.add.reduceat(np.where(known, error, 0.0) ** 2, starts, axis=0))
    weight = np.concatenate(weights)
    energies = [np.concatenate(way) for way in ways]
    for i, channel in enumerate(simulator.channels):
        frames = weight[:, i].sum()
        if frames == 0:
            continue
        before, after = (float(np.sqrt(e[:, i].sum() / frames)) for e in energies)
        wide, left = (rms_range(e[:, i], weight[:, i], seed) for e in energies)
        yield ChannelAlone(
            channel.name, channel.joint, channel.unit, before, after, wide, left
        )  # fmt: skip
