"""Actuation and kinematics of the legged simulator: commands to shafts, shafts to unloaded feet."""

from dataclasses import dataclass, replace

import numpy as np

from gap.machines.legged.grid import FOOT_WINDOW_S, Grid, lagged
from gap.machines.legged.inputs import LeggedInputs
from gap.machines.legged.machine import LeggedMachine
from gap.machines.legged.settings import (
    NO_LIMIT_RAD_S,
    Settings,
    ShaftSettings,
    neutral_settings,
)
from gap.machines.legged.signals import FootSignals, ShaftSignals
from model.kinematics.four_bar import LinkagePose, linkage_pose
from model.values.arrays import FloatArray

# A free shaft in a play is dragged against its rear flank by its bearings, and falls against either by the
# weight of foot and coupler, as fast as grease lets it. All three are assumed.
BEARING_DRAG_NM = 0.003
BEARING_DAMPING_NM_S = 0.02
FOOT_WEIGHT_N = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Feet:
    """Kinematics of W frames: the signals, and how far the foot link has turned since mid-stance.

    Attributes:
        signals: Feet and their slopes.
        rate_m_s: Velocity of the feet in the body frame, (W, N, 3).
        turn_rad: Angle of the coupler from its angle at shaft angle 0, from +x to +z, (W, N).
    """

    signals: FootSignals
    rate_m_s: FloatArray
    turn_rad: FloatArray


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
    own = settings.shaft
    return any(own.compliance_rad_nm) or any(own.backlash_rad) or bool(settings.at("actuation"))


def shafts(inputs: LeggedInputs, settings: Settings, loads: Loads | None) -> FloatArray:
    """Where commands and loads put the shafts, (W, N) [rad], as an encoder sees them.

    Args:
        inputs: Commands.
        settings: What is added.
        loads: Needed where loads move shafts.
    """
    own = settings.shaft
    command = inputs.delayed_command(own.delay_s)
    angle = _limited(inputs.grid, _lagged(inputs.grid, command, own), own)
    if loads is None:
        return angle
    if any(own.compliance_rad_nm):
        angle = angle + np.array(own.compliance_rad_nm) * loads.torque_nm
    if any(own.backlash_rad):
        angle = angle + _in_play(inputs.grid, loads.flank_nm, own.backlash_rad)
    for added in settings.at("actuation"):
        signals = ShaftSignals(inputs.grid.time_s, inputs.command_rad, loads.torque_nm, angle)
        angle = added.act(signals, added.values, added.legs).shaft_rad
    return angle


def _in_play(grid: Grid, torque_nm: FloatArray, width_rad: tuple[float, ...]) -> FloatArray:
    """Where shafts are in their play, (W, N) [rad]: grease slows them on their way from flank to flank."""
    found = np.zeros(torque_nm.shape)
    for leg, width in enumerate(width_rad):
        if width == 0.0:
            continue
        pull = np.nan_to_num(torque_nm[:, leg]) - BEARING_DRAG_NM
        end = abs(width) / 2
        at = float(np.sign(pull[0])) * end
        out = []
        for way in (pull * grid.period_s / BEARING_DAMPING_NM_S).tolist():
            at = min(max(at + way, -end), end)
            out.append(at)
        found[:, leg] = np.array(out) * np.sign(width)
    return found


def _lagged(grid: Grid, command: FloatArray, own: ShaftSettings) -> FloatArray:
    if not any(any(lags) for lags in own.lags_s):
        return command
    angle = command.copy()
    for leg, column in enumerate(command.T):
        known = np.isfinite(column)
        constants = [lags[leg] for lags in own.lags_s if lags[leg] > 0]
        if constants and known.any():
            whole = np.interp(grid.time_s, grid.time_s[known], column[known])[:, None]
            for time_constant_s in constants:
                whole = lagged(grid, whole, time_constant_s)
            angle[:, leg] = np.where(known, whole[:, 0], np.nan)
    return angle


