"""Sensors and clocks of the legged simulator: what the truth reads as, and the truth behind a reading."""

from dataclasses import replace

import numpy as np

from gap.machines.legged.grid import Grid, lagged, shifted
from gap.machines.legged.inputs import LeggedInputs
from gap.machines.legged.settings import SensorSettings, Settings
from gap.machines.legged.signals import SensorSignals
from model.values.arrays import FloatArray


def read_sensors(grid: Grid, truth: SensorSignals, settings: Settings) -> SensorSignals:
    """Return what the sensors read when this is the truth."""
    own = settings.sensor
    shaft = truth.shaft_rad * np.array(own.encoder_ratio)
    foot, body, angles = _in_marker_frame(truth, own)
    late = _pose_time(grid, own)
    if late is not None:
        foot, body, angles = (shifted(grid, a, late) for a in (foot, body, angles))
    signals = SensorSignals(
        truth.time_s, shaft, foot, _read_force(grid, truth.force_n, own), body, angles
    )
    for added in settings.at("sensing"):
        signals = added.act(signals, added.values, added.legs)
    return signals


def true_inputs(inputs: LeggedInputs, settings: Settings) -> LeggedInputs:
    """Return the measured inputs of stages as they would have been with perfect sensors.

    The inverse of ``read_sensors`` but for a low pass, which is taken as the delay that it mostly is.
    """
    own, grid = settings.sensor, inputs.grid
    out = inputs
    if any(ratio != 1.0 for ratio in own.encoder_ratio):
        out = replace(out, shaft_rad=inputs.shaft_rad / np.array(own.encoder_ratio))
    force = _true_force(grid, inputs.force_n, own)
    if force is not inputs.force_n:
        out = replace(out, force_n=force)
    late = _pose_time(grid, own)
    body, angles, foot = inputs.body_m, inputs.body_rad, inputs.foot_m
    if late is not None:
        back = (grid.time_s + own.pose_delay_s) * own.clock_ratio
        body, angles, foot = (shifted(grid, a, back) for a in (body, angles, foot))
    if own.pose_yaw_rad or own.pose_x_m or own.pose_y_m:
        c, s = np.cos(own.pose_yaw_rad), np.sin(own.pose_yaw_rad)
        roll, pitch, yaw = angles[:, 0], angles[:, 1], angles[:, 2] - own.pose_yaw_rad
        angles = np.column_stack([c * roll - s * pitch, s * roll + c * pitch, yaw])
        arm = _arm(angles, own)
        body = body - arm
        x, y = foot[..., 0], foot[..., 1]
        foot = np.stack(
            [c * x - s * y + own.pose_x_m, s * x + c * y + own.pose_y_m, foot[..., 2]], axis=-1
        )
    if body is not inputs.body_m or angles is not inputs.body_rad:
        out = replace(out, body_m=body, body_rad=angles, foot_m=foot)
    return out


def _pose_time(grid: Grid, own: SensorSettings) -> FloatArray | None:
    """When what the pose stream stamps as the grid's times was true, (W,); None if it is punctual."""
    if own.pose_delay_s == 0.0 and own.clock_ratio == 1.0:
        return None
    when: FloatArray = grid.time_s / own.clock_ratio - own.pose_delay_s
    return when


def _arm(angles: FloatArray, own: SensorSettings) -> FloatArray:
    """The markers' origin seen from the body's, world axes, (W, 3); tilts are small."""
    roll, pitch, yaw = angles.T
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = own.pose_x_m, own.pose_y_m
    return np.column_stack([c * x - s * y, s * x + c * y, roll * y - pitch * x])


def _in_marker_frame(
    truth: SensorSignals, own: SensorSettings
) -> tuple[FloatArray, FloatArray, FloatArray]:
    if not (own.pose_yaw_rad or own.pose_x_m or own.pose_y_m):
        return truth.foot_m, truth.body_m, truth.body_rad
    c, s = np.cos(own.pose_yaw_rad), np.sin(own.pose_yaw_rad)
    body = truth.body_m + _arm(truth.body_rad, own)
    roll, pitch, yaw = truth.body_rad.T
    # a small tilt turns like a vector
    angles = np.column_stack([c * roll + s * pitch, c * pitch - s * roll, yaw + own.pose_yaw_rad])
    x, y = truth.foot_m[..., 0] - own.pose_x_m, truth.foot_m[..., 1] - own.pose_y_m
    foot = np.stack([c * x + s * y, c * y - s * x, truth.foot_m[..., 2]], axis=-1)
    return foot, body, angles


def _biases(own: SensorSettings, time_s: FloatArray) -> FloatArray:
    bias = np.stack([own.bias_x_n, own.bias_y_n, own.bias_z_n], axis=1)
    wide = np.repeat(bias[None], len(time_s), axis=0)
    wide[..., 2] += time_s[:, None] * np.array(own.drift_n_s)
    return wide


def _read_force(grid: Grid, force: FloatArray, own: SensorSettings) -> FloatArray:
    if any(own.force_yaw_rad):
        force = _turned(force, -np.array(own.force_yaw_rad))
    force = force * np.array(own.force_gain)[:, None]
    if own.force_lag_s:
        known = np.isfinite(force)
        smooth = lagged(grid, np.where(known, force, 0.0), own.force_lag_s)
        force = np.where(known, smooth, np.nan)
    if own.force_delay_s:
        force = shifted(grid, force, grid.time_s - own.force_delay_s)
    return force + _biases(own, grid.time_s)


def _true_force(grid: Grid, force: FloatArray, own: SensorSettings) -> FloatArray:
    biased = any(any(row) for row in (own.bias_x_n, own.bias_y_n, own.bias_z_n, own.drift_n_s))
    if biased:
        force = force - _biases(own, grid.time_s)
    late = own.force_delay_s + own.force_lag_s
    if late:
        force = shifted(grid, force, grid.time_s + late)
    if any(gain != 1.0 for gain in own.force_gain):
        force = force / np.array(own.force_gain)[:, None]
    if any(own.force_yaw_rad):
        force = _turned(force, np.array(own.force_yaw_rad))
    return force


def _turned(force: FloatArray, yaw: FloatArray) -> FloatArray:
    c, s = np.cos(yaw), np.sin(yaw)
    x, y = force[..., 0], force[..., 1]
    return np.stack([c * x - s * y, s * x + c * y, force[..., 2]], axis=-1)
