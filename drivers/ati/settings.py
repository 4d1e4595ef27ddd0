"""Settings of the force-torque unit, as the robot file has them. N legs."""

import math
from dataclasses import dataclass

import numpy as np

from model.values.arrays import FloatArray, IntArray, readonly
from model.values.force_calibration import ForceCalibration


@dataclass(frozen=True, slots=True, eq=False)
class ForceSensorSettings:
    """The wireless force-torque unit and how each transducer is mounted.

    Attributes:
        names: Leg names, N of them.
        transducers: Transducer number of each leg, 1-6, or 0 for a leg without one, (N,) int64.
        address: Host name or address of the unit.
        udp_port: Its UDP port (49152).
        console_port: Its telnet port (23).
        local_port: Our UDP port, fixed; 0 lets the system choose (tests).
        rate_hz: Packets a second, 5 to 4000.
        oversampling: 1 to 32; rate x oversampling <= 4000.
        silent_limit_s: Seconds without a record before the robot stops.
        offset_m: Transducer origin relative to the crank shaft, body axes, (N, 3) [m].
        yaw_rad: Rotation about z from body axes to sensor axes, (N,) [rad].
        up: +1 where the sensor's z axis points up, -1 where it is mounted the other way up, (N,): then it
            is turned about its own x axis by half a turn on top of the yaw.
        bias_n: Reading without contact, sensor axes, subtracted, (N, 3) [N].
        calibration: Calibration file, read; it takes the place of ``bias_n``. None without one.
    """

    names: tuple[str, ...]
    transducers: IntArray
    address: str
    udp_port: int
    console_port: int
    local_port: int
    rate_hz: int
    oversampling: int
    silent_limit_s: float
    offset_m: FloatArray
    yaw_rad: FloatArray
    up: IntArray
    bias_n: FloatArray
    calibration: ForceCalibration | None = None

    @property
    def any(self) -> bool:
        """Whether any leg has a transducer; else there is no unit to talk to."""
        return bool((self.transducers > 0).any())


def no_sensors(names: tuple[str, ...]) -> ForceSensorSettings:
    """Return the settings of a robot whose legs have no force sensors."""
    legs = len(names)
    none, upright = (
        readonly(np.zeros(legs, dtype=np.int64)),
        readonly(np.ones(legs, dtype=np.int64)),
    )
    nowhere = readonly(np.zeros((legs, 3)))
    return ForceSensorSettings(
        names=names,
        transducers=none,
        address="",
        udp_port=0,
        console_port=0,
        local_port=0,
        rate_hz=0,
        oversampling=0,
        silent_limit_s=math.inf,
        offset_m=nowhere,
        yaw_rad=readonly(np.zeros(legs)),
        up=upright,
        bias_n=nowhere,
    )
