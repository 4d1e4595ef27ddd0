"""Legs that turn on one shaft each: what a four-bar and a crank share around their own kernels."""

from collections.abc import Callable

import numpy as np

from model.values.arrays import FloatArray
from model.values.legs import FootMotion

# Angles, speeds (F N,), numbers of the leg, shafts (N, 3); out: positions, velocities (F N, 3).
FeetKernel = Callable[
    [FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, FloatArray], None
]


class OneShaftKinematics:
    """All legs of one geometry: shaft angles to feet in the body frame; joint k turns leg k.

    Args:
        feet_kernel: Compiled feet of many angles.
        prepare: Loads or makes its machine code.
        numbers: The leg's dimensions, as the kernel takes them.
        shaft_position: Shafts in the body frame, (N, 3) [m].
    """

    def __init__(
        self,
        feet_kernel: FeetKernel,
        prepare: Callable[[], None],
        numbers: FloatArray,
        shaft_position: FloatArray,
    ) -> None:
        self._feet_kernel = feet_kernel
        self._prepare = prepare
        self._numbers = numbers
        self._shaft_position = np.ascontiguousarray(shaft_position)

    @property
    def joint_count(self) -> int:
        """Number of shafts, one a leg."""
        return len(self._shaft_position)

    def feet(self, angle_rad: FloatArray, rate_rad_s: FloatArray) -> FootMotion:
        """Return unloaded feet in the body frame.

        Args:
            angle_rad: Shaft angles, (..., N) [rad]; NaN gives NaN.
            rate_rad_s: Shaft speeds, (..., N) [rad/s].

        Returns:
            Positions and velocities of the leg's matter there, (..., N, 3).
        """
        angle = np.ascontiguousarray(angle_rad, dtype=np.float64)
        rate = np.ascontiguousarray(rate_rad_s, dtype=np.float64)
        shaft, shape = self._shaft_position, angle.shape
        if shape[-1] != len(shaft) or rate.shape != shape:
            raise ValueError(
                f"angles {shape} and speeds {rate.shape} are not those of {len(shaft)} legs"
            )
        position, velocity = np.empty((*shape, 3)), np.empty((*shape, 3))
        if len(shape) == 1:  # of a tick: no views of views
            self._feet_kernel(angle, rate, self._numbers, shaft, position, velocity)
            return FootMotion(position, velocity)
        self._feet_kernel(
            angle.ravel(), rate.ravel(), self._numbers, shaft, position.reshape(-1, 3),
            velocity.reshape(-1, 3),
        )  # fmt: skip
        return FootMotion(position, velocity)

    def jacobian(self, angle_rad: FloatArray) -> FloatArray:
        """Return d foot velocity / d shaft speed, (..., N, 3, N) [m/rad], from angles (..., N) [rad]."""
        angle = np.asarray(angle_rad, dtype=np.float64)
        slope = self.feet(angle, np.ones_like(angle)).velocity_m_s
        jacobian: FloatArray = slope[..., None] * np.eye(self.joint_count)[:, None, :]
        return jacobian

    def prepare(self) -> None:
        """Load or make the machine code of ``feet`` now, so that no tick has to wait for it."""
        self._prepare()
