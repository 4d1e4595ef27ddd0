"""Support, friction and external forces of a legged robot: feet to loads, pose and velocity."""

from dataclasses import dataclass, replace

import numpy as np

from model.effects.grid import FOOT_WINDOW_S
from model.effects.machine import LeggedMachine
from model.effects.pushes import (
    Before,
    Scene,
    pushes,
    resistance,
    resists_motion,
    sideways_force,
    sway_velocity,
    weight_and_centre,
)
from model.effects.settings import Settings
from model.effects.shafts import Feet
from model.effects.signals import FrictionSignals, MotionSignals, SupportSignals
from model.motion.se2 import turned
from model.support.frames import SupportSolutions, solve_support_frames
from model.support.twisting import solve_twisting_support, twist_of_rows
from model.traction.coulomb_kernel import FootLaw
from model.traction.frames import REST_SPEED_M_S, SlidingFeet
from model.values.arrays import BoolArray, FloatArray

STANDS_ON = frozenset({
    "leg_length", "ground_step", "ground_stiffness", "chassis_twist", "leg_stiffness", "com_offset",
    "payload", "ground_slope", "tether_force", "drag", "inertia_lag",
})  # fmt: skip
EDGE_M = 0.004  # over which an edge in the floor is rounded, so that fits can move it


@dataclass(frozen=True, slots=True, eq=False)
class Standing:
    """Support of W frames.

    Attributes:
        load_n: (W, N).
        slopes: slope_x, slope_y of the body against the ground, (W, 2).
        height_m: Height of the body's origin over the ground, (W,).
        com_m: Where the weight acts, without what pushes sideways, (2,).
        twist_rad: Roll of the chassis at each leg against its middle, (W, N) or (1, N).
    """

    load_n: FloatArray
    slopes: FloatArray
    height_m: FloatArray
    com_m: FloatArray
    twist_rad: FloatArray

    @property
    def sway_m(self) -> FloatArray:
        """How far the origin leans away from above where it would be upright, body axes, (W, 2)."""
        return np.stack(
            [self.height_m * self.slopes[:, 0], -self.height_m * self.slopes[:, 1]], axis=1
        )


@dataclass(frozen=True, slots=True, eq=False)
class Sliding:
    """Friction of W frames, body axes.

    Attributes:
        force_xy_n: On each foot, (W, N, 2).
        velocity_B: Of the body, (W, 3).
        friction: Coefficient at each foot at its slip, (W, N).
        anisotropy_B: w of each foot, (W or 1, N, 2).
    """

    force_xy_n: FloatArray
    velocity_B: FloatArray  # noqa: N815 - frame suffix
    friction: FloatArray
    anisotropy_B: FloatArray  # noqa: N815


def _beyond(scene: Scene, feet_xy: FloatArray, edge_m: float) -> FloatArray:
    """How far feet are beyond an edge across the world's x, 0 to 1, (W, N)."""
    aside, _ = turned(feet_xy[..., 0], feet_xy[..., 1], scene.world[:, 2:])
    share: FloatArray = 0.5 * (1.0 + np.tanh((scene.world[:, :1] + aside - edge_m) / EDGE_M))
    return share


def foot_slip(
    foot_m: FloatArray,
    foot_m_s: FloatArray,
    velocity_B: FloatArray,  # noqa: N803 - frame suffix
) -> FloatArray:
    """Velocity of feet over the ground, (..., N, 2) [m/s], body axes.

    Args:
        foot_m: Feet in the body frame, (..., N, 3).
        foot_m_s: Their velocity in it, (..., N, 3).
        velocity_B: Velocity of the body, (..., 3).
    """
    velocity = velocity_B[..., None, :]
    slip: FloatArray = foot_m_s[..., :2] + velocity[..., :2]
    slip += velocity[..., 2:] * np.stack([-foot_m[..., 1], foot_m[..., 0]], axis=-1)
    return slip


def contact_points(feet: Feet, settings: Settings) -> FloatArray:
    """Unloaded points of contact, (W, N, 3), of legs of their length.

    A round foot has its centre above the linkage's foot point, so its point of contact stays that point.
    """
    points = feet.signals.position_m
    if settings.has("leg_length"):
        points = points.copy()
        points[..., 2] -= settings.each("leg_length")[0]
    return points


def leg_stiffness(machine: LeggedMachine, settings: Settings) -> FloatArray:
    """Springs of the legs alone, (N,) [N/m]."""
    stiffness: FloatArray = machine.contact.stiffness * settings.each("leg_stiffness")[0]
    return stiffness


