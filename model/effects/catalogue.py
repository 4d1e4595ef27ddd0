"""The catalogue of effects of a legged robot: names, stages, numbers, and how two causes act together.

Names, parameters and conventions are those that robot files and diagnoses from anywhere share; words for a
person are in ``gap.machines.legged.catalogue``. ``spread`` is one standard deviation of what a builder of
such machines would expect.
"""

import operator
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from model.effects.causes import EffectNumbers, Parameter, Scope

STAGES = ("actuation", "kinematics", "support", "friction", "dynamics", "external", "sensing")
NO_LIMIT_RAD_S = 10.0  # twice what the servos can do: no limit
ALL, LEG, BOTH = (Scope.ALL,), (Scope.JOINT,), (Scope.ALL, Scope.JOINT)


class Combine(Enum):
    """What two causes of one effect do to a number together."""

    ADD = "add"
    MULTIPLY = "multiply"
    LEAST = "least"
    SET = "set"  # where or how fast; it means nothing while the other numbers are neutral
    APART = "apart"  # each cause acts for itself, all its parameters together


TOGETHER: MappingProxyType[Combine, Callable[[float, float], float]] = MappingProxyType({
    Combine.ADD: operator.add,
    Combine.MULTIPLY: operator.mul,
    Combine.LEAST: min,
    Combine.SET: lambda _, new: new,
    Combine.APART: lambda _, new: new,
})  # fmt: skip


@dataclass(frozen=True, slots=True)
class ChainEffect(EffectNumbers):
    """An effect of the chain.

    Attributes:
        combine: How each of its parameters combines.
    """

    combine: tuple[Combine, ...]

    @property
    def apart(self) -> bool:
        """Whether each of its causes acts for itself."""
        return Combine.APART in self.combine


Number = tuple[Parameter, Combine]


def _number(name: str, unit: str, lower: float, upper: float, spread: float) -> Number:
    return Parameter(name, unit, 0.0, lower, upper, spread), Combine.ADD


def _apart(name: str, unit: str, lower: float, upper: float, spread: float) -> Number:
    return Parameter(name, unit, 0.0, lower, upper, spread), Combine.APART


def _alike(
    names: tuple[str, ...], unit: str, lower: float, upper: float, spread: float
) -> tuple[Number, ...]:
    return tuple(_number(name, unit, lower, upper, spread) for name in names)


def _ratio(lower: float, upper: float, spread: float, name: str = "ratio") -> Number:
    return Parameter(name, "", 1.0, lower, upper, spread), Combine.MULTIPLY


def _edge() -> Number:
    """A place along the world's x from which the ground is another."""
    return Parameter("x_m", "m", 0.2, -1.0, 10.0, 0.5, located=True), Combine.SET


def _effect(stage: str, name: str, scopes: tuple[Scope, ...], *numbers: Number) -> ChainEffect:
    parameters, combine = tuple(p for p, _ in numbers), tuple(c for _, c in numbers)
    return ChainEffect(name, stage, parameters, scopes, combine)


_LIMIT = Parameter("limit_rad_s", "rad/s", NO_LIMIT_RAD_S, 0.2, NO_LIMIT_RAD_S, 8.0)
_SLIP = Parameter("speed_m_s", "m/s", 0.005, 0.002, 0.05, 0.005)
XY_M = ("x_m", "y_m")

