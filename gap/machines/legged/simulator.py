"""The legged robot's simulator under diagnosis: its chain, channels and catalogue of effects."""

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import replace
from functools import lru_cache

import numpy as np

from gap.data.check import check_trial
from gap.delegate import MachineSize
from gap.interfaces import Cause, DataFault, Drive, Effect, Observation
from gap.machines.legged.chain import LeggedChain
from gap.machines.legged.channels import channels, cycles_of, make_observation, to_channels
from gap.machines.legged.check import check_legged
from gap.machines.legged.grip import Windows, given_grip, make_windows
from gap.machines.legged.inputs import LeggedInputs, make_inputs
from model.effects.catalogue import STAGES, places_of
from model.effects.leg_kinds import check_effects, effects_of
from model.effects.machine import LeggedMachine
from model.effects.machine_scale import effects_for
from model.effects.settings import Settings, UserEffect, settings_of
from model.values.arrays import FloatArray, readonly
from record.trial.trial import Trial

TRIALS_REMEMBERED = 16


class LeggedSimulator:
    """Implements ``gap.interfaces.Simulator`` for robots with one shaft a leg; a user may add effects."""

    name = "legged"
    stages = STAGES
    bodies = ("body",)

    def __init__(self, machine: LeggedMachine, added: tuple[UserEffect, ...] = ()) -> None:
        self.machine = machine
        self.joints = machine.names.joints
        scaled = effects_for(machine.size)
        known = (scaled[effect.name] for effect in effects_of(machine.leg))
        effects = (*known, *(user.effect for user in added))
        self.effects: tuple[Effect, ...] = effects
        if not machine.names.one_joint_a_leg:
            self.effects = tuple(replace(e, parts=places_of(e, machine.names)) for e in effects)
        self.channels = channels(machine.names)
        size = machine.size
        self.sizes = (
            MachineSize("weight", size.weight_n, "N"),
            MachineSize("reach", size.reach_m, "m"),
        )
        self._added = added
        self._chain = LeggedChain(machine)
        self._inputs = lru_cache(maxsize=TRIALS_REMEMBERED)(self._make_inputs)
        self.windows = lru_cache(maxsize=TRIALS_REMEMBERED)(self._make_windows)

    def observe(self, trial: Trial) -> Observation:
        """Put the measured data of a trial on the channels.

        Raises:
            GapError: It is another robot's, or too short.
        """
        inputs = self._inputs(trial)
        base = self._chain.walk(inputs, self._settings(()), Drive.MEASURED)
        windows, size = self.windows(inputs), self.machine.size
        return make_observation(inputs, base.standing.load_n, windows, size.reach_m)

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        """Return what the channels would read with these causes added, (F, C).

        Raises:
            GapError: A cause is not of the catalogue, cannot be with such legs, or its joints or values
                do not fit.
        """
        inputs = self._inputs(trial)
        # values that a search tries may break the chain: frames without an answer count against the cause
        broken = np.errstate(invalid="ignore", over="ignore", divide="ignore")
        with broken if causes else nullcontext():
            settings = self._settings(causes)
            read = self._chain.reading(inputs, settings, drive)
            windows, grid = self.windows(inputs), inputs.grid
            given = given_grip(windows, grid, read.truth, read.sliding, settings)
        predicted: FloatArray = readonly(
            to_channels(inputs.grid, inputs.command_rad, read.signals, windows, given)
        )
        return predicted

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        """Look for faults of the data: any trial's, and those that geometry and weight show."""
        faults = check_trial(trial)
        if any((fault.kind, fault.channel) == ("unit", "time_s") for fault in faults):
            return faults
        inputs = self._inputs(trial)
        walk = self._chain.read(inputs, self._settings(()), Drive.MEASURED)
        return (*faults, *check_legged(inputs, walk, self.machine.size.weight_n))

    def _settings(self, causes: Sequence[Cause]) -> Settings:
        check_effects(causes, self.machine.leg)
        # the robot file's own last: a step or a patch that is there stays where it is
        return settings_of(
            (*causes, *self.machine.effects), self.machine.names, self.machine.size, self._added
        )

    def _make_windows(self, inputs: LeggedInputs) -> Windows:
        cycle = cycles_of(inputs)[::2]
        return make_windows(inputs.grid.time_s[::2], cycle, self.machine.size.weight_n)

    def _make_inputs(self, trial: Trial) -> LeggedInputs:
        return make_inputs(trial, self.machine.names)
