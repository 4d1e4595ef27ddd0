"""Readings of the IMU as the body's: the newest one that is fresh, turned by how it is mounted."""

from math import asin, atan2, cos, isfinite, nan, sin

from model.values.readings import ImuRecord
from robot.config.imu import ImuConfig


class MountedImu:
    """An IMU on the body.

    Args:
        config: How it is mounted, and when a reading is too old.
    """

    def __init__(self, config: ImuConfig) -> None:
        self._to_body = config.to_body
        self._stale_ns = round(config.stale_after * 1e9)

    def of_body(self, readings: tuple[ImuRecord, ...], t_ns: int) -> tuple[float, float, float]:
        """Return yaw rate [rad/s], roll and pitch [rad] of the body; NaN for what is not known.

        Args:
            readings: Those of a tick, oldest first.
            t_ns: Time of the tick.
        """
        if not readings or abs(t_ns - readings[-1].t_ns) > self._stale_ns:
            return nan, nan, nan
        newest = readings[-1]
        rate, roll, pitch = newest.yaw_rate_rad_s, newest.roll_rad, newest.pitch_rad
        if self._to_body is None:
            return rate, roll, pitch
        rate *= float(self._to_body[2, 2])
        if not (isfinite(roll) and isfinite(pitch)):
            return rate, nan, nan
        # upwards, in the IMU's axes; then in the body's
        up = (-sin(pitch), cos(pitch) * sin(roll), cos(pitch) * cos(roll))
        x, y, z = (self._to_body @ up).tolist()
        return rate, atan2(y, z), -asin(max(-1.0, min(1.0, x)))
