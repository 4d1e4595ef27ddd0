"""What a search knows, how far it looks, and the causes that it has taken, step by step."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from gap.constants import LEAST_SHARE
from gap.residuals.evidence import Evidence
from gap.residuals.healthy import Healthy
from gap.search.candidates import Family
from gap.search.fit import ROUNDS, Fitted
from gap.search.healthy_search import HealthySearch
from gap.search.options import SHORTLIST, Option
from model.values.arrays import FloatArray

MOST_CAUSES = 5


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """One cause that was taken, and the others that were fitted in its place, best first.

    ``p`` is its chance in a healthy machine, among all candidates; 0 without references. ``wider`` are
    causes at every joint that it explains most of: while it is named, they are none.
    """

    chosen: Option
    rivals: tuple[Option, ...]
    p: float = 0.0
    wider: tuple[Family, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Selection:
    """The causes.

    Attributes:
        fitted: All of them together.
        unseen: Score of each block without its fold, (B,).
        steps: One a cause, in the order of ``fitted.causes``.
        p: Chance that a healthy machine shows any candidate as large as the best of the first step (or of
            the first after what vibrates, if that is less, for two looks); 1 if there was none.
        nearest: The candidate with that chance.
        refused: Steps to what was new, but held-out runs spoke against.
    """

    fitted: Fitted
    unseen: FloatArray
    steps: tuple[Step, ...]
    p: float = 1.0
    nearest: Option | None = None
    refused: tuple[Step, ...] = ()

    def rivals_of(self, at: int) -> tuple[Option, ...]:
        """Return the alternatives to a cause; what is named as well does not stand in its place."""
        named = {step.chosen.added.family for step in self.steps}
        return tuple(one for one in self.steps[at].rivals if one.added.family not in named)


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """References in units of what the others predict, and what the search finds in each of them.

    Once as evidence, once each by itself. ``held`` are trials that are held out, where there are some.
    """

    runs: Evidence
    each: Sequence[Healthy]
    searched: Callable[[], HealthySearch]
    held: Evidence | None = None

    @property
    def search(self) -> HealthySearch:
        """What the search finds in healthy runs, waited for where it is still under way."""
        return self.searched()


@dataclass(frozen=True, slots=True)
class Search:
    """How far to look.

    Attributes:
        shortlist: Candidates that are fitted at each step.
        most: Causes.
        least_share: Share of the score, in the channels in which it acts, that a cause must close where
            there are no references.
        rounds: Most steps of a fit.
        least_size: Spreads from neutral that a cause must have.
        least_gain: Share of the whole score that a cause must gain where there are no references.
        pairs: Whether two causes are tried together where there are no references and no one is worth it.
        laws: Whether a law that alone gains too little is tried with the cause that it needs.
        walk: Whether causes of the whole machine are ranked as they act at a few sizes. It is for misfits
            that nothing explains: where healthy runs do, what is left is small, and first order is right.
    """

    shortlist: int = SHORTLIST
    most: int = MOST_CAUSES
    least_share: float = LEAST_SHARE
    rounds: int = ROUNDS
    least_size: float = 0.0
    least_gain: float = 0.0
    pairs: bool = False
    laws: bool = False
    walk: bool = False
