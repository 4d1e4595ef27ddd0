"""Any simulator that makes a whole trial from commands, under diagnosis through the same interface.

A physics engine (the MuJoCo twin) is one piece: it has no stages that could be fed measured inputs one
by one. Its answers are put on the channels of the legged simulator, with the same filters.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from gap.delegate import Delegate
from gap.interfaces import Cause, Drive, Effect, check_causes
from gap.machines.legged.channels import to_channels
from gap.machines.legged.inputs import make_inputs
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.machine import LeggedMachine
from model.errors import GapError
from model.values.arrays import FloatArray, readonly
from record.trial.trial import Trial

ROLLOUTS_REMEMBERED = 64
# The only stage whose inputs are the commands, whatever the drive.
FED_BY_COMMANDS = "actuation"

Rollout = Callable[[Trial, tuple[Cause, ...]], Trial]


class RolloutSimulator(Delegate):
    """A simulator around a rollout, on the channels of the legged simulator.

    Args:
        name: Its name, for example ``mujoco``.
        machine: The robot.
        effects: What the rollout can add to itself; their names and parameters are those of the catalogue.
        rollout: Given a trial and causes, the trial as it would have been: the same commands and legs, what
            sensors without noise would have read at (about) the same times, NaN where it has no answer. The
            same arguments must give the same trial.
    """

    def __init__(
        self, name: str, machine: LeggedMachine, effects: tuple[Effect, ...], rollout: Rollout
    ) -> None:
        legged = LeggedSimulator(machine)
        super().__init__(legged)
        self._windows = legged.windows
        self.name, self.effects = name, effects
        self._names = machine.names
        self._channels_of = lru_cache(maxsize=ROLLOUTS_REMEMBERED)(self._roll)
        self._rollout = rollout

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Return what the channels would read, (F, C).

        Fed what was measured, only channels of the actuation are known (commands feed them); the others
        are NaN.

        Raises:
            GapError: A cause is not among the effects, or the rollout's trial does not fit.
        """
        check_causes(causes, self, "leg")
        values = self._channels_of(trial, tuple(causes))
        if drive is Drive.COMMAND:
            return values
        own = np.array([channel.stage == FED_BY_COMMANDS for channel in self.channels])
        known_values: FloatArray = readonly(np.where(own, values, np.nan))
        return known_values

    def _roll(self, trial: Trial, causes: tuple[Cause, ...]) -> FloatArray:
        made = self._rollout(trial, causes)
        wanted = make_inputs(trial, self._names)
        got = make_inputs(made, self._names)
        if got.grid.frames != wanted.grid.frames or got.grid.period_s != wanted.grid.period_s:
            raise GapError(
                f"{self.name} answered with {got.grid.frames} frames of {got.grid.period_s:g} s, "
                f"the trial has {wanted.grid.frames} of {wanted.grid.period_s:g} s"
            )
        values: FloatArray = readonly(
            to_channels(wanted.grid, wanted.command_rad, got, self._windows(wanted))
        )
        return values
