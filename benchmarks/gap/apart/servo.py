"""Twelve servos: a position loop at 500 Hz with an encoder of 4096 counts, then a current loop."""

import math

import numpy as np

from benchmarks.gap.apart.day import Day
from benchmarks.gap.apart.fault import Fault
from benchmarks.gap.apart.layout import RATE_GAIN_NM_S_RAD, TORQUE_LIMIT_NM, FloatArray

LOOP_S = 0.002
COUNT_RAD = 2 * np.pi / 4096
RATE_SHARE = 0.35  # of a new rate in the filtered one
CURRENT_SHARE = 1 - math.exp(-1 / 4)  # of what is missing, in a step of 1 ms: a loop of 4 ms
BROWNOUT_SHARE = 0.05  # of the torque that is left
SHORTEST_LAG_S = 1e-9


class Servos:
    """Servos of one run. ``sample`` is called at 500 Hz, ``torque_nm`` at 1 kHz."""

    def __init__(self, day: Day, fault: Fault, first_command_rad: FloatArray) -> None:
        self._fault = fault
        self._gain_nm_rad = day.position_gain_nm_rad * fault.at_joints(
            fault.position_gain_ratio, 1.0
        )
        self._encoder_zero_rad = day.encoder_zero_rad
        self.zero_rad = fault.at_joints(fault.joint_zero_rad, 0.0)
        self._lag_s = fault.at_joints(fault.servo_lag_s, 0.0)
        self._weak = fault.at_joints(1.0, 0.0) > 0
        self._goal_rad = first_command_rad.copy()
        self._reading_rad: FloatArray | None = None
        self._rate_rad_s = np.zeros_like(first_command_rad)
        self._asked_nm = np.zeros_like(first_command_rad)
        self._torque_nm = np.zeros_like(first_command_rad)

    def sample(self, time_s: float, command_rad: FloatArray, joint_rad: FloatArray) -> FloatArray:
        """Take a command, and return what the encoders say.

        Args:
            time_s: Since recording began; negative before.
            command_rad: What arrives at the servos now, (12,).
            joint_rad: True angles of the joints, (12,).
        """
        share = np.minimum(1, LOOP_S / np.maximum(self._lag_s, SHORTEST_LAG_S))
        lagged_rad = self._goal_rad + (command_rad - self._goal_rad) * share
        self._goal_rad = np.where(self._lag_s > 0, lagged_rad, command_rad)
        turned_rad = joint_rad - self.zero_rad + self._encoder_zero_rad
        reading_rad: FloatArray = np.round(turned_rad / COUNT_RAD) * COUNT_RAD
        if self._reading_rad is not None:
            rate_rad_s = (reading_rad - self._reading_rad) / LOOP_S
            self._rate_rad_s = self._rate_rad_s + RATE_SHARE * (rate_rad_s - self._rate_rad_s)
        self._reading_rad = reading_rad
        wanted_nm = self._gain_nm_rad * (self._goal_rad - reading_rad)
        wanted_nm = wanted_nm - RATE_GAIN_NM_S_RAD * self._rate_rad_s
        self._asked_nm = np.clip(wanted_nm, -TORQUE_LIMIT_NM, TORQUE_LIMIT_NM)
        brownout = self._fault.brownout
        if brownout is not None and time_s > 0 and time_s % brownout.period_s < brownout.weak_s:
            self._asked_nm[self._weak] *= BROWNOUT_SHARE
        return reading_rad

    def torque_nm(self) -> FloatArray:
        """Return the torques of the next millisecond, (12,) [N m]."""
        self._torque_nm = self._torque_nm + (self._asked_nm - self._torque_nm) * CURRENT_SHARE
        return self._torque_nm
