"""The verdict, and the causes and their alternatives with all details."""

from collections.abc import Sequence

import numpy as np

from gap.constants import (
    CLEAR_EXCESS,
    EXCESS_ERRORS,
    IN_DOUBT_SHARE,
    MOST_PART,
    NONE_LIKELY,
)
from gap.diagnosis.alternatives.ambiguity import OpenRival
from gap.diagnosis.answer.findings import Verdict
from gap.diagnosis.answer.named_cause import NamedCause, Value
from gap.diagnosis.comparison.detection import Detection
from gap.diagnosis.comparison.how_far import HowFar
from gap.diagnosis.comparison.trend import Trend
from gap.interfaces import Cause, Effect
from gap.residuals.evidence import Evidence
from gap.search.candidates import on_bound
from gap.search.steps import Selection
from model.values.arrays import FloatArray


def gap_exists(
    evidence: Evidence, detection: Detection | None, selection: Selection, hunts: bool = False
) -> bool:
    """Whether there is a gap: a cause that is new, or what no healthy machine shows without any cause.

    ``hunts`` is whether a joint hunts as in no reference.
    """
    if selection.steps or hunts:
        return True
    if detection is not None:
        return detection.below
    excess, count = evidence.excess(evidence.base), evidence.count.sum(axis=0)
    limit = np.fmax(CLEAR_EXCESS, 1.0 + EXCESS_ERRORS * np.sqrt(2.0 / np.fmax(count, 1.0)))
    return bool(np.any(excess > limit))


def verdict_of(
    exists: bool,
    named: Sequence[NamedCause],
    none: float,
    ambiguous: Sequence[OpenRival],
    *,
    helps: bool = True,
) -> Verdict:
    """Choose among the four; a cause on a bound of its values explains nothing.

    Nor do causes that do not help to predict held-out runs, or leave a joint that hunts (``helps`` is
    False).

    It is not ambiguous for causes that explain next to nothing: the rest is what the simulator lacks.
    """
    if not exists:
        return Verdict.NO_GAP
    on_bound = any(value.on_bound for one in named for value in one.values)
    if not named or none > NONE_LIKELY or on_bound or not helps:
        return Verdict.UNEXPLAINED
    doubted = {one.of for one in ambiguous}
    shares = np.array([one.shrink for one in named])  # NaN where runs are too few to tell
    theirs = shares[[(one.effect, one.joints) in doubted for one in named]].sum()
    small = not doubted or theirs <= IN_DOUBT_SHARE * shares.sum()
    return Verdict.EXPLAINED if small else Verdict.AMBIGUOUS


def named_causes(
    selection: Selection,
    probabilities: Sequence[float],
    far: HowFar,
    trends: Sequence[Trend],
    errors: FloatArray,
    clear: Sequence[float],
) -> tuple[NamedCause, ...]:
    """Return the causes with everything known of them, the one that closes most first.

    That is by held-out runs, or by those that were fitted to, where held-out runs do not show all causes.
    There is one probability, one trend and one ``clear_of_nothing`` a cause; the standard errors are in
    spreads, (P,).
    """
    causes, at = [], 0
    parts = _parts(far, len(selection.steps))
    for i, (cause, step) in enumerate(zip(selection.fitted.causes, selection.steps, strict=True)):
        effect = step.chosen.added.effect
        size = len(effect.parameters)
        judged = far.changes(i)
        causes.append(
            NamedCause(
                effect=effect.family,
                joints=cause.joints,
                stage=effect.stage,
                values=fitted_values(effect, cause, errors[at : at + size]),
                probability=probabilities[i],
                nats=step.chosen.over.nats,
                nats_error=step.chosen.over.error,
                shrink=parts[i] if judged else np.nan,
                alone=far.alone[i] if judged else np.nan,
                last=far.last[i] if judged else np.nan,
                physics=effect.physics,
                remedy=effect.remedy,
                form=effect.name,
                trend=trends[i],
                clear=clear[i],
                vibration=step.chosen.added.vibration,
                p=step.p,
            )
        )
        at += size
    if not all(map(far.changes, range(len(causes)))):
        return tuple(sorted(causes, key=lambda one: -one.nats))
    return tuple(sorted(causes, key=lambda one: -np.nan_to_num(one.shrink, nan=0.0)))


def _parts(far: HowFar, count: int) -> list[float]:
    """Each cause's part of what all close: the mean of first and last in, made to add up.

    All NaN where causes undo so much of each other that one would close more than the whole gap.
    """
    raw = far.each
    total = float(raw.sum())
    if not np.isfinite(far.shrink) or not total > 0.0:  # nor NaN
        return [np.nan] * count
    parts = raw * far.shrink / total
    if np.abs(parts).max() > MOST_PART:
        return [np.nan] * count
    return [float(part) for part in np.fmin(parts, 1.0)]


def fitted_values(effect: Effect, cause: Cause, errors: FloatArray) -> tuple[Value, ...]:
    """Return the values of a cause with their errors, (P,) in spreads, and which lie on a bound."""
    out = []
    for p, value, error in zip(effect.parameters, cause.values, errors, strict=True):
        ends = on_bound(p, value)
        out.append(Value(p.name, p.unit, value, float(error) * p.spread, p.neutral, ends))
    return tuple(out)
