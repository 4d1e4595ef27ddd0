"""What acts on the legged simulator's body besides its feet: gravity, a tether, drag, inertia."""

from dataclasses import dataclass

import numpy as np
from scipy.constants import g as standard_gravity

from gap.machines.legged.grid import TWIST_WINDOW_S, Grid
from gap.machines.legged.machine import LeggedMachine
from gap.machines.legged.settings import GroundSettings
from model.traction.frames import Inertia, Pushes
from model.values.arrays import FloatArray

# A body that friction mu M g holds at this slip takes its time constant to follow.
INERTIA_SLIP_M_S = 0.02
# What resists a foretold velocity that is not the measured one: a share of drag, inertia over a time.
DRAG_OF_DEVIATION = 0.2
DEVIATION_S = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Before:
    """A moment before: vx, vy, yaw rate then, (3,), and how long ago that was."""

    velocity_B: FloatArray  # noqa: N815
    since_s: float


def weight_and_centre(machine: LeggedMachine, own: GroundSettings) -> tuple[float, FloatArray]:
    """Weight [N] and centre of mass in the body frame, (2,) [m], with what rides along."""
    mass = machine.mass_kg
    moment = mass * np.array([own.com_x_m, own.com_y_m])
    for rider_kg, x, y in own.payloads:
        mass += rider_kg
        moment = moment + rider_kg * np.array([x, y])
    return mass * standard_gravity, moment / mass


def gradient(own: GroundSettings, world: FloatArray) -> FloatArray:
    """Rise of the ground per metre along body x and y, (W, 2), as the body turns."""
    turned = world[:, 2] - world[0, 2]
    c, s = np.cos(turned), np.sin(turned)
    return np.stack([c * own.slope_x + s * own.slope_y, c * own.slope_y - s * own.slope_x], axis=1)


def sideways_force(machine: LeggedMachine, own: GroundSettings, world: FloatArray) -> FloatArray:
    """Gravity's share and the tether, along the ground at the centre of mass, body axes, (W, 2) [N]."""
    force = np.zeros((len(world), 2))
    if own.slope_x or own.slope_y:
        force -= weight_and_centre(machine, own)[0] * gradient(own, world)
    if own.tether_x_n or own.tether_y_n:
        c, s = np.cos(world[:, 2]), np.sin(world[:, 2])
        force[:, 0] += c * own.tether_x_n + s * own.tether_y_n
        force[:, 1] += c * own.tether_y_n - s * own.tether_x_n
    return force


def _added_inertia(machine: LeggedMachine, own: GroundSettings) -> tuple[float, float]:
    """Mass [kg], and moment of inertia about the vertical [kg m^2], with the time constant in question."""
    mass = own.inertia_s * float(machine.contact.mu.mean()) * machine.weight_n / INERTIA_SLIP_M_S
    arms = machine.legs.shaft_position[:, :2]
    return mass, mass * float((arms**2).sum(axis=1).mean())


def resistance(
    machine: LeggedMachine,
    grid: Grid,
    own: GroundSettings,
    velocity_B: FloatArray,  # noqa: N803
) -> FloatArray:
    """Wrench of drag and inertia at a known velocity, body axes, (W, 3) [N, N, N m]."""
    wrench = -own.drag_n_s_m * velocity_B * [1.0, 1.0, 0.0]
    if own.inertia_s and not grid.is_moment:
        mass, about_z = _added_inertia(machine, own)
        change = grid.slope(velocity_B, TWIST_WINDOW_S)
        change[:, :2] += velocity_B[:, 2:] * np.stack([-velocity_B[:, 1], velocity_B[:, 0]], axis=1)
        wrench = wrench - change * [mass, mass, about_z]
    return wrench


def _swaying(grid: Grid, sway_m: FloatArray) -> FloatArray:
    """Velocity of the origin by its sway, (W, 3); none in a moment that is too short to tell."""
    velocity = np.zeros((len(sway_m), 3))
    if not grid.is_moment:
        velocity[:, :2] = grid.slope(sway_m, TWIST_WINDOW_S)
    return velocity


def pushes(
    machine: LeggedMachine,
    grid: Grid,
    own: GroundSettings,
    wrench: FloatArray,
    sway_m: FloatArray,
    velocity_B: FloatArray | None,  # noqa: N803
    before: Before | None,
) -> Pushes:
    """Add drag and inertia to what else acts on the body, (W, 3).

    Where the velocity was measured they are those of the measured one. What is foretold deviates from it;
    a share of the drag, and the inertia over a second, act against that, so that a
    frame in which friction cannot hold the wrench does not run away.
    """
    if not own.resists_motion:
        return Pushes(wrench)
    mass, about_z = _added_inertia(machine, own)
    aside = _swaying(grid, sway_m)
    if velocity_B is not None:
        along = DRAG_OF_DEVIATION * own.drag_n_s_m + mass / DEVIATION_S
        about = about_z / DEVIATION_S
        held = (velocity_B - aside) * [along, along, about]
        return Pushes(wrench + resistance(machine, grid, own, velocity_B) + held, along, about)
    inertia = None
    if own.inertia_s:
        inertia = Inertia(mass, about_z, np.full(3, np.nan))
        if before is not None:
            inertia = Inertia(mass, about_z, before.velocity_B, before.since_s)
    wrench = wrench + resistance(machine, grid, own, aside)
    return Pushes(wrench, own.drag_n_s_m, inertia=inertia)
