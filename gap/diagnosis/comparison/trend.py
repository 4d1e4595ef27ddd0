"""Whether a cause keeps its size in the course of a run: wear, heat and dust do not.

Effects of the catalogue are constant. A gap that grows while the machine runs is fitted by one of them with
its mean size, and what is left may look healthy. So what is left in each run is fitted with the cause's
change and with the same change growing along the run; in the references too, where neither is expected. The
growths in the trials are judged by a t test, with the scatter of all these runs. Only runs that repeat one
motion are judged: where the motion changes, a simulator's error changes with it.

Where no cause is named, what may wear is asked for all the same: friction that fades may be within the
scatter between days on the mean, and change in each run as it does in none of the references.
"""

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace

import numpy as np
from scipy import special

from gap.constants import (
    CHANGE_LEVEL,
    EVEN_CHANGE,
    FEWEST_CYCLES,
    JOINTS_SHARE,
    LEAST_CHANGE,
    NEARLY_AS_SURE,
    UNSTEADY_GROWTH,
    UNSTEADY_LEVEL,
)
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import STEP, Candidate, Family, stepped
from gap.search.fit import Fitted
from gap.search.scatter import scatter
from model.values.arrays import FloatArray

FEWEST_RUNS = 2
SEEN = 1e-4  # how unlike a cause and the growing one must be
FAINT = 1e-2  # nats that a growth of a cause's own size must have to be seen
FEWEST_FREE = 3  # degrees of freedom of a change's scatter


@dataclass(frozen=True, slots=True)
class Trend:
    """How a cause's size changes from the beginning of a run to its end.

    Attributes:
        growth: Change over a run as a share of the mean size; NaN if these runs do not determine it.
        error: Its standard error; NaN likewise.
        free: Degrees of freedom of that.
    """

    growth: float
    error: float
    free: float

    @property
    def chance(self) -> float:
        """Of so much, either way, in a cause that changes no more than a simulator's error may look like.

        A small change may be very sure, and a large one a coincidence: neither counts.
        """
        beyond = (abs(self.growth) - UNSTEADY_GROWTH) / self.error
        return float(min(1.0, 2.0 * special.stdtr(self.free, -beyond)))

    def surely(self, causes: int) -> bool:
        """Whether it changes; ``causes`` is of how many this is one."""
        return bool(self.chance * causes <= UNSTEADY_LEVEL)


UNKNOWN = Trend(np.nan, np.nan, np.nan)


@dataclass(frozen=True, slots=True)
class RunChange:
    """What changes in the course of the trials' runs, beyond what it does in references.

    Attributes:
        effect: The effect whose size changes.
        joints: Where; empty for the whole machine.
        stage: In which it acts.
        parameter: Its number.
        unit: Of that number.
        change: By how much, from the beginning of a run to its end, to first order.
        chance: Of so much in a healthy machine, among all effects that may wear.
        remedy: What to check.
        alike: Others, with their joints, that change nearly as surely.
    """

    effect: str
    joints: tuple[str, ...]
    stage: str
    parameter: str
    unit: str
    change: float
    chance: float
    remedy: str
    alike: tuple[Family, ...] = ()


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


def none_with(
    trends: Sequence[Trend], none: float, p_change: float = 1.0, little: Set[int] = frozenset()
) -> float:
    """Return the probability of none of the catalogue, raised if something changes during the runs.

    Args:
        trends: Of each named cause.
        none: The probability without a look at what changes.
        p_change: The chance of what was found to change where no cause is named.
        little: Numbers of the causes that add next to nothing to the others: what a large cause leaves may
            change, and leaves the gap explained.
    """
    sure = [
        one.chance * len(trends) / UNSTEADY_LEVEL
        for at, one in enumerate(trends)
        if one.surely(len(trends)) and at not in little
    ]
    if p_change < CHANGE_LEVEL:
        sure.append(p_change / CHANGE_LEVEL)
    kept = EVEN_CHANGE * min(sure) if sure else 1.0
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
    return Trend(float(groups[0].mean()), float(error), float(free))


