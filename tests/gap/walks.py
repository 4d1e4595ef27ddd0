"""Trials for the tests of the legged simulator, made by a gait and the chain itself."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from gaits.catalog import make_gait
from gap.delegate import Without
from gap.diagnosis.answer.findings import Diagnosis
from gap.diagnosis.comparison.commissioning import commissioned_study
from gap.diagnosis.diagnose import diagnose_study
from gap.effect_file import UserEffect
from gap.interfaces import Cause, Drive
from gap.machines.legged.chain import LeggedChain
from gap.machines.legged.inputs import make_inputs
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.machine import LeggedMachine, parse_machine
from model.effects.settings import settings_of
from model.values.arrays import FloatArray, readonly
from record.trial.header import TrialHeader, TrialNoise
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial
from robot.config.robot_file import load_robot

NOISE = TrialNoise(0.15, 5e-4, 2e-3, 8e-4, 5e-4)
RATE_HZ = 100.0


def cause(effect: str, *values: float, legs: tuple[str, ...] = ()) -> Cause:
    return Cause(effect, legs, values)


@cache
def machine() -> LeggedMachine:
    return parse_machine(load_robot().text)


@cache
def simulator() -> LeggedSimulator:
    return LeggedSimulator(machine())


@cache
def command_trial(gait: str, frequency_hz: float, seconds: float, steer: float = 0.0) -> Trial:
    """Commands of a gait in steady walking, and nothing else."""
    robot = load_robot()
    plan = make_gait(gait, robot.parameters)
    time_s = np.arange(round(seconds * RATE_HZ) + 1) / RATE_HZ
    motion = plan.motion(plan.start_phase + frequency_hz * time_s, steer)
    legs = robot.parameters.legs.names
    header = TrialHeader(
        "legged", legs, gait, frequency_hz, RATE_HZ, "", NOISE, "bigant.toml", robot.text
    )
    commands = [
        TableColumn(f"command_{leg}_rad", motion.angle_rad[:, k]) for k, leg in enumerate(legs)
    ]
    return build_trial(header, (TableColumn("time_s", time_s), *commands))


def walk(
    gait: str,
    frequency_hz: float = 0.2,
    seconds: float = 10.0,
    causes: Sequence[Cause] = (),
    *,
    steer: float = 0.0,
    noise_seed: int | None = None,
    added: tuple[UserEffect, ...] = (),
) -> Trial:
    """A trial with everything measured, as the chain has it with these causes."""
    bare = command_trial(gait, frequency_hz, seconds, steer)
    names = machine().names
    inputs = make_inputs(bare, names)
    read = LeggedChain(machine()).read(
        inputs, settings_of(causes, names, machine().size, added), Drive.COMMAND
    )
    rng = np.random.default_rng(noise_seed)

    def samples(values: FloatArray, sigma: float) -> FloatArray:
        flat = values.reshape(len(values), -1)
        fine = np.stack(
            [np.interp(bare.time_s, read.time_s, column) for column in flat.T], axis=1
        ).reshape(len(bare.time_s), *values.shape[1:])
        if noise_seed is not None:
            fine = fine + rng.normal(0.0, sigma, fine.shape)
        array: FloatArray = readonly(fine)
        return array

    return replace(
        bare,
        shaft_rad=samples(read.shaft_rad, NOISE.shaft_rad),
        foot_m=samples(read.foot_m, NOISE.foot_position_m),
        force_n=samples(read.force_n, NOISE.force_n),
        body_position_m=samples(read.body_m, NOISE.body_position_m),
        body_angles_rad=samples(read.body_rad, NOISE.body_angle_rad),
    )


def diagnosed_among(
    effects: Collection[str], trials: Sequence[Trial], references: Sequence[Trial],
    standing: tuple[Cause, ...],
) -> Diagnosis:  # fmt: skip
    """Diagnose with these effects alone in the catalogue, which takes seconds."""
    whole = simulator()
    others = {effect.family for effect in whole.effects} - set(effects)
    lacking = Without(whole, tuple(others))
    return diagnose_study(commissioned_study(trials, lacking, references, standing=standing))
