"""Play of gears: against which flank a shaft lies, and how it crosses from one to the other.

In the air a free shaft falls by the weight of foot and coupler, as fast as grease lets it. On the ground it
is a strut: the foot stands, its link swings with the body, and the shaft crosses the play as fast as the
foot would slip were there none. A load cell sees when a strut bears; where loads are predicted, that speed
must be as well.
"""

import numpy as np
from scipy.ndimage import uniform_filter1d

from model.effects.grid import Grid
from model.effects.signals import FootSignals
from model.motion.filters import play
from model.values.arrays import FloatArray

# A shaft in the air is dragged against its rear flank by its bearings. All three are assumed. A drag of a
# fifth of the weight, as once, held shafts back that had fallen.
BEARING_DRAG_NM = 0.0005
BEARING_DAMPING_NM_S = 0.02
FOOT_WEIGHT_N = 0.5
# When a free shaft falls is known to a tenth of a second or two. What is predicted is the mean over that:
# a step at a time that is off fits best with a width that is too small.
FALL_WINDOW_S = 0.3
SLIP_KNOWN_TO_M_S = (
    0.001  # how well a model's slip is known: a strut that seems to stand is as fast as that
)


def in_play(
    grid: Grid, torque_nm: FloatArray, width_rad: FloatArray, fastest_rad_s: FloatArray | None
) -> FloatArray:
    """Where shafts are in their play, (W, J) [rad].

    Args:
        grid: Times of the frames.
        torque_nm: What turns free shafts, (W, J), positive where it drives them on.
        width_rad: Full widths of the play, (J,).
        fastest_rad_s: Speed of shafts through their play at most, (W, J); None for no limit but grease.
    """
    place_rad = np.zeros(torque_nm.shape)
    window = max(1, round(FALL_WINDOW_S / grid.period_s))
    for joint in np.flatnonzero(width_rad):
        speed = (np.nan_to_num(torque_nm[:, joint]) - BEARING_DRAG_NM) / BEARING_DAMPING_NM_S
        first = -np.sign(speed[0]) * width_rad[joint] / 2
        if fastest_rad_s is not None:
            speed = np.clip(speed, -fastest_rad_s[:, joint], fastest_rad_s[:, joint])
        pushed = np.cumsum(speed * grid.period_s)
        place = pushed - play(pushed, width_rad[joint], first)
        place_rad[:, joint] = uniform_filter1d(place, window, mode="nearest")
    return place_rad


def crossing_speed(signals: FootSignals, slip_m_s: FloatArray, load_n: FloatArray) -> FloatArray:
    """How fast shafts cross a play where feet stand, (W, J) [rad/s]; infinite where they are in the air.

    Args:
        signals: Feet of the walk without the play.
        slip_m_s: Slip of their feet, (W, N, 2), body axes.
        load_n: Their loads, (W, N).
    """
    if signals.jacobian_m_rad is not None:
        lever = signals.jacobian_m_rad[:, :, :2]  # (W, N, 2, J)
        along = np.abs(np.einsum("wnij,wni->wj", lever, slip_m_s))
        size = np.linalg.norm(lever, axis=(1, 2))
        stands = np.any((load_n > 0.0)[..., None] & lever.any(axis=2), axis=1)
    else:
        lever_x = signals.slope_m_rad[..., 0]
        along, size = np.abs(lever_x * slip_m_s[..., 0]), np.abs(lever_x)
        stands = load_n > 0.0
    known = along + SLIP_KNOWN_TO_M_S * size
    fastest: FloatArray = np.full(size.shape, np.inf)
    np.divide(known, size**2, out=fastest, where=stands & (size > 0.0) & np.isfinite(known))
    return fastest


def foot_weight_torque(signals: FootSignals) -> FloatArray:
    """Torque of the weight of a foot and its link about each shaft, (W, J) [N m]."""
    if signals.jacobian_m_rad is not None:
        slope: FloatArray = signals.jacobian_m_rad[:, :, 2].sum(axis=1)
        return -FOOT_WEIGHT_N * slope
    return -FOOT_WEIGHT_N * signals.slope_m_rad[..., 1]
