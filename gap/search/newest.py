"""Which candidates are newest to first order: small ones, too, behind what the simulator has wrong.

Where a simulator is wrong in something that healthy runs show as well, many candidates gain by that. One
that gains little, and that no healthy run shows, would not be among the best of them.
"""

from gap.residuals.chances import clearer
from gap.search.candidates import Family
from gap.search.healthy_search import HealthySearch, chance_of_fits
from gap.search.run_fits import fits_of


def newest(search: HealthySearch) -> dict[Family, float]:
    """Return the chance of what the trials show of each candidate, the least of its forms."""
    alone, beside = (
        [
            chance_of_fits(fits, search.trials, search.references, view.usual)
            for fits in fits_of(search.with_trials, search.signatures, days)
        ]
        for view, days in ((search.alone, None), (search.beside, search.days))
    )
    out: dict[Family, float] = {}
    for (own, _), first, second in zip(search.alone.fits, alone, beside, strict=True):
        family = own.signature.candidate.family
        out[family] = min(out.get(family, 1.0), clearer(first, second))
    return out
