"""A cause that is new, beside a better one that healthy runs hardly show: which of them it is.

A candidate that explains more may miss the level by little where one passes that explains a part of the
same: it has more numbers, or its size scatters more from day to day. (A bias of three numbers was named a
drift of one.) That any cause is new shows a gap; the question is then which cause it has, as where energies
show it. The other way round, an effect with numbers of its own at every joint explains a cause at one of
them, and what differs at the others from day to day as well.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence

import numpy as np

from gap.constants import CONTAINS_SHARE, OPEN_LEVEL
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate, candidates_of
from gap.search.cross_validation import advantage
from gap.search.options import CAUSE_LEVEL, Option, ends_on_bound, fit_option, worth
from model.effects.causes import joint_by_joint
from model.values.arrays import FloatArray


def containing(evidence: Evidence, new: Option, others: Iterable[tuple[Option, float]]) -> Option:
    """Return the best option that explains what a new cause explains and more; itself if there is none.

    Args:
        evidence: What is fitted to.
        new: The cause that is new.
        others: Better ones that are not, best first, each with its chance in a healthy machine. One on a
            bound of its values explains nothing.
    """
    for other, p in others:
        if p >= OPEN_LEVEL or ends_on_bound(other):
            continue
        if _ahead(evidence, other, new) and _contains(evidence, other, new):
            return other
    return new


def at_one_joint(
    evidence: Evidence,
    best: Option,
    p: float,
    others: Sequence[Option],
    chance: Callable[[Option], float],
    standing: FloatArray,
) -> tuple[Option, float]:
    """Return a new cause at one joint that explains most of what one at every joint does, and its chance.

    Args:
        evidence: What is fitted to.
        best: What is to be taken.
        p: Its chance in a healthy machine.
        others: What was fitted as well, best first.
        chance: That of another one, ``Look.chance``.
        standing: Score of each block with what stood before, (B,).
    """
    effect = best.added.effect
    if not effect.each or joint_by_joint(best.cause, effect)[0].effect not in evidence.effects:
        return best, p  # or the effect of single joints was taken out of the catalogue
    rest = tuple(one for one in best.fitted.causes if one is not best.cause)
    part = _largest_part(evidence, best, rest, ())
    listed = [one for one in others if set(one.added.joints) & set(effect.each)]
    if all(one.added.key != part.key for one in listed):
        listed.append(_with_part(evidence, part, rest, standing))
    for one in listed:
        most = one.over.nats > CONTAINS_SHARE * best.over.nats or one.added.key == part.key
        if most and not ends_on_bound(one):
            own = chance(one)
            if own < max(CAUSE_LEVEL, p):
                there_too = _at_another_joint(evidence, best, one, chance)
                return (best, p) if there_too else (one, own)
    return best, p


def _largest_part(
    evidence: Evidence, every: Option, beside: tuple[Cause, ...], without: tuple[str, ...]
) -> Cause:
    """What a cause at every joint is at the joint where this explains most beside others."""
    effect = every.added.effect
    parts = [c for c in joint_by_joint(every.cause, effect) if c.joints != without]
    return parts[int(np.argmin(evidence.nats([(*beside, part) for part in parts])))]


def _with_part(
    evidence: Evidence, part: Cause, beside: tuple[Cause, ...], standing: FloatArray
) -> Option:
    added = Candidate(evidence.effects[part.effect], part.joints)
    return fit_option(evidence, added, (*beside, part), standing)


def _at_another_joint(
    evidence: Evidence, every: Option, one: Option, chance: Callable[[Option], float]
) -> bool:
    """Whether the joint that gains most beside a cause at another surely lacks what every joint may.

    It does not if something else at that joint explains clearly more.
    """
    beside = one.fitted.causes
    part = _largest_part(evidence, every, beside, one.added.joints)
    both = _with_part(evidence, part, beside, one.unseen)
    clear = worth(both.over, len(part.values), len(both.unseen))
    if not clear or chance(both) >= CAUSE_LEVEL:
        return False
    return not any(_ahead(evidence, other, both) for other in _others_there(evidence, part, one))


def _others_there(evidence: Evidence, part: Cause, one: Option) -> Iterator[Option]:
    """Yield other causes at a joint, beside a cause at another one."""
    for other in candidates_of(evidence.simulator):
        if other.joints == part.joints and other.effect.name != part.effect:
            start = [min(p.neutral + p.spread, p.upper) for p in other.effect.parameters]
            causes = (*one.fitted.causes, other.cause(start))
            yield fit_option(evidence, other, causes, one.unseen)


def _ahead(evidence: Evidence, one: Option, other: Option) -> bool:
    """Whether one clearly explains more than another."""
    return advantage(one.unseen, other.unseen, evidence.block_part).clear


def _contains(evidence: Evidence, other: Option, new: Option) -> bool:
    """Whether little is left for the new cause beside the other."""
    both = fit_option(evidence, new.added, (*other.fitted.causes, new.cause), other.unseen)
    return both.over.nats < (1.0 - CONTAINS_SHARE) * new.over.nats
