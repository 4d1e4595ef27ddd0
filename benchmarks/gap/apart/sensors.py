"""What cameras and force sensors make of a run: offsets, delays, noise, and their faults."""

import numpy as np

from benchmarks.gap.apart.day import Day
from benchmarks.gap.apart.fault import Fault, MarkerJump
from benchmarks.gap.apart.layout import BoolArray, FloatArray
from benchmarks.gap.apart.run_table import RunTable

POSITION_SD_M = 0.0003
ANGLE_SD_RAD = 0.001
FORCE_SD_N = 0.2
JUMP_WITHIN_S = 2.0


def measured(true: RunTable, day: Day, fault: Fault, random: np.random.Generator) -> RunTable:
    """Return a run as it is recorded, from what was true in it; joints are recorded already.

    The draws keep their order: the jump, positions, angles, forces.
    """
    time_s, position_m, angle_rad = true.time_s, true.position_m, true.roll_pitch_yaw_rad
    if fault.marker_jump is not None:
        at_s = fault.marker_jump.earliest_s + JUMP_WITHIN_S * random.random()
        after = time_s > at_s
        position_m, angle_rad = _jumped(position_m, angle_rad, after, fault.marker_jump)
    position_m = _of_markers(position_m, angle_rad[:, 2], day.marker_offset_m)
    angle_rad = angle_rad + np.array([0, 0, day.marker_yaw_rad + fault.marker_yaw_rad])
    if fault.pose_delay_s:
        position_m = _delayed(position_m, time_s, fault.pose_delay_s)
        angle_rad = _delayed(angle_rad, time_s, fault.pose_delay_s)
    position_m = position_m + random.normal(0, POSITION_SD_M, position_m.shape)
    angle_rad = angle_rad + random.normal(0, ANGLE_SD_RAD, angle_rad.shape)
    ratio = fault.at_legs(fault.force_ratio, 1.0)[None, :, None]
    noise_n = random.normal(0, FORCE_SD_N, true.foot_force_n.shape)
    force_n = true.foot_force_n * ratio + day.force_bias_n + noise_n
    return RunTable(time_s, true.command_rad, true.encoder_rad, position_m, angle_rad, force_n)


def _jumped(
    position_m: FloatArray, angle_rad: FloatArray, after: BoolArray, jump: MarkerJump
) -> tuple[FloatArray, FloatArray]:
    """Positions and angles (T, 3) of a plate that was knocked; ``after`` (T,) is true from then on."""
    angle_rad = angle_rad + np.outer(after, [0, 0, jump.yaw_rad])
    yaw = angle_rad[:, 2]
    ahead = np.c_[np.cos(yaw), np.sin(yaw), 0 * yaw]
    return position_m + (after * jump.x_m)[:, None] * ahead, angle_rad


def _of_markers(position_m: FloatArray, yaw: FloatArray, offset_m: FloatArray) -> FloatArray:
    """Positions (T, 3) of markers that are off the trunk's origin by (x, y, z) in its axes."""
    x, y, z = offset_m
    along_x = np.cos(yaw) * x - np.sin(yaw) * y
    along_y = np.sin(yaw) * x + np.cos(yaw) * y
    moved: FloatArray = position_m + np.c_[along_x, along_y, np.full(len(yaw), z)]
    return moved


def _delayed(values: FloatArray, time_s: FloatArray, delay_s: float) -> FloatArray:
    """Values (T, columns) as they were ``delay_s`` before."""
    then_s = time_s - delay_s
    columns = (np.interp(then_s, time_s, column) for column in values.T)
    delayed: FloatArray = np.c_[tuple(columns)]
    return delayed
