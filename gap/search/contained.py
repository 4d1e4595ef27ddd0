"""A cause that is new, beside a better one that healthy runs hardly show: which of them it is.

A candidate that explains more may miss the level by little where one passes that explains a part of the
same: it has more numbers, or its size scatters more from day to day. (A bias of three numbers was named a
drift of one.) That any cause is new shows a gap; the question is then which cause it has, as where energies
show it.
"""

from collections.abc import Iterable

from gap.constants import AHEAD_NATS, CONTAINS_SHARE, OPEN_LEVEL
from gap.residuals.evidence import Evidence
from gap.search.cross_validation import advantage
from gap.search.options import Option, ends_on_bound, fit_option


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
        ahead = advantage(other.unseen, new.unseen, evidence.block_part)
        if ahead.nats > max(ahead.error, AHEAD_NATS) and _contains(evidence, other, new):
            return other
    return new


def _contains(evidence: Evidence, other: Option, new: Option) -> bool:
    """Whether little is left for the new cause beside the other."""
    both = fit_option(evidence, new.added, (*other.fitted.causes, new.cause), other.unseen)
    return both.over.nats < (1.0 - CONTAINS_SHARE) * new.over.nats
