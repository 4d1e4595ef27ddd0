"""What acts on a legged robot's body besides its feet: gravity, a tether, drag, inertia."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from model.effects.grid import TWIST_WINDOW_S, Grid
from model.effects.machine import LeggedMachine
from model.effects.settings import Settings
from model.motion.se2 import turned
from model.traction.frames import Inertia, Pushes, TractionSolver, solve_traction_frames
from model.values.arrays import FloatArray
from model.values.gravity import STANDARD_GRAVITY

# A body that friction mu M g holds at this slip takes its time constant to follow.
INERTIA_SLIP_M_S = 0.02
# What resists a predicted velocity that is not the measured one: a share of drag, inertia over a time.
DRAG_OF_DEVIATION = 0.2
DEVIATION_S = 1.0


def change_of(grid: Grid, velocity_B: FloatArray, smoothed: bool) -> FloatArray:  # noqa: N803
    """Return how fast vx, vy, yaw rate change, (W, 3), in axes that do not turn.

    ``smoothed`` is a velocity that is the slope of a place: what two windows took is given back.
    """
    change = grid.slope(velocity_B, TWIST_WINDOW_S)
    return grid.given_back(change, TWIST_WINDOW_S, windows=2) if smoothed else change


@dataclass(frozen=True, slots=True, eq=False)
class Scene:
    """W frames of a robot on its ground.

    Only effects that are bound to a place need the world: x, y, yaw of the body, (W, 3). What balances the
    feet, and what tells how a velocity changes, may know answers that they gave before. Foot forces that
    were measured with the body's velocity show its change as it was (``change_seen``); a pose alone shows
    it smoothed, and with too much noise to give back what that took.
    """

    machine: LeggedMachine
    grid: Grid
    settings: Settings
    world: FloatArray
    solve: TractionSolver = solve_traction_frames
    change_seen: bool = False
    change: Callable[[Grid, FloatArray, bool], FloatArray] = change_of


@dataclass(frozen=True, slots=True, eq=False)
class Before:
    """A moment before: vx, vy, yaw rate then, (3,), and how long ago that was."""

    velocity_B: FloatArray  # noqa: N815
    since_s: float


def weight_and_centre(machine: LeggedMachine, settings: Settings) -> tuple[float, FloatArray]:
    """Weight [N] and centre of mass in the body frame, (2,) [m], with what rides along."""
    mass = machine.mass_kg
    moment = mass * np.array(settings.whole("com_offset"))
    for (rider_kg,), (x,), (y,) in settings.apart("payload"):
        mass += rider_kg
        moment = moment + rider_kg * np.array([x, y])
    return mass * STANDARD_GRAVITY, moment / mass


def gradient(settings: Settings, world: FloatArray) -> FloatArray:
    """Rise of the ground per metre along body x and y, (W, 2), as the body turns."""
    slope_x, slope_y = np.array(settings.whole("ground_slope"))
    return np.stack(turned(slope_x, slope_y, world[0, 2] - world[:, 2]), axis=1)


def sideways_force(scene: Scene) -> FloatArray:
    """Gravity's share and the tether, along the ground at the centre of mass, body axes, (W, 2) [N]."""
    settings, world = scene.settings, scene.world
    force = np.zeros((len(world), 2))
    if settings.has("ground_slope"):
        force -= weight_and_centre(scene.machine, settings)[0] * gradient(settings, world)
    if settings.has("tether_force"):
        x_n, y_n = np.array(settings.whole("tether_force"))
        force += np.stack(turned(x_n, y_n, -world[:, 2]), axis=1)
    return force


def resists_motion(settings: Settings) -> bool:
    """Whether drag or inertia acts."""
    return settings.has("drag", "inertia_lag")


def _added_inertia(scene: Scene) -> tuple[float, float]:
    """Mass [kg], and moment of inertia about the vertical [kg m^2], with the time constant in question."""
    machine = scene.machine
    (lag_s,) = scene.settings.whole("inertia_lag")
    mass = lag_s * float(machine.contact.mu.mean()) * machine.size.weight_n / INERTIA_SLIP_M_S
    arms = machine.legs.shaft_position[:, :2]
    return mass, mass * float((arms**2).sum(axis=1).mean())


def resistance(scene: Scene, velocity_B: FloatArray, *, smoothed: bool) -> FloatArray:  # noqa: N803
    """Wrench of drag and inertia at a known velocity, body axes, (W, 3) [N, N, N m].

    Args:
        scene: The robot on its ground.
        velocity_B: vx, vy, yaw rate, (W, 3).
        smoothed: It is the slope of a place: what two windows took of its change is given back.
    """
    (drag,) = scene.settings.whole("drag")
    wrench = -drag * velocity_B * [1.0, 1.0, 0.0]
    if scene.settings.has("inertia_lag") and not scene.grid.is_moment:
        mass, about_z = _added_inertia(scene)
        change = scene.change(scene.grid, velocity_B, smoothed).copy()
        change[:, :2] += velocity_B[:, 2:] * np.stack([-velocity_B[:, 1], velocity_B[:, 0]], axis=1)
        wrench = wrench - change * [mass, mass, about_z]
    return wrench


def sway_velocity(scene: Scene, sway_m: FloatArray) -> FloatArray:
    """Velocity of the body's origin against the point on the ground below it, by its sway, (W, 3)."""
    aside = np.zeros((len(sway_m), 3))
    if not scene.grid.is_moment:  # too short to tell
        aside[:, :2] = scene.grid.slope(sway_m, TWIST_WINDOW_S)
    return aside


def pushes(
    scene: Scene,
    wrench: FloatArray,
    sway_m: FloatArray,
    velocity_B: FloatArray | None,  # noqa: N803
    before: Before | None,
) -> Pushes:
    """Add drag and inertia to what else acts on the body, (W, 3).

    Where the velocity was measured they are those of the measured one. What is predicted deviates from it;
    a share of the drag, and the inertia over a second, act against that, so that a
    frame in which friction cannot hold the wrench does not run away.
    """
    if not resists_motion(scene.settings):
        return Pushes(wrench)
    (drag,) = scene.settings.whole("drag")
    mass, about_z = _added_inertia(scene)
    aside = sway_velocity(scene, sway_m)
    if velocity_B is not None:
        along = DRAG_OF_DEVIATION * drag + mass / DEVIATION_S
        about = about_z / DEVIATION_S
        held = (velocity_B - aside) * [along, along, about]
        return Pushes(
            wrench + resistance(scene, velocity_B, smoothed=scene.change_seen) + held, along, about
        )
    inertia = None
    if scene.settings.has("inertia_lag"):
        inertia = Inertia(mass, about_z, np.full(3, np.nan))
        if before is not None:
            inertia = Inertia(mass, about_z, before.velocity_B, before.since_s)
    return Pushes(wrench + resistance(scene, aside, smoothed=True), drag, inertia=inertia)
