"""Edges that nothing crossed: slippery ground below all feet is no patch, it is less grip everywhere."""

from collections.abc import Sequence
from dataclasses import replace

from gap.constants import AHEAD_NATS
from gap.residuals.evidence import Evidence
from gap.search.options import Option


def with_seen_edges(evidence: Evidence, options: Sequence[Option]) -> list[Option]:
    """Return options without those whose edge leaves no trace, where one without an edge does as well."""
    return [
        one
        for one in options
        if not any(_as_good(other, one) for other in options) or not _unseen(evidence, one)
    ]


def _as_good(simpler: Option, one: Option) -> bool:
    """Whether an option explains as much in the same stage with fewer parameters, a nat each."""
    fewer = len(one.added.effect.parameters) - len(simpler.added.effect.parameters)
    same_stage = simpler.added.effect.stage == one.added.effect.stage
    behind = one.over.nats - simpler.over.nats
    return same_stage and fewer > 0 and behind < AHEAD_NATS + fewer


def _unseen(evidence: Evidence, option: Option) -> bool:
    """Whether its edge may as well be anywhere before all that the machine touched."""
    cause = option.cause
    pairs = tuple(zip(option.added.effect.parameters, cause.values, strict=True))
    if not any(p.located for p, _ in pairs):
        return False
    before = replace(cause, values=tuple(p.lower if p.located else value for p, value in pairs))
    causes = tuple(before if one == cause else one for one in option.fitted.causes)
    fitted, moved = (
        float(evidence.score(one).sum())
        for one in (option.fitted.residual, evidence.residuals([causes])[0])
    )
    return moved - fitted < AHEAD_NATS
