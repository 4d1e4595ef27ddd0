"""The four-bar of ``model.kinematics.four_bar`` for the legs of one frame, compiled for the loop."""

import numpy as np

from model.compiled import compile_for, compiled, given, out
from model.values.arrays import FloatArray


@compiled
def feet_kernel(
    angle: FloatArray,
    rate: FloatArray,
    numbers: FloatArray,
    shaft: FloatArray,
    position: FloatArray,
    velocity: FloatArray,
) -> None:
    """Feet of one frame in the body frame.

    Args:
        angle: Shaft angles, (N,) [rad].
        rate: Shaft speeds, (N,) [rad/s].
        numbers: crank, ground pivot x and z, coupler, rocker, foot along and across [m], branch,
            mid-stance [rad], (9,).
        shaft: Crank shafts, (N, 3) [m].
        position: Out: (N, 3) [m].
        velocity: Out: (N, 3) [m/s].
    """
    crank, pivot_x, pivot_z, coupler, rocker = (
        numbers[0], numbers[1], numbers[2], numbers[3], numbers[4],
    )  # fmt: skip
    along_foot, across_foot, branch, mid_stance = numbers[5], numbers[6], numbers[7], numbers[8]
    for k in range(angle.size):
        phi = mid_stance - angle[k]
        c, s = np.cos(phi), np.sin(phi)
        ax, az = crank * c, crank * s
        ex, ez = pivot_x - ax, pivot_z - az
        distance = np.sqrt(ex * ex + ez * ez)
        along = (coupler**2 - rocker**2 + distance**2) / (2.0 * distance)
        across = branch * np.sqrt(max(coupler**2 - along**2, 0.0))
        ex, ez = ex / distance, ez / distance
        bx, bz = ax + along * ex - across * ez, az + along * ez + across * ex
        ux, uz = (bx - ax) / coupler, (bz - az) / coupler
        vx, vz = (bx - pivot_x) / rocker, (bz - pivot_z) / rocker
        fx = ax + along_foot * ux - across_foot * uz
        fz = az + along_foot * uz + across_foot * ux
        sine = -uz * vx + ux * vz
        turn = -(-crank * s * vx + crank * c * vz) / (coupler * sine)
        position[k, 0] = shaft[k, 0] + fx
        position[k, 1] = shaft[k, 1]
        position[k, 2] = shaft[k, 2] + fz
        velocity[k, 0] = -(-crank * s - turn * (fz - az)) * rate[k]
        velocity[k, 1] = 0.0
        velocity[k, 2] = -(crank * c + turn * (fx - ax)) * rate[k]


def prepare() -> None:
    """Compile for arrays in rows, read-only or not, and for nothing else after."""
    compile_for(feet_kernel, *given(1, 1, 1, 2), *out(2, 2))