_CATALOGUE = (
    _effect("actuation", "command_delay", ALL, _number("delay_s", "s", 0.0, 0.3, 0.04)),
    _effect("actuation", "servo_lag", BOTH, _apart("time_constant_s", "s", 0.0, 0.5, 0.05)),
    _effect("actuation", "servo_speed_limit", BOTH, (_LIMIT, Combine.LEAST)),
    _effect("actuation", "servo_compliance", BOTH, _number("rad_per_nm", "rad/(N m)", 0.0, 0.2, 0.02)),
    _effect("actuation", "gear_backlash", LEG, _number("width_rad", "rad", 0.0, 0.5, 0.02)),
    _effect("actuation", "shaft_zero_offset", LEG, _number("offset_rad", "rad", -0.6, 0.6, 0.05)),
    _effect("kinematics", "link_length", BOTH,
            *_alike(("crank_m", "coupler_m", "rocker_m"), "m", -0.01, 0.01, 0.001)),
    _effect("kinematics", "hip_mount_offset", LEG, *_alike(XY_M, "m", -0.05, 0.05, 0.005)),
    _effect("kinematics", "leg_flex", ALL,
            *_alike(("lateral_m_per_n", "longitudinal_m_per_n"), "m/N", 0.0, 2e-3, 5e-5)),
    _effect("support", "leg_stiffness", LEG, _ratio(0.1, 5.0, 0.2)),
    _effect("support", "ground_stiffness", ALL, _ratio(0.05, 1.0, 0.2)),
    _effect("support", "leg_length", LEG, _number("offset_m", "m", -0.03, 0.03, 0.003)),
    _effect("support", "ground_slope", ALL, *_alike(("slope_x", "slope_y"), "", -0.2, 0.2, 0.02)),
    _effect("support", "ground_step", ALL, _number("height_m", "m", -0.03, 0.03, 0.005), _edge()),
    _effect("support", "com_offset", ALL, *_alike(XY_M, "m", -0.1, 0.1, 0.01)),
    _effect("support", "payload", ALL, _apart("mass_kg", "kg", 0.0, 5.0, 0.5),
            _apart("x_m", "m", -0.3, 0.3, 0.08), _apart("y_m", "m", -0.3, 0.3, 0.08)),
    _effect("support", "chassis_twist", ALL, _number("rad_per_nm", "rad/(N m)", 0.0, 0.05, 0.004)),
    _effect("friction", "foot_friction", LEG, _ratio(0.05, 4.0, 0.25)),
    _effect("friction", "friction_level", ALL, _ratio(0.05, 4.0, 0.25)),
    _effect("friction", "friction_anisotropy", BOTH, *_alike(("w_x", "w_y"), "", -1.5, 1.5, 0.3)),
    _effect("friction", "coulomb_friction", ALL),
    _effect("friction", "stiction", ALL, _ratio(1.0, 3.0, 0.3, "static_ratio"), (_SLIP, Combine.SET)),
    _effect("friction", "friction_patch", ALL, _ratio(0.1, 4.0, 0.25), _edge()),
    _effect("friction", "foot_rolling", ALL, _number("radius_m", "m", 0.0, 0.05, 0.006)),
    _effect("friction", "tilt_coupling", ALL),
    _effect("dynamics", "inertia_lag", ALL, _number("time_constant_s", "s", 0.0, 0.5, 0.03)),
    _effect("external", "tether_force", ALL, *_alike(("x_n", "y_n"), "N", -30.0, 30.0, 2.0)),
    _effect("external", "drag", ALL, _number("n_s_per_m", "N s/m", 0.0, 2000.0, 130.0)),
    _effect("sensing", "force_gain", LEG, _ratio(0.3, 3.0, 0.1)),
    _effect("sensing", "force_bias", LEG, *_alike(("x_n", "y_n", "z_n"), "N", -20.0, 20.0, 1.0)),
    _effect("sensing", "force_drift", LEG, _number("n_per_s", "N/s", -1.0, 1.0, 0.02)),
    _effect("sensing", "force_rotation", LEG, _number("yaw_rad", "rad", -0.8, 0.8, 0.06)),
    _effect("sensing", "force_delay", ALL, _number("delay_s", "s", 0.0, 0.4, 0.04)),
    _effect("sensing", "force_lowpass", ALL, _number("time_constant_s", "s", 0.0, 0.4, 0.04)),
    _effect("sensing", "pose_delay", ALL, _number("delay_s", "s", -0.3, 0.3, 0.03)),
    _effect("sensing", "pose_yaw_offset", ALL, _number("yaw_rad", "rad", -0.5, 0.5, 0.04)),
    _effect("sensing", "pose_origin_offset", ALL, *_alike(XY_M, "m", -0.1, 0.1, 0.01)),
    _effect("sensing", "clock_skew", ALL, _ratio(0.95, 1.05, 0.002)),
    _effect("sensing", "encoder_scale", LEG, _ratio(0.8, 1.25, 0.01)),
)  # fmt: skip
EFFECTS = MappingProxyType({effect.name: effect for effect in _CATALOGUE})
