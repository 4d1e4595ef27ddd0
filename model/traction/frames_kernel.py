"""Planar balance over frames with given loads, for the compiler: pushes, inertia, elastic feet, Stribeck.

Each foot answers a slip s with a force; the body's velocity is that at which all forces, the push and the
drag balance. Viscous: F = -sigma mu N L s, L = I + w w^T, sigma the scale of the online model
(``model.quasistatic.frame_kernel``). Coulomb: F = -mu N L n / sqrt(|n|^2 + rest^2), n = L s: below the
speed ``rest`` a foot creeps, which also makes the forces of several sticking feet unique. The balance is
then the minimum of a convex power, found by Newton steps with a line search, or by reweighted linear
balances (which always go down) where a Newton step does not help, and where feet give sideways or friction
falls with speed.

An elastic foot (compliance C) slips by s = (rigid slip) + C dF/dt, in time steps of the frames. Inertia is
a resistance M / dt against the change of velocity since the frame before (implicit Euler), as drag is one
against the velocity itself: ``resist`` is the sum of both, along the ground and about the vertical, (2,).
"""

import numpy as np

from model.compiled import compiled
from model.traction.coulomb_kernel import solve3
from model.values.arrays import BoolArray, FloatArray

CREEP_SPEED_M_S = 1e-3  # as in ``model.quasistatic.frame_kernel``
NEWTON_STEPS = 60
REWEIGHTED_STEPS = 400
CONVERGED = 1e-11  # change of a velocity, share of the largest foot speed
REWEIGHTED_LOOSER = 1e3
FIRST_REWEIGHTED = 4  # steps before Newton's are tried; as many again where those do not help
MOST_FAILURES = 4  # then only safe steps


@compiled
def _weakening(speed: float, static_ratio: float, static_speed: float) -> float:
    """Friction over its value at speed: static_ratio at rest, 1 when fast (Stribeck)."""
    factor = 1.0
    if static_ratio != 1.0:
        factor += (static_ratio - 1.0) * np.exp(-((speed / static_speed) ** 2))
    return factor


@compiled
def _add(
    a: FloatArray, r: FloatArray, x: float, y: float, ux: float, uy: float,
    gxx: float, gxy: float, gyx: float, gyy: float, fx: float, fy: float,
) -> None:  # fmt: skip
    """Add a foot with force f - G (slip) to the balance; its lever is (-y, x)."""
    px, py = -gxx * y + gxy * x, -gyx * y + gyy * x
    a[0, 0] += gxx
    a[0, 1] += gxy
    a[0, 2] += px
    a[1, 0] += gyx
    a[1, 1] += gyy
    a[1, 2] += py
    a[2, 0] += -y * gxx + x * gyx
    a[2, 1] += -y * gxy + x * gyy
    a[2, 2] += -y * px + x * py
    bx, by = fx - gxx * ux - gxy * uy, fy - gyx * ux - gyy * uy
    r[0] += bx
    r[1] += by
    r[2] += -y * bx + x * by


@compiled
def _power(
    x: FloatArray, y: FloatArray, u: FloatArray, c: FloatArray, w: FloatArray,
    push: FloatArray, resist: FloatArray, rest: float, v: FloatArray,
) -> float:  # fmt: skip
    total: float = 0.5 * (resist[0] * (v[0] * v[0] + v[1] * v[1]) + resist[1] * v[2] * v[2])
    total -= push[0] * v[0] + push[1] * v[1] + push[2] * v[2]
    for k in range(x.size):
        if c[k] > 0.0:
            sx, sy = v[0] - v[2] * y[k] + u[k, 0], v[1] + v[2] * x[k] + u[k, 1]
            along = w[k, 0] * sx + w[k, 1] * sy
            nx, ny = sx + w[k, 0] * along, sy + w[k, 1] * along
            total += c[k] * np.sqrt(nx * nx + ny * ny + rest * rest)
    return total


@compiled
def _coulomb_step(
    x: FloatArray, y: FloatArray, u: FloatArray, c: FloatArray, w: FloatArray,
    push: FloatArray, resist: FloatArray, rest: float, newton: float, v: FloatArray, out: FloatArray,
) -> bool:  # fmt: skip
    """Next velocity from v: Newton (1) or reweighted (0)."""
    a = np.zeros((3, 3))
    r = push.copy()
    a[0, 0] = a[1, 1] = resist[0]
    a[2, 2] = resist[1]
    for k in range(x.size):
        if c[k] <= 0.0:
            continue
        sx, sy = v[0] - v[2] * y[k] + u[k, 0], v[1] + v[2] * x[k] + u[k, 1]
        wx, wy = w[k, 0], w[k, 1]
        along = wx * sx + wy * sy
        nx, ny = sx + wx * along, sy + wy * along
        size = np.sqrt(nx * nx + ny * ny + rest * rest)
        along = wx * nx + wy * ny
        mx, my = nx + wx * along, ny + wy * along  # L n
        lxx, lxy, lyy = 1.0 + wx * wx, wx * wy, 1.0 + wy * wy
        h = c[k] / size
        gxx = h * (lxx * lxx + lxy * lxy) - newton * h * mx * mx / (size * size)
        gxy = h * lxy * (lxx + lyy) - newton * h * mx * my / (size * size)
        gyy = h * (lxy * lxy + lyy * lyy) - newton * h * my * my / (size * size)
        fx = -h * mx + gxx * sx + gxy * sy
        fy = -h * my + gxy * sx + gyy * sy
        _add(a, r, x[k], y[k], u[k, 0], u[k, 1], gxx, gxy, gxy, gyy, fx, fy)
    return solve3(a, r, out)


