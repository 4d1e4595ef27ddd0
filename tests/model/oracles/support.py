"""Spring support in numpy, as the paper searches it: what the compiled search is tested against.

The pose is s = (slope_x, slope_y, height). A foot at q in the body frame stands at height
p(s) = -slope_x q_x + slope_y q_y + q_z + height (eqn:zpj) and carries K max(-p, 0). Balance of force
and moments is the stationary point of the convex energy

    E(s) = sum_k K_k/2 min(p_k, 0)^2 + Mg height

so the paper's walk from contact change to contact change is a descent of E, and any correct search
finds the same loads. We walk as the paper does: scan for the level height that carries the weight,
solve the balance of the feet in contact, go there along a straight line through the contact changes
for as long as E falls, repeat. With one or two feet (or feet in a row) in contact the balance leaves
the body free to tilt about them: it tilts the way the weight pulls, feet in contact keeping their
height, until another foot comes down (errata E6, E7 of our notes on the paper are put right here).
"""

import numpy as np

from model.errors import ModelError
from model.values.arrays import FloatArray, readonly
from model.values.contact import Support

# Imbalance accepted, as a share of the weight (moments: of weight times the largest lever).
BALANCE_TOLERANCE = 1e-11
# Eigenvalues of the balance below this share of the largest leave the body free to tilt.
RANK_TOLERANCE = 1e-12
WALKS_PER_FOOT = 20
# Changes of height below this share of the direction are rounding.
ROUNDING = 1e-13


def solve_support(feet_B: FloatArray, stiffness: FloatArray, load: float) -> Support:  # noqa: N803
    """Height, slopes and foot loads at which vertical leg springs carry the body.

    Args:
        feet_B: Unloaded feet in the body frame, origin at the centre of mass, (N, 3) [m].
        stiffness: Spring constant of each leg, (N,) [N/m], positive.
        load: Weight carried [N], positive.

    Returns:
        The support. Without an equilibrium (the robot tips, no feet, non-finite input) ``converged``
        is False, ``reason`` says why and the numbers are NaN: the control loop has to decide.

    Raises:
        ModelError: Shapes do not fit.
    """
    if feet_B.ndim != 2 or feet_B.shape[1] != 3 or stiffness.shape != feet_B.shape[:1]:
        raise ModelError(
            f"feet must be (N, 3) and stiffness (N,), not {feet_B.shape} and {stiffness.shape}"
        )
    count = len(feet_B)
    if count == 0:
        return _none(count, "there are no feet")
    if not (np.isfinite(feet_B).all() and np.isfinite(stiffness).all() and np.isfinite(load)):
        return _none(count, "a foot position, stiffness or the load is not a number")
    if load <= 0 or (stiffness <= 0).any():
        return _none(count, "load and stiffness must be positive")
    return _walk(feet_B, stiffness, load)


def _none(count: int, reason: str) -> Support:
    return Support(
        converged=False,
        reason=reason,
        height_m=np.nan,
        slope_x=np.nan,
        slope_y=np.nan,
        load_n=readonly(np.full(count, np.nan)),
        contact=readonly(np.zeros(count, dtype=bool)),
        switches=0,
    )


