"""A robot that is not driven: its file says nothing of servos, force sensors and the loop.

Legs of several joints are recorded, imported, modelled, estimated and diagnosed. What such a robot has no
value of is NaN, and lists are empty: nothing here can pass for a limit. ``load_robot`` and the controller
refuse it.
"""

import numpy as np

from drivers.dynamixel.settings import ServoBusSettings
from model.errors import ConfigError
from model.values.arrays import IntArray, readonly
from model.values.parameters import ServoParameters

UNKNOWN = float("nan")


def not_driven() -> ConfigError:
    """Return why legs of several joints do not walk from here, and what can be done with them."""
    return ConfigError(
        "leg.kind",
        "is chain, and legs of several joints are not driven: what they measured is brought in by bigant "
        "import, and seen by show, view, odom, replay and gap",
    )


def no_servo() -> ServoParameters:
    """Return what is known of servos that the file does not name."""
    return ServoParameters(UNKNOWN, UNKNOWN, UNKNOWN, UNKNOWN, ())


def no_servo_bus() -> ServoBusSettings:
    """Return a bus without servos."""
    nothing: IntArray = readonly(np.zeros(0, dtype=np.int64))
    return ServoBusSettings((), nothing, nothing, nothing, (), 0, UNKNOWN, 0)
