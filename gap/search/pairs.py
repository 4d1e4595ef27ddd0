"""Two causes that explain together what neither explains alone, sought where no single one is worth it.

Friction that a nominal file has fitted into its motor's constants is such a pair: adding the friction makes
the prediction worse until the constants give way, and the constants alone are right as they stand. Pairs
are ranked to first order, and the best are fitted and judged as single causes are.
"""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate, families_of
from gap.search.look import Look
from gap.search.options import Option, fit_option, worth
from gap.search.screen import Signatures
from gap.search.steps import Selection, Step

FITTED = 6  # pairs
MOST_RIVALS = 4


def best_pair(look: Look, selection: Selection, signatures: Signatures) -> Selection | None:
    """Return the selection with the best pair of causes; None where no pair is worth it.

    Args:
        look: Says what is fitted to.
        selection: The causes so far.
        signatures: Of every candidate, about these causes.
    """
    evidence, taken = look.evidence, selection.fitted.causes
    pairs: list[tuple[Option, Option]] = []
    for causes, (one, other) in _starts(evidence, selection, signatures):
        option = fit_option(evidence, other, (*taken, *causes), selection.unseen)
        first = Option(one, option.fitted, option.unseen, option.over)
        pairs.append((first, option))
    pairs = [one for one in pairs if worth(one[1].over, _size(one), len(one[1].unseen))]
    if not pairs:
        return None
    best = max(pairs, key=lambda pair: pair[1].over.nats - _size(pair))
    keys = [option.added.family for option in best]
    rivals: list[list[Option]] = [[], []]
    for pair in sorted(pairs, key=lambda pair: -pair[1].over.nats):
        own = [option.added.family for option in pair]
        for at in (0, 1):  # what stands in the place of one beside the other
            partner = keys[1 - at]
            if pair is not best and partner in own:
                rival = pair[1 - own.index(partner)]
                if rival.added.family != keys[at]:
                    rivals[at].append(rival)
    steps = [Step(one, tuple(own[:MOST_RIVALS])) for one, own in zip(best, rivals, strict=True)]
    fitted, unseen = best[1].fitted, best[1].unseen
    return Selection(fitted, unseen, (*selection.steps, *steps), selection.p)


def _size(pair: tuple[Option, Option]) -> int:
    return sum(len(option.added.effect.parameters) for option in pair)


def _starts(
    evidence: Evidence, selection: Selection, signatures: Signatures
) -> Iterator[tuple[tuple[Cause, Cause], tuple[Candidate, Candidate]]]:
    """Yield the pairs that gain most to first order, with the values to begin from."""
    residual = selection.fitted.residual
    taken = families_of(selection.fitted.causes, evidence.effects)
    smooth = [
        one
        for one in signatures.each
        if one.offset < 0 and one.rows and one.candidate.family not in taken
    ]
    rows = [row for one in smooth for row in one.rows]
    if len(smooth) < 2:
        return
    matrix = signatures.matrix[rows]
    weight = evidence.weights(residual).astype(np.float32).ravel()
    weighted = matrix * weight
    gram = (weighted @ matrix.T).astype(np.float64) + np.eye(len(rows))
    pull = (weighted @ residual.astype(np.float32).ravel()).astype(np.float64)
    places = np.split(np.arange(len(rows)), np.cumsum([len(one.rows) for one in smooth])[:-1])
    ranked = []
    for a, b in combinations(range(len(smooth)), 2):
        if smooth[a].candidate.family == smooth[b].candidate.family:
            continue  # two forms of one cause
        at = np.concatenate([places[a], places[b]])
        step = np.linalg.solve(gram[np.ix_(at, at)], pull[at])
        ranked.append((0.5 * float(pull[at] @ step) - len(at), a, b, step))
    ranked.sort(key=lambda pair: -pair[0])
    for _, a, b, step in ranked[:FITTED]:
        one, other = smooth[a], smooth[b]
        split = len(places[a])
        causes = (
            one.candidate.cause(one.moved(step[:split])),
            other.candidate.cause(other.moved(step[split:])),
        )
        yield causes, (one.candidate, other.candidate)
