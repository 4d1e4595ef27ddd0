"""A tiny machine of known truth: three stages, three joints, eight effects.

Stage ``drive`` makes a joint angle, ``press`` a force from it, ``move`` the body's speed from the forces.
Trials are made by the same equations with causes that the engine is not told.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import ClassVar

import numpy as np

from gap.interfaces import (
    Cause,
    Channel,
    DataFault,
    Drive,
    Effect,
    Observation,
    Parameter,
    Scope,
    check_causes,
)
from model.effects.causes import Shaking
from model.values.arrays import FloatArray, readonly
from record.trial.header import SERVO_BENCH, TrialHeader, TrialNoise
from record.trial.table_file import TableColumn
from record.trial.trial import Trial, build_trial

JOINTS = ("a", "b", "c")
HZ = 20.0
NOISE = {"angle": 0.004, "force": 0.05, "speed": 0.01}


def toy_effect(name: str, stage: str, scope: Scope, *parameters: Parameter) -> Effect:
    return Effect(name, stage, parameters, (scope,), f"{name} happens.", f"look at {name}.")


def number(name: str, spread: float, neutral: float = 0.0, lower: float = -9.0) -> Parameter:
    return Parameter(name, "", neutral, lower, 9.0, spread)


EFFECTS = (
    toy_effect("delay", "drive", Scope.ALL, number("delay_s", 0.03, lower=0.0)),
    toy_effect("lag", "drive", Scope.ALL, number("time_constant_s", 0.03, lower=0.0)),
    toy_effect("offset", "drive", Scope.JOINT, number("offset_rad", 0.03)),
    toy_effect("stiffness", "press", Scope.JOINT, number("ratio", 0.2, 1.0, 0.1)),
    toy_effect("bias", "press", Scope.JOINT, number("bias_n", 0.3)),
    toy_effect("square_law", "press", Scope.ALL),
    toy_effect("grip", "move", Scope.JOINT, number("ratio", 0.2, 1.0, 0.1)),
    toy_effect("tether", "move", Scope.ALL, number("x_n", 0.1)),
)
# effects that ``chain`` knows beside these: of a sensor, and at a place
SPEED_GAIN = toy_effect("speed_gain", "sensing", Scope.ALL, number("ratio", 0.1, 1.0, 0.1))
# what no run without a look at its vibration tells from it
CHATTER = replace(
    SPEED_GAIN, name="chatter", shaking=Shaking(("speed",), (("force",),), ("speed_gain",))
)
BUMP = toy_effect(
    "bump", "press", Scope.JOINT, number("height_n", 0.3),
    Parameter("place_rad", "rad", 0.0, -0.6, 0.6, 0.3, located=True),
)  # fmt: skip
# of all joints, beyond an angle
RISE = toy_effect(
    "rise", "press", Scope.ALL, number("height_n", 0.3),
    Parameter("beyond_rad", "rad", 0.2, -0.9, 0.6, 0.3, located=True),
)  # fmt: skip
# the same with the other sign
BEND = replace(toy_effect("bend", "press", Scope.ALL, number("size", 0.2)), even=True)
BUMP_WIDTH = 0.15
CHANNELS = (
    *(Channel("angle", j, "drive", "rad") for j in JOINTS),
    *(Channel("force", j, "press", "N") for j in JOINTS),
    Channel("speed", "", "move", "m/s"),
)


@dataclass(eq=False)
class Toy:
    """Implements ``gap.interfaces.Simulator``.

    ``scale`` multiplies every channel and its noise; ``catalogue`` is what the engine may see.
    """

    catalogue: tuple[Effect, ...] = EFFECTS
    scale: tuple[float, ...] = (1.0,) * 7

    name = "toy"
    stages: ClassVar[tuple[str, ...]] = ("drive", "press", "move")
    bodies: tuple[str, ...] = ()
    joints = JOINTS
    channels = CHANNELS

    @property
    def effects(self) -> tuple[Effect, ...]:
        return self.catalogue

    def observe(self, trial: Trial) -> Observation:
        values = np.column_stack(
            [trial.shaft_rad, trial.force_n[..., 2], trial.body_position_m[:, 0]]
        )
        noise = np.array([NOISE[c.name] for c in CHANNELS])
        cycle = trial.time_s * trial.header.frequency_hz
        scale = np.array(self.scale)
        weight = np.isfinite(values) * 1.0
        return Observation(
            trial.time_s,
            cycle,
            values * scale,
            np.broadcast_to(noise * scale, values.shape),
            weight,
        )

    def predict(self, trial: Trial, causes: Sequence[Cause], drive: Drive) -> FloatArray:
        check_causes(causes, self)
        measured = trial if drive is Drive.MEASURED else None
        out = chain(trial.time_s, trial.header.frequency_hz, trial.header.gait, causes, measured)
        return np.asarray(out * np.array(self.scale))

    def check(self, trial: Trial) -> tuple[DataFault, ...]:
        if np.nanmax(np.abs(trial.shaft_rad)) > 50:
            return (DataFault("unit", "shaft_a_rad", "degrees?", True),)
        return ()


def chain(
    time_s: FloatArray, hz: float, gait: str, causes: Sequence[Cause], measured: Trial | None
) -> FloatArray:
    delay = lag = tether = 0.0
    offset, bias = np.zeros(3), np.zeros(3)
    stiffness, grip = np.ones(3), np.ones(3)
    square, gain = False, 1.0
    bumps: list[tuple[list[int], float, float]] = []
    rises: list[tuple[float, float]] = []
    for cause in causes:
        on = [JOINTS.index(j) for j in cause.joints] or [0, 1, 2]
        v = cause.values
        match cause.effect:
            case "delay":
                delay += v[0]
            case "lag":
                lag += v[0]
            case "offset":
                offset[on] += v[0]
            case "stiffness":
                stiffness[on] *= v[0]
            case "bias":
                bias[on] += v[0]
            case "square_law":
                square = True
            case "grip":
                grip[on] *= v[0]
            case "tether":
                tether += v[0]
            case "speed_gain" | "chatter":
                gain *= v[0]
            case "bump":
                bumps.append((on, v[0], v[1]))
            case "rise":
                rises.append((v[0], v[1]))
            case "bend":
                stiffness *= 1.0 + v[0] ** 2
    angle = turned(time_s.tobytes(), hz, 0.5 if gait == "walk" else 0.15, delay, lag) + offset
    used_angle = measured.shaft_rad if measured is not None else angle
    press = 1.5 + used_angle
    force = 2.0 * stiffness * (press**2 / 1.5 if square else press) + bias
    for on, height, place in bumps:
        force[:, on] += height * np.exp(-0.5 * ((used_angle[:, on] - place) / BUMP_WIDTH) ** 2)
    for height, beyond in rises:
        force += height * (used_angle > beyond)
    used_force = measured.force_n[..., 2] if measured is not None else force - bias
    pull = used_force * grip
    speed = gain * 0.3 * ((pull * np.cos(used_angle)).sum(axis=1) + tether) / pull.sum(axis=1)
    return np.column_stack([angle, force, speed])


@lru_cache(maxsize=256)  # asked for again with other causes of the later stages
def turned(times: bytes, hz: float, shape: float, delay: float, lag: float) -> FloatArray:
    """The joints' angles without an offset."""
    phase = 2 * np.pi * hz * (np.frombuffer(times)[:, None] - delay) - np.array([0.0, 2.1, 4.2])
    # a first-order lag of each harmonic, exactly
    angle = np.zeros(phase.shape)
    for order, size in ((1, 0.5), (2, shape), (3, 0.1)):
        w = 2 * np.pi * hz * order * lag
        angle += size / np.sqrt(1 + w * w) * np.sin(order * phase - np.arctan(w))
    return readonly(angle)


