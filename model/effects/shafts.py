"""Actuation and kinematics of a legged robot: commands to shafts, shafts to unloaded feet."""

from dataclasses import dataclass

import numpy as np

from model.effects.catalogue import NO_LIMIT_RAD_S
from model.effects.grid import FOOT_WINDOW_S, Grid
from model.effects.leg_paths import foot_paths
from model.effects.machine import LeggedMachine
from model.effects.settings import Settings
from model.effects.signals import FootSignals, ShaftSignals
from model.motion.filters import lagged, play
from model.values.arrays import FloatArray

# A free shaft in a play is dragged against its rear flank by its bearings, and falls against either by the
# weight of foot and coupler, as fast as grease lets it. All three are assumed.
BEARING_DRAG_NM = 0.003
BEARING_DAMPING_NM_S = 0.02
FOOT_WEIGHT_N = 0.5
MOVES_FEET = frozenset({"shaft_zero_offset", "link_length", "hip_mount_offset", "foot_rolling"})


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """Kinematics of W frames: the signals, and how far the foot link has turned since mid-stance.

    Attributes:
        rate_m_s: Velocity of the feet in the body frame, (W, N, 3).
        turn_rad: Angle of the foot's link from its angle at shaft angle 0, from +x to +z, (W, N).
        rolling_m_s: How much faster along x the feet's matter moves than the places where they touch, as
            they are round and turn, (W, N), or (1, 1) for not at all; in ``rate_m_s`` already.
    """

    signals: FootSignals
    rate_m_s: FloatArray
    turn_rad: FloatArray
    rolling_m_s: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Loads:
    """What the ground does to the shafts, W frames.

    Attributes:
        torque_nm: Torque about each shaft, positive where it drives it on, (W, N).
        flank_nm: The same for deciding which flank of a play a shaft lies against, (W, N).
    """

    torque_nm: FloatArray
    flank_nm: FloatArray


def feels_loads(settings: Settings) -> bool:
    """Whether loads move shafts."""
    return settings.has("servo_compliance", "gear_backlash") or bool(settings.at("actuation"))


def shafts(
    grid: Grid,
    command_rad: FloatArray,
    acting_rad: FloatArray,
    settings: Settings,
    loads: Loads | None,
) -> FloatArray:
    """Where commands and loads put the shafts, (W, N) [rad], as an encoder sees them.

    Commands are (W, N), and the same with their delay; loads are needed where they move shafts.
    """
    angle = _limited(grid, _lagged(grid, acting_rad, settings), settings)
    if loads is None:
        return angle
    if settings.has("servo_compliance"):
        angle = angle + settings.each("servo_compliance")[0] * loads.torque_nm
    if settings.has("gear_backlash"):
        angle = angle + _in_play(grid, loads.flank_nm, settings.each("gear_backlash")[0])
    signals = ShaftSignals(grid.time_s, command_rad, loads.torque_nm, angle)
    return settings.acted("actuation", signals).shaft_rad


def _in_play(grid: Grid, torque_nm: FloatArray, width_rad: FloatArray) -> FloatArray:
    """Where shafts are in their play, (W, N) [rad]: grease slows them on their way from flank to flank."""
    place_rad = np.zeros(torque_nm.shape)
    for leg in np.flatnonzero(width_rad):
        pull = np.nan_to_num(torque_nm[:, leg]) - BEARING_DRAG_NM
        pushed = np.cumsum(pull * grid.period_s / BEARING_DAMPING_NM_S)
        first = -np.sign(pull[0]) * width_rad[leg] / 2
        place_rad[:, leg] = pushed - play(pushed, width_rad[leg], first)
    return place_rad


def _lagged(grid: Grid, command: FloatArray, settings: Settings) -> FloatArray:
    angle = command.copy()
    lags = (lag_s for (lag_s,) in settings.apart("servo_lag"))
    for leg, constants_s in enumerate(zip(*lags, strict=True)):
        known = np.isfinite(command[:, leg])
        if any(constants_s) and known.any():
            whole = np.interp(grid.time_s, grid.time_s[known], command[known, leg])
            for constant_s in constants_s:
                whole = lagged(whole, constant_s, grid.period_s, ramping=True)
            angle[:, leg] = np.where(known, whole, np.nan)
    return angle


def _limited(grid: Grid, wanted: FloatArray, settings: Settings) -> FloatArray:
    """The fastest motion behind the wanted one that keeps the limits, forward and backward."""
    if not settings.has("servo_speed_limit"):
        return wanted
    (limit,) = settings.each("servo_speed_limit")
    ramp = grid.time_s[:, None] * limit
    # NaN would spread to all that follows
    known = np.isfinite(wanted)
    ahead = np.minimum.accumulate(np.where(known, wanted, np.inf) - ramp) + ramp
    both = np.maximum.accumulate(np.where(known, ahead, -np.inf) + ramp) - ramp
    return np.where(known, np.where(limit < NO_LIMIT_RAD_S, both, wanted), np.nan)


def feet(machine: LeggedMachine, grid: Grid, shaft_rad: FloatArray, settings: Settings) -> Feet:
    """Unloaded feet from encoder angles, (W, N) [rad]."""
    crank = shaft_rad
    if settings.has("shaft_zero_offset"):
        crank = crank + settings.each("shaft_zero_offset")[0]
    paths = foot_paths(machine.leg, crank, settings)
    position = np.empty((*crank.shape, 3))
    position[..., 0] = paths.foot_m[..., 0]
    position[..., 1] = 0.0
    position[..., 2] = paths.foot_m[..., 1]
    position += machine.legs.shaft_position
    if settings.has("hip_mount_offset"):
        position[..., :2] += settings.each("hip_mount_offset").T
    signals = FootSignals(grid.time_s, crank, position, paths.slope_m_rad)
    signals = settings.acted("kinematics", signals)
    rate = grid.slope(signals.position_m, FOOT_WINDOW_S)
    rolling = paths.rolled_m
    if len(rolling) == len(rate):
        rolling = grid.slope(rolling, FOOT_WINDOW_S)
        rate[..., 0] += rolling
    return Feet(signals, rate, paths.turn_rad, rolling)


def moves_feet(settings: Settings) -> Settings:
    """Return the part of settings that ``feet`` looks at, all else neutral."""
    acting = tuple(one for one in settings.acting if one[0] in MOVES_FEET)
    return Settings(settings.legs, acting, settings.at("kinematics"))


def load_torque(signals: FootSignals, force_n: FloatArray) -> FloatArray:
    """Torque of foot forces about the shafts, by virtual work, (W, N) [N m].

    The force is the ground's on each foot, body axes, (W, N, 3).
    """
    torque: FloatArray = (
        signals.slope_m_rad[..., 0] * force_n[..., 0]
        + signals.slope_m_rad[..., 1] * force_n[..., 2]
    )
    return torque
