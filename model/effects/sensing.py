"""Sensors and clocks of a legged robot: what the truth reads as, and the truth behind a reading."""

from dataclasses import replace
from typing import TypeVar

import numpy as np

from model.effects.grid import Grid
from model.effects.settings import Settings
from model.effects.signals import SensorSignals
from model.motion.filters import at_times, lagged
from model.motion.se2 import turned
from model.values.arrays import FloatArray

Signals = TypeVar("Signals", bound=SensorSignals)
FORCE_WINDOW_S = 0.13  # as short as noise allows
OF_FORCES = frozenset(
    {"force_gain", "force_bias", "force_drift", "force_rotation", "force_cross_talk"}
)

READS_FORCES = OF_FORCES | {"force_lowpass", "force_delay"}


def read_sensors(
    grid: Grid, truth: SensorSignals, settings: Settings, seen: SensorSignals | None = None
) -> SensorSignals:
    """Return what the sensors read when this is the truth.

    Args:
        grid: Times of the frames.
        truth: As it is predicted.
        settings: What is added.
        seen: As it was measured, and made good with ``true_signals``; None for nothing. Axes that are
            turned mix what was there, which a prediction may miss by as much as there is: what one
            component gets of another is that of what was seen.
    """
    seen = truth if seen is None else seen
    foot, body, angles = _in_marker_frame(truth, settings, seen)
    if settings.has("pose_delay", "clock_skew"):
        (delay_s,), (ratio,) = (settings.whole(e) for e in ("pose_delay", "clock_skew"))
        late = grid.time_s / ratio - delay_s
        foot, body, angles = (at_times(grid.time_s, a, late) for a in (foot, body, angles))
    read = SensorSignals(
        time_s=truth.time_s,
        shaft_rad=truth.shaft_rad * settings.each("encoder_scale")[0],
        foot_m=foot,
        force_n=_read_force(grid, truth.force_n, settings, seen.force_n),
        body_m=body,
        body_rad=angles,
    )
    return settings.acted("sensing", read)


def true_signals(grid: Grid, read: Signals, settings: Settings) -> Signals:
    """Return signals as they would have been with perfect sensors.

    The inverse of ``read_sensors``; what a low pass took comes back as far as noise allows, that is slower
    than its slope's window. What no sensor error touches stays the array that it is.
    """
    if settings.has("encoder_scale"):
        read = replace(read, shaft_rad=read.shaft_rad / settings.each("encoder_scale")[0])
    if settings.has(*OF_FORCES):
        read = replace(read, force_n=true_forces(read.force_n, grid.time_s, settings))
    if settings.has("force_delay"):
        (late_s,) = settings.whole("force_delay")
        read = replace(read, force_n=at_times(grid.time_s, read.force_n, grid.time_s + late_s))
    if settings.has("force_lowpass"):
        (lag_s,) = settings.whole("force_lowpass")
        ahead = lag_s * grid.slope(read.force_n, FORCE_WINDOW_S)
        read = replace(read, force_n=read.force_n + ahead)
    if settings.has("pose_delay", "clock_skew"):
        (delay_s,), (ratio,) = (settings.whole(e) for e in ("pose_delay", "clock_skew"))
        back = (grid.time_s + delay_s) * ratio
        foot, body, angles = (
            at_times(grid.time_s, a, back) for a in (read.foot_m, read.body_m, read.body_rad)
        )
        read = replace(read, foot_m=foot, body_m=body, body_rad=angles)
    if settings.has("pose_yaw_offset", "pose_origin_offset"):
        (turn,), (x_m, y_m) = (settings.whole(e) for e in ("pose_yaw_offset", "pose_origin_offset"))
        yaw = np.array(turn)
        roll, pitch, heading = read.body_rad.T
        # a small tilt turns like a vector
        angles = np.column_stack([*turned(roll, pitch, yaw), heading - yaw])
        x, y = turned(read.foot_m[..., 0], read.foot_m[..., 1], yaw)
        foot = np.stack([x + x_m, y + y_m, read.foot_m[..., 2]], axis=-1)
        body = read.body_m - _arm(angles, x_m, y_m)
        read = replace(read, foot_m=foot, body_m=body, body_rad=angles)
    return read