def toy_trial(
    causes: Sequence[Cause] = (), hz: float = 0.5, gait: str = "walk", seconds: float = 16.0, seed: int = 0,
    strange: float = 0.0, wander: float = 0.0, growing: float = 0.0, shaking: float = 0.0,
) -> Trial:  # fmt: skip
    """Measure the toy with causes; ``strange`` adds what no effect is, ``wander`` what varies.

    The speed shakes by ``shaking`` times its noise.

    What the causes do grows over the run by ``growing`` times their mean.
    """
    rng = np.random.default_rng(seed)
    time_s = np.arange(round(seconds * HZ)) / HZ
    extra = [Cause("stiffness", (j,), (1 + wander * rng.standard_normal(),)) for j in JOINTS]
    true = chain(time_s, hz, gait, [*causes, *extra], None)
    without = chain(time_s, hz, gait, extra, None)
    true += growing * (time_s / time_s[-1] - 0.5)[:, None] * (true - without)
    true[:, 3:6] += strange * np.sign(np.sin(2 * np.pi * 5 * hz * time_s))[:, None]
    noise = rng.standard_normal(true.shape) * np.array([NOISE[c.name] for c in CHANNELS])
    seen = true + noise
    seen[:, 6] += shaking * NOISE["speed"] * rng.standard_normal(len(seen))
    header = TrialHeader(
        SERVO_BENCH, JOINTS, gait, hz, HZ, "", TrialNoise(math.nan), "", "", legs=JOINTS
    )
    columns = [TableColumn("time_s", time_s)]
    columns += [TableColumn(f"shaft_{j}_rad", seen[:, i]) for i, j in enumerate(JOINTS)]
    columns += [TableColumn(f"force_{j}_z_n", seen[:, 3 + i]) for i, j in enumerate(JOINTS)]
    columns.append(TableColumn("body_x_m", seen[:, 6]))
    return build_trial(header, tuple(columns))


CONDITIONS = ((0.5, "walk"), (0.8, "walk"), (0.5, "trot"), (0.8, "trot"))


def toy_case(causes: Sequence[Cause] = (), seed: int = 0, **more: float) -> list[Trial]:
    return [
        toy_trial(causes, hz, gait, seed=1000 * seed + i, **more)
        for i, (hz, gait) in enumerate(CONDITIONS)
    ]


def toy_references(seed: int = 0, **more: float) -> list[Trial]:
    return [
        toy_trial((), hz, gait, seed=1000 * seed + 500 + i, **more)
        for i, (hz, gait) in enumerate((*CONDITIONS, *CONDITIONS[:2]))
    ]


LIKE = (0.05, 0.05, 0.05)  # share of its stiffness that each joint differs by from day to day
UNLIKE = (0.05, 0.05, 0.15)  # one joint three times as much


def walked_day(
    at: int, seed: int, wander: tuple[float, ...], causes: tuple[Cause, ...] = ()
) -> Trial:
    """Return a run of a day on which each joint has another stiffness."""
    rng = np.random.default_rng(seed)
    days = [
        Cause("stiffness", (joint,), (1 + share * rng.standard_normal(),))
        for joint, share in zip(JOINTS, wander, strict=True)
    ]
    return toy_trial([*days, *causes], *CONDITIONS[at % 4], seed=10**6 + seed)
