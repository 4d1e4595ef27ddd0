"""Total horizontal force on a body over its planar velocity, without rotation (fig:fxy).

The zero of the field is the minimum of a convex dissipation: a quadratic for the ansatz, whose zero
is the mean of the feet weighted by grip, and a sum of norms for Coulomb's law, whose zero is their
geometric median. Where the body's velocity brings a foot to rest the Coulomb field jumps.
"""

import numpy as np

from model.quasistatic.frames import FrictionLaw
from model.traction.coulomb_kernel import FootLaw
from model.traction.frames import answers_for, balance_frames, given_alone
from model.values.arrays import FloatArray


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
    # each foot stands half on either side of the body, so that nothing turns it
    count = len(grip)
    feet = np.zeros((1, 2 * count, 2))
    feet[0, :count, 1], feet[0, count:, 1] = 1.0, -1.0
    speed, limit = np.tile(foot_velocity, (2, 1))[None], np.tile(grip / 2, 2)[None]
    out = answers_for(1, 2 * count)
    given = given_alone(feet, speed, limit, np.zeros((1, 2 * count, 2)))
    balance_frames(given, FootLaw(law is FrictionLaw.COULOMB), out, newtons=False)
    return out.velocity_B[0, :2]
