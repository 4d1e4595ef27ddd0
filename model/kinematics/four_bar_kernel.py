"""The four-bar of ``model.kinematics.four_bar``, compiled: poses at many angles, feet of many frames."""

import numpy as np

from model.compiled import compile_for, compiled, given, out
from model.values.arrays import FloatArray


@compiled
def _pose(
    angle: float, numbers: FloatArray
) -> tuple[float, float, float, float, float, float, float, float]:
    """Crank pin, rocker pin, foot and d foot / d shaft angle, x and z each [m], [m/rad]."""
    crank, pivot_x, pivot_z, coupler, rocker = (
        numbers[0], numbers[1], numbers[2], numbers[3], numbers[4],
    )  # fmt: skip
    along_foot, across_foot, branch = numbers[5], numbers[6], numbers[7]
    phi = numbers[8] - angle
    c, s = np.cos(phi), np.sin(phi)
    ax, az = crank * c, crank * s
    ex, ez = pivot_x - ax, pivot_z - az
    distance = np.sqrt(ex * ex + ez * ez)
    along = (coupler**2 - rocker**2 + distance**2) / (2.0 * distance)
    # beyond a dead centre there is no pose; check_linkage has excluded that, rounding has not
    across = branch * np.sqrt(max(coupler**2 - along**2, 0.0))
    ex, ez = ex / distance, ez / distance
    bx, bz = ax + along * ex - across * ez, az + along * ez + across * ex
    ux, uz = (bx - ax) / coupler, (bz - az) / coupler
    vx, vz = (bx - pivot_x) / rocker, (bz - pivot_z) / rocker
    fx = ax + along_foot * ux - across_foot * uz
    fz = az + along_foot * uz + across_foot * ux
    # closure differentiated by phi, times v:  (dA + coupler du) . v = 0,  du = left(u) dpsi
    sine = ux * vz - uz * vx
    turn = -(-crank * s * vx + crank * c * vz) / (coupler * sine)
    return ax, az, bx, bz, fx, fz, crank * s + turn * (fz - az), -crank * c - turn * (fx - ax)


@compiled
def poses_kernel(angle: FloatArray, numbers: FloatArray, out: FloatArray) -> None:
    """Poses at many angles.

    Args:
        angle: Shaft angles, (M,) [rad].
        numbers: crank, ground pivot x and z, coupler, rocker, foot along and across [m], branch,
            mid-stance [rad], (9,).
        out: Out: as ``_pose`` has them, (M, 8).
    """
    for m in range(angle.size):
        (
            out[m, 0], out[m, 1], out[m, 2], out[m, 3],
            out[m, 4], out[m, 5], out[m, 6], out[m, 7],
        ) = _pose(angle[m], numbers)  # fmt: skip


@compiled
def feet_kernel(
    angle: FloatArray, rate: FloatArray, numbers: FloatArray, shaft: FloatArray,
    position: FloatArray, velocity: FloatArray,
) -> None:  # fmt: skip
    """Feet in the body frame.

    Args:
        angle: Shaft angles, (F, N) [rad].
        rate: Shaft speeds, (F, N) [rad/s].
        numbers: As for ``poses_kernel``.
        shaft: Crank shafts, (N, 3) [m].
        position: Out: (F, N, 3) [m].
        velocity: Out: (F, N, 3) [m/s].
    """
    for f in range(angle.shape[0]):
        for k in range(angle.shape[1]):
            _, _, _, _, x, z, x_slope, z_slope = _pose(angle[f, k], numbers)
            position[f, k, 0] = shaft[k, 0] + x
            position[f, k, 1] = shaft[k, 1]
            position[f, k, 2] = shaft[k, 2] + z
            velocity[f, k, 0] = x_slope * rate[f, k]
            velocity[f, k, 1] = 0.0
            velocity[f, k, 2] = z_slope * rate[f, k]


def prepare() -> None:
    """Compile for arrays in rows, read-only or not, and for nothing else after."""
    compile_for(poses_kernel, *given(1, 1), *out(2))
    compile_for(feet_kernel, *given(2, 2, 1, 2), *out(3, 3))
