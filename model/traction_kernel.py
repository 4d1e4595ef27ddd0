"""The viscous-Coulomb balance of ``model.traction`` for one frame, written for the compiler."""

import numpy as np

from model.compiled import compiled, compiled_sums
from model.signals import FloatArray

# Smallest ratio of the pivots of the balance, lengths scaled by the feet's spread.
CONDITION = 1e-9
FINE = 0
TOO_FEW_FEET = 5
ONE_POINT = 6


@compiled_sums
def _drag(feet: FloatArray, loads: FloatArray, mu: FloatArray, work: FloatArray) -> tuple[
    float, float, float, float
]:  # fmt: skip
    """Lay out mu N in row 0; return its sum, its centre and its spread (root mean square)."""
    total, cx, cy = 0.0, 0.0, 0.0
    for k in range(feet.shape[0]):
        d = mu[k] * loads[k]
        work[0, k] = d
        total += d
        cx += d * feet[k, 0]
        cy += d * feet[k, 1]
    if total > 0.0:
        cx /= total
        cy /= total
    spread = 0.0
    for k in range(feet.shape[0]):
        x, y = feet[k, 0] - cx, feet[k, 1] - cy
        spread += work[0, k] * (x * x + y * y)
    return total, cx, cy, np.sqrt(spread / total) if total > 0.0 else 0.0


@compiled_sums
def _balance(
    feet: FloatArray, speed: FloatArray, anisotropy: FloatArray, work: FloatArray,
    total: float, cx: float, cy: float, spread: float,
) -> tuple[
    float, float, float, float, float, float, float, float, float
]:  # fmt: skip
    """Matrix and right side of the balance about the centre, lengths in units of the spread."""
    m00, m01, m02, m11, m12, m22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    r0, r1, r2 = 0.0, 0.0, 0.0
    unit, scale = 1.0 / total, 1.0 / spread
    for k in range(feet.shape[0]):
        d = work[0, k] * unit
        ax, ay = anisotropy[k, 0], anisotropy[k, 1]
        dxx = d * (1.0 + ax * ax)
        dxy = d * ax * ay
        dyy = d * (1.0 + ay * ay)
        gx = -(feet[k, 1] - cy) * scale
        gy = (feet[k, 0] - cx) * scale
        px = dxx * gx + dxy * gy
        py = dxy * gx + dyy * gy
        m00 += dxx
        m01 += dxy
        m11 += dyy
        m02 += px
        m12 += py
        m22 += gx * px + gy * py
        ux, uy = speed[k, 0], speed[k, 1]
        r0 -= dxx * ux + dxy * uy
        r1 -= dxy * ux + dyy * uy
        r2 -= px * ux + py * uy
    return m00, m01, m02, m11, m12, m22, r0, r1, r2


@compiled_sums
def _spread_out(
    feet: FloatArray, speed: FloatArray, anisotropy: FloatArray, work: FloatArray,
    vx: float, vy: float, rate: float, cx: float, cy: float, slip: FloatArray, force: FloatArray,
) -> None:  # fmt: skip
    """Slip and force of every foot from the velocity of the centre."""
    for k in range(feet.shape[0]):
        sx = vx - rate * (feet[k, 1] - cy) + speed[k, 0]
        sy = vy + rate * (feet[k, 0] - cx) + speed[k, 1]
        slip[k, 0] = sx
        slip[k, 1] = sy
        d = work[0, k]
        along = anisotropy[k, 0] * sx + anisotropy[k, 1] * sy
        force[k, 0] = -d * (sx + anisotropy[k, 0] * along)
        force[k, 1] = -d * (sy + anisotropy[k, 1] * along)


@compiled
def traction_kernel(
    feet: FloatArray,
    speed: FloatArray,
    loads: FloatArray,
    mu: FloatArray,
    anisotropy: FloatArray,
    velocity: FloatArray,
    slip: FloatArray,
    force: FloatArray,
    work: FloatArray,
) -> int:
    """Solve (sum G^T D G) (v, w) = - sum G^T D q' with D = mu N (I + a a^T), G = [I, S q].

    Moments are taken about the centre of the drag, where translation and rotation hardly mix.

    Args:
        feet: (N, 3) or (N, 2) [m], body frame.
        speed: Horizontal foot velocities in the body, (N, 2) [m/s].
        loads: (N,) [N].
        mu: (N,).
        anisotropy: (N, 2).
        velocity: Out: vx, vy, yaw rate, (3,).
        slip: Out: (N, 2) [m/s].
        force: Out: the bare ansatz -D slip, (N, 2).
        work: Work space, (1 or more, N); row 0 is mu N afterwards.

    Returns:
        FINE, TOO_FEW_FEET or ONE_POINT.
    """
    total, cx, cy, spread = _drag(feet, loads, mu, work)
    loaded = 0
    for k in range(feet.shape[0]):
        loaded += work[0, k] > 0.0
        if loaded == 2:
            break
    if loaded < 2:
        return TOO_FEW_FEET
    if spread <= CONDITION * (abs(cx) + abs(cy) + spread):
        return ONE_POINT
    m00, m01, m02, m11, m12, m22, r0, r1, r2 = _balance(
        feet, speed, anisotropy, work, total, cx, cy, spread
    )
    l10 = m01 / m00
    s11 = m11 - l10 * m01
    s12 = m12 - l10 * m02
    l20 = m02 / m00
    l21 = s12 / s11
    s22 = m22 - l20 * m02 - l21 * s12
    if not s22 > CONDITION * m00:
        return ONE_POINT
    r1 -= l10 * r0
    r2 -= l20 * r0 + l21 * r1
    w = r2 / s22
    vy = (r1 - s12 * w) / s11
    vx = (r0 - m01 * vy - m02 * w) / m00
    rate = w / spread
    velocity[0] = vx + rate * cy
    velocity[1] = vy - rate * cx
    velocity[2] = rate
    _spread_out(feet, speed, anisotropy, work, vx, vy, rate, cx, cy, slip, force)
    return FINE


@compiled_sums
def foot_speeds(
    velocity: FloatArray, pose: FloatArray, tilt_coupling: bool, speed: FloatArray
) -> bool:
    """Horizontal foot velocities, on a tilted body with the share of the vertical ones (E2).

    Returns:
        Whether all of them are numbers.
    """
    slope_x = pose[0] if tilt_coupling else 0.0
    slope_y = pose[1] if tilt_coupling else 0.0
    check = 0.0
    for k in range(velocity.shape[0]):
        x, y, z = velocity[k, 0], velocity[k, 1], velocity[k, 2]
        speed[k, 0] = x + slope_x * z
        speed[k, 1] = y - slope_y * z
        check += 0.0 * x + 0.0 * y + 0.0 * z
    return check == 0.0
