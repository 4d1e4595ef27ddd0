"""Effects of friction, dynamics and external forces."""

import numpy as np

from model.errors import ConfigError
from model.values.arrays import FloatArray, IntArray
from sim_hw.plant.parameters import CrankLegs
from sim_hw.twin.effects import (
    ALL,
    BOTH,
    LEG,
    EffectKind,
    adds,
    at,
    changed,
    scales,
    sets,
    sets_vector,
    sized,
)
from sim_hw.twin.twin import Twin


def _foot_rolling(twin: Twin, legs: IntArray, values: FloatArray) -> Twin:
    if isinstance(twin.plant.leg, CrankLegs) and twin.plant.leg.radius.any():
        raise ConfigError("effect foot_rolling", "this robot's legs are round and roll already")
    return sets("plant.rolling_radius")(twin, legs, values)


def _fading(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    left = np.flatnonzero(twin.plant.shaft_position[:, 1] > 0)
    fade = at(twin.plant.friction.fade_s, left, values[0])
    faded = changed(twin, "plant.friction.fade_s", fade)
    return changed(faded, "plant.friction.fade_floor", float(values[1]))


def _stiction(twin: Twin, _: IntArray, values: FloatArray) -> Twin:
    ratio, speed = values
    stuck = changed(
        twin, "plant.friction.static_ratio", twin.plant.friction.static_ratio * float(ratio)
    )
    return changed(stuck, "plant.friction.static_speed", float(speed))


INHERENT = "every twin has it; the model may lack it"

KINDS = (
    EffectKind(
        "foot_friction", "friction", LEG, (sized("ratio", "", 0.1, 4, 1, 0.7, 0.4),),
        "the foot's coefficient of contact friction", scales("plant.mu"),
    ),
    EffectKind(
        "friction_level", "friction", ALL, (sized("ratio", "", 0.1, 4, 1, 0.7, 0.5),),
        "all feet's coefficients of contact friction", scales("plant.mu"),
    ),
    EffectKind(
        "friction_anisotropy", "friction", BOTH,
        (sized("w_x", "", -2, 2, 0, 0.5, 1.0), sized("w_y", "", -2, 2, 0, 0.0, 0.3)),
        "contact axes turned with the body, an ellipse of friction mu (1 + w^2) along w",
        sets_vector("plant.friction.anisotropy", leg_wise=True),
    ),
    EffectKind("coulomb_friction", "friction", ALL, (), INHERENT, None),
    EffectKind(
        "stiction", "friction", ALL,
        (sized("static_ratio", "", 1, 3, 1, 1.3, 1.8),
         sized("speed_m_s", "m/s", 1e-4, 0.2, 0.01, 0.01, 0.01)),
        "the coefficient falls from its static to its sliding value with the foot's speed",
        _stiction,
    ),
    EffectKind(
        "friction_patch", "friction", ALL,
        (sized("ratio", "", 0.1, 4, 1, 0.7, 0.4), sized("x_m", "m", -10, 10, 0.15, 0.15, 0.15)),
        "the coefficient beyond x in the world",
        sets("plant.friction.patch_ratio", "plant.friction.patch_x"),
    ),
    EffectKind(
        "foot_rolling", "friction", ALL, (sized("radius_m", "m", 0, 0.06, 0, 0.01, 0.025),),
        "round feet that turn with their links and roll", _foot_rolling,
    ),
    EffectKind("tilt_coupling", "friction", ALL, (), INHERENT, None),
    EffectKind(
        "inertia_lag", "dynamics", ALL, (sized("time_constant_s", "s", 0, 0.5, 0, 0.03, 0.1),),
        "a weightless mass on a stiff hitch, which friction brings to a slip of 20 mm/s in this time",
        adds("plant.ballast_s"),
    ),
    EffectKind(
        "tether_force", "external", ALL,
        (sized("x_n", "N", -20, 20, 0, 1.5, 4), sized("y_n", "N", -20, 20, 0, 0, 1.5)),
        "a constant force on the centre of the body, world axes",
        sets("plant.disturbance.pull_x", "plant.disturbance.pull_y"),
    ),
    EffectKind(
        "drag", "external", ALL, (sized("n_s_per_m", "N s/m", 0, 2000, 0, 100, 400),),
        "a damper between body and world, horizontally", adds("plant.disturbance.drag"),
    ),
    EffectKind(
        "gusts", "external", ALL,
        (sized("sd_n", "N", 0, 20, 0, 2, 5), sized("time_s", "s", 0.05, 10, 0.5, 0.5, 0.5)),
        "a wandering horizontal force on the body",
        sets("plant.disturbance.gust", "plant.disturbance.gust_time"), catalogued=False,
    ),
    EffectKind(
        "fading_friction", "friction", ALL,
        (sized("time_s", "s", 1, 1000, 1000, 20, 8), sized("floor", "", 0.05, 1, 1, 0.5, 0.3)),
        "the left feet's coefficients fade in the course of the run", _fading, catalogued=False,
    ),
    EffectKind(
        "sticking_foot", "friction", LEG, (sized("force_n", "N", 0, 20, 0, 2, 6),),
        "the foot clings to the ground until it is a millimetre away",
        sets("plant.friction.adhesion"), catalogued=False,
    ),
)  # fmt: skip
