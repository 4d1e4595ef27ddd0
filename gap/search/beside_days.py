"""The chance of a fitted cause in a healthy machine, beside what differs from day to day.

By itself a cause is fitted again to each reference as it is measured (``gap.search.novelty``). Here it is
compared by its change in the trials, over which references are laid, and by generalised least squares.
"""

from dataclasses import replace

import numpy as np

from gap.constants import FALSE_ALARMS, SHAPE_DIFFERS
from gap.interfaces import Cause
from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate
from gap.search.fit import Fitted
from gap.search.healthy_search import HealthySearch
from gap.search.novelty import chance_of
from gap.search.run_fits import sizes_alike, slices_of, taken_by_days
from gap.search.sizes import Sizes, sizes_of
from model.values.arrays import FloatArray


def chance_beside_days(
    evidence: Evidence,
    search: HealthySearch,
    candidate: Candidate,
    values: tuple[float, ...],
    change: FloatArray,
) -> float:
    """Return the chance of so large a cause in a healthy machine, for this one candidate.

    Args:
        evidence: The trials.
        search: What was found in references.
        candidate: The only cause, or one more than those that the trials are laid with.
        values: Its parameters, as fitted.
        change: What it changes of what is left of the trials, whitened, (F, C).
    """
    pull, energy = _pulls(evidence, search, candidate, change)
    sizes = sizes_of(pull, energy, search.with_trials.gaits, search.with_trials.days)
    seen, known = sizes.taken(search.trials), sizes.taken(search.references)
    if not len(seen):
        return 1.0
    usual = search.beside.usual.of(bool(candidate.joints))
    expected = usual.times(1.0 / max(float(energy[list(search.references)].mean()), 1e-30))
    return chance_of(seen, known, _alike(search, candidate, values), len(values), expected)


def chance_beside_others(
    evidence: Evidence, search: HealthySearch, candidate: Candidate, added: Cause, fitted: Fitted,
    alone: float,
) -> float:  # fmt: skip
    """Return the same chance of one of several causes, in what the others leave of the trials.

    What they leave is also what the simulator has wrong about them, which no reference shows. So this says
    nothing, 1, of a cause that changes no more than that may be, nor of one that by itself, of which there
    is the chance ``alone``, is like what healthy runs show.
    """
    if alone >= FALSE_ALARMS:
        return 1.0
    others = tuple(one for one in fitted.causes if one is not added)
    (left,) = evidence.residuals([others])
    weights = evidence.weights(fitted.residual)
    changed = float((weights * (left - fitted.residual) ** 2).sum())
    if changed < SHAPE_DIFFERS**2 * float((weights * (evidence.base - left) ** 2).sum()):
        return 1.0
    beside = replace(search, with_trials=search.left_in_trials(evidence, left, ()))
    return chance_beside_days(evidence, beside, candidate, added.values, left - fitted.residual)


def _pulls(
    evidence: Evidence, search: HealthySearch, candidate: Candidate, change: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Pull on a change in each reference and then in each trial, and its energies, beside other causes."""
    laid, signatures = search.with_trials, search.signatures
    own = {
        row
        for one in signatures.each
        if one.candidate.family == candidate.family
        for row in one.rows
    }
    kept = np.array([row not in own for row in laid.linear], dtype=bool)
    rows, variance = laid.linear[kept], search.days[kept]
    pulls, energies = np.zeros((2, len(laid.gaits)))
    for part, cut in enumerate(slices_of(evidence)):
        changed = change.ravel()[cut].astype(np.float32)
        along = (signatures.matrix[:, cut] @ changed).astype(np.float64)[rows]
        taken = taken_by_days(laid.runs.grams[part], rows, variance, along)
        energy = float(changed @ changed) - float(taken @ along)
        for run in (r for r, at in enumerate(laid.runs.parts) if at == part):
            pull = float(changed @ laid.residuals[run])
            pulls[run] = pull - float(taken @ laid.runs.pulls[run, rows])
            energies[run] = energy
    return pulls, energies


def _alike(search: HealthySearch, candidate: Candidate, values: tuple[float, ...]) -> list[Sizes]:
    """Sizes in references of the same change at other joints, and across it; none if it is not linear."""
    for fits in search.beside.fits:
        signature = fits[0].signature
        if signature.candidate.key == candidate.key and signature.offset < 0:
            parameters = candidate.effect.parameters
            direction = np.array(
                [(values[i] - signature.start[i]) / parameters[i].spread for i in signature.live]
            )
            gram = fits[0].gram[list(search.references)].mean(axis=0)
            return sizes_alike(fits, direction, gram, search.references)
    return []
