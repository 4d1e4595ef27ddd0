"""Effects of friction, dynamics and external forces."""

from dataclasses import replace

import numpy as np

from model.values.arrays import FloatArray, IntArray
from sim_hw.twin.body import at
from sim_hw.twin.effects import ALL, BOTH, LEG, EffectKind, EffectParameter
from sim_hw.twin.twin import Twin

# Slip at which the added inertia has the time constant asked for: a body that friction mu M g holds at
# slip v takes m v / (mu M g) to follow.
SLIP_M_S = 0.02


def _plant(twin: Twin, **changes: object) -> Twin:
    return replace(twin, plant=replace(twin.plant, **changes))  # type: ignore[arg-type]


def _friction(twin: Twin, **changes: object) -> Twin:
    return _plant(twin, friction=replace(twin.plant.friction, **changes))  # type: ignore[arg-type]


def _mu_ratio(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    return _plant(twin, mu=at(twin.plant.mu, legs, twin.plant.mu[legs] * values[0]))


def _anisotropy(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    return _friction(twin, anisotropy=at(twin.plant.friction.anisotropy, legs, values))


def _stiction(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _friction(twin, static_ratio=float(values[0]), static_speed=float(values[1]))


def _patch(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _friction(twin, patch_ratio=float(values[0]), patch_x=float(values[1]))


def _rolling(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _plant(twin, rolling_radius=float(values[0]))


def _inertia_lag(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    p = twin.plant
    mass = float(values[0]) * float(p.mu.mean()) * p.mass * p.gravity / SLIP_M_S
    arm2 = float((p.shaft_position[:, :2] ** 2).sum(axis=1).mean())
    return _plant(twin, added_inertia=np.array([mass, mass * arm2]))


def _tether(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    pull = replace(twin.plant.disturbance, pull_x=float(values[0]), pull_y=float(values[1]))
    return _plant(twin, disturbance=pull)


def _drag(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    return _plant(twin, disturbance=replace(twin.plant.disturbance, drag=float(values[0])))


def _gusts(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    gust = replace(twin.plant.disturbance, gust=float(values[0]), gust_time=float(values[1]))
    return _plant(twin, disturbance=gust)


def _fading(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    left = np.flatnonzero(twin.plant.shaft_position[:, 1] > 0)
    fade = at(twin.plant.friction.fade_s, left, values[0])
    return _friction(twin, fade_s=fade, fade_floor=float(values[1]))


def _sticking(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    return _friction(twin, adhesion=at(twin.plant.friction.adhesion, legs, values[0]))


def _p(name: str, unit: str, low: float, high: float, *sizes: float) -> EffectParameter:
    neutral, mild, strong = sizes
    return EffectParameter(name, unit, low, high, neutral, mild, strong)


INHERENT = "every twin has it; the model may lack it"

KINDS = (
    EffectKind(
        "foot_friction", "friction", LEG, (_p("ratio", "", 0.1, 4, 1, 0.7, 0.4),),
        "the foot's coefficient of contact friction", _mu_ratio,
    ),
    EffectKind(
        "friction_level", "friction", ALL, (_p("ratio", "", 0.1, 4, 1, 0.7, 0.5),),
        "all feet's coefficients of contact friction", _mu_ratio,
    ),
    EffectKind(
        "friction_anisotropy", "friction", BOTH,
        (_p("w_x", "", -2, 2, 0, 0.5, 1.0), _p("w_y", "", -2, 2, 0, 0.0, 0.3)),
        "contact axes turned with the body, an ellipse of friction mu (1 + w^2) along w", _anisotropy,
    ),
    EffectKind("coulomb_friction", "friction", ALL, (), INHERENT, None),
    EffectKind(
        "stiction", "friction", ALL,
        (_p("static_ratio", "", 1, 3, 1, 1.3, 1.8), _p("speed_m_s", "m/s", 1e-4, 0.2, 0.01, 0.01, 0.01)),
        "the coefficient falls from its static to its sliding value with the foot's speed", _stiction,
    ),
    EffectKind(
        "friction_patch", "friction", ALL,
        (_p("ratio", "", 0.1, 4, 1, 0.7, 0.4), _p("x_m", "m", -10, 10, 0.15, 0.15, 0.15)),
        "the coefficient beyond x in the world", _patch,
    ),
    EffectKind(
        "foot_rolling", "friction", ALL, (_p("radius_m", "m", 0, 0.06, 0, 0.01, 0.025),),
        "round feet that turn with their couplers and roll", _rolling,
    ),
    EffectKind("tilt_coupling", "friction", ALL, (), INHERENT, None),
    EffectKind(
        "inertia_lag", "dynamics", ALL, (_p("time_constant_s", "s", 0, 0.5, 0, 0.03, 0.1),),
        "horizontal inertia without weight, sized for a slip of 20 mm/s", _inertia_lag,
    ),
    EffectKind(
        "tether_force", "external", ALL,
        (_p("x_n", "N", -20, 20, 0, 1.5, 4), _p("y_n", "N", -20, 20, 0, 0, 1.5)),
        "a constant force on the centre of the body, world axes", _tether,
    ),
    EffectKind(
        "drag", "external", ALL, (_p("n_s_per_m", "N s/m", 0, 2000, 0, 100, 400),),
        "a damper between body and world, horizontally", _drag,
    ),
    EffectKind(
        "gusts", "external", ALL,
        (_p("sd_n", "N", 0, 20, 0, 2, 5), _p("time_s", "s", 0.05, 10, 0.5, 0.5, 0.5)),
        "a wandering horizontal force on the body", _gusts, catalogued=False,
    ),
    EffectKind(
        "fading_friction", "friction", ALL,
        (_p("time_s", "s", 1, 1000, 1000, 20, 8), _p("floor", "", 0.05, 1, 1, 0.5, 0.3)),
        "the left feet's coefficients fade in the course of the run", _fading, catalogued=False,
    ),
    EffectKind(
        "sticking_foot", "friction", LEG, (_p("force_n", "N", 0, 20, 0, 2, 6),),
        "the foot clings to the ground until it is a millimetre away", _sticking, catalogued=False,
    ),
)  # fmt: skip
