"""The motivating example on a line: legs of equal load push a body along x (fig:1d_ex).

Foot i moves at v_i relative to the body, so over the ground at v_B + v_i. Coulomb's law balances
where as many feet slip forward as backward, at minus the median; the viscous-Coulomb ansatz at minus
the mean. Forces are in units of one foot's mu N (the ansatz: mu N times 1 s/m).
"""

import numpy as np

from model.values.arrays import FloatArray


def coulomb_force(body_velocity: FloatArray | float, foot_velocity: FloatArray) -> FloatArray:
    """Sum of the feet's Coulomb forces; a foot exactly at rest adds nothing.

    Args:
        body_velocity: v_B, any shape (...) [m/s].
        foot_velocity: v_i, (M,) [m/s].

    Returns:
        (...), in units of mu N: a staircase that falls from M to -M.
    """
    slip = np.asarray(body_velocity, dtype=np.float64)[..., None] + foot_velocity
    total: FloatArray = -np.sign(slip).sum(axis=-1)
    return total


def viscous_force(body_velocity: FloatArray | float, foot_velocity: FloatArray) -> FloatArray:
    """Sum of the feet's forces under the ansatz, a straight line.

    Args:
        body_velocity: v_B, any shape (...) [m/s].
        foot_velocity: v_i, (M,) [m/s].

    Returns:
        (...), in units of mu N x 1 s/m.
    """
    slip = np.asarray(body_velocity, dtype=np.float64)[..., None] + foot_velocity
    total: FloatArray = -slip.sum(axis=-1)
    return total


def coulomb_balance(foot_velocity: FloatArray) -> tuple[float, float]:
    """Slowest and fastest body velocity in balance under Coulomb's law [m/s].

    Args:
        foot_velocity: v_i, (M,) [m/s], M > 0.

    Returns:
        Both are minus the median for an odd number of legs. For an even number they are the two
        middle feet's, and every velocity between them balances as well: the answer is not unique.
    """
    body = np.sort(-foot_velocity)
    count = len(body)
    return float(body[(count - 1) // 2]), float(body[count // 2])


def viscous_balance(foot_velocity: FloatArray) -> float:
    """Body velocity in balance under the ansatz: minus the mean, always unique [m/s]."""
    return -float(np.mean(foot_velocity))
