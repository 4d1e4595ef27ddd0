"""Actuation and kinematics of a legged robot: commands to shafts, shafts to unloaded feet."""

from dataclasses import dataclass, replace

import numpy as np

from model.effects.catalogue import NO_LIMIT_RAD_S
from model.effects.gear_play import (
    BEARING_DRAG_NM,
    DRAGGED_PLAY,
    LOOP_S,
    PLAY,
    PLAY_IN_LOOP,
    PLAYS,
    Strut,
    in_play,
    strong_drag,
)
from model.effects.grid import FOOT_WINDOW_S, Grid
from model.effects.leg_paths import foot_paths
from model.effects.machine import LeggedMachine
from model.effects.settings import Settings
from model.effects.signals import FootSignals, ShaftSignals
from model.kinematics.chain import ChainKinematics
from model.motion.filters import lagged, play
from model.values.arrays import FloatArray, readonly
from model.values.parameters import ChainParameters

# By less than that, a shaft may be off its command at the start for other reasons than a limit.
LATE_S = 0.1
STILL = readonly(np.zeros((1, 1, 2)))  # of feet that do not roll
UNSEEN_GIVE = "servo_compliance_beyond_encoder"
GIVES = ("servo_compliance", UNSEEN_GIVE)
MOVES_SHAFTS = frozenset({"command_delay", "servo_lag", "servo_speed_limit", "joint_friction"})
MOVES_FEET = frozenset({"shaft_zero_offset", "link_length", "hip_mount_offset", "foot_rolling"})


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """Kinematics of W frames: the signals, and how far the foot link has turned since mid-stance.

    Attributes:
        rate_m_s: Velocity of the feet in the body frame, (W, N, 3).
        turn_rad: Angle of the foot's link from its angle at shaft angle 0, from +x to +z, (W, N).
        rolling_m_s: How much faster along x and y the feet's matter moves than the places where they touch,
            as they are round and turn, (W, N, 2), or (1, 1, 2) for not at all; in ``rate_m_s`` already.
    """

    signals: FootSignals
    rate_m_s: FloatArray
    turn_rad: FloatArray
    rolling_m_s: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class Loads:
    """What the ground does to the shafts, W frames.

    Attributes:
        torque_nm: Torque about each shaft, positive where it drives it on, (W, J).
        flank_nm: The same for deciding which flank of a play a shaft lies against, (W, J).
        strut: What the ground lets shafts do in their play; None for nothing but grease.
    """

    torque_nm: FloatArray
    flank_nm: FloatArray
    strut: Strut | None = None


def feels_loads(settings: Settings) -> bool:
    """Whether loads move shafts."""
    return settings.has(*GIVES, *PLAYS) or bool(settings.at("actuation"))


def shafts(
    grid: Grid,
    command_rad: FloatArray,
    acting_rad: FloatArray,
    settings: Settings,
    loads: Loads | None,
    start_rad: FloatArray | None = None,
) -> FloatArray:
    """Where commands and loads put the shafts, (W, J) [rad], as an encoder sees them.

    Commands are (W, J), and the same with their delay; loads are needed where they move shafts. The start
    is where shafts were measured in the first frame, (J,), NaN where they were not: one that is too slow
    may be far behind when a recording begins.
    """
    angle = _limited(grid, _lagged(grid, acting_rad, settings), settings, start_rad)
    if loads is not None and settings.has("servo_compliance"):
        angle = angle + settings.each("servo_compliance")[0] * loads.torque_nm
    if settings.has("joint_friction"):  # what the loop holds moves only against it
        angle = _held_back(angle, settings.each("joint_friction")[0])
    if loads is None:
        return angle
    for form in (PLAY, DRAGGED_PLAY):
        if settings.has(form):
            (width_rad,) = settings.each(form)
            drag_nm = BEARING_DRAG_NM if form == PLAY else strong_drag(acting_rad)
            angle = angle + in_play(grid, loads.flank_nm, width_rad, loads.strut, drag_nm)
    if settings.has(PLAY_IN_LOOP):
        (width_rad,) = settings.each(PLAY_IN_LOOP)
        place = in_play(grid, loads.flank_nm, width_rad, loads.strut)
        angle = angle + place - _taken_back(grid, place, settings)
    signals = ShaftSignals(grid.time_s, command_rad, loads.torque_nm, angle)
    return settings.acted("actuation", signals).shaft_rad


def _taken_back(grid: Grid, place_rad: FloatArray, settings: Settings) -> FloatArray:
    """How much of where shafts are in their play their loops have taken back, (W, J) [rad]."""
    behind_s = np.zeros(place_rad.shape[1])
    for (lag_s,) in settings.apart("servo_lag"):
        behind_s += np.asarray(lag_s)
    taken = np.empty_like(place_rad)
    for joint, own_s in enumerate(behind_s):
        taken[:, joint] = lagged(place_rad[:, joint], own_s or LOOP_S, grid.period_s)
    return taken


def _held_back(wanted_rad: FloatArray, behind_rad: FloatArray) -> FloatArray:
    """Where dry friction leaves shafts that a position loop pulls, (W, J) [rad].

    A shaft stands until it is so far behind that the loop overcomes friction, (J,), and then stays so far
    behind; it stands again when the motion turns round. It begins behind the motion that it is in.
    """
    angle = wanted_rad.copy()
    for joint in np.flatnonzero(behind_rad):
        known = np.isfinite(wanted_rad[:, joint])
        driven = wanted_rad[known, joint]
        moves = np.diff(driven)
        started = moves[moves != 0.0]
        if len(started):
            begin = driven[0] - np.sign(started[0]) * behind_rad[joint]
            angle[known, joint] = play(driven, 2.0 * behind_rad[joint], begin)
    return angle


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


