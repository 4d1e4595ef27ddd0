"""Which candidates these runs cannot distinguish from the named ones."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from gap.constants import CLEAR_ERRORS, HIDDEN_SHARE, STILL_LIKELY, VIBRATION_CLEAR
from gap.diagnosis.alternatives.probability import RivalCause
from gap.residuals.evidence import Evidence
from gap.rounding import value_words
from gap.search.fit import ENOUGH_SEPARATION, Fitted, energy_left
from gap.search.steps import Selection, Step
from model.values.arrays import FloatArray

MOST_OPEN = 2


@dataclass(frozen=True, slots=True)
class OpenRival(RivalCause):
    """An alternative that cannot be ruled out.

    Attributes:
        separation: Energy between what it and the named cause predict, in units of noise; NaN for one that
            was not fitted.
        tells: What would have to be measured, where nothing was between the two; else empty.
    """

    separation: float
    tells: str = ""

    @property
    def looks_the_same(self) -> bool:
        """Whether the two predict the same within noise."""
        return self.separation < ENOUGH_SEPARATION

    @property
    def predicts_as_well(self) -> bool:
        """Whether it predicts held-out blocks as well within the scatter of blocks."""
        return self.behind < CLEAR_ERRORS * self.behind_error and self.behind < ENOUGH_SEPARATION

    @property
    def is_likely(self) -> bool:
        """Whether its probability is still that of an open alternative."""
        return self.probability >= STILL_LIKELY

    @property
    def predicts_better(self) -> bool:
        """Whether it clearly predicts held-out blocks better than what is named (for another reason)."""
        return self.behind < -max(CLEAR_ERRORS * self.behind_error, ENOUGH_SEPARATION)

    @property
    def is_distinguished(self) -> bool:
        """Whether these runs distinguish the two, and the alternative is open all the same."""
        if self.tells or self.looks_the_same:
            return False
        return self.predicts_better or not (self.predicts_as_well or self.behind < 0.0)

    @property
    def why(self) -> str:
        """Why it cannot be ruled out."""
        if self.tells:
            return f"nothing was measured between them: {self.tells}"
        if self.looks_the_same:
            return f"separation {self.separation:.2g}, {ENOUGH_SEPARATION:.0f} settles it"
        if self.behind < 0.0:
            higher = value_words(-self.behind, self.behind_error)
            return f"its held-out log-likelihood is higher by {higher} nats"
        if self.predicts_as_well:
            worse = value_words(self.behind, self.behind_error)
            return f"its held-out log-likelihood is lower by only {worse} nats"
        if self.is_likely:
            return f"its probability is still {self.probability:.2f}"
        return (
            f"its held-out log-likelihood is {self.behind:.2g} nats lower, less than "
            f"{HIDDEN_SHARE:.0%} of what all causes leave unexplained"
        )


def open_rivals(
    evidence: Evidence,
    selection: Selection,
    rivals: Sequence[Sequence[RivalCause]],
    left_nats: float,
) -> tuple[OpenRival, ...]:
    """Return every alternative that these runs leave open, nearest first.

    The alternatives are those of each step, as ``gap.diagnosis.alternatives.probability.chances`` has them;
    ``left_nats`` is what the causes leave beyond what a healthy machine does.
    """
    alternatives: list[OpenRival] = []
    named = {step.chosen.added.family for step in selection.steps}
    for number, (step, known) in enumerate(zip(selection.steps, rivals, strict=True)):
        chosen = step.chosen.fitted
        weights = evidence.weights(chosen.residual)
        own = [
            # not the other way round: a cause of any size imitates an alternative that does nothing
            OpenRival(**asdict(one), separation=separation(chosen, option.fitted, weights))
            for option, one in zip(selection.rivals_of(number), known, strict=True)
        ]
        left_open = [
            one
            for one in own
            if one.vibration_nats < VIBRATION_CLEAR
            and (
                one.looks_the_same
                or one.predicts_as_well
                or one.is_likely
                or one.behind < HIDDEN_SHARE * left_nats
            )
        ]
        alike = [one for one in _alike(number, step, own) if _key(one) not in named]
        keys = {_key(one) for one in alike}
        left_open = [one for one in left_open if _key(one) not in keys]
        alternatives += [*alike, *sorted(left_open, key=lambda one: one.behind)[:MOST_OPEN]]
    return tuple(alternatives)


def _key(one: RivalCause) -> tuple[str, tuple[str, ...]]:
    return one.effect, one.joints


def _alike(number: int, step: Step, own: Sequence[OpenRival]) -> Iterator[OpenRival]:
    """Yield what nothing that was measured lies between, fitted or not."""
    effect, joints = step.chosen.added.effect, step.chosen.added.joints
    fitted = {_key(one): one for one in own}
    nothing = (np.nan, np.nan, np.nan)
    for name in effect.alike:
        of = step.chosen.added.family
        unknown = OpenRival(number, name, joints, *nothing, of, name, separation=np.nan)
        yield replace(fitted.get((name, joints), unknown), tells=effect.tells)


def separation(of: Fitted, by: Fitted, weights: FloatArray) -> float:
    """Energy that is left between two predictions when ``by`` is adjusted to ``of`` to first order.

    Weights of the residuals are (F, C).
    """
    root = np.sqrt(weights)
    return energy_left((by.residual - of.residual) * root, by.slopes * root, prior=1.0)
