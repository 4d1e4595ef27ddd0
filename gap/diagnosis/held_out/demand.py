"""What is asked of a cause that gains little of the whole: its size, and its part of its own channels."""

from dataclasses import dataclass

from gap.constants import (
    HELD_OUT_MOST,
    LEAST_SIZE,
    MAY_REACH,
    NOT_BUILT,
    NOT_BUILT_HELD,
    NOT_BUILT_SHARE,
    REST_SHARE,
    SIZEABLE,
)
from gap.diagnosis.comparison.gap_evidence import GapEvidence
from gap.diagnosis.held_out.held_stage import share_of_stage
from gap.search.candidates import size_of
from gap.search.fit import Fitted
from gap.search.options import Option, Walked, ends_on_bound, share_of


@dataclass(frozen=True, slots=True)
class Demand:
    """What a cause must be that gains little of the whole.

    Attributes:
        size: In spreads.
        share: Of the score that it closes in the channels in which it acts.
        held: The same in held-out runs, each stage fed what was measured.
    """

    size: float
    share: float
    held: float


LARGE = Demand(SIZEABLE, REST_SHARE, HELD_OUT_MOST)
AGAIN = Demand(SIZEABLE, REST_SHARE, REST_SHARE)  # of one that was dropped before
MOST = Demand(LEAST_SIZE, HELD_OUT_MOST, HELD_OUT_MOST)
BEYOND_BUILT = Demand(NOT_BUILT, NOT_BUILT_SHARE, NOT_BUILT_HELD)


def may_meet(one: Walked, demand: Demand) -> bool:
    """Whether a candidate may meet a demand when it is fitted."""
    candidate = one.gain.signature.candidate
    size = size_of(candidate.cause(one.gain.values), candidate.effect)
    return one.share >= MAY_REACH * demand.share and size >= MAY_REACH * demand.size


def meets(comparison: GapEvidence, option: Option, standing: Fitted, demand: Demand) -> bool:
    """Whether an option adds what is so large, and explains its part of fitted and of held-out runs."""
    if size_of(option.cause, option.added.effect) < demand.size or ends_on_bound(option):
        return False
    if share_of(comparison.evidence, option, standing, 0.0) < demand.share:
        return False
    causes = option.fitted.causes
    return share_of_stage(comparison, causes, len(causes) - 1) >= demand.held