@compiled
def _coulomb(
    x: FloatArray, y: FloatArray, u: FloatArray, c: FloatArray, w: FloatArray,
    push: FloatArray, resist: FloatArray, rest: float, tolerance: float, v: FloatArray,
) -> bool:  # fmt: skip
    """Least power from the velocity v on; v is overwritten."""
    new = np.empty(3)
    trial = np.empty(3)
    power = _power(x, y, u, c, w, push, resist, rest, v)
    for _ in range(NEWTON_STEPS):
        taken = False
        if _coulomb_step(x, y, u, c, w, push, resist, rest, 1.0, v, new):
            step = 1.0
            for _half in range(4):
                for i in range(3):
                    trial[i] = v[i] + step * (new[i] - v[i])
                now = _power(x, y, u, c, w, push, resist, rest, trial)
                if now <= power * (1.0 + 1e-14 * (power > 0.0)) + 1e-300:
                    taken = True
                    break
                step *= 0.35
        if not taken:
            if not _coulomb_step(x, y, u, c, w, push, resist, rest, 0.0, v, new):
                return False
            for i in range(3):
                trial[i] = new[i]
            now = _power(x, y, u, c, w, push, resist, rest, trial)
        change = max(abs(trial[0] - v[0]), abs(trial[1] - v[1]), 0.3 * abs(trial[2] - v[2]))
        for i in range(3):
            v[i] = trial[i]
        power = now
        if change <= tolerance:
            return True
    return True  # no more to gain within rounding


@compiled
def _reweighted(
    x: FloatArray, y: FloatArray, u: FloatArray, c: FloatArray, w: FloatArray,
    push: FloatArray, resist: FloatArray, rest: float, coulomb: bool, give: FloatArray, period: float,
    static_ratio: float, static_speed: float, before: FloatArray, tolerance: float, scale: float,
    v: FloatArray, slip: FloatArray, force: FloatArray,
) -> float:  # fmt: skip
    """Balance by reweighting, for laws that are no plain convex power; returns sigma (NaN: none).

    ``before`` holds the forces one frame ago, (N, 2), for feet that give. v and slip are where to begin and
    where it ends, force is the output.
    """
    count = x.size
    sigma = scale
    old, trial = v.copy(), v.copy()
    laws, a, r = np.zeros((count, 6)), np.zeros((3, 3)), np.zeros(3)
    last, slow, failures = np.inf, 0, 0
    for number in range(REWEIGHTED_STEPS):
        newton = 1.0 if coulomb and slow == 0 else 0.0
        a[:, :] = 0.0
        r[:] = push
        a[0, 0] = a[1, 1] = resist[0]
        a[2, 2] = resist[1]
        for k in range(count):
            if c[k] > 0.0:
                _linear_law(
                    slip[k], c[k], w[k], give[k], before[k], period, coulomb, rest, sigma, newton,
                    static_ratio, static_speed, laws[k],
                )  # fmt: skip
                g = laws[k]
                _add(a, r, x[k], y[k], u[k, 0], u[k, 1], g[0], g[1], g[2], g[3], g[4], g[5])
        if not solve3(a, r, trial):
            return np.nan
        power, aim, change = 0.0, 0.0, 0.0
        for k in range(count):
            rx, ry = trial[0] - trial[2] * y[k] + u[k, 0], trial[1] + trial[2] * x[k] + u[k, 1]
            force[k, 0] = laws[k, 4] - laws[k, 0] * rx - laws[k, 1] * ry
            force[k, 1] = laws[k, 5] - laws[k, 2] * rx - laws[k, 3] * ry
            nx = rx + give[k, 0] * (force[k, 0] - before[k, 0]) / period
            ny = ry + give[k, 1] * (force[k, 1] - before[k, 1]) / period
            if c[k] > 0.0:
                change = max(change, abs(nx - slip[k, 0]), abs(ny - slip[k, 1]))
            slip[k, 0], slip[k, 1] = nx, ny
            if not coulomb:
                h2 = (force[k, 0] ** 2 + force[k, 1] ** 2) / (sigma * sigma)
                power += h2
                aim += h2 / (np.sqrt(nx * nx + ny * ny) + CREEP_SPEED_M_S)
        for i in range(3):
            change = max(change, abs(trial[i] - old[i]))
        if newton == 1.0:  # the first step jumps; the others must close in, or safe steps follow
            if not change < 0.5 * last and change > tolerance:
                failures += 1
                slow = FIRST_REWEIGHTED if failures < MOST_FAILURES else REWEIGHTED_STEPS
            last = change
        else:
            slow, last = max(slow - 1, 0), np.inf
        for i in range(3):
            v[i] = old[i] = trial[i]
        if not coulomb and power > 0.0:
            new = aim / power
            change = max(change, tolerance * 1e7 * abs(new / sigma - 1.0))
            sigma = new
        if number > 0 and change <= tolerance:
            break
    return sigma


