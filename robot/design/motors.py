"""What the motors of the file's servos can do, by their data sheets: share of the supply voltage, heat."""

from typing import NamedTuple

import numpy as np

from drivers.dynamixel.catalog import MODEL_BY_NAME
from model.values.arrays import FloatArray
from model.values.parameters import ServoParameters


class MotorLine(NamedTuple):
    """The straight line from stall torque to no-load speed of each servo, at the supply voltage.

    Attributes:
        stall_nm: (N,) [N m].
        no_load_rad_s: (N,).
    """

    stall_nm: FloatArray
    no_load_rad_s: FloatArray


def motor_line(servo: ServoParameters) -> MotorLine:
    """Return what the servos can do; both ends grow with the voltage.

    Args:
        servo: Their models and the supply voltage.
    """
    ratings = [MODEL_BY_NAME[name].ratings for name in servo.models]
    volts = np.array([servo.supply_voltage / one.voltage_v for one in ratings])
    return MotorLine(
        np.array([one.stall_torque_n_m for one in ratings]) * volts,
        np.array([one.no_load_rad_s for one in ratings]) * volts,
    )


def duty_of(servo: ServoParameters, torque_nm: FloatArray, rate_rad_s: FloatArray) -> FloatArray:
    """Return the share of the supply voltage that each servo needs, (F, N); above 1 it cannot follow.

    Friction of the gear is in neither figure of a data sheet's line and left out.

    Args:
        servo: Models and supply voltage of N servos.
        torque_nm: Their torques, (F, N) [N m].
        rate_rad_s: Their speeds, (F, N) [rad/s].
    """
    line = motor_line(servo)
    duty: FloatArray = np.abs(torque_nm / line.stall_nm + rate_rad_s / line.no_load_rad_s)
    return duty
