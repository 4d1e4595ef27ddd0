"""The chance of a fitted cause in a healthy machine, beside what differs from day to day.

By itself a cause is fitted again to each reference as it is measured (``gap.search.novelty``). Here it is
compared by its change in the trials, over which references are laid, and by generalised least squares.
"""

from collections.abc import Sequence

import numpy as np

from gap.residuals.evidence import Evidence
from gap.search.candidates import Candidate
from gap.search.healthy_search import HealthySearch
from gap.search.novelty import SEEN, across_of, chance_of
from gap.search.run_fits import RunFits, slices_of
from gap.search.sizes import Sizes
from model.values.arrays import FloatArray


def chance_beside_days(
    evidence: Evidence,
    search: HealthySearch,
    candidate: Candidate,
    values: tuple[float, ...],
    change: FloatArray,
    without: FloatArray,
) -> float:
    """Return the chance of so large a cause in a healthy machine, for this one candidate.

    Args:
        evidence: The trials.
        search: What was found in references.
        candidate: What was added.
        values: Its parameters, as fitted.
        change: By how much it changes the residual, (F, C).
        without: Residual with all causes but it, (F, C).
    """
    pull, energy = _pulls(evidence, search, candidate, change, without)
    shown = energy > SEEN * max(float(energy.max()), 1e-30)
    gaits = (*(part.gait for part in evidence.parts), *search.laid.gaits)
    sizes = Sizes(np.where(shown, pull / np.where(shown, energy, 1.0), np.nan), gaits)
    trials = len(evidence.parts)
    seen, known = sizes.taken(range(trials)), sizes.taken(range(trials, len(sizes)))
    if not len(seen):
        return 1.0
    usual = search.beside.usual.of(bool(candidate.joints))
    expected = usual.times(1.0 / max(float(energy[trials:].mean()), 1e-30))
    alike = _alike(search, candidate, values)
    return chance_of(seen, known, alike, len(values), expected)


def _pulls(
    evidence: Evidence, search: HealthySearch, candidate: Candidate, change: FloatArray,
    without: FloatArray,
) -> tuple[FloatArray, FloatArray]:  # fmt: skip
    """Pull on a change in each trial and in each reference, and its energies, beside other causes."""
    laid, signatures = search.laid, search.signatures
    own = {
        row
        for one in signatures.each
        if one.candidate.family == candidate.family
        for row in one.rows
    }
    kept = np.array([row not in own for row in laid.linear], dtype=bool)
    rows, weight = laid.linear[kept], np.diag(1.0 / search.beside.days[kept])
    trials = len(evidence.parts)
    pulls, energies = np.zeros(trials + len(laid.gaits)), np.zeros(trials + len(laid.gaits))
    for part, cut in enumerate(slices_of(evidence)):
        changed, left = (one.ravel()[cut].astype(np.float32) for one in (change, without))
        block = signatures.matrix[:, cut]
        along = (block @ changed).astype(np.float64)[rows]
        taken = np.linalg.solve(laid.runs.grams[part][np.ix_(rows, rows)] + weight, along)
        energy = float(changed @ changed) - float(taken @ along)
        pulls[part] = float(changed @ left) - float(taken @ (block @ left).astype(np.float64)[rows])
        energies[part] = energy
        for run in (r for r, at in enumerate(laid.runs.parts) if at == part):
            pull = float(changed @ laid.residuals[run])
            pulls[trials + run] = pull - float(taken @ laid.runs.pulls[run, rows])
            energies[trials + run] = energy
    return pulls, energies


def _alike(search: HealthySearch, candidate: Candidate, values: tuple[float, ...]) -> list[Sizes]:
    """Sizes in references of the same change at other joints, and across it; none if it is not linear."""
    for own, others in search.beside.fits:
        signature = own.signature
        if signature.candidate.key == candidate.key and signature.offset < 0:
            direction = _direction(own, values)
            across = across_of(own.gram.mean(axis=0), direction) if len(direction) > 1 else ()
            references = range(len(own.gaits))
            return [
                *(one.along(direction).taken(references) for one in others),
                *(own.along(one).taken(references) for one in across),
            ]
    return []


def _direction(own: RunFits, values: Sequence[float]) -> FloatArray:
    """Fitted values as spreads away from where a candidate was differenced, one a row."""
    signature = own.signature
    parameters = signature.candidate.effect.parameters
    return np.array(
        [(values[i] - signature.start[i]) / parameters[i].spread for i in signature.live]
    )
