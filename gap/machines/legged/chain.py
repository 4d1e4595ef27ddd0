"""The legged chain: commands to sensor readings through all stages, with whatever is added.

Command drive: every stage is fed by the one before; where loads act back on shafts, or effects are
bound to places, the chain is run until nothing changes. Measured drive: shafts, loads, foot forces and
pose come from the sensors (made good for what the causes say of the sensors), where they were measured.
"""

from collections import OrderedDict
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from gap.interfaces import Drive
from gap.machines.legged.grid import body_velocity
from gap.machines.legged.ground import Sliding, Standing, slide, stand
from gap.machines.legged.inputs import LeggedInputs
from gap.machines.legged.machine import LeggedMachine
from gap.machines.legged.pushes import gradient
from gap.machines.legged.sensing import read_sensors, true_inputs
from gap.machines.legged.settings import Settings, neutral_settings
from gap.machines.legged.shafts import (
    FOOT_WEIGHT_N,
    Feet,
    Loads,
    feels_loads,
    feet,
    load_torque,
    moves_feet,
    shafts,
)
from gap.machines.legged.signals import SensorSignals
from model.motion.se2 import integrate
from model.values.arrays import FloatArray

PASSES = 30
CONVERGED = 1e-7  # change from pass to pass of shafts [rad] and places [m]
REMEMBERED = 24


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """The truth of W frames as the chain has it.

    Attributes:
        shaft_rad: Shafts as commands and loads put them, (W, N).
        feet: Unloaded feet.
        standing: Support.
        sliding: Friction.
        world: x, y, yaw of the body, (W, 3).
    """

    shaft_rad: FloatArray
    feet: Feet
    standing: Standing
    sliding: Sliding
    world: FloatArray


