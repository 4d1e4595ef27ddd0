"""Probabilities of causes, and of none of them.

The constants are in ``gap.constants``: an alternative whose held-out log-likelihood is two nats lower is
0.37 times as likely, and causes that explain 95 % of the gap with a residual near its expectation leave 2 %
for none of them.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy import special

from gap.constants import (
    ERROR_SHARE,
    FORM_DIFFERS,
    GAIN_SHARE,
    MISFIT_SHARE,
    NONE,
    NONE_ACTING,
    NONE_ENERGY,
    NONE_LEFT,
    NONE_MANY,
    NONE_OPEN,
    NONE_OPEN_ALONE,
    NONE_UNWATCHED,
    NONE_WORST,
    NONE_WORST_ALONE,
    ROUGH_CLOSES,
    ROUGH_DIFFERS,
    SURELY_ODD,
    TEMPERATURE,
)
from gap.diagnosis.comparison.how_far import HowFar
from gap.interfaces import Cause, Channel, Effect
from gap.residuals.left_there import HeldOutEnergies, left_at_joint, made_worse
from gap.search.cross_validation import Advantage, advantage
from gap.search.options import Option
from gap.search.steps import Selection
from model.values.arrays import FloatArray, IntArray

HALF = 0.5  # chance that a cause's size is not nothing, below which it is more likely nothing


@dataclass(frozen=True, slots=True)
class RivalCause:
    """A candidate that was fitted and not taken.

    Attributes:
        cause: Number of the cause it was an alternative to.
        probability: That it is this one instead.
        behind: Nats by which it predicts held-out blocks worse.
        of: Effect and joints of the cause it was an alternative to.
        form: Name in the catalogue: ``effect``, or the one of its forms that fits best.
        vibration_nats: Nats of those by which vibration, or its absence, speaks for the cause.
    """

    cause: int
    effect: str
    joints: tuple[str, ...]
    probability: float
    behind: float
    behind_error: float
    of: tuple[str, tuple[str, ...]]
    form: str
    vibration_nats: float = field(default=0.0, kw_only=True)


@dataclass(frozen=True, slots=True)
class Fit:
    """What the causes explain in the trials that were fitted to, by cross-validation.

    Attributes:
        closed: Share of the explainable gap that they close, 0 to 1.
        excess_after: Energy over expectation with them.
        worst_after: The same of the worst channel.
        p_after: Chance of so much left in a healthy machine; 0 where there is none to compare with.
        nats_after: Score that is left beyond that of a healthy machine.
        closed_acting: Share of the energy that no healthy run shows which they close where they act; 1
            where there is none to compare with.
        left_there: How much more is left at joints of causes on held-out runs than at others, see
            ``gap.residuals.left_there``; 0 where that is unknown.
        unwatched: How many stages of the chain have no channel that was measured; only whether any matters.
        rough: How roughly the form of the cause that gains most is known, 0 to 1; 0 without references.
    """

    closed: float
    excess_after: float
    worst_after: float
    p_after: float
    nats_after: float
    closed_acting: float = 1.0
    left_there: float = 0.0
    unwatched: float = 0.0
    rough: float = 0.0


def none_of_them(fit: Fit, causes: int, referenced: bool) -> float:
    """Return the probability that the cause is none of the catalogue.

    Args:
        fit: What the causes explain.
        causes: How many there are.
        referenced: Whether the expectation comes from references.
    """
    wide, worst = (NONE_OPEN, NONE_WORST) if referenced else (NONE_OPEN_ALONE, NONE_WORST_ALONE)
    many, unwatched = (NONE_MANY, NONE_UNWATCHED) if referenced else (0.0, 0.0)
    features = none_features(fit, causes)
    weights = (NONE, wide, NONE_ENERGY, worst, many, NONE_ACTING, NONE_LEFT, unwatched)
    logit = sum(one * value for one, value in zip(weights, features, strict=True))
    return 1.0 / (1.0 + math.exp(-logit))


def clear_of_nothing(
    selection: Selection, effects: Mapping[str, Effect], errors: FloatArray
) -> tuple[float, ...]:
    """Return the probability, of each cause, that its size is not one of nothing.

    Among all effects of a catalogue, the size of one is some standard errors from neutral by chance: that
    of Sidak for so many (1967, doi:10.1080/01621459.1967.10482935). Of several numbers the one that is
    farthest counts: runs and models scatter all of them alike. Where a joint hunts, one effect alone was
    tried. A cause that surely vibrates is judged by its vibration, and a law is there or not, whatever its
    size.

    Args:
        selection: The causes.
        effects: The catalogue.
        errors: Standard error of each parameter of all causes in spreads, (P,).
    """
    families, out, at = len({one.family for one in effects.values()}), [], 0
    for cause, step in zip(selection.fitted.causes, selection.steps, strict=True):
        each = effects[cause.effect].parameters
        own = zip(each, cause.values, errors[at : at + len(each)], strict=True)
        at += len(each)
        away = [_away(v - p.neutral, p.spread * e) for p, v, e in own if not p.located]
        sized = bool(away) and not effects[cause.effect].law
        far = 1.0 - 2.0 * float(special.ndtr(-max(away))) if sized else 1.0
        added = step.chosen.added
        if added.vibration is not None and added.vibrates:
            out.append(1.0 - added.vibration.chance)
        else:
            out.append(far if added.hunts else far**families)
    return tuple(out)


def _away(size: float, error: float) -> float:
    """Return standard errors from neutral; 0 where the error is not known."""
    if error > 0.0:
        return abs(size) / error
    return math.inf if size != 0.0 and error == 0.0 else 0.0


def none_if_nothing(none: float, clear: Sequence[float]) -> float:
    """Return the probability of "none of these", raised by that of all named causes being nothing.

    ``clear`` is ``clear_of_nothing`` of each.
    """
    return none + (1.0 - none) * math.prod(1.0 - one for one in clear) if clear else none


def none_features(fit: Fit, causes: int) -> tuple[float, ...]:
    """Return what the log odds of "none of these" are linear in, eight numbers.

    These are 1, the open gap, energy, the worst channel, causes above two, what is open where the causes
    act, what is left at their joints on held-out runs, and whether a stage of the chain is not measured
    (0 or 1). Of a large cause that is right a few percent may be left. What a healthy machine leaves too is
    no sign that something is missing. What is wrong in a stage that is not measured shows only in what
    follows from it, and there a cause of another stage can look the same. A cause whose form is only
    roughly known closes less than all.
    """
    closed, acting = fit.closed, fit.closed_acting
    closes = 1.0 - fit.rough * (1.0 - ROUGH_CLOSES)  # if nothing else is there
    closed, acting = (min(one / closes, 1.0) for one in (closed, acting))
    odd = min(1.0, -math.log(max(fit.p_after, 1e-9)) / -math.log(SURELY_ODD))
    return (
        1.0,
        odd * (1.0 - closed),
        odd * math.log(max(fit.excess_after, 1.0)),
        odd * math.log(max(fit.worst_after, 1.0)),
        max(0, causes - 2),
        1.0 - acting,
        fit.left_there,
        min(fit.unwatched, 1.0),
    )


def left_of(
    far: HowFar,
    causes: Sequence[Cause],
    effects: Mapping[str, Effect],
    channels: Sequence[Channel],
) -> float:
    """Return how much more is left at joints of causes than at others (``gap.residuals.left_there``).

    Or how much worse a signal is there, if that is more. Of several causes, each counts by its part of what
    all close on held-out runs.
    """
    if not causes:
        return 0.0
    rows = [row for row in far.channels if row.floor > 0.0]
    before, after = (
        np.array([(one / row.floor) ** 2 for row, one in zip(rows, each, strict=True)])
        for each in ([row.before for row in rows], [row.after for row in rows])
    )
    steady = {one.name for one in channels if not (one.lasting or one.trapped)}
    names = [row.channel for row in rows]
    signals = np.array([name in steady for name in names])
    energies = HeldOutEnergies(names, [row.joint for row in rows], before, after, signals)
    joints = {joint for one in causes for joint in one.joints}
    closed = np.fmax(far.each, 0.0)
    parts = closed / closed.sum() if closed.sum() > 0.0 else np.full(len(causes), 1 / len(causes))
    left = 0.0
    for one, part in zip(causes, parts, strict=True):
        if len(one.joints) == 1:
            differs = ROUGH_DIFFERS if effects[one.effect].rough else FORM_DIFFERS
            there = left_at_joint(energies, one.joints[0], joints, differs)
            left += part * max(there, made_worse(energies, one.joints[0], joints))
    return float(left)


def chances(
    selection: Selection,
    strata: IntArray,
    none: float,
    left_nats: float,
    clear: Sequence[float],
) -> tuple[tuple[float, tuple[RivalCause, ...]], ...]:
    """Return the probability of each cause, and its alternatives with theirs.

    Args:
        selection: The causes.
        strata: Trial of each block, (B,).
        none: Probability that it is none of the catalogue.
        left_nats: Score that is left beyond that of a healthy machine.
        clear: Of each cause, ``clear_of_nothing``.
    """
    out = []
    surest = min((step.p for step in selection.steps), default=0.0)
    for i, step in enumerate(selection.steps):
        others = selection.rivals_of(i)
        behinds = [behind_of(one, step.chosen, strata) for one in others]
        weights, alike = [], step.chosen.added.effect.alike
        fitted = {one.added.effect.name for one in others}
        unfitted = sum(name not in fitted for name in alike)
        for one, behind in zip(others, behinds, strict=True):
            if one.added.effect.name in alike:  # no fit can tell them apart
                weights.append(1.0)
                continue
            blur = blur_of(behind, left_nats, step.chosen.over.nats)
            weights.append(weight_of(behind, blur, vibration_nats_of(one, step.chosen)))
        # what a healthy machine shows by chance is neither this cause nor an alternative to it
        real = 1.0 - step.p if step.p == surest else one_more_is_real(step.p)
        share = real * clear[i] * (1.0 - none) / (1.0 + sum(weights) + unfitted)
        of = step.chosen.added.family
        rivals = tuple(
            RivalCause(
                i,
                *one.added.family,
                share * weight,
                behind.nats,
                behind.error,
                of,
                one.added.effect.name,
                vibration_nats=vibration_nats_of(one, step.chosen),
            )
            for one, weight, behind in zip(others, weights, behinds, strict=True)
        )
        out.append((share, rivals))
    return tuple(out)


def one_more_is_real(p: float) -> float:
    """Return the probability that a cause beside the surest one is real, given its chance in healthy runs.

    That there is a gap says nothing of one more cause: it is as likely as not before its size is seen. A
    p-value speaks for it by at most the bound of Sellke, Bayarri and Berger (2001,
    doi:10.1198/000313001300339950).
    """
    if p >= math.exp(-1.0):
        return HALF
    return 1.0 / (1.0 - math.e * p * math.log(p)) if p > 0.0 else 1.0


def blur_of(behind: Advantage, left_nats: float, gained_nats: float) -> float:
    """Return the difference of log-likelihood between two causes that counts as one [nats].

    Args:
        behind: Of the alternative behind the cause.
        left_nats: Score that is left beyond that of a healthy machine.
        gained_nats: By how much the cause predicts held-out blocks better.
    """
    misfit = MISFIT_SHARE * left_nats + GAIN_SHARE * max(gained_nats, 0.0)
    return TEMPERATURE + ERROR_SHARE * behind.error + misfit


def weight_of(behind: Advantage, blur_nats: float, vibration_nats: float = 0.0) -> float:
    """Return how likely an alternative is beside the cause that it is behind.

    Misfits of a simulator blur what it predicts, not what is measured without it.
    """
    blurred = max(min((behind.nats - vibration_nats) / blur_nats, 700.0), 0.0)
    return math.exp(-blurred - max(vibration_nats, -600.0))


def vibration_nats_of(rival: Option, chosen: Option) -> float:
    """Return the nats by which vibration speaks for the chosen one rather than for an alternative."""
    return max(0.0, -rival.added.shaken) - max(0.0, -chosen.added.shaken)


def behind_of(rival: Option, chosen: Option, strata: IntArray) -> Advantage:
    """Return how much better the chosen one predicts than an alternative, each minus its price."""
    ahead = advantage(chosen.unseen, rival.unseen, strata)
    return replace(ahead, nats=ahead.nats + rival.added.price - chosen.added.price)
