"""Which candidates are newest to first order: small ones, too, behind what the simulator has wrong.

Where a simulator is wrong in something that healthy runs show as well, many candidates gain by that. One
that gains little, and that no healthy run shows, would not be among the best of them.
"""

from gap.residuals.chances import clearer
from gap.residuals.evidence import Evidence
from gap.search.candidates import Family
from gap.search.healthy_search import HealthySearch, chance_of_fits
from gap.search.run_fits import fits_of
from model.values.arrays import FloatArray


def newest(evidence: Evidence, search: HealthySearch, residual: FloatArray) -> dict[Family, float]:
    """Return the chance of what the trials show of each candidate, the least of its forms.

    Args:
        evidence: The trials.
        search: What was found in references.
        residual: What is left of the trials, (F, C).
    """
    laid = search.laid.with_trials(evidence, search.signatures, residual)
    references = range(len(search.laid.gaits))
    trials = range(len(references), len(laid.gaits))
    alone, beside = (
        [
            chance_of_fits(own, others, trials, references, view.usual)
            for own, others in fits_of(laid, search.signatures, days)
        ]
        for view, days in ((search.alone, None), (search.beside, search.beside.days))
    )
    out: dict[Family, float] = {}
    for (own, _), first, second in zip(search.alone.fits, alone, beside, strict=True):
        family = own.signature.candidate.family
        out[family] = min(out.get(family, 1.0), clearer(first, second))
    return out
