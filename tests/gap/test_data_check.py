"""Each kind of data fault is found where it was done, and none in healthy trials or in any effect."""

import os
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gap.data.time_lag import stream_faults
from gap.interfaces import Cause, DataFault, Scope
from gap.machines.legged.simulator import LeggedSimulator
from model.effects.catalogue import CATALOGUE
from model.effects.machine import parse_machine
from model.values.arrays import FloatArray
from record.trial.trial import Trial, read_trial
from tests.gap.predictions import COULOMB
from tests.gap.walks import machine, simulator, walk
from tests.soaked import soaked

LEGS = machine().legs.names
ML, FR = LEGS.index("ML"), LEGS.index("FR")
Damage = Callable[[Trial], Trial]


@cache
def healthy(gait: str = "metachronal") -> Trial:
    return walk(gait, 0.2, 15.0, [COULOMB], noise_seed=5)


def changed(trial: Trial, field: str, change: Callable[[FloatArray], None]) -> Trial:
    array = getattr(trial, field).copy()
    change(array)
    return replace(trial, **{field: array})


def at(
    field: str, index: tuple[int | slice, ...], change: Callable[[FloatArray], FloatArray]
) -> Damage:
    def damage(trial: Trial) -> Trial:
        def inner(array: FloatArray) -> None:
            array[index] = change(array[index])

        return changed(trial, field, inner)

    return damage


def exchanged(field: str, j: int, k: int) -> Damage:
    def damage(trial: Trial) -> Trial:
        def inner(array: FloatArray) -> None:
            array[:, [j, k]] = array[:, [k, j]]

        return changed(trial, field, inner)

    return damage


def late(fields: tuple[str, ...], seconds: float, skew: float = 0.0) -> Damage:
    def damage(trial: Trial) -> Trial:
        when = trial.time_s / (1 + skew) - seconds
        arrays: dict[str, Any] = {}
        for field in fields:
            values = getattr(trial, field)
            flat = values.reshape(len(values), -1)
            moved = np.stack([np.interp(when, trial.time_s, c) for c in flat.T], axis=1)
            arrays[field] = moved.reshape(values.shape)
        return replace(trial, **arrays)

    return damage


def spiked(values: FloatArray) -> FloatArray:
    values = values.copy()
    values[[200, 700, 1100]] += [60.0, -60.0, 80.0]
    return values


def frozen(values: FloatArray) -> FloatArray:
    values = values.copy()
    values[400:700] = values[400]
    return values


def without(values: FloatArray) -> FloatArray:
    values = values.copy()
    values[300:360] = np.nan
    return values


