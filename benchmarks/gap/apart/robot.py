"""The hexapod as MJCF: as its builder describes it, and as it is, with rubber shanks and soft contact."""

import math
from dataclasses import dataclass

from benchmarks.gap.apart.day import Day
from benchmarks.gap.apart.fault import Fault, Payload
from benchmarks.gap.apart.layout import (
    COXA_M,
    FEMUR_M,
    FOOT_FRICTION,
    FOOT_RADIUS_M,
    HIP_HEIGHT_M,
    JOINTS,
    LEGS,
    MOUNTS,
    POSITION_GAIN_NM_RAD,
    RATE_GAIN_NM_S_RAD,
    SHANK_M,
    TORQUE_LIMIT_NM,
)

HEAD = """\
<mujoco model="krabbe"><compiler angle="radian" autolimits="true"/>
<option timestep="0.001" integrator="implicitfast" cone="elliptic" impratio="8"/>
<default><geom contype="0" conaffinity="0"/><joint armature="0.012" damping="0.03"/></default><worldbody>"""
FLOOR_FRICTION = 0.001  # counts for nothing: feet have priority, and coefficients of their own
ABOVE_FLOOR_M = 0.001  # of the feet at first


@dataclass(frozen=True, slots=True)
class _Shank:
    """A rubber shank."""

    length_m: float
    stiffness_n_m: float


@dataclass(frozen=True, slots=True)
class _Leg:
    """A leg: offset of its hip (x, y) [m], and its shank; a rigid one has none."""

    hip_offset_m: tuple[float, float] = (0.0, 0.0)
    shank: _Shank | None = None


def described_robot() -> str:
    """Return the MJCF that goes with the robot file: nominal sizes, rigid shanks, servos as actuators."""
    servos = "".join(
        f'<position joint="{joint}" kp="{POSITION_GAIN_NM_RAD:g}" kv="{RATE_GAIN_NM_S_RAD:g}" '
        f'forcerange="-{TORQUE_LIMIT_NM:g} {TORQUE_LIMIT_NM:g}"/>'
        for joint in JOINTS
    )
    return "\n".join([
        *_trunk(FOOT_FRICTION, 0.0, (0.0, 0.0), None),
        *(line for leg in LEGS for line in _leg(leg, _Leg())),
        "</body></worldbody>", f"<actuator>{servos}</actuator>", "</mujoco>",
    ])  # fmt: skip


def built_robot(day: Day, fault: Fault) -> str:
    """Return the MJCF of the robot as it is in a run; torques come from outside."""
    more_m = fault.at_legs(fault.leg_length_m, 0.0).tolist()
    stiffness_ratio = fault.at_legs(fault.shank_stiffness_ratio, 1.0)
    stiffness_n_m = (day.shank_stiffness_n_m * stiffness_ratio).tolist()
    offset_m = [fault.hip_offset_m if fault.place == leg else (0.0, 0.0) for leg in LEGS]
    legs = {
        name: _Leg(offset_m[i], _Shank(SHANK_M + more_m[i], stiffness_n_m[i]))
        for i, name in enumerate(LEGS)
    }
    x_m, y_m = day.battery_offset_m.tolist()
    return "\n".join([
        *_trunk(FLOOR_FRICTION, ABOVE_FLOOR_M, (x_m, y_m), fault.payload),
        *(line for name, leg in legs.items() for line in _leg(name, leg)),
        "</body></worldbody>", "</mujoco>",
    ])  # fmt: skip


def _trunk(
    friction: float, above_m: float, battery_m: tuple[float, float], payload: Payload | None
) -> list[str]:
    height_m = SHANK_M + FOOT_RADIUS_M - HIP_HEIGHT_M + above_m
    lines = [
        HEAD,
        '<geom name="floor" type="plane" size="8 8 .1" contype="1" conaffinity="1" '
        f'friction="{friction} 0.001 0.00001"/>',
        f'<body name="trunk" pos="0 0 {height_m}"><freejoint name="root"/>',
        '<geom type="box" size="0.19 0.075 0.03" mass="2.4"/>',
        f'<geom type="box" size="0.05 0.03 0.02" pos="{battery_m[0]} {battery_m[1]} 0" mass="0.6"/>',
    ]
    if payload is not None:
        lines.append(
            f'<geom type="box" size="0.03 0.03 0.02" pos="{payload.x_m} {payload.y_m} 0.05" '
            f'mass="{payload.mass_kg}"/>'
        )
    return lines


def _leg(name: str, leg: _Leg) -> list[str]:
    mount = MOUNTS[name]
    x_m, y_m = mount.x_m + leg.hip_offset_m[0], mount.y_m + leg.hip_offset_m[1]
    return [
        f'<body name="{name}_c" pos="{x_m} {y_m} {HIP_HEIGHT_M}" '
        f'euler="0 0 {math.radians(mount.direction_deg)}">'
        f'<joint name="{name}_yaw" axis="0 0 1" range="-0.9 0.9"/>'
        f'<geom type="capsule" fromto="0 0 0 {COXA_M} 0 0" size="0.015" mass="0.10"/>',
        f'<body name="{name}_s" pos="{COXA_M} 0 0">'
        f'<joint name="{name}_lift" axis="0 -1 0" range="-0.9 0.9"/>'
        f'<geom type="capsule" fromto="0 0 0 {FEMUR_M} 0 0.02" size="0.01" mass="0.07"/>'
        f'<geom type="capsule" fromto="{FEMUR_M} 0 0.02 {FEMUR_M} 0 {-SHANK_M + 0.03}" size="0.009" '
        'mass="0.08"/>',
        _foot(name, leg.shank),
        "</body></body>",
    ]


def _foot(name: str, shank: _Shank | None) -> str:
    """A ball that is part of a rigid shank, or slides along a rubber one."""
    ball = (
        f'<geom name="{name}_tip" type="sphere" size="{FOOT_RADIUS_M}" mass="0.02" contype="1" '
        'conaffinity="1" friction="0.7 0.001 0.00001"'
    )
    if shank is None:
        return ball + f' pos="{FEMUR_M} 0 {-SHANK_M}"/>'
    return (
        f'<body name="{name}_f" pos="{FEMUR_M} 0 {-shank.length_m}">'
        f'<joint name="{name}_rub" type="slide" axis="0 0 1" armature="0" damping="14" '
        f'stiffness="{shank.stiffness_n_m}"/>'
        + ball
        + ' solref="0.006 1" solimp="0.9 0.98 0.001" priority="1"/></body>'
    )