def _limited(grid: Grid, wanted: FloatArray, own: ShaftSettings) -> FloatArray:
    """The fastest motion behind the wanted one that keeps the limits, forward and backward."""
    if all(limit >= NO_LIMIT_RAD_S for limit in own.speed_limit_rad_s):
        return wanted
    ramp = grid.time_s[:, None] * np.array(own.speed_limit_rad_s)
    # NaN would spread to all that follows
    known = np.isfinite(wanted)
    ahead = np.minimum.accumulate(np.where(known, wanted, np.inf) - ramp) + ramp
    both = np.maximum.accumulate(np.where(known, ahead, -np.inf) + ramp) - ramp
    touched = np.array(own.speed_limit_rad_s) < NO_LIMIT_RAD_S
    return np.where(known, np.where(touched, both, wanted), np.nan)


def feet(machine: LeggedMachine, grid: Grid, shaft_rad: FloatArray, settings: Settings) -> Feet:
    """Unloaded feet from encoder angles, (W, N) [rad]."""
    own = settings.shaft
    crank = shaft_rad
    if any(own.zero_offset_rad):
        crank = crank + np.array(own.zero_offset_rad)
    pose = _poses(machine, crank, own)
    position = np.empty((*crank.shape, 3))
    position[..., 0] = pose.foot[..., 0]
    position[..., 1] = 0.0
    position[..., 2] = pose.foot[..., 1]
    position += machine.legs.shaft_position
    if any(own.hip_x_m) or any(own.hip_y_m):
        position[..., 0] += np.array(own.hip_x_m)
        position[..., 1] += np.array(own.hip_y_m)
    signals = FootSignals(grid.time_s, crank, position, pose.foot_slope)
    for added in settings.at("kinematics"):
        signals = added.act(signals, added.values, added.legs)
    rate = grid.slope(signals.position_m, FOOT_WINDOW_S)
    return Feet(signals, rate, _coupler_turn(machine, pose) if own.rolling_m else np.zeros((1, 1)))


def moves_feet(settings: Settings) -> Settings:
    """Return the part of settings that ``feet`` looks at, all else neutral."""
    plain = neutral_settings(len(settings.shaft.backlash_rad))
    own = settings.shaft
    shaft = replace(
        plain.shaft,
        zero_offset_rad=own.zero_offset_rad,
        crank_m=own.crank_m,
        coupler_m=own.coupler_m,
        rocker_m=own.rocker_m,
        hip_x_m=own.hip_x_m,
        hip_y_m=own.hip_y_m,
        rolling_m=own.rolling_m,
    )
    return replace(plain, shaft=shaft, added=settings.at("kinematics"))


def _poses(machine: LeggedMachine, crank: FloatArray, own: ShaftSettings) -> LinkagePose:
    """All linkages; those with other links are solved on their own."""
    nominal = machine.linkage
    changes = list(zip(own.crank_m, own.coupler_m, own.rocker_m, strict=True))
    pose = linkage_pose(nominal, crank)
    for change in dict.fromkeys(c for c in changes if any(c)):
        legs = [leg for leg, own_change in enumerate(changes) if own_change == change]
        links = replace(
            nominal,
            crank=nominal.crank + change[0],
            coupler=nominal.coupler + change[1],
            rocker=nominal.rocker + change[2],
        )
        other = linkage_pose(links, crank[:, legs])
        for name in LinkagePose.__slots__:
            getattr(pose, name)[:, legs] = getattr(other, name)
    return pose


def _coupler_turn(machine: LeggedMachine, pose: LinkagePose) -> FloatArray:
    middle = linkage_pose(machine.linkage, np.zeros(1))
    along = pose.rocker_pin - pose.crank_pin
    at_zero = (middle.rocker_pin - middle.crank_pin)[0]
    cross = at_zero[0] * along[..., 1] - at_zero[1] * along[..., 0]
    turn: FloatArray = np.arctan2(cross, along @ at_zero)
    return turn


def load_torque(signals: FootSignals, force_n: FloatArray) -> FloatArray:
    """Torque of foot forces about the shafts, by virtual work, (W, N) [N m].

    Args:
        signals: Feet and their slopes.
        force_n: Ground's force on each foot, body axes, (W, N, 3).
    """
    torque: FloatArray = (
        signals.slope_m_rad[..., 0] * force_n[..., 0]
        + signals.slope_m_rad[..., 1] * force_n[..., 2]
    )
    return torque
