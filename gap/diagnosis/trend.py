"""Whether a cause keeps its size in the course of a run: wear, heat and dust do not.

Effects of the catalogue are constant. A gap that grows while the machine runs is fitted by one of them with
its mean size, and what is left may look healthy. So what is left in each run is fitted with the cause's
change and with the same change growing along the run; in the references too, where neither is expected. The
growths in the trials are judged by a t test, with the scatter of all these runs. Only runs that repeat one
motion are judged: where the motion changes, a simulator's error changes with it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from gap.constants import UNSTEADY_GROWTH, UNSTEADY_LEVEL
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.fit import Fitted
from gap.search.scatter import scatter
from model.values.arrays import FloatArray

FEWEST_CYCLES = 2.5  # of a run, from which its slope is told
FEWEST_RUNS = 2
SEEN = 1e-4  # how unlike a cause and the growing one must be


@dataclass(frozen=True, slots=True)
class Trend:
    """How a cause's size changes from the beginning of a run to its end.

    Attributes:
        growth: Change over a run as a share of the mean size; NaN if these runs do not determine it.
        chance: Of so much, either way, in a cause that keeps its size; NaN likewise.
    """

    growth: float
    chance: float

    def surely(self, causes: int) -> bool:
        """Whether it changes; ``causes`` is of how many this is one."""
        return bool(self.chance * causes <= UNSTEADY_LEVEL and abs(self.growth) >= UNSTEADY_GROWTH)


UNKNOWN = Trend(np.nan, np.nan)


def trends_of(evidence: Evidence, healthy: Evidence | None, fitted: Fitted) -> tuple[Trend, ...]:
    """Return the trend of each fitted cause; ``healthy`` are references, None for too few.

    Causes of one stage have one trend together: each takes a part of what changes there, and what each
    leaves by itself is little.
    """
    if not _repeats(evidence):
        return (UNKNOWN,) * len(fitted.causes)
    effects = evidence.effects
    groups: dict[str, list[Cause]] = {}
    for one in fitted.causes:
        if not effects[one.effect].in_time:
            groups.setdefault(effects[one.effect].stage, []).append(one)
    trends = {stage: _trend(evidence, healthy, fitted, tuple(own)) for stage, own in groups.items()}
    return tuple(
        UNKNOWN if effects[one.effect].in_time else trends[effects[one.effect].stage]
        for one in fitted.causes
    )


def none_with(trends: Sequence[Trend], none: float) -> float:
    """Return the probability of none of the catalogue, raised if a cause changes during the runs."""
    kept = 1.0
    for one in trends:
        if one.surely(len(trends)):
            kept = min(kept, 0.5 * one.chance * len(trends) / UNSTEADY_LEVEL)
    return none + (1.0 - none) * (1.0 - kept)


def _repeats(evidence: Evidence) -> bool:
    cycles = [part.observation.cycle for part in evidence.parts]
    return all(np.isfinite(one).all() and abs(one[-1] - one[0]) >= FEWEST_CYCLES for one in cycles)


def _trend(
    evidence: Evidence, healthy: Evidence | None, fitted: Fitted, causes: tuple[Cause, ...]
) -> Trend:
    rest = tuple(one for one in fitted.causes if one not in causes)
    groups = [growths(evidence, rest, fitted.causes, fitted.residual)]
    if len(groups[0]) < FEWEST_RUNS:
        return UNKNOWN
    if healthy is not None and _repeats(healthy):
        groups.append(growths(healthy, (), causes, healthy.base))
    square, free = scatter(groups)
    error = np.sqrt(max(square / free / len(groups[0]), 1e-24))
    growth = float(groups[0].mean())
    return Trend(growth, float(2.0 * special.stdtr(free, -abs(growth) / error)))


def growths(
    evidence: Evidence,
    without: tuple[Cause, ...],
    including: tuple[Cause, ...],
    residual: FloatArray,
) -> FloatArray:
    """Return by how much of what causes do a residual grows over each run, (R,); blind runs are left out.

    Args:
        evidence: Runs.
        without: The other causes.
        including: Those and these.
        residual: What is left, whitened, (F, C).
    """
    weights = evidence.weights(residual)
    before, after = evidence.predictions([without, including])
    out, first = [], 0
    for part, whitener, a, b in zip(evidence.parts, evidence.whiteners, before, after, strict=True):
        rows = slice(first, first + part.frames)
        first += part.frames
        time_s = part.observation.time_s
        place = (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 0.5
        shapes = [whitener.whiten_change(b - a), whitener.whiten_change(place[:, None] * (b - a))]
        gram = np.array([[np.sum(weights[rows] * x * y) for x in shapes] for y in shapes])
        pull = np.array([np.sum(weights[rows] * x * residual[rows]) for x in shapes])
        if np.linalg.det(gram) > SEEN * gram[0, 0] ** 2 > 0.0:
            out.append(float(np.linalg.solve(gram, pull)[1]))
    return np.array(out)