def _walk(feet: FloatArray, stiffness: FloatArray, load: float) -> Support:
    q_x, q_y, q_z = feet.T
    lever = max(float(np.abs(feet[:, :2]).max()), 1e-9)  # [m] makes slopes and height comparable
    # p = rows @ s + q_z with s = (lever slope_x, lever slope_y, height), all in metres
    rows = np.stack([-q_x / lever, q_y / lever, np.ones_like(q_x)], axis=1)
    weight = np.array([0.0, 0.0, load])
    state = np.array([0.0, 0.0, _level_height(q_z, stiffness, load)])
    switches = 0
    for _ in range(WALKS_PER_FOOT * len(feet)):
        p = rows @ state + q_z
        contact = p < 0
        in_contact = rows[contact]
        pressed = stiffness[contact]
        gradient = in_contact.T @ (pressed * p[contact]) + weight  # dE/ds
        if np.abs(gradient).max() <= BALANCE_TOLERANCE * load:
            return _found(state, lever, np.where(contact, -stiffness * p, 0.0), switches)
        direction = _direction(in_contact, pressed, gradient)
        change = rows @ direction
        change[np.abs(change) < ROUNDING * np.abs(direction).max()] = 0.0  # feet tilted about
        step, crossed = _descend(p, change, stiffness, load * direction[2])
        if not np.isfinite(step):
            return _none(len(feet), "the centre of mass is not above the feet: the robot tips")
        state = state + step * direction
        switches += crossed
    return _none(len(feet), "the search for the contact set did not end; report the pose")


def _level_height(q_z: FloatArray, stiffness: FloatArray, load: float) -> float:
    """Height at which the level body is carried: feet come down lowest first (erratum E6)."""
    order = np.argsort(q_z)
    low, k = q_z[order], stiffness[order]
    total, moment = np.cumsum(k), np.cumsum(k * low)
    # with the n lowest feet down: sum K (-(z + q_z)) = load  ->  z = -(load + sum K q_z) / sum K
    z = -(load + moment) / total
    down = np.append(low[1:], np.inf) + z >= 0  # the next foot is still in the air
    return float(z[int(np.argmax(down))])


def _direction(rows: FloatArray, stiffness: FloatArray, gradient: FloatArray) -> FloatArray:
    """Way to the balance of these feet, or the way the body tilts where they leave it free."""
    hessian = rows.T @ (stiffness[:, None] * rows)
    values, vectors = np.linalg.eigh(hessian)
    along = vectors.T @ gradient
    free = values <= RANK_TOLERANCE * values[-1]
    if free.any() and np.abs(along[free]).max() > BALANCE_TOLERANCE * np.abs(gradient).max():
        tilt = -vectors[:, free] @ along[free]
        direction: FloatArray = tilt / np.linalg.norm(tilt)
        return direction
    solved: FloatArray = -vectors @ np.where(free, 0.0, along / np.where(free, 1.0, values))
    return solved


def _descend(
    p: FloatArray, change: FloatArray, stiffness: FloatArray, weight_change: float
) -> tuple[float, int]:
    """Go along a line until E no longer falls.

    Args:
        p: Foot heights now, (N,).
        change: Their change for a unit step, (N,).
        stiffness: (N,).
        weight_change: Change of the weight's energy for a unit step.

    Returns:
        Step length (infinite if E falls for ever) and the number of contact changes passed.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        kinks = np.where(change != 0, -p / change, -1.0)
    kinks = np.sort(kinks[kinks > 0])
    at = np.concatenate([[0.0], kinks])
    heights = np.minimum(p + at[:, None] * change, 0.0)
    slopes = heights @ (stiffness * change) + weight_change  # dE/dt at every contact change
    rising = np.flatnonzero(slopes >= 0)
    if len(rising) == 0:
        last = p + (at[-1] + 1.0) * change
        curvature = float(np.sum((stiffness * change**2)[last < 0]))
        # E is quadratic from here on: it falls to its minimum, or for ever
        if curvature <= 0:
            return np.inf, 0
        return float(at[-1] - slopes[-1] / curvature), len(kinks)
    after = int(rising[0])
    if after == 0:
        return 0.0, 0
    before = after - 1
    share = -slopes[before] / (slopes[after] - slopes[before])
    return float(at[before] + share * (at[after] - at[before])), before


def _found(state: FloatArray, lever: float, loads: FloatArray, switches: int) -> Support:
    return Support(
        converged=True,
        reason="",
        height_m=float(state[2]),
        slope_x=float(state[0] / lever),
        slope_y=float(state[1] / lever),
        load_n=readonly(loads),
        contact=readonly(loads > 0),
        switches=switches,
    )
