"""Play of gears: against which flank a shaft lies, and how it crosses from one to the other.

In the air a free shaft falls by the weight of foot and coupler, as fast as grease lets it. On the ground it
is a strut: the foot stands, its link swings with the body, and the shaft crosses the play as fast as the
foot would slip were there none. A load cell shows when a strut bears nothing, and so crosses; where loads
are predicted, that speed is only its fastest.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from model.effects.grid import Grid
from model.effects.signals import FootSignals
from model.motion.filters import play
from model.values.arrays import FloatArray

PLAY = "gear_backlash"
PLAY_IN_LOOP = "gear_backlash_in_loop"
DRAGGED_PLAY = "gear_backlash_dragged"
UNSEEN_PLAY = "gear_backlash_beyond_encoder"
PLAYS = (PLAY, PLAY_IN_LOOP, DRAGGED_PLAY, UNSEEN_PLAY)
# Time constant in which a position loop brings its shaft back, where no lag of the servo is known; assumed.
LOOP_S = 0.05
# How far the zero of a load cell may be off: as much as decides where a foot in the air hangs. Assumed.
ZERO_OFF_N = 2.0
# A shaft in the air is dragged against its rear flank by its bearings. All three are assumed. A drag of a
# fifth of the weight, as once, held shafts back that had fallen.
BEARING_DRAG_NM = 0.0005
BEARING_DAMPING_NM_S = 0.02
FOOT_WEIGHT_N = 0.5
# Where bearings drag by more than the foot weighs, the shaft stays at its rear flank in the air. Assumed.
STRONG_DRAG_NM = 0.03
# When a free shaft falls is known to a tenth of a second or so. What is predicted is the mean over that: a
# step at a time that is off fits best with a width that is too small.
FALL_WINDOW_S = 0.2
# How well a model's slip is known: a strut that seems to stand is as fast as that.
SLIP_KNOWN_TO_M_S = 0.0003
# Share of its friction that a foot keeps while its shaft is between the flanks.
LOOSE_PUSH = 0.1
# Share of a foot's load, at its lever, below which a torque is none: forces point no more surely.
SLACK_SHARE = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Strut:
    """Shafts in their play whose feet stand, W frames of J shafts.

    Attributes:
        speed_rad_s: Speed at which their feet stand, (W, J); 0 in the air.
        slack_nm: Torque below which a shaft lies against no flank and has that speed, (W, J); 0 where
            torques are predicted and not measured.
        fastest_rad_s: Its speed at most, (W, J); infinite for no limit but grease.
    """

    speed_rad_s: FloatArray
    slack_nm: FloatArray
    fastest_rad_s: FloatArray


def in_play(
    grid: Grid,
    torque_nm: FloatArray,
    width_rad: FloatArray,
    strut: Strut | None,
    drag_nm: FloatArray | float = BEARING_DRAG_NM,
) -> FloatArray:
    """Where shafts are in their play, (W, J) [rad].

    Args:
        grid: Times of the frames.
        torque_nm: What turns free shafts, (W, J), positive where it drives them on.
        width_rad: Full widths of the play, (J,).
        strut: What the ground lets them do; None for nothing but grease.
        drag_nm: Torque by which bearings hold shafts back, (W, J) or one for all.
    """
    place_rad, drag_nm = np.zeros(torque_nm.shape), np.broadcast_to(drag_nm, torque_nm.shape)
    window = max(1, round(FALL_WINDOW_S / grid.period_s))
    for joint in np.flatnonzero(width_rad):
        torque = np.nan_to_num(torque_nm[:, joint])
        speed = (torque - drag_nm[:, joint]) / BEARING_DAMPING_NM_S
        first = -np.sign(speed[0]) * width_rad[joint] / 2
        if strut is not None:
            fastest = strut.fastest_rad_s[:, joint]
            slack = np.abs(torque) < strut.slack_nm[:, joint]
            speed = np.where(slack, strut.speed_rad_s[:, joint], np.clip(speed, -fastest, fastest))
            if slack[0]:  # it may be anywhere
                first = speed[0] * grid.period_s
        pushed = np.cumsum(speed * grid.period_s)
        place = pushed - play(pushed, width_rad[joint], first)
        place_rad[:, joint] = uniform_filter1d(place, window, mode="nearest")
    return place_rad


def strong_drag(driven_rad: FloatArray) -> FloatArray:
    """Torque by which bearings hold shafts back against how they are driven, (W, J) [N m]."""
    turns = np.gradient(driven_rad, axis=0)
    return STRONG_DRAG_NM * np.sign(np.nan_to_num(turns))


def strut_of(
    signals: FootSignals, slip_m_s: FloatArray, load_n: FloatArray, *, measured: bool
) -> Strut:
    """What the ground lets shafts in their play do, if their feet stand.

    Args:
        signals: Feet of the walk without the play.
        slip_m_s: Slip of their feet, (W, N, 2), body axes.
        load_n: Their loads, (W, N).
        measured: Whether the torques are measured that turn the shafts.
    """
    jacobian = signals.jacobian_m_rad
    if jacobian is not None:
        lever = jacobian[:, :, :2]  # (W, N, 2, J)
        along = np.einsum("wnij,wni->wj", lever, slip_m_s)
        size = np.linalg.norm(lever, axis=(1, 2))
        stands = np.any((load_n > 0.0)[..., None] & lever.any(axis=2), axis=1)
        bears = np.einsum("wn,wnj->wj", np.maximum(load_n, 0.0), np.linalg.norm(jacobian, axis=2))
    else:
        slope = signals.slope_m_rad
        along, size = slope[..., 0] * slip_m_s[..., 0], np.abs(slope[..., 0])
        stands = load_n > 0.0
        bears = np.maximum(load_n, 0.0) * np.linalg.norm(slope, axis=2)
    known = stands & (size > 0.0) & np.isfinite(along)
    speed, fastest = np.zeros(size.shape), np.full(size.shape, np.inf)
    np.divide(-along, size**2, out=speed, where=known)
    if measured:
        return Strut(speed, np.where(known, SLACK_SHARE * bears, 0.0), fastest)
    least = SLIP_KNOWN_TO_M_S * size
    np.divide(np.abs(along) + least, size**2, out=fastest, where=known)
    return Strut(speed, np.zeros(size.shape), fastest)


def foot_weight_torque(signals: FootSignals) -> FloatArray:
    """Torque of the weight of a foot and its link about each shaft, (W, J) [N m]."""
    if signals.jacobian_m_rad is not None:
        slope: FloatArray = signals.jacobian_m_rad[:, :, 2].sum(axis=1)
        return -FOOT_WEIGHT_N * slope
    return -FOOT_WEIGHT_N * signals.slope_m_rad[..., 1]