def change_in_runs(
    trials: Sequence[Evidence], healthy: Evidence, candidates: Sequence[Candidate]
) -> RunChange | None:
    """Return what changes most surely in the course of trials that no cause was named for.

    Runs of one gait are compared, by a t test with what gaits have by themselves taken out. There are many
    joints, so all of them together have a fifth of the level.

    Args:
        trials: Whole runs, those that were fitted to and those held out.
        healthy: References.
        candidates: Only those that may wear are asked.

    Returns:
        The one with the smallest chance; None where these runs do not determine it.
    """
    groups = (*trials, healthy)
    asked = [one for one in candidates if one.effect.wears and len(one.neutral) == 1]
    if not asked or not all(map(_repeats, groups)):
        return None
    gaits = [part.gait for one in groups for part in one.parts]
    trial = np.repeat([1.0, 0.0], [sum(len(one.parts) for one in trials), len(healthy.parts)])
    causes = [one.cause(stepped(one.effect.parameters, one.neutral, 0, STEP)) for one in asked]
    grown = np.concatenate([_growth_of_each(one, causes) for one in groups], axis=1)
    length_s = np.concatenate([_lengths_s(one) for one in groups])
    grown *= np.median(length_s[trial > 0]) / length_s
    changes = []
    for one, cause, each in zip(asked, causes, grown, strict=True):
        by, chance = difference(each, trial, gaits)
        change = by * (cause.values[0] - one.neutral[0])
        if abs(change) >= LEAST_CHANGE * one.effect.parameters[0].spread:  # nor NaN
            changes.append(_change(one, change, min(1.0, chance * _tests_for(one, asked))))
    if not changes:
        return None
    changes.sort(key=lambda own: (own.chance, own.effect, own.joints))
    surest, *others = changes
    near = [one for one in others if one.chance <= NEARLY_AS_SURE * surest.chance]
    return replace(surest, alike=tuple((one.effect, one.joints) for one in near))


def _tests_for(one: Candidate, asked: Sequence[Candidate]) -> float:
    """How many tests one counts as: those of its kind (whole machine, joints) over its kind's share."""
    kind = [bool(other.joints) is bool(one.joints) for other in asked]
    share = JOINTS_SHARE if one.joints else 1.0 - JOINTS_SHARE
    return sum(kind) / (1.0 if all(kind) else share)


def _change(one: Candidate, change: float, chance: float) -> RunChange:
    effect, (p,) = one.effect, one.effect.parameters
    return RunChange(
        effect.name, one.joints, effect.stage, p.name, p.unit, change, chance, effect.remedy
    )


def _growth_of_each(evidence: Evidence, causes: Sequence[Cause]) -> FloatArray:
    """Return by how much of what each cause does the residual grows over each run, (causes, R)."""
    before, *after = evidence.predictions([(), *((one,) for one in causes)])
    weights = evidence.base_weights
    return np.array([_grown(evidence, before, one, evidence.base, weights) for one in after])


def _lengths_s(evidence: Evidence) -> FloatArray:
    return np.array([np.ptp(part.observation.time_s) for part in evidence.parts])


def difference(values: FloatArray, trial: FloatArray, gaits: Sequence[str]) -> tuple[float, float]:
    """Return by how much trials differ from references of their gaits, and the chance of so much.

    Args:
        values: One a run, (R,); NaN where a run says nothing.
        trial: 1 for each trial and 0 for each reference, (R,).
        gaits: Of each run.

    Returns:
        The difference and, by a t test with one variance for all, its chance; NaN where too few are left.
    """
    known = np.isfinite(values)
    names = sorted({gait for gait, one in zip(gaits, known, strict=True) if one})
    own = [[float(gait == name) for name in names] for gait in gaits]
    columns = np.column_stack([trial, own])[known]
    free = int(known.sum()) - columns.shape[1]
    if free < FEWEST_FREE or np.linalg.matrix_rank(columns) < columns.shape[1]:
        return np.nan, np.nan
    inverse = np.linalg.inv(columns.T @ columns)
    fitted = inverse @ columns.T @ values[known]
    left = values[known] - columns @ fitted
    error = np.sqrt(max(float(left @ left) / free * inverse[0, 0], 1e-24))
    return float(fitted[0]), float(2.0 * special.stdtr(free, -abs(fitted[0]) / error))


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
    before, after = evidence.predictions([without, including])
    each = _grown(evidence, before, after, residual, evidence.weights(residual))
    return each[np.isfinite(each)]


def _grown(
    evidence: Evidence,
    before: Sequence[FloatArray],
    after: Sequence[FloatArray],
    residual: FloatArray,
    weights: FloatArray,
) -> FloatArray:
    """Return the growth over each run, (R,), as ``growths`` does; NaN for blind runs.

    Before and after are predictions of each run without and with what may grow; weights are those of the
    residual's values, (F, C).
    """
    out, first = [], 0
    for part, whitener, a, b in zip(evidence.parts, evidence.whiteners, before, after, strict=True):
        rows = slice(first, first + part.frames)
        first += part.frames
        time_s = part.observation.time_s
        place = (time_s - time_s[0]) / (time_s[-1] - time_s[0]) - 0.5
        shapes = [whitener.whiten_change(b - a), whitener.whiten_change(place[:, None] * (b - a))]
        gram = np.array([[np.sum(weights[rows] * x * y) for x in shapes] for y in shapes])
        pull = np.array([np.sum(weights[rows] * x * residual[rows]) for x in shapes])
        apart = np.linalg.det(gram)
        seen = apart > SEEN * gram[0, 0] ** 2 and apart > FAINT * gram[0, 0]
        out.append(float(np.linalg.solve(gram, pull)[1]) if seen else np.nan)
    return np.array(out)
