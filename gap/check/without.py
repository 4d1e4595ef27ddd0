"""A simulator with part of its catalogue taken away: what is diagnosed when the cause has no name?"""

from collections.abc import Sequence

from gap.delegate import Delegate
from gap.interfaces import Cause, Drive, Simulator
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial


class Without(Delegate):
    """A simulator that does not know some effects.

    Args:
        whole: The simulator.
        missing: Names of the effects taken away.
    """

    def __init__(self, whole: Simulator, missing: frozenset[str]) -> None:
        super().__init__(whole)
        self.missing = missing
        self.effects = tuple(e for e in whole.effects if e.name not in missing)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Predict as the whole simulator does.

        Raises:
            GapError: A cause is a missing one.
        """
        for cause in causes:
            if cause.effect in self.missing:
                raise GapError(f"{cause.effect} has been taken out of the catalogue")
        return super().predict(trial, causes, drive)


def without(simulator: Simulator, names: Sequence[str]) -> Simulator:
    """Return the simulator without some effects.

    Raises:
        GapError: It has no such effect.
    """
    known = {effect.name for effect in simulator.effects}
    for name in names:
        if name not in known:
            raise GapError(
                f"{name!r} is no effect of the {simulator.name} simulator; see: bigant gap effects"
            )
    return Without(simulator, frozenset(names)) if names else simulator