def true_forces(force_n: FloatArray, since_s: FloatArray | float, settings: Settings) -> FloatArray:
    """Take gain, bias, drift, cross-talk and rotation of the transducers out of readings.

    Args:
        force_n: As the calibrated sensors report them, (..., N, 3).
        since_s: Time since the run began, for drifts, (...,).
        settings: What is added.

    Returns:
        (..., N, 3).
    """
    force = (force_n - _biases(since_s, settings)) / settings.each("force_gain").T
    of_x, of_y = settings.each("force_cross_talk")
    z = force[..., 2]
    x, y = turned(
        force[..., 0] - of_x * z, force[..., 1] - of_y * z, settings.each("force_rotation")[0]
    )
    return np.stack([x, y, z], axis=-1)


def _read_force(
    grid: Grid, force_n: FloatArray, settings: Settings, seen_n: FloatArray
) -> FloatArray:
    force = force_n
    if settings.has("force_rotation", "force_cross_talk", "force_gain"):
        yaw = -settings.each("force_rotation")[0]
        x, y = _turned_as_seen(force_n[..., :2], seen_n[..., :2], yaw)
        of_x, of_y = settings.each("force_cross_talk")
        z = force_n[..., 2]
        force = np.stack([x + of_x * z, y + of_y * z, z], axis=-1) * settings.each("force_gain").T
    if settings.has("force_lowpass"):
        known = np.isfinite(force)
        (lag_s,) = settings.whole("force_lowpass")
        smooth = lagged(np.where(known, force, 0.0), lag_s, grid.period_s, ramping=True)
        force = np.where(known, smooth, np.nan)
    if settings.has("force_delay"):
        (delay_s,) = settings.whole("force_delay")
        force = at_times(grid.time_s, force, grid.time_s - delay_s)
    if settings.has("force_bias", "force_drift"):
        force = force + _biases(grid.time_s, settings)
    return force


def _biases(since_s: FloatArray | float, settings: Settings) -> FloatArray:
    """What is added to readings at times (...,), (..., N, 3) [N]."""
    x_n, y_n, z_n = settings.each("force_bias")
    drifted = np.asarray(since_s)[..., None] * settings.each("force_drift")[0]
    return np.stack([*np.broadcast_arrays(x_n, y_n, z_n + drifted)], axis=-1)


def _turned_as_seen(
    pair: FloatArray, seen: FloatArray, angle: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Components of a vector, (..., 2), turned by an angle, by what was seen of it where that is known."""
    known = np.isfinite(seen).all(axis=-1, keepdims=True)
    x, y = np.moveaxis(np.where(known, seen, pair), -1, 0)
    of_x, of_y = turned(x, y, angle)
    return pair[..., 0] + (of_x - x), pair[..., 1] + (of_y - y)


def _in_marker_frame(
    truth: SensorSignals, settings: Settings, seen: SensorSignals
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Feet, body and angles as the markers' frame has them."""
    if not settings.has("pose_yaw_offset", "pose_origin_offset"):
        return truth.foot_m, truth.body_m, truth.body_rad
    (turn,), (x_m, y_m) = (settings.whole(e) for e in ("pose_yaw_offset", "pose_origin_offset"))
    yaw = np.array(turn)
    tilt, heading = truth.body_rad[:, :2], truth.body_rad[:, 2]
    known = seen.body_rad[:, :2]
    angles = np.column_stack([*_turned_as_seen(tilt, known, -yaw), heading + yaw])
    feet = turned(truth.foot_m[..., 0] - x_m, truth.foot_m[..., 1] - y_m, -yaw)
    foot = np.stack([*feet, truth.foot_m[..., 2]], axis=-1)
    lean = np.column_stack([np.where(np.isfinite(known), known, tilt), heading])
    return foot, truth.body_m + _arm(lean, x_m, y_m), angles


def _arm(angles: FloatArray, x_m: float, y_m: float) -> FloatArray:
    """The markers' origin seen from the body's, world axes, (W, 3); tilts are small."""
    roll, pitch, yaw = angles.T
    x, y = turned(np.array(x_m), np.array(y_m), yaw)
    return np.column_stack([x, y, roll * y_m - pitch * x_m])