ALL = slice(None)
POSE = ("body_position_m", "body_angles_rad", "foot_m")
FAULTS: tuple[tuple[str, str, Damage], ...] = (
    ("unit", "shaft_ML_rad", at("shaft_rad", (ALL, ML), np.rad2deg)),
    ("unit", "force", at("force_n", (ALL,), lambda f: f / 9.80665)),
    ("unit", "force", at("force_n", (ALL,), lambda f: 1000 * f)),
    ("unit", "foot", at("foot_m", (ALL,), lambda q: 1000 * q)),
    ("unit", "body", at("body_position_m", (ALL,), lambda p: 1000 * p)),
    ("unit", "body_pitch_rad", at("body_angles_rad", (ALL,), np.rad2deg)),
    ("unit", "time_s", lambda t: replace(t, time_s=1000 * t.time_s)),
    ("sign", "shaft_ML_rad", at("shaft_rad", (ALL, ML), np.negative)),
    ("sign", "force", at("force_n", (ALL,), np.negative)),
    ("sign", "force_ML_z_n", at("force_n", (ALL, ML, 2), np.negative)),
    ("sign", "body_pitch_rad", at("body_angles_rad", (ALL, 1), np.negative)),
    ("sign", "body_z_m", at("body_position_m", (ALL, 2), np.negative)),
    ("sign", "foot_y", at("foot_m", (ALL, ALL, 1), np.negative)),
    ("wrap", "shaft_ML_rad", at("shaft_rad", (ALL, ML), lambda a: (a + np.pi) % (2 * np.pi) - np.pi)),
    ("magnitude_only", "force_ML_x_n", at("force_n", (ALL, ML, 0), np.abs)),
    ("swapped", "shaft_ML_rad", exchanged("shaft_rad", ML, FR)),
    ("swapped", "force_ML_z_n", exchanged("force_n", ML, FR)),
    ("swapped", "foot_ML", exchanged("foot_m", ML, FR)),
    ("swapped", "force", at("force_n", (ALL,), lambda f: f[..., [2, 1, 0]])),
    ("swapped", "foot", at("foot_m", (ALL,), lambda q: q[..., [1, 0, 2]])),
    ("frozen", "force_ML_z_n", at("force_n", (ALL, ML, 2), frozen)),
    ("frozen", "shaft_ML_rad", at("shaft_rad", (ALL, ML), frozen)),
    ("frozen", "body_yaw_rad", at("body_angles_rad", (ALL, 2), frozen)),
    ("spikes", "force_ML_y_n", at("force_n", (ALL, ML, 1), spiked)),
    ("gap", "force_ML_z_n", at("force_n", (ALL, ML, 2), without)),
    ("gap", "time_s", lambda t: t.rows((t.time_s < 4.0) | (t.time_s > 4.7))),
    ("saturated", "force_ML_z_n", at("force_n", (ALL, ML, 2), lambda f: np.minimum(f, 12.0))),
    ("clock_offset", "shaft", late(("shaft_rad",), 0.6)),
    ("clock_offset", "force", late(("force_n",), 0.6)),
    ("clock_offset", "body", late(POSE, 0.6)),
    ("clock_offset", "force", late(("force_n",), -0.3)),
    ("clock_offset", "force", late(("force_n",), 0.0, skew=0.03)),
    ("clock_offset", "body", late(POSE, 0.0, skew=0.011)),
)  # fmt: skip


def names(faults: tuple[DataFault, ...]) -> list[tuple[str, str]]:
    return [(fault.kind, fault.channel) for fault in faults]


@pytest.mark.parametrize(
    ("kind", "channel", "damage"),
    FAULTS,
    ids=[f"{k}-{c}-{i}" for i, (k, c, _) in enumerate(FAULTS)],
)
def test_a_fault_is_found_where_it_is(kind: str, channel: str, damage: Damage) -> None:
    found = simulator().check(damage(healthy()))
    assert (kind, channel) in names(found), found
    assert all(fault.evidence and fault.evidence[-1] != "." for fault in found)


def test_one_lone_sample_is_no_plural() -> None:
    def once(values: FloatArray) -> None:
        values[200, ML, 1] += 100.0

    (fault,) = simulator().check(changed(healthy(), "force_n", once))
    assert fault.evidence.startswith("1 lone sample stands out by 99.8 (")


@pytest.mark.parametrize("gait", ["tripod", "metachronal"])
def test_healthy_trials_have_none(gait: str) -> None:
    for seed in (1, None):
        assert simulator().check(walk(gait, 0.2, 15.0, [COULOMB], noise_seed=seed)) == ()
    assert simulator().check(walk(gait, 0.1, 25.0, noise_seed=2, steer=0.5)) == ()


@pytest.mark.parametrize("field", ["force_n", "foot_m", "body_position_m", "shaft_rad"])
def test_a_trial_without_some_of_its_sensors_has_no_faults(field: str) -> None:
    trial = healthy()
    bare = replace(trial, **{field: np.full_like(getattr(trial, field), np.nan)})
    assert simulator().check(bare) == ()


FIRST_OF_STAGE = {entry.stage: entry for entry in reversed(CATALOGUE)}