@compiled
def _linear_law(
    slip: FloatArray, c: float, w: FloatArray, give: FloatArray, before: FloatArray, period: float,
    coulomb: bool, rest: float, sigma: float, newton: float, static_ratio: float,
    static_speed: float, out: FloatArray,
) -> None:  # fmt: skip
    """A foot's force near its present slip as f - G (rigid slip); out: Gxx, Gxy, Gyx, Gyy, fx, fy.

    F = e - B s, s = rigid + C (F - before) / period, so G = B (I + C B / period)^-1 and
    f = e - G C (e - before) / period.
    """
    wx, wy = w[0], w[1]
    sx, sy = slip[0], slip[1]
    lxx, lxy, lyy = 1.0 + wx * wx, wx * wy, 1.0 + wy * wy
    grip = c * _weakening(np.sqrt(sx * sx + sy * sy), static_ratio, static_speed)
    ex, ey = 0.0, 0.0
    if coulomb:
        nx, ny = lxx * sx + lxy * sy, lxy * sx + lyy * sy
        square = nx * nx + ny * ny + rest * rest
        h = grip / np.sqrt(square)
        mx, my = lxx * nx + lxy * ny, lxy * nx + lyy * ny
        share = newton * h / square
        bxx = h * (lxx * lxx + lxy * lxy) - share * mx * mx
        bxy = h * lxy * (lxx + lyy) - share * mx * my
        byy = h * (lxy * lxy + lyy * lyy) - share * my * my
        along = share * (mx * sx + my * sy)
        ex, ey = -along * mx, -along * my
    else:
        h = grip * sigma
        bxx, bxy, byy = h * lxx, h * lxy, h * lyy
    ax, ay = give[0] / period, give[1] / period
    mxx, mxy, myx, myy = 1.0 + ax * bxx, ax * bxy, ay * bxy, 1.0 + ay * byy
    det = mxx * myy - mxy * myx
    gxx, gxy = (bxx * myy - bxy * myx) / det, (bxy * mxx - bxx * mxy) / det
    gyx, gyy = (bxy * myy - byy * myx) / det, (byy * mxx - bxy * mxy) / det
    tx, ty = ax * (ex - before[0]), ay * (ey - before[1])
    out[0], out[1], out[2], out[3] = gxx, gxy, gyx, gyy
    out[4], out[5] = ex - gxx * tx - gxy * ty, ey - gyx * tx - gyy * ty