def _limited(
    grid: Grid, wanted: FloatArray, settings: Settings, start_rad: FloatArray | None
) -> FloatArray:
    """The fastest motion behind the wanted one that keeps the limits, forward and backward."""
    if not settings.has("servo_speed_limit"):
        return wanted
    (limit,) = settings.each("servo_speed_limit")
    ramp = grid.time_s[:, None] * limit
    from_start = wanted.copy()
    if start_rad is not None:
        off = (start_rad - wanted[0] + np.pi) % (2.0 * np.pi) - np.pi
        from_start[0] += np.where(np.abs(off) > LATE_S * limit, off, 0.0)
    # NaN would spread to all that follows
    known = np.isfinite(wanted)
    ahead = np.minimum.accumulate(np.where(known, from_start, np.inf) - ramp) + ramp
    both = np.maximum.accumulate(np.where(known, ahead, -np.inf) + ramp) - ramp
    return np.where(known, np.where(limit < NO_LIMIT_RAD_S, both, wanted), np.nan)


def feet(machine: LeggedMachine, grid: Grid, shaft_rad: FloatArray, settings: Settings) -> Feet:
    """Unloaded feet from encoder angles, (W, J) [rad]."""
    crank = shaft_rad
    if settings.has("shaft_zero_offset"):
        crank = crank + settings.each("shaft_zero_offset")[0]
    if isinstance(machine.leg, ChainParameters):
        return _chain_feet(machine.leg, grid, crank, settings)
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
    rolling = STILL
    if len(paths.rolled_m) == len(rate):
        rolling = np.zeros((*crank.shape, 2))
        rolling[..., 0] = grid.slope(paths.rolled_m, FOOT_WINDOW_S)
        rate[..., 0] += rolling[..., 0]
    return Feet(signals, rate, paths.turn_rad, rolling)


def _chain_feet(
    chain: ChainParameters, grid: Grid, angle_rad: FloatArray, settings: Settings
) -> Feet:
    """Unloaded feet of legs with several joints."""
    kinematics = ChainKinematics(chain)
    position = kinematics.feet(angle_rad, np.zeros_like(angle_rad)).position_m
    if settings.has("hip_mount_offset"):
        position[..., :2] += settings.each("hip_mount_offset").T
    slope = np.full((1, len(chain.foot), 2), np.nan)
    jacobian = kinematics.jacobian(angle_rad) if feels_loads(settings) else None
    signals = FootSignals(grid.time_s, angle_rad, position, slope, jacobian)
    signals = settings.acted("kinematics", signals)
    rate, rolling = grid.slope(signals.position_m, FOOT_WINDOW_S), STILL
    if chain.radius.any():
        moved = kinematics.feet(angle_rad, grid.slope(angle_rad, FOOT_WINDOW_S)).velocity_m_s
        rolling = (moved - grid.slope(position, FOOT_WINDOW_S))[..., :2]
        rate[..., :2] += rolling
    return Feet(signals, rate, np.zeros((1, 1)), rolling)


def moves_feet(settings: Settings) -> Settings:
    """Return the part of settings that ``feet`` looks at, all else neutral."""
    acting = tuple(one for one in settings.acting if one[0] in MOVES_FEET)
    return replace(settings, acting=acting, added=settings.at("kinematics"))


def moves_shafts(settings: Settings) -> Settings:
    """Return the part of settings that ``shafts`` looks at without loads, all else neutral.

    It has the delay of the commands that are given to it, too.
    """
    acting = tuple(one for one in settings.acting if one[0] in MOVES_SHAFTS)
    return replace(settings, acting=acting, added=())


def load_torque(signals: FootSignals, force_n: FloatArray) -> FloatArray:
    """Torque of foot forces about the shafts, by virtual work, (W, J) [N m].

    The force is the ground's on each foot, body axes, (W, N, 3).
    """
    torque: FloatArray
    if signals.jacobian_m_rad is not None:
        torque = np.einsum("wnij,wni->wj", signals.jacobian_m_rad, force_n)
    else:
        torque = (
            signals.slope_m_rad[..., 0] * force_n[..., 0]
            + signals.slope_m_rad[..., 1] * force_n[..., 2]
        )
    return torque


def shaft_give(signals: FootSignals, compliance: FloatArray) -> FloatArray:
    """How far feet give along x where shafts give by (J,) [rad/(N m)], (W, N) [m/N]."""
    give: FloatArray
    if signals.jacobian_m_rad is not None:
        give = signals.jacobian_m_rad[:, :, 0] ** 2 @ compliance
    else:
        give = compliance * signals.slope_m_rad[..., 0] ** 2
    return give


def springing(signals: FootSignals, compliance: FloatArray, force_x_n: FloatArray) -> FloatArray:
    """How far forces along x, (W, N), turn shafts that give, (W, J) [rad]."""
    turn: FloatArray
    if signals.jacobian_m_rad is not None:
        turn = compliance * np.einsum("wnj,wn->wj", signals.jacobian_m_rad[:, :, 0], force_x_n)
    else:
        turn = compliance * signals.slope_m_rad[..., 0] * force_x_n
    return turn
