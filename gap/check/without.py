"""A simulator with part of its catalogue taken away: what is said when the cause has no name?"""

from collections.abc import Sequence
from dataclasses import dataclass

from gap.interfaces import Cause, Channel, DataFault, Drive, Effect, Observation, Simulator
from model.errors import GapError
from model.values.arrays import FloatArray
from record.trial.trial import Trial


@dataclass(frozen=True, slots=True)
class Without:
    """A simulator that does not know some effects.

    Attributes:
        whole: The simulator.
        missing: Names of the effects taken away.
    """

    whole: Simulator
    missing: frozenset[str]

    @property
    def name(self) -> str:
        """Name of the whole simulator."""
        return self.whole.name

    @property
    def stages(self) -> tuple[str, ...]:
        """Its stages."""
        return self.whole.stages

    @property
    def joints(self) -> tuple[str, ...]:
        """Its joints."""
        return self.whole.joints

    @property
    def effects(self) -> tuple[Effect, ...]:
        """Its effects without the missing ones."""
        return tuple(e for e in self.whole.effects if e.name not in self.missing)

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Its channels."""
        return self.whole.channels

    def observe(self, trial: Trial) -> Observation:
        """Observe as the whole simulator does."""
        return self.whole.observe(trial)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Predict as the whole simulator does.

        Raises:
            GapError: A cause is a missing one.
        """
        for cause in causes:
            if cause.effect in self.missing:
                raise GapError(f"{cause.effect} has been taken out of the catalogue")
        return self.whole.predict(trial, causes, drive)

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Check as the whole simulator does."""
        return self.whole.check(trial)


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