@compiled
def traction_frames_kernel(
    feet: FloatArray, speed: FloatArray, limit: FloatArray, anisotropy: FloatArray,
    push: FloatArray, drag: FloatArray, inertia: FloatArray, last: FloatArray, walk: bool, coulomb: bool,
    rest: float, give: FloatArray, period: float, static_ratio: float, static_speed: float,
    velocity: FloatArray, slip: FloatArray, force: FloatArray, valid: BoolArray,
) -> None:  # fmt: skip
    """Solve frames in order; the last four arguments are written. Shapes: ``model.traction.frames``.

    ``inertia`` is over the time step, (2,). Of a ``walk`` each frame's velocity is the next one's ``last``.
    """
    frames, count = limit.shape
    one_step = not give.any() and static_ratio == 1.0
    before = np.zeros((count, 2))
    v, pushes, resist, previous = np.zeros(3), np.zeros(3), np.zeros(2), last.copy()
    heavy = inertia[0] > 0.0 or inertia[1] > 0.0
    warm = False
    for f in range(frames):
        x, y, u, c = feet[f, :, 0].copy(), feet[f, :, 1].copy(), speed[f], limit[f]
        w = anisotropy[f if anisotropy.shape[0] > 1 else 0]
        loaded, fastest, check = 0, 0.0, push[f, 0] + push[f, 1] + push[f, 2]
        for k in range(count):
            loaded += c[k] > 0.0
            fastest = max(fastest, abs(u[k, 0]), abs(u[k, 1]))
            check += c[k] + x[k] + y[k] + u[k, 0] + u[k, 1]
        valid[f] = loaded >= 2 and np.isfinite(check)
        if valid[f]:
            tolerance = CONVERGED * max(fastest, rest)
            pushes[:] = push[f]
            resist[:] = drag
            if heavy and np.isfinite(previous[0] + previous[1] + previous[2]):
                # kept in the world while the body turns
                turned = previous[2] * period if walk else 0.0
                pushes[0] += inertia[0] * (previous[0] + turned * previous[1])
                pushes[1] += inertia[0] * (previous[1] - turned * previous[0])
                pushes[2] += inertia[1] * previous[2]
                resist[0] += inertia[0]
                resist[1] += inertia[1]
            pushed = (
                resist[0] != 0.0
                or resist[1] != 0.0
                or push[f, 0] != 0.0
                or push[f, 1] != 0.0
                or push[f, 2] != 0.0
            )
            sigma = 1.0
            if not (coulomb and warm):
                sigma = _start(x, y, u, c, w, v, slip[f], force[f])
            elif not one_step:
                slip[f] = slip[f - 1]
            if coulomb and one_step:
                if not _coulomb(x, y, u, c, w, pushes, resist, rest, tolerance, v):
                    sigma = np.nan
                _coulomb_forces(x, y, u, c, w, rest, v, slip[f], force[f])
            elif not coulomb and one_step and not pushed:
                for k in range(count):
                    force[f, k, 0] *= sigma
                    force[f, k, 1] *= sigma
            else:
                sigma = _reweighted(
                    x, y, u, c, w, pushes, resist, rest, coulomb, give[f if give.shape[0] > 1 else 0],
                    period, static_ratio, static_speed, before, REWEIGHTED_LOOSER * tolerance, sigma, v,
                    slip[f], force[f],
                )  # fmt: skip
            valid[f] = np.isfinite(v[0] + v[1] + v[2] + sigma)
        warm = valid[f]
        if valid[f]:
            velocity[f, :] = v
            if walk:
                previous[:] = v
            before[:, :] = force[f]
        else:
            velocity[f, :] = np.nan
            slip[f, :, :] = np.nan
            force[f, :, :] = np.nan
            v[:] = 0.0


@compiled
def _start(
    x: FloatArray, y: FloatArray, u: FloatArray, c: FloatArray, w: FloatArray,
    v: FloatArray, slip: FloatArray, force: FloatArray,
) -> float:  # fmt: skip
    """Viscous balance without a push: velocity, slip, the bare ansatz' forces; returns sigma."""
    a = np.zeros((3, 3))
    r = np.zeros(3)
    for k in range(x.size):
        wx, wy = w[k, 0], w[k, 1]
        gxx, gxy, gyy = c[k] * (1.0 + wx * wx), c[k] * wx * wy, c[k] * (1.0 + wy * wy)
        _add(a, r, x[k], y[k], u[k, 0], u[k, 1], gxx, gxy, gxy, gyy, 0.0, 0.0)
    if not solve3(a, r, v):
        v[:] = np.nan
        return np.nan
    power, aim = 0.0, 0.0
    for k in range(x.size):
        sx, sy = v[0] - v[2] * y[k] + u[k, 0], v[1] + v[2] * x[k] + u[k, 1]
        along = w[k, 0] * sx + w[k, 1] * sy
        slip[k, 0], slip[k, 1] = sx, sy
        force[k, 0] = -c[k] * (sx + w[k, 0] * along)
        force[k, 1] = -c[k] * (sy + w[k, 1] * along)
        square = force[k, 0] ** 2 + force[k, 1] ** 2
        power += square
        aim += square / (np.sqrt(sx * sx + sy * sy) + CREEP_SPEED_M_S)
    return aim / power if power > 0.0 else 1.0 / CREEP_SPEED_M_S


@compiled
def _coulomb_forces(
    x: FloatArray, y: FloatArray, u: FloatArray, c: FloatArray, w: FloatArray, rest: float,
    v: FloatArray, slip: FloatArray, force: FloatArray,
) -> None:  # fmt: skip
    for k in range(x.size):
        sx, sy = v[0] - v[2] * y[k] + u[k, 0], v[1] + v[2] * x[k] + u[k, 1]
        slip[k, 0], slip[k, 1] = sx, sy
        along = w[k, 0] * sx + w[k, 1] * sy
        nx, ny = sx + w[k, 0] * along, sy + w[k, 1] * along
        along = w[k, 0] * nx + w[k, 1] * ny
        h = c[k] / np.sqrt(nx * nx + ny * ny + rest * rest)
        force[k, 0], force[k, 1] = -h * (nx + w[k, 0] * along), -h * (ny + w[k, 1] * along)