def stands_on(settings: Settings) -> Settings:
    """Return the part of settings that ``stand`` looks at, all else neutral."""
    acting = tuple(one for one in settings.acting if one[0] in STANDS_ON)
    return replace(settings, acting=acting, added=settings.at("support"))


def stand(
    scene: Scene,
    feet: Feet,
    velocity_B: FloatArray | None = None,  # noqa: N803 - frame suffix
) -> Standing:
    """Find loads and pose of the body on its legs.

    Drag and inertia need vx, vy, yaw rate of the body, (W, 3), as far as they are known.
    """
    machine, grid, settings = scene.machine, scene.grid, scene.settings
    points = contact_points(feet, settings)
    ground = np.zeros(points.shape[:2])
    if settings.has("ground_step"):
        height_m, x_m = settings.whole("ground_step")
        ground = height_m * _beyond(scene, points, x_m)
    (firmness,) = settings.whole("ground_stiffness")
    (twist_rad_nm,) = settings.whole("chassis_twist")
    stiffness = leg_stiffness(machine, settings) * firmness
    weight, centre = weight_and_centre(machine, settings)
    com = np.broadcast_to(centre, (grid.frames, 2))
    signals = SupportSignals(grid.time_s, points, ground, stiffness, weight, com)
    shaft_x = machine.legs.shaft_position[:, 0]
    sideways = sideways_force(scene)
    if velocity_B is not None and resists_motion(settings):
        sideways = sideways + resistance(scene, velocity_B, smoothed=scene.change_seen)[:, :2]
    if sideways.any():
        # it acts at the height of the body's origin, friction on the ground: the weight's line moves
        first, _ = _balance(signals, shaft_x, 0.0)
        height = first.pose[:, 2] + com[:, 0] * first.pose[:, 0] - com[:, 1] * first.pose[:, 1]
        com = com + height[:, None] * sideways / weight
        signals = SupportSignals(grid.time_s, points, ground, stiffness, weight, com)
    signals = settings.acted("support", signals)
    support, twist = _balance(signals, shaft_x, twist_rad_nm)
    com = signals.com_m
    height = support.pose[:, 2] + com[:, 0] * support.pose[:, 0] - com[:, 1] * support.pose[:, 1]
    return Standing(support.load_n, support.pose[:, :2], height, centre, twist)


def _balance(
    signals: SupportSignals, shaft_x: FloatArray, twist_rad_nm: float
) -> tuple[SupportSolutions, FloatArray]:
    """Balance seen from where the weight acts; a chassis that twists, until its angles at legs stay."""
    points = signals.feet_m.copy()
    points[..., 0] -= signals.com_m[:, :1]
    points[..., 1] -= signals.com_m[:, 1:]
    if twist_rad_nm == 0.0:
        support = solve_support_frames(
            points, signals.ground_m, signals.stiffness_n_m, signals.weight_n
        )
        return support, np.zeros((1, points.shape[1]))
    row, give = twist_of_rows(shaft_x, twist_rad_nm)
    support, angle = solve_twisting_support(
        points, signals.ground_m, signals.stiffness_n_m, signals.weight_n,
        signals.feet_m[..., 1], (row, give),
    )  # fmt: skip
    return support, angle[:, row]