class LeggedChain:
    """The chain of one machine; stages that several predictions share are solved once.

    Args:
        machine: The robot.
    """

    def __init__(self, machine: LeggedMachine) -> None:
        self._machine = machine
        # settings compare by value, inputs by identity: what was solved before is found again
        self._plain_walk = lru_cache(maxsize=REMEMBERED)(self._walk)
        self._known_feet: OrderedDict[tuple[int, Settings], tuple[FloatArray, Feet]] = OrderedDict()

    def read(self, inputs: LeggedInputs, settings: Settings, drive: Drive) -> SensorSignals:
        """Return what the sensors would read."""
        known = true_inputs(inputs, settings) if drive is Drive.MEASURED else inputs
        walk = self.walk(known, settings, drive)
        return read_sensors(inputs.grid, self._truth(known, walk, settings, drive), settings)

    def walk(self, known: LeggedInputs, settings: Settings, drive: Drive) -> Walk:
        """Run all stages before the sensors, or remember them.

        Args:
            known: Inputs, with perfect sensors.
            settings: What is added.
            drive: What feeds the stages.
        """
        sensor = neutral_settings(self._machine.legs.count).sensor
        others = tuple(added for added in settings.added if added.stage != "sensing")
        return self._plain_walk(known, replace(settings, sensor=sensor, added=others), drive)

    def _walk(self, known: LeggedInputs, settings: Settings, drive: Drive) -> Walk:
        measured = drive is Drive.MEASURED
        world = _measured_world(known) if measured else None
        velocity = None
        if world is not None and settings.ground.resists_motion:
            velocity = body_velocity(known.grid, world)
        flank = None
        if not measured and any(settings.shaft.backlash_rad):
            # which flank a shaft lies against is told by the loads of a walk without the play
            tight = replace(settings.shaft, backlash_rad=(0.0,) * len(settings.shaft.backlash_rad))
            flank = foot_forces(self._plain_walk(known, replace(settings, shaft=tight), drive))
        place = np.tile(known.start_pose, (known.grid.frames, 1)) if world is None else world
        force = known.force_n if measured else np.zeros_like(known.force_n)
        walk = self._pass(known, settings, drive, force, flank, place, velocity)
        if not _acts_back(settings, drive, world is None):
            return walk
        for _ in range(PASSES):
            before = walk
            force = force if measured else foot_forces(walk)
            place = walk.world if world is None else world
            walk = self._pass(known, settings, drive, force, flank, place, velocity, walk)
            if _change(before, walk) <= CONVERGED:
                break
        return walk

    def _pass(
        self,
        known: LeggedInputs,
        settings: Settings,
        drive: Drive,
        force: FloatArray,
        flank_force: FloatArray | None,
        world: FloatArray,
        velocity: FloatArray | None,
        before: Walk | None = None,
    ) -> Walk:
        """One pass: forces about the shafts, places and a measured velocity are those given."""
        machine, grid = self._machine, known.grid
        measured = drive is Drive.MEASURED
        loads, give, springing = None, None, None
        if feels_loads(settings):
            # the lever is that of the shaft where it nearly is
            near = known.shaft_rad if measured else known.command_rad
            lever = feet(machine, grid, near, settings).signals
            torque = load_torque(lever, force)
            flank = torque if flank_force is None else load_torque(lever, flank_force)
            loads = Loads(torque, flank - FOOT_WEIGHT_N * lever.slope_m_rad[..., 1])
            if not measured:
                # a shaft that gives under friction is a foot that gives: too stiff for a loop of passes
                compliance = np.array(settings.shaft.compliance_rad_nm)
                give = compliance * lever.slope_m_rad[..., 0] ** 2
                springing = compliance * lever.slope_m_rad[..., 0] * _finite(force[..., 0])
        own = shafts(known, settings, loads)
        turned = np.where(np.isfinite(known.shaft_rad), known.shaft_rad, own) if measured else own
        if measured and np.isfinite(known.shaft_rad).all():
            walked = self._measured_feet(known, settings)
        else:
            walked = feet(machine, grid, turned, settings)
        moving = velocity
        if moving is None and before is not None:
            moving = _finite(before.sliding.velocity_B)
        standing = stand(machine, grid, walked, settings, world, moving)
        load = standing.load_n
        if measured:
            seen = known.force_n[..., 2]
            load = np.where(np.isfinite(seen), np.maximum(seen, 0.0), load)
        held = walked
        if springing is not None and springing.any():
            held = feet(machine, grid, turned - springing, settings)
        sliding = slide(machine, grid, held, standing, settings, world, load, give, velocity)
        return Walk(own, walked, standing, sliding, _integrated(known, sliding.velocity_B))

    def _measured_feet(self, known: LeggedInputs, settings: Settings) -> Feet:
        """Feet on measured shafts: most effects of other stages share them."""
        angles = known.shaft_rad
        key = (id(angles), moves_feet(settings))
        if key in self._known_feet:
            self._known_feet.move_to_end(key)
            return self._known_feet[key][1]
        found = feet(self._machine, known.grid, angles, settings)
        # the angles are kept with their feet, so that no other array gets their id
        self._known_feet[key] = (angles, found)
        if len(self._known_feet) > REMEMBERED:
            self._known_feet.popitem(last=False)
        return found

    def _truth(
        self, known: LeggedInputs, walk: Walk, settings: Settings, drive: Drive
    ) -> SensorSignals:
        """What perfect sensors would read of a walk."""
        own = settings.ground
        force = foot_forces(walk, known=False)
        acting = force
        if drive is Drive.MEASURED:
            acting = np.where(np.isfinite(known.force_n), known.force_n, force)
        foot = walk.feet.signals.position_m.copy()
        stiffness = self._machine.contact.stiffness * np.array(own.stiffness_ratio)
        foot[..., 2] += np.maximum(acting[..., 2], 0.0) / stiffness - np.array(own.leg_length_m)
        twist = walk.standing.twist_rad
        if twist.any():  # about an axis along x at the height of the shafts
            aside = -foot[..., 2] * twist
            foot[..., 2] += foot[..., 1] * twist
            foot[..., 1] += aside
        radius = settings.shaft.rolling_m
        if radius:  # a marker at the bottom of a round foot turns with it about its centre
            foot[..., 0] += radius * np.sin(walk.feet.turn_rad)
            foot[..., 2] += radius * (1.0 - np.cos(walk.feet.turn_rad))
        if own.flex_lateral_m_n or own.flex_longitudinal_m_n:
            foot[..., :2] += acting[..., :2] * [own.flex_longitudinal_m_n, own.flex_lateral_m_n]
        body, angles = _body(known, walk, settings)
        return SensorSignals(known.grid.time_s, walk.shaft_rad, foot, force, body, angles)


