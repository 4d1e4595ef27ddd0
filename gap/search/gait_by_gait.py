"""Whether a cause is new by runs of the same gait alone.

What a simulator has wrong can look like a cause in one gait and not in another, in trials and references
alike, and much more so than causes do as a rule. Then runs scatter little within a gait, and a cause is new
by how far the trials of each gait are ahead of the references of that gait: an analysis of variance with
gait as a fixed effect, in which the cause may have another size in every gait.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap.residuals.moderated import Scatter
from gap.search.scatter import HealthyScatter, healthy_scatter
from gap.search.sizes import Sizes


@dataclass(frozen=True, slots=True)
class GaitByGait:
    """Trials against references of the same gait, for those gaits that both have.

    Attributes:
        ahead: By how much sizes are ahead, in the mean of gaits as precise as each is.
        square: Of what trials are ahead by in each gait, over its variance in units of a run's, summed.
        gaits: How many there are.
        scatter: Of runs of one gait.
    """

    ahead: float
    square: float
    gaits: int
    scatter: HealthyScatter


def has_gaits(seen: Sizes, known: Sizes) -> bool:
    """Whether there are several gaits, one that both have, and scatter in one."""
    trials, references = seen.by_gait(), known.by_gait()
    scatters = any(len(one) > 1 for one in (*trials.values(), *references.values()))
    return len({*trials, *references}) > 1 and bool(trials.keys() & references.keys()) and scatters


def gait_by_gait(
    seen: Sizes, known: Sizes, others: Sequence[Sizes], usual: Scatter
) -> GaitByGait | None:
    """Compare sizes in trials with sizes in references; None with one gait, or without scatter in one.

    Args:
        seen: Sizes in M trials.
        known: In N references.
        others: As of ``gap.search.novelty.chance_of``.
        usual: How much sizes of other causes scatter within a gait, in units of these sizes.
    """
    if not has_gaits(seen, known):
        return None
    trials, references = seen.by_gait(), known.by_gait()
    common = [gait for gait in trials if gait in references]
    own = [*trials.values(), *references.values()]
    off = [float(trials[g].values.mean() - references[g].values.mean()) for g in common]
    worth = [1.0 / (1.0 / len(trials[g]) + 1.0 / len(references[g])) for g in common]
    elsewhere = [cell for one in others for cell in one.by_gait().values()]
    return GaitByGait(
        ahead=float(np.dot(off, worth) / np.sum(worth)),
        square=float(np.dot(np.square(off), worth)),
        gaits=len(common),
        scatter=healthy_scatter(own, elsewhere, usual),
    )
