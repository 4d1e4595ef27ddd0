"""What perfect sensors would read of a walk that the chain has found."""

from dataclasses import dataclass

import numpy as np

from gap.interfaces import Drive
from gap.machines.legged.inputs import LeggedInputs
from model.compiled import compiled
from model.effects.ground import Sliding, Standing, leg_stiffness
from model.effects.machine import LeggedMachine
from model.effects.pushes import gradient
from model.effects.settings import Settings
from model.effects.shafts import Feet
from model.effects.signals import SensorSignals
from model.motion.se2 import turned
from model.values.arrays import FloatArray, given_rows

NO_FORCE = np.empty((0, 0, 3))
MARKER_SHARE = "marker_on_shank"


@dataclass(frozen=True, slots=True, eq=False)
class Walk:
    """The truth of W frames as the chain has it.

    Shafts, (W, N), are where commands and loads put them; the world holds x, y, yaw of the body, (W, 3).
    """

    shaft_rad: FloatArray
    feet: Feet
    standing: Standing
    sliding: Sliding
    world: FloatArray


def truth_of(
    machine: LeggedMachine, known: LeggedInputs, walk: Walk, settings: Settings, drive: Drive
) -> SensorSignals:
    """What perfect sensors would read of a walk."""
    legs = walk.standing.load_n.shape
    foot, force, acting = (np.empty((*legs, 3)) for _ in range(3))
    position, force_xy, load, measured, stiffness, longer = map(given_rows, (
        walk.feet.signals.position_m, walk.sliding.force_xy_n, walk.standing.load_n,
        known.force_n if drive is Drive.MEASURED else NO_FORCE,
        leg_stiffness(machine, settings), settings.each("leg_length")[0],
    ))  # fmt: skip
    (seen,) = settings.whole(MARKER_SHARE)  # of what legs give
    _lay_truth(position, force_xy, load, measured, stiffness, longer, seen, foot, force, acting)
    twist = walk.standing.twist_rad
    if twist.any():  # about an axis along x at the height of the shafts
        aside = -foot[..., 2] * twist
        foot[..., 2] += foot[..., 1] * twist
        foot[..., 1] += aside
    if settings.has("foot_rolling"):
        # a marker at the bottom of a round foot turns with it about its centre
        (radius_m,) = settings.whole("foot_rolling")
        foot[..., 0] += radius_m * np.sin(walk.feet.turn_rad)
        foot[..., 2] += radius_m * (1.0 - np.cos(walk.feet.turn_rad))
    if settings.has("leg_flex"):
        lateral, fore = settings.whole("leg_flex")
        _bend(acting, fore * seen, lateral * seen, foot)
    body, angles = _body(known, walk, settings)
    return SensorSignals(known.grid.time_s, walk.shaft_rad, foot, force, body, angles)


@compiled
def _lay_truth(
    position: FloatArray, force_xy: FloatArray, load: FloatArray, measured: FloatArray,
    stiffness: FloatArray, longer: FloatArray, seen: float, foot: FloatArray, force: FloatArray,
    acting: FloatArray,
) -> None:  # fmt: skip
    """Feet under load, the forces on them, and those that act: measured ones where there are any."""
    for f in range(load.shape[0]):
        for k in range(load.shape[1]):
            force[f, k, 0], force[f, k, 1] = force_xy[f, k, 0], force_xy[f, k, 1]
            force[f, k, 2] = load[f, k]
            for i in range(3):
                acting[f, k, i], foot[f, k, i] = force[f, k, i], position[f, k, i]
                if measured.shape[0] > 0 and np.isfinite(measured[f, k, i]):
                    acting[f, k, i] = measured[f, k, i]
            press = acting[f, k, 2]
            if press < 0.0:
                press = 0.0
            foot[f, k, 2] += seen * (press / stiffness[k] - longer[k])


@compiled
def _bend(force: FloatArray, fore_m_n: float, lateral_m_n: float, foot: FloatArray) -> None:
    """Move feet sideways by what their legs give."""
    for f in range(foot.shape[0]):
        for k in range(foot.shape[1]):
            foot[f, k, 0] += force[f, k, 0] * fore_m_n
            foot[f, k, 1] += force[f, k, 1] * lateral_m_n


def _body(known: LeggedInputs, walk: Walk, settings: Settings) -> tuple[FloatArray, FloatArray]:
    """Body's place and angles in the world, (W, 3) each; NaN where there is no balance.

    The planar balance moves the ground below the origin; the origin, at its height above it, sways with the
    tilt. On a slope it rises with the ground and leans with it.
    """
    slopes, height, sway = walk.standing.slopes, walk.standing.height_m, walk.standing.sway_m
    rolls, pitches = slopes[:, 1], slopes[:, 0]
    if settings.has("ground_slope"):
        rise = gradient(settings, walk.world)
        rolls, pitches = rolls + rise[:, 1], pitches - rise[:, 0]
    roll, pitch = np.arctan(rolls), np.arctan(pitches)
    yaw = walk.world[:, 2]
    sway = sway - sway[:1]
    place = walk.world[:, :2] + np.stack(turned(sway[:, 0], sway[:, 1], yaw), axis=1)
    if settings.has("ground_slope"):
        start = known.start_pose
        slope_x, slope_y = np.array(settings.whole("ground_slope"))
        height = height + (place - start[:2]) @ np.array(turned(slope_x, slope_y, start[2]))
    none = ~np.isfinite(walk.sliding.velocity_B).all(axis=1)
    x, y, yaw = (np.where(none, np.nan, a) for a in (*place.T, yaw))
    return np.column_stack([x, y, height]), np.column_stack([roll, pitch, yaw])


def foot_forces(walk: Walk) -> FloatArray:
    """Ground's force on each foot, (W, N, 3) [N]; 0 where there is no answer."""
    force = [walk.sliding.force_xy_n, walk.standing.load_n[..., None]]
    return finite(np.concatenate(force, axis=2))


def finite(values: FloatArray) -> FloatArray:
    """Return values with 0 where they are not finite."""
    return np.where(np.isfinite(values), values, 0.0)
