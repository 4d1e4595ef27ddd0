"""What is wrong with numbers of a robot file by themselves: units, inertia, springs, friction, sensors."""

import math
from collections.abc import Iterator

import numpy as np

from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY
from model.values.parameters import BodyParameters, ContactParameters
from robot.design.concern import Concern, warning

LONGEST_M, SHORTEST_M = 5.0, 0.005  # of a robot that is meant
HEAVIEST_KG, LIGHTEST_KG = 200.0, 0.02
UNEVEN = 50.0  # shafts so many times farther apart than legs are long, or the other way round
MILLI = 1e3
LARGEST_MU, SMALLEST_MU = 2.0, 0.05
# Radius of gyration over the robot's extent: a solid block has 0.3 to 0.6, a shell or a frame more.
GYRATION_LEAST, GYRATION_MOST = 0.05, 2.0
STIFFEST_SINK_M = 1e-6
SENSOR_REACH = 3.0  # legs' lengths


def body_concerns(body: BodyParameters, extent_m: float) -> Iterator[Concern]:
    """Yield what is wrong with mass and inertia.

    Args:
        body: Mass and inertia.
        extent_m: Farthest shaft or foot from the centre of mass.
    """
    if body.mass > HEAVIEST_KG or body.mass < LIGHTEST_KG:
        grams = (
            f"; {body.mass:g} g would be {body.mass / MILLI:g}" if body.mass > HEAVIEST_KG else ""
        )
        yield warning(
            "units", "body.mass", f"{body.mass:g} kg is no mass of a robot that walks on such servos",
            f"give it in kg{grams}",
        )  # fmt: skip
        return
    moments = np.asarray(body.inertia, dtype=np.float64)
    gyration = np.sqrt(moments / body.mass)
    if extent_m > 0 and not (
        gyration.min() > GYRATION_LEAST * extent_m and gyration.max() < GYRATION_MOST * extent_m
    ):
        block = body.mass * (0.4 * extent_m) ** 2
        yield warning(
            "inertia", "body.inertia",
            f"with {body.mass:g} kg it is that of a body {gyration.min() * 1e3:.3g} to "
            f"{gyration.max() * 1e3:.3g} mm across (radius of gyration), the legs reach "
            f"{extent_m * 1e3:.0f} mm", f"give it in kg m^2; a body of this size has about {block:.2g}",
        )  # fmt: skip


def size_concerns(shaft_m: FloatArray, leg_m: float) -> Iterator[Concern]:
    """Yield where lengths are in another unit.

    Args:
        shaft_m: Shafts in the body frame, (N, 3) [m].
        leg_m: Farthest that a foot comes from its shaft.
    """
    apart = float(np.ptp(shaft_m, axis=0).max())
    for key, length in (("legs.shaft_position", apart), ("leg", leg_m)):
        if length > LONGEST_M:
            yield warning(
                "units", key, f"it reaches over {length:.3g} m",
                f"give lengths in m; {length:.3g} mm would be {length / MILLI:.3g} m",
            )  # fmt: skip
        elif length < SHORTEST_M:
            yield warning(
                "units", key, f"it reaches over no more than {length * 1e3:.3g} mm",
                "give lengths in m",
            )  # fmt: skip
    if min(apart, leg_m) > 0 and max(apart, leg_m) / min(apart, leg_m) > UNEVEN:
        yield warning(
            "units", "leg", f"legs are {leg_m:.3g} m long and their shafts {apart:.3g} m apart",
            "give both in m",
        )  # fmt: skip


def contact_concerns(
    contact: ContactParameters, body: BodyParameters, names: tuple[str, ...], leg_m: float
) -> Iterator[Concern]:
    """Yield what is wrong with springs and friction.

    Args:
        contact: Leg springs and friction.
        body: Its mass.
        names: Leg names.
        leg_m: Farthest that a foot comes from its shaft.
    """
    standing = np.minimum(3, len(names))
    sink = body.mass * STANDARD_GRAVITY / standing / contact.stiffness
    worst = int(sink.argmax())
    # a third of the leg's length below itself is no leg any more
    if sink[worst] > leg_m / 3:
        wanted = body.mass * STANDARD_GRAVITY / standing / (0.07 * leg_m)
        yield warning(
            "units" if sink[worst] > leg_m else "too soft", "contact.stiffness",
            f"with a third of the weight on it, leg {names[worst]} sinks by {_length(sink[worst])}, and is "
            f"{_length(leg_m)} long", f"give it in N/m; about {wanted:.2g} is usual for this weight",
        )  # fmt: skip
    stiff = int(sink.argmin())
    if sink[stiff] < STIFFEST_SINK_M:
        yield warning(
            "too stiff", "contact.stiffness",
            f"with a third of the weight on it, leg {names[stiff]} gives by {sink[stiff] * 1e6:.2g} um: "
            "which feet carry would hang on rounding", "give it in N/m; legs and feet give by millimetres",
        )  # fmt: skip
    for leg, mu in zip(names, contact.mu.tolist(), strict=True):
        if mu > LARGEST_MU or mu < SMALLEST_MU:
            slippery = "a foot that grips so little cannot push" if mu < SMALLEST_MU else (
                "rubber on a clean floor has about 1"
            )  # fmt: skip
            yield warning(
                "friction", "contact.mu", f"leg {leg} has {mu:g}; {slippery}",
                "give the coefficient of friction, for example 0.6",
            )  # fmt: skip
            break


def sensor_concerns(
    offset_m: FloatArray, names: tuple[str, ...], leg_m: float
) -> Iterator[Concern]:
    """Yield where a force sensor is far from its leg.

    Args:
        offset_m: Places of the sensors relative to the shafts, (N, 3) [m].
        names: Leg names.
        leg_m: Farthest that a foot comes from its shaft.
    """
    away = np.nan_to_num(np.sqrt((offset_m**2).sum(axis=1)))
    worst = int(away.argmax())
    if away[worst] > SENSOR_REACH * leg_m:
        yield warning(
            "sensor", "force_sensor.offset",
            f"the sensor of leg {names[worst]} is {_length(float(away[worst]))} from its shaft, the foot "
            f"comes no farther than {_length(leg_m)}", "give it in m, relative to the shaft",
        )  # fmt: skip


def _length(metres: float) -> str:
    return f"{metres:.3g} m" if math.fabs(metres) >= 1 else f"{metres * 1e3:.3g} mm"
