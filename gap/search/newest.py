"""Which candidates are newest to first order: small ones, too, behind what the simulator has wrong.

Where a simulator is wrong in something that healthy runs show as well, many candidates gain by that. One
that gains little, and that no healthy run shows, would not be among the best of them.
"""

from gap.residuals.chances import clearer
from gap.search.candidates import Family
from gap.search.healthy_search import HealthySearch, chance_of_fits


def newest(search: HealthySearch) -> dict[Family, float]:
    """Return the chance of what the trials show of each candidate, the least of its forms."""
    alone, beside = (
        [chance_of_fits(fits, search.trials, search.references, view.usual) for fits in view.fits]
        for view in (search.alone, search.beside)
    )
    out: dict[Family, float] = {}
    for (own, _), first, second in zip(search.alone.fits, alone, beside, strict=True):
        family = own.signature.candidate.family
        out[family] = min(out.get(family, 1.0), clearer(first, second))
    return out
