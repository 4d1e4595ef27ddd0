"""The viscous-Coulomb balance of one frame with given loads, written for the compiler."""

import numpy as np

from model.compiled import compiled, compiled_sums, in_place
from model.support.kernel import DRAG, SPEED_X, SPEED_Y, W_X, W_Y, X, Y
from model.values.arrays import FloatArray

# Smallest ratio of the pivots of the balance, lengths scaled by the feet's spread.
CONDITION = 1e-9
# Slip below which a foot is taken to rest when forces are put on a scale [m/s].
CREEP_SPEED_M_S = 1e-3
FINE = 0
TOO_FEW_FEET = 5
ONE_POINT = 6


@in_place
@compiled_sums
def _drag(work: FloatArray, loads: FloatArray, mu: FloatArray) -> tuple[
    float, float, float, float
]:  # fmt: skip
    """Fill row DRAG with mu N; return its sum, its centre and its spread (root mean square)."""
    total, cx, cy = 0.0, 0.0, 0.0
    for k in range(loads.size):
        d = mu[k] * loads[k]
        work[DRAG, k] = d
        total += d
        cx += d * work[X, k]
        cy += d * work[Y, k]
    if total > 0.0:
        cx /= total
        cy /= total
    spread = 0.0
    for k in range(loads.size):
        x, y = work[X, k] - cx, work[Y, k] - cy
        spread += work[DRAG, k] * (x * x + y * y)
    return total, cx, cy, np.sqrt(spread / total) if total > 0.0 else 0.0


@in_place
@compiled_sums
def _balance(
    work: FloatArray, total: float, cx: float, cy: float, spread: float
) -> tuple[
    float, float, float, float, float, float, float, float, float
]:  # fmt: skip
    """Matrix and right side of the balance about the centre, lengths in units of the spread."""
    m00, m01, m02, m11, m12, m22 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    r0, r1, r2 = 0.0, 0.0, 0.0
    unit, scale = 1.0 / total, 1.0 / spread
    for k in range(work.shape[1]):
        d = work[DRAG, k] * unit
        ax, ay = work[W_X, k], work[W_Y, k]
        dxx = d * (1.0 + ax * ax)
        dxy = d * ax * ay
        dyy = d * (1.0 + ay * ay)
        gx = -(work[Y, k] - cy) * scale
        gy = (work[X, k] - cx) * scale
        px = dxx * gx + dxy * gy
        py = dxy * gx + dyy * gy
        m00 += dxx
        m01 += dxy
        m11 += dyy
        m02 += px
        m12 += py
        m22 += gx * px + gy * py
        ux, uy = work[SPEED_X, k], work[SPEED_Y, k]
        r0 -= dxx * ux + dxy * uy
        r1 -= dxy * ux + dyy * uy
        r2 -= px * ux + py * uy
    return m00, m01, m02, m11, m12, m22, r0, r1, r2


@in_place
@compiled_sums
def _spread_out(
    work: FloatArray, vx: float, vy: float, rate: float, cx: float, cy: float,
    slip: FloatArray, force: FloatArray,
) -> None:  # fmt: skip
    """Slip and force of every foot from the velocity of the centre."""
    for k in range(work.shape[1]):
        sx = vx - rate * (work[Y, k] - cy) + work[SPEED_X, k]
        sy = vy + rate * (work[X, k] - cx) + work[SPEED_Y, k]
        slip[k, 0] = sx
        slip[k, 1] = sy
        d = work[DRAG, k]
        along = work[W_X, k] * sx + work[W_Y, k] * sy
        force[k, 0] = -d * (sx + work[W_X, k] * along)
        force[k, 1] = -d * (sy + work[W_Y, k] * along)


@in_place
@compiled
def traction_kernel(
    work: FloatArray,
    loads: FloatArray,
    mu: FloatArray,
    velocity: FloatArray,
    slip: FloatArray,
    force: FloatArray,
) -> int:
    """Solve (sum G^T D G) (v, w) = - sum G^T D q' with D = mu N (I + a a^T), G = [I, S q].

    Moments are taken about the centre of the drag, where translation and rotation hardly mix.

    Args:
        work: Work space of ``model.support.kernel``: rows X, Y (feet [m]), SPEED_X, SPEED_Y (their
            horizontal velocities in the body [m/s]), W_X, W_Y are read; row DRAG is mu N afterwards.
        loads: (N,) [N].
        mu: (N,).
        velocity: Out: vx, vy, yaw rate, (3,).
        slip: Out: (N, 2) [m/s].
        force: Out: the bare ansatz -D slip, (N, 2).

    Returns:
        FINE, TOO_FEW_FEET or ONE_POINT.
    """
    total, cx, cy, spread = _drag(work, loads, mu)
    loaded = 0
    for k in range(loads.size):
        loaded += work[DRAG, k] > 0.0
        if loaded == 2:
            break
    if loaded < 2:
        return TOO_FEW_FEET
    if spread <= CONDITION * (abs(cx) + abs(cy) + spread):
        return ONE_POINT
    m00, m01, m02, m11, m12, m22, r0, r1, r2 = _balance(work, total, cx, cy, spread)
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
    _spread_out(work, vx, vy, rate, cx, cy, slip, force)
    return FINE


@in_place
@compiled
def coulomb_scale(slip: FloatArray, force: FloatArray, creep: float) -> float:
    """Scale sigma of the viscous ansatz' forces that brings them nearest to Coulomb's at the same slips.

    The least squares fit of sigma D s to D s / |s|, both (N, 2): forces are D s up to a common factor, and
    ``creep`` keeps feet at rest from deciding it. 0 without forces.
    """
    power, aim = 0.0, 0.0
    for k in range(slip.shape[0]):
        square = force[k, 0] ** 2 + force[k, 1] ** 2
        power += square
        if square > 0.0:
            aim += square / (np.sqrt(slip[k, 0] ** 2 + slip[k, 1] ** 2) + creep)
    return aim / power if power > 0.0 else 0.0


@in_place
@compiled_sums
def foot_speeds(velocity: FloatArray, work: FloatArray) -> bool:
    """Fill SPEED_X and SPEED_Y; return whether all speeds are numbers, the vertical ones too."""
    check = 0.0
    for k in range(velocity.shape[0]):
        x, y, z = velocity[k, 0], velocity[k, 1], velocity[k, 2]
        work[SPEED_X, k], work[SPEED_Y, k] = x, y
        check += 0.0 * x + 0.0 * y + 0.0 * z
    return check == 0.0


@in_place
@compiled
def lay_anisotropy(anisotropy: FloatArray, work: FloatArray) -> None:
    """Fill W_X and W_Y."""
    for k in range(anisotropy.shape[0]):
        work[W_X, k] = anisotropy[k, 0]
        work[W_Y, k] = anisotropy[k, 1]
