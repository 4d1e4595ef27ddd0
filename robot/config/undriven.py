"""A robot that is not driven: its file says nothing of servos, force sensors, gaits and the loop.

Legs of several joints, and a robot that is only measured, are recorded, imported, modelled, estimated and
diagnosed. What such a robot has no value of is NaN, and lists are empty: nothing here can pass for a limit.
``load_robot`` and the controller refuse it.
"""

import numpy as np

from drivers.dynamixel.settings import ServoBusSettings
from model.errors import ConfigError
from model.values.arrays import IntArray, readonly
from model.values.parameters import ChainParameters, LegGeometry, ServoParameters

UNKNOWN = float("nan")
# Tables of a robot file that say how it is driven; one that has none of them is of a robot that is measured
DRIVING_TABLES = frozenset({"servo", "servo_bus", "loop", "gait", "safety", "force_sensor"})


def not_driven(leg: LegGeometry) -> ConfigError:
    """Return why a robot with such legs does not walk from here, and what can be done with it."""
    seen = "brought in by bigant import, and seen by show, view, odom, replay and gap"
    if isinstance(leg, ChainParameters):
        words = f"is chain, and legs of several joints are not driven: what they measured is {seen}"
        return ConfigError("leg.kind", words)
    return ConfigError(
        "servo",
        f"is missing: this robot is measured and not driven, and what it measured is {seen}; to drive it, "
        "add [servo], [servo_bus], [loop], [gait] and the servos' numbers in [legs] (bigant robot new "
        "writes a whole file)",
    )


def no_servo() -> ServoParameters:
    """Return what is known of servos that the file does not name."""
    return ServoParameters(UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, ())


def no_servo_bus() -> ServoBusSettings:
    """Return a bus without servos."""
    nothing: IntArray = readonly(np.zeros(0, dtype=np.int64))
    return ServoBusSettings((), nothing, nothing, nothing, (), 0, UNKNOWN, 0)
