"""Which trials judge: chosen by the user, in place of the rule that holds some out evenly."""

from collections.abc import Sequence
from dataclasses import dataclass

from model.errors import GapError


@dataclass(frozen=True, slots=True)
class HoldOut:
    """What is held out of a diagnosis to judge it.

    Attributes:
        trials: Indices of the trials that judge, whole; empty with ``last_third``.
        last_third: Whether the last third of each trial judges what was fitted to the rest.
    """

    trials: tuple[int, ...] = ()
    last_third: bool = False

    def check(self, usable: Sequence[int]) -> None:
        """Make sure that there is something to fit to and something to judge.

        Args:
            usable: Indices of the trials that are long enough.

        Raises:
            GapError: There is not.
        """
        if self.last_third:
            return
        held = [one for one in usable if one in self.trials]
        if not held:
            raise GapError(
                "the runs that are held out are too short to judge; hold out longer ones"
            )
        if len(held) == len(usable):
            raise GapError("every run is held out, so there is none to fit to; hold out fewer")
