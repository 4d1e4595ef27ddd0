"""The paper's small examples, for its figures: legs on a line, laws between the two, the force field.

The total force on a body over its velocity, without rotation, is zero at the minimum of a convex
dissipation: a quadratic for the ansatz, whose zero is the mean of the feet weighted by grip, and a sum of
norms for Coulomb's law, whose zero is their geometric median. On a line (fig:1d_ex) that is minus the
median of the feet's velocities; in the plane (fig:fxy) Coulomb's field jumps where the body's velocity
brings a foot to rest.

Between the laws (eqn:h2) a foot that slips at v feels F = -mu N H(|v|, eps) v with

    H(v, eps) = (eps + v) / (eps + v^2)

eps -> 0 gives Coulomb's law (H = 1/v), eps -> infinity the ansatz (H = 1). As printed, eps is added to a
speed and to a squared speed, so the speeds are numbers: speed over 1 m/s.
"""

import numpy as np

from model.quasistatic.frames import FrictionLaw
from model.traction.coulomb_kernel import FootLaw
from model.traction.frames import SlidingFeet, solve_traction_frames
from model.values.arrays import FloatArray


def coulomb_balance(foot_velocity: FloatArray) -> tuple[float, float]:
    """Slowest and fastest body velocity in balance on a line under Coulomb's law [m/s].

    Args:
        foot_velocity: Velocities of feet of equal grip relative to the body, (M,) [m/s], M > 0.

    Returns:
        Both are minus the median for an odd number of legs. For an even number they are the two
        middle feet's, and every velocity between them balances as well: the answer is not unique.
    """
    body = np.sort(-foot_velocity)
    count = len(body)
    return float(body[(count - 1) // 2]), float(body[count // 2])


def force_share(speed: FloatArray | float, eps: float) -> FloatArray:
    """Horizontal force over mu N at a slip speed: v H(v, eps).

    Args:
        speed: Slip speed, any shape [m/s], not negative.
        eps: 0 is Coulomb's law, ``inf`` the viscous-Coulomb ansatz.

    Returns:
        The shape of ``speed``. At rest it is 0, also under Coulomb's law, whose force there can be
        anything from 0 to 1.
    """
    v = np.asarray(speed, dtype=np.float64)
    if np.isinf(eps):
        return v.copy()
    moving = np.where(v > 0, v, 1.0)
    share: FloatArray = np.where(v > 0, moving * (eps + moving) / (eps + moving**2), 0.0)
    return share


def ansatz_error(change: FloatArray) -> FloatArray:
    """Relative error of the ansatz, matched to Coulomb's law at v = (1, 0), at v + change (fig:Fv-Fc).

    Both laws point against the slip, so only the magnitudes differ: mu N |v + change| against mu N.

        error = | |v + change| - 1 |

    Across the sliding direction this grows with the square of the change (2 % at 0.2), along it in
    proportion (20 % at 0.2): the paper's "within 2 %" holds only across (erratum E9).

    Args:
        change: Change of the slip velocity over the slip speed, (..., 2): along it, across it.

    Returns:
        (...), 0.02 is 2 %.
    """
    speed = np.hypot(1.0 + change[..., 0], change[..., 1])
    error: FloatArray = np.abs(speed - 1.0)
    return error


def total_force(
    body_velocity: FloatArray, foot_velocity: FloatArray, grip: FloatArray, law: FrictionLaw
) -> FloatArray:
    """Sum of the feet's horizontal forces, on a line (D = 1) or in the plane (D = 2).

    Args:
        body_velocity: (..., D) [m/s].
        foot_velocity: Velocities of the feet relative to the body, (N, D) [m/s].
        grip: mu times load of each foot, (N,) [N].
        law: Friction law.

    Returns:
        (..., D) [N] for Coulomb's law, [N m/s] for the bare ansatz. A foot exactly at rest adds 0.
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
    places = np.repeat([[0.0, 1.0], [0.0, -1.0]], len(grip), axis=0)
    speed, limit = np.tile(foot_velocity, (2, 1)), np.tile(grip / 2, 2)
    foot_law, isotropic = FootLaw(law is FrictionLaw.COULOMB), np.zeros((1, len(limit), 2))
    answer = solve_traction_frames(
        SlidingFeet(places[None], speed[None], limit[None], isotropic), foot_law
    )
    return answer.velocity_B[0, :2]
