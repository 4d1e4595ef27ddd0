"""Edges: of a patch that nothing crossed, and of limits, below which they act at once.

Slippery ground below all feet is no patch, it is less grip everywhere. The slope of a limit says little of
the values around it; each value that its slopes were taken about was predicted, so what it gains is known.
"""

from collections.abc import Sequence
from dataclasses import replace

from gap.constants import AHEAD_NATS
from gap.residuals.evidence import Evidence
from gap.search.candidates import only_a_limit, size_of
from gap.search.options import Option
from gap.search.screen import Gain, Signatures
from model.values.arrays import FloatArray


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


def limits_as_they_act(
    evidence: Evidence, residual: FloatArray, signatures: Signatures, ranked: Sequence[Gain]
) -> list[Gain]:
    """Return what candidates gain, best first; limits at the best of their values, if that is more.

    Args:
        evidence: What is fitted to.
        residual: What is left so far, whitened, (F, C).
        signatures: Of all candidates.
        ranked: What they gain to first order.
    """
    before = float(evidence.score(residual).sum())
    best: dict[tuple[str, tuple[str, ...]], Gain] = {
        one.signature.candidate.key: one for one in ranked
    }
    for one in signatures.each:
        known = best.get(one.candidate.key)
        if known is None or not only_a_limit(one.candidate.effect) or one.offset < 0:
            continue
        change = signatures.matrix[one.offset].reshape(residual.shape)
        away = size_of(one.candidate.cause(one.start), one.candidate.effect)
        nats = before - float(evidence.score(residual - change).sum()) - 0.5 * away**2
        if nats > known.nats:
            best[one.candidate.key] = replace(known, signature=one, values=one.start, nats=nats)
    return sorted(best.values(), key=lambda gain: (-gain.nats, gain.signature.candidate.key))