def foot_forces(walk: Walk, *, known: bool = True) -> FloatArray:
    """Ground's force on each foot, (W, N, 3) [N]; where there is no answer 0 if ``known``, else NaN."""
    force = np.concatenate([walk.sliding.force_xy_n, walk.standing.load_n[..., None]], axis=2)
    return _finite(force) if known else force


def _finite(values: FloatArray) -> FloatArray:
    return np.where(np.isfinite(values), values, 0.0)


def _acts_back(settings: Settings, drive: Drive, place_unknown: bool) -> bool:
    ground = settings.ground
    loads = any(settings.shaft.compliance_rad_nm) or bool(settings.at("actuation"))
    places = (
        ground.step_height_m or ground.patch_ratio != 1.0 or ground.slope_x or ground.slope_y
        or ground.tether_x_n or ground.tether_y_n or ground.resists_motion
    )  # fmt: skip
    return (loads and drive is Drive.COMMAND) or (bool(places) and place_unknown)


def _change(before: Walk, after: Walk) -> float:
    shaft = np.abs(after.shaft_rad - before.shaft_rad)
    place = np.abs(after.world - before.world)
    return float(max(np.nanmax(shaft, initial=0.0), np.nanmax(place, initial=0.0)))


def _measured_world(known: LeggedInputs) -> FloatArray | None:
    world = np.column_stack([known.body_m[:, :2], known.body_rad[:, 2]])
    complete = np.isfinite(world).all(axis=1)
    if not complete.any():
        return None
    time_s = known.grid.time_s
    return np.stack([np.interp(time_s, time_s[complete], c[complete]) for c in world.T], axis=1)


def _integrated(known: LeggedInputs, velocity: FloatArray) -> FloatArray:
    """Place of the point below the body's origin, (W, 3), from where the trial began."""
    held = np.where(np.isfinite(velocity), velocity, 0.0)
    return integrate((held[:-1] + held[1:]) / 2, known.grid.period_s, known.start_pose)


def _body(known: LeggedInputs, walk: Walk, settings: Settings) -> tuple[FloatArray, FloatArray]:
    """Body's place and angles in the world, (W, 3) each; NaN where there is no balance.

    The planar balance moves the ground below the origin; the origin, at its height above it, sways with the
    tilt. On a slope it rises with the ground and leans with it.
    """
    slopes, height = walk.standing.slopes, walk.standing.height_m
    rise = gradient(settings.ground, walk.world)
    roll = np.arctan(slopes[:, 1] + rise[:, 1])
    pitch = np.arctan(slopes[:, 0] - rise[:, 0])
    yaw = walk.world[:, 2]
    sway = walk.standing.sway_m - walk.standing.sway_m[:1]
    c, s = np.cos(yaw), np.sin(yaw)
    x = walk.world[:, 0] + c * sway[:, 0] - s * sway[:, 1]
    y = walk.world[:, 1] + s * sway[:, 0] + c * sway[:, 1]
    z = height
    if settings.ground.slope_x or settings.ground.slope_y:
        start = known.start_pose
        c0, s0 = np.cos(start[2]), np.sin(start[2])
        own = settings.ground
        uphill = (c0 * own.slope_x - s0 * own.slope_y, s0 * own.slope_x + c0 * own.slope_y)
        z = z + uphill[0] * (x - start[0]) + uphill[1] * (y - start[1])
    none = ~np.isfinite(walk.sliding.velocity_B).all(axis=1)
    x, y, yaw = (np.where(none, np.nan, a) for a in (x, y, yaw))
    return np.column_stack([x, y, z]), np.column_stack([roll, pitch, yaw])
