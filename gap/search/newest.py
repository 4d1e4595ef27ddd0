"""Which candidates are newest to first order: small ones, too, behind what the simulator has wrong.

Where a simulator is wrong in something that healthy runs show as well, many candidates gain by that. One
that gains little, and that no healthy run shows, would not be among the best of them.
"""

from collections.abc import Iterable

from gap.residuals.chances import clearer
from gap.residuals.evidence import Evidence
from gap.search.candidates import Family
from gap.search.healthy_search import HealthySearch, chance_of_fits
from gap.search.run_fits import FitsElsewhere, fits_of
from model.values.arrays import FloatArray


def newest(search: HealthySearch) -> dict[Family, float]:
    """Return the chance of what the trials show of each candidate, the least of its forms."""
    alone, beside = (
        [chance_of_fits(fits, search.trials, search.references, view.usual) for fits in view.fits]
        for view in (search.alone, search.beside)
    )
    both = (clearer(first, second) for first, second in zip(alone, beside, strict=True))
    return _least(search.alone.fits, both)


def newest_left(
    search: HealthySearch, evidence: Evidence, residual: FloatArray
) -> dict[Family, float]:
    """Return the same of what causes leave of the trials, (F, C), each candidate by itself.

    What differs from day to day says little of it: what is left is also what the simulator has wrong about
    those causes.
    """
    laid = search.left_in_trials(evidence, residual, ())
    fits = fits_of(laid, search.signatures)
    chances = (
        chance_of_fits(one, search.trials, search.references, search.alone.usual) for one in fits
    )
    return _least(fits, chances)


def _least(fits: Iterable[FitsElsewhere], chances: Iterable[float]) -> dict[Family, float]:
    """The least chance of the forms of each cause."""
    out: dict[Family, float] = {}
    for (own, _), chance in zip(fits, chances, strict=True):
        family = own.signature.candidate.family
        out[family] = min(out.get(family, 1.0), chance)
    return out
