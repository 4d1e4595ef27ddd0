"""The virtual IMU: yaw rate, roll and pitch of the plant's body with bias, noise and delay.

A gyro's reading is its mean over the time since the reading before, as a chip's own filter makes it. All of
its randomness comes from one seed, so the same run gives the same readings.
"""

from collections import deque
from math import asin, atan2, nan

import numpy as np
from scipy.spatial.transform import Rotation

from model.values.arrays import FloatArray
from model.values.readings import ImuRecord
from sim_hw.assumed import ImuAssumed

DIGITS = 7  # of what it reports: 0.1 microradian


class VirtualImu:
    """An IMU on the body.

    Args:
        assumed: Its errors, rate and delay.
        seed: Of its noise.
        to_body: Turns a vector in its axes into the body's, (3, 3); None where they are the same.
    """

    def __init__(self, assumed: ImuAssumed, seed: int, to_body: FloatArray | None = None) -> None:
        self._assumed = assumed
        self._mounting = None if to_body is None else Rotation.from_matrix(to_body)
        self._random = np.random.default_rng([seed, 0x49])
        self._period_ns = round(1e9 / assumed.rate_hz)
        self._bias = assumed.yaw_rate_bias_rad_s
        self._last: tuple[int, FloatArray] | None = None
        self._waiting: deque[ImuRecord] = deque()
        self.due_ns = 0

    @property
    def yaw_rate_bias_rad_s(self) -> float:
        """The true bias of its gyro now [rad/s]."""
        return self._bias

    def sample(self, t_ns: int, quaternion_xyzw: FloatArray) -> None:
        """Take a reading of the body as it stands at a time; the first has no rate and is not sent.

        Args:
            t_ns: The time, not before ``due_ns``.
            quaternion_xyzw: Body to world, (4,), scalar last.
        """
        if self._mounting is not None:
            quaternion_xyzw = (Rotation.from_quat(quaternion_xyzw) * self._mounting).as_quat()
        before, self._last = self._last, (t_ns, quaternion_xyzw)
        self.due_ns = t_ns + self._period_ns - t_ns % self._period_ns
        if before is None:
            return
        assumed, dt_s = self._assumed, (t_ns - before[0]) * 1e-9
        rate_noise, walk, roll_noise, pitch_noise = self._random.standard_normal(4).tolist()
        self._bias += assumed.yaw_rate_walk * dt_s**0.5 * walk
        rate = _turned_about_z(before[1], quaternion_xyzw) / dt_s
        rate += self._bias + assumed.yaw_rate_noise_rad_s * rate_noise
        roll, pitch = _roll_pitch(quaternion_xyzw)
        roll += assumed.roll_error_rad + assumed.tilt_noise_rad * roll_noise
        pitch += assumed.pitch_error_rad + assumed.tilt_noise_rad * pitch_noise
        if not assumed.tilt:
            roll = pitch = nan
        self._waiting.append(
            ImuRecord(t_ns, round(rate, DIGITS), round(roll, DIGITS), round(pitch, DIGITS))
        )

    def arrived(self, now_ns: int) -> tuple[ImuRecord, ...]:
        """Return the readings that have arrived since the last call, oldest first."""
        latest_ns = now_ns - round(self._assumed.delay_s * 1e9)
        arrived: list[ImuRecord] = []
        while self._waiting and self._waiting[0].t_ns <= latest_ns:
            arrived.append(self._waiting.popleft())
        return tuple(arrived)


def _turned_about_z(before: FloatArray, after: FloatArray) -> float:
    """Turn about the body's own z axis from one attitude to the next [rad]; quaternions, scalar last."""
    (ax, ay, az, aw), (bx, by, bz, bw) = before.tolist(), after.tolist()
    z = aw * bz - az * bw - ax * by + ay * bx
    w = aw * bw + ax * bx + ay * by + az * bz
    return 2.0 * atan2(z if w >= 0 else -z, abs(w))


def _roll_pitch(quaternion: FloatArray) -> tuple[float, float]:
    x, y, z, w = quaternion.tolist()
    roll = atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    return roll, asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
