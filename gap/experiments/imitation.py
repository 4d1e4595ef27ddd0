"""The size at which an alternative looks most like causes that were named, in the runs that were made."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gap.interfaces import Cause, Drive, Simulator, reach_of
from gap.residuals.floor import Floor
from gap.residuals.pool import PredictionRequest
from gap.residuals.predictions import Misfit, Predictor
from gap.search.candidates import Candidate, starts_of, stepped
from gap.search.fit import PLAIN, fit_causes
from model.values.arrays import FloatArray
from record.trial.trial import Trial

STEPS = 4
UNSEEN = 1e12  # noise of a channel that is not measured


@dataclass(frozen=True, eq=False)
class Imitation(Misfit):
    """What causes predict against what a goal does, end to end: of each trial only its commands count.

    The noise is the standard deviation of each trial's channels, (F, C); the drive is another for trials
    without commands.
    """

    noise: Sequence[FloatArray]
    goal: tuple[Cause, ...]
    drive: Drive = Drive.COMMAND

    @cached_property
    def goal_prediction(self) -> FloatArray:
        """What the goal predicts, in units of the noise, (F, C) of all trials."""
        return self.predicted(self.goal)

    def predicted(self, causes: tuple[Cause, ...]) -> FloatArray:
        """Return what causes predict, in units of the noise, (F, C) of all trials."""
        requests = [PredictionRequest(i, causes, self.drive) for i in range(len(self.noise))]
        predicted = self.predictor.predict(requests)
        rows = [one / noise for one, noise in zip(predicted, self.noise, strict=True)]
        return np.nan_to_num(np.concatenate(rows))

    def residuals(self, sets: Sequence[tuple[Cause, ...]]) -> list[FloatArray]:
        """Return the goal minus what each set predicts."""
        return [self.goal_prediction - self.predicted(causes) for causes in sets]


def noise_of(simulator: Simulator, trials: Sequence[Trial], floor: Floor) -> list[FloatArray]:
    """Return the standard deviation of each trial's channels, (F, C); large where they weigh little.

    The floor is that of the runs that judge.
    """
    sigma = np.fmax(floor.sigma * np.sqrt(floor.dependence), 1e-12)
    noise = []
    for one in trials:
        observed = simulator.observe(one)
        own = sigma / np.fmax(np.sqrt(observed.weight), 1e-12)
        seen = np.isfinite(observed.values).any(axis=0)
        # of a run that was made, what it did not measure tells nothing; of a proposal nothing is measured
        noise.append(np.where((seen | ~seen.any()) & floor.compared, own, UNSEEN))
    return noise


def imitate(
    simulator: Simulator,
    trials: Sequence[Trial],
    causes: tuple[Cause, ...],
    of: int,
    rival: Candidate,
    floor: Floor,
    drive: Drive = Drive.COMMAND,
) -> tuple[Cause, ...]:
    """Replace one cause, ``causes[of]``, by an alternative at the size that predicts the same runs best.

    The floor is that under the drive.
    """
    noise = noise_of(simulator, trials, floor)
    misfit = Imitation(Predictor(simulator, trials), noise, causes, drive)

    def put(values: Sequence[float]) -> tuple[Cause, ...]:
        return (*causes[:of], rival.cause(values), *causes[of + 1 :])

    silent = []
    for i in range(len(rival.neutral)):
        values = stepped(rival.effect.parameters, rival.neutral, i, 1.0)
        pair = (misfit.predicted(put(values)), misfit.predicted(put(rival.neutral)))
        silent.append(bool(np.allclose(*pair, atol=1e-6)))
    reach = reach_of([simulator.observe(one) for one in trials])
    starts = starts_of(rival.effect, silent, reach)
    fits = [fit_causes(misfit, put(start), STEPS, PLAIN, of) for start in starts]
    return min(fits, key=lambda one: one.nats).causes
