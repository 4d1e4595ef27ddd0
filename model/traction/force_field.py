"""Total horizontal force on a body over its planar velocity, without rotation (fig:fxy).

The zero of the field is the minimum of a convex dissipation: a quadratic for the ansatz, whose zero
is the mean of the feet weighted by grip, and a sum of norms for Coulomb's law, whose zero is their
geometric median. Where the body's velocity brings a foot to rest the Coulomb field jumps.
"""

import numpy as np

from model.quasistatic.frames import FrictionLaw
from model.values.arrays import FloatArray

NEWTON_STEPS = 100
SPEED_TOLERANCE = 1e-13


def total_force(
    body_velocity: FloatArray, foot_velocity: FloatArray, grip: FloatArray, law: FrictionLaw
) -> FloatArray:
    """Sum of the feet's horizontal forces.

    Args:
        body_velocity: (..., 2) [m/s].
        foot_velocity: Velocities of the feet relative to the body, (N, 2) [m/s].
        grip: mu times load of each foot, (N,) [N].
        law: Friction law.

    Returns:
        (..., 2) [N] for Coulomb's law, [N m/s] for the bare ansatz. A foot exactly at rest adds 0.
    """
    slip = body_velocity[..., None, :] + foot_velocity
    if law is FrictionLaw.COULOMB:
        speed = np.linalg.norm(slip, axis=-1, keepdims=True)
        slip = slip / np.where(speed > 0, speed, 1.0)
    total: FloatArray = -np.sum(grip[:, None] * slip, axis=-2)
    return total


def balance_velocity(foot_velocity: FloatArray, grip: FloatArray, law: FrictionLaw) -> FloatArray:
    """Body velocity at which the forces balance, without rotation.

    Args:
        foot_velocity: (N, 2) [m/s].
        grip: (N,) [N], positive.
        law: Friction law. Under Coulomb's law feet whose velocities lie on one line, in even number,
            leave a choice; one of the answers is returned.

    Returns:
        (2,) [m/s].
    """
    rest = -foot_velocity  # body velocities that bring each foot to rest
    mean: FloatArray = grip @ rest / grip.sum()
    if law is FrictionLaw.VISCOUS:
        return mean
    return _geometric_median(rest, grip)


def _geometric_median(points: FloatArray, weight: FloatArray) -> FloatArray:
    """Minimum of the cost sum weight |v - point|.

    If the best of the points is not the minimum, a step down from it leaves all points above for
    good, so the cost is smooth wherever a descent may go: Newton, halved while it does not descend.
    """

    def cost(at: FloatArray) -> float:
        return float(weight @ np.linalg.norm(at - points, axis=1))

    best = int(np.argmin([cost(point) for point in points]))
    v: FloatArray = points[best].copy()
    pull = total_force(v, -points, weight, FrictionLaw.COULOMB)
    if np.hypot(*pull) <= weight[best]:  # the foot at rest holds what the others pull
        return v
    size = float(np.linalg.norm(points - v, axis=1).max()) / np.hypot(*pull)
    while cost(v + size * pull) >= cost(v) and size > SPEED_TOLERANCE:
        size /= 2
    v = v + size * pull
    for _ in range(NEWTON_STEPS):
        away = v - points
        distance = np.maximum(np.linalg.norm(away, axis=1), SPEED_TOLERANCE)
        unit = away / distance[:, None]
        gradient = weight @ unit
        across = np.eye(2) - unit[:, :, None] * unit[:, None, :]
        hessian = np.sum((weight / distance)[:, None, None] * across, axis=0)
        # a trace of damping for feet on a line, where the cost is flat along it
        hessian += 1e-12 * np.trace(hessian) * np.eye(2)
        step = -np.linalg.solve(hessian, gradient)
        here, size = cost(v), 1.0
        while cost(v + size * step) > here and size > SPEED_TOLERANCE:
            size /= 2
        v = v + size * step
        if np.hypot(*(size * step)) < SPEED_TOLERANCE:
            break
    return v