def slide(
    scene: Scene,
    feet: Feet,
    standing: Standing,
    load_n: FloatArray,
    shaft_give_m_n: FloatArray | None = None,
    velocity_B: FloatArray | None = None,  # noqa: N803
    before: Before | None = None,
) -> Sliding:
    """Find velocity and friction forces.

    Args:
        scene: Robot, times, place and what is added.
        feet: Unloaded feet.
        standing: Pose of the body.
        load_n: Loads that press the feet down: the support's, or measured ones, (W, N).
        shaft_give_m_n: How far feet give fore and aft because their shafts do, (W, N).
        velocity_B: Measured velocity, (W, 3), which drag and inertia resist, and which sets the grip of
            feet with stiction; None: the one that is found.
        before: The moment before all frames, if they are not a walk.
    """
    machine, grid, settings = scene.machine, scene.grid, scene.settings
    points = contact_points(feet, settings)
    rate = feet.rate_m_s
    speed = rate[..., :2]
    if settings.has("tilt_coupling"):
        speed = speed + standing.slopes[:, None, :] * [1.0, -1.0] * rate[..., 2:]
    if settings.has("foot_rolling"):
        # the surface of a foot that turns with its link passes through the point of contact
        (radius_m,) = settings.whole("foot_rolling")
        speed = speed.copy()
        speed[..., 0] += radius_m * grid.slope(feet.turn_rad, FOOT_WINDOW_S)
    if standing.twist_rad.any():
        # feet below a row that rolls are pushed sideways; those that stick answer with a force
        aside = -points[..., 2] * standing.twist_rad
        points, speed = points.copy(), speed.copy()
        points[..., 1] += aside
        speed[..., 1] += grid.slope(aside, FOOT_WINDOW_S)
    (level,) = settings.whole("friction_level")
    (static_ratio,) = settings.whole("stick_slip")
    level = level * 0.5 * (1.0 + static_ratio)  # between sticking and slipping, in the mean
    mu = machine.contact.mu * (settings.each("foot_friction")[0] * level) * np.ones_like(load_n)
    if settings.has("friction_patch"):
        ratio, x_m = settings.whole("friction_patch")
        mu = mu * (1.0 + (ratio - 1.0) * _beyond(scene, points, x_m))
    static_ratio, slow_m_s = settings.whole("stiction")
    if velocity_B is not None and settings.has("stiction"):
        below = velocity_B - sway_velocity(scene, standing.sway_m)
        mu = mu * _grip(foot_slip(points, speed, below), static_ratio, slow_m_s)
        static_ratio = 1.0
    force = sideways_force(scene)
    centre = standing.com_m
    moment = centre[0] * force[:, 1] - centre[1] * force[:, 0]
    signals = FrictionSignals(
        grid.time_s,
        points[..., :2],
        speed,
        load_n,
        mu,
        (machine.contact.anisotropy + settings.each("friction_anisotropy").T)[None],
        np.column_stack([force, moment]),
    )
    signals = settings.acted("external", settings.acted("friction", signals))
    coulomb = settings.has("coulomb_friction")
    law = FootLaw(coulomb, REST_SPEED_M_S, static_ratio, slow_m_s)
    traction = scene.solve(
        SlidingFeet(
            signals.feet_m, signals.speed_m_s, signals.mu * signals.load_n, signals.anisotropy_B
        ),
        law,
        pushes(scene, signals.wrench_B, standing.sway_m, velocity_B, before),
        grid.period_s,
        _give(scene, points[..., 2], shaft_give_m_n),
    )
    velocity = traction.velocity_B
    if settings.at("dynamics"):
        motion = settings.acted("dynamics", MotionSignals(grid.time_s, _held(velocity)))
        velocity = np.where(traction.valid[:, None], motion.velocity_B, np.nan)
    friction = signals.mu
    if static_ratio != 1.0:  # the law has it, at the slip that was found
        friction = friction * _grip(traction.slip_B, static_ratio, slow_m_s)
    return Sliding(traction.force_xy_B, velocity, friction, signals.anisotropy_B)


def _grip(slip_m_s: FloatArray, static_ratio: float, slow_m_s: float) -> FloatArray:
    """Grip of feet that slide at (W, N, 2), in units of that of fast ones, (W, N).

    A foot that sticks and slips many times a second is seen to creep, and grips in the mean as its law has
    it at that speed. Where the slip is not seen but found, such a law has several answers, and hops.
    """
    more: FloatArray = np.exp(-(slip_m_s**2).sum(axis=2) / slow_m_s**2)
    return 1.0 + (static_ratio - 1.0) * more


def _give(scene: Scene, foot_z_m: FloatArray, shaft_give_m_n: FloatArray | None) -> FloatArray:
    """How far feet give along body x and y, (W or 1, N, 2) [m/N]."""
    settings, shaft_x = scene.settings, scene.machine.legs.shaft_position[:, 0]
    give = np.tile(settings.whole("leg_flex")[::-1], (1, len(shaft_x), 1))  # lateral is along y
    if shaft_give_m_n is not None:
        give = give + np.stack([shaft_give_m_n, np.zeros_like(shaft_give_m_n)], axis=2)
    if settings.has("chassis_twist") and not scene.grid.is_moment:
        # what pushes a foot aside rolls its row; a moment is too short for that
        row, rolls = twist_of_rows(shaft_x, *settings.whole("chassis_twist"))
        aside = np.diag(rolls)[row] * foot_z_m**2
        give = give + np.stack([np.zeros_like(aside), aside], axis=2)
    return give


def _held(velocity: FloatArray) -> FloatArray:
    """Bridge frames without an answer, so that filters pass them."""
    known: BoolArray = np.all(np.isfinite(velocity), axis=1)
    if known.all() or not known.any():
        return np.where(known[:, None], velocity, 0.0)
    at = np.arange(len(velocity))
    return np.stack([np.interp(at, at[known], column[known]) for column in velocity.T], axis=1)