@pytest.mark.parametrize(
    "entry", soaked(CATALOGUE, lambda e: e in FIRST_OF_STAGE.values(), lambda e: e.name)
)
def test_effects_are_no_data_faults(entry: object) -> None:
    effect = next(e for e in CATALOGUE if e is entry)
    values = tuple(
        float(np.clip(p.neutral + p.spread * (1 if p.upper > p.neutral else -1), p.lower, p.upper))
        for p in effect.parameters
    )
    legs = ("ML",) if Scope.JOINT in effect.scopes else ()
    ill = walk("metachronal", 0.2, 6.0, [COULOMB, Cause(effect.name, legs, values)], noise_seed=1)
    assert [fault for fault in simulator().check(ill) if fault.severe] == []


def test_trials_of_another_origin_are_healthy() -> None:
    data = os.environ.get("BIGANT_SHARED_DATA")
    if not data:
        pytest.skip("BIGANT_SHARED_DATA names no folder of measured data")
    for gait in ("tripod", "metachronal"):
        trial = read_trial(Path(data) / "trial_table_example" / f"{gait}.parquet")
        robot = LeggedSimulator(parse_machine(trial.header.robot_text))
        assert robot.check(trial) == ()


COUNT_A = 0.00336  # one count of the servos' current register


def test_a_coarse_current_that_turns_slowly_is_neither_saturated_nor_frozen() -> None:
    """Near a turning point and under an even load the same count comes again and again."""
    trial = healthy()
    slow = 0.29 * np.sin(2 * np.pi * 0.2 * trial.time_s)
    even = np.where((trial.time_s % 5.0) < 0.8, 0.1, slow)
    current = np.round(np.column_stack([slow, even] * 3) / COUNT_A) * COUNT_A
    assert [
        f for f in simulator().check(replace(trial, current_a=current)) if "current" in f.channel
    ] == []
    clipped = replace(trial, current_a=np.minimum(current, 40 * COUNT_A))
    assert ("saturated", f"current_{LEGS[0]}_a") in names(simulator().check(clipped))
    stuck = current.copy()
    stuck[300:900, 0] = stuck[300, 0]
    found = names(simulator().check(replace(trial, current_a=stuck)))
    assert ("frozen", f"current_{LEGS[0]}_a") in found


def test_a_motor_that_always_pushes_one_way_has_lost_no_sign() -> None:
    """Its current comes near 0 within the noise, and not as near as one whose sign was lost."""
    trial = healthy()
    rows, chance = len(trial.time_s), np.random.default_rng(7)
    sway = np.sin(2 * np.pi * 0.2 * trial.time_s)[:, None]
    noise = 0.012 * chance.standard_normal((rows, 6))
    pushing = np.round(np.clip(0.066 + 0.02 * sway + noise, 2 * COUNT_A, None) / COUNT_A) * COUNT_A
    assert pushing.min() > 0.0
    assert simulator().check(replace(trial, current_a=pushing)) == ()
    both_ways = np.round(np.abs(0.066 * sway + noise) / COUNT_A) * COUNT_A
    found = names(simulator().check(replace(trial, current_a=both_ways)))
    assert [one for one in found if one[0] == "magnitude_only"] == [
        ("magnitude_only", f"current_{leg}_a") for leg in LEGS
    ]


@pytest.mark.parametrize(
    ("ahead_s", "ringing", "said"), [(0.2, 0.0, True), (0.2, 0.07, False), (0.5, 0.07, True)]
)
def test_a_likeness_that_hardly_changes_with_the_lag_is_no_clock_s_offset(
    ahead_s: float, ringing: float, said: bool
) -> None:
    """Legs that ring are as unlike the prediction at any small lag, and the peak is an accident."""
    time_s, legs = np.arange(0.0, 40.0, 0.02), np.arange(6)
    phase = 2 * np.pi * (0.15 * time_s[:, None] + legs / 6)
    rings = np.sin(2 * np.pi * (1.3 + 0.13 * legs) * time_s[:, None] + legs)
    force = np.sin(phase + 2 * np.pi * 0.15 * ahead_s) + ringing * rings
    found = stream_faults(time_s, np.sin(phase), force, "force", "the shafts")
    assert names(found) == ([("clock_offset", "force")] if said else [])
