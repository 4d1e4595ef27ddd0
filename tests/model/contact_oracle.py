"""Foot loads by a method that shares nothing with ours: a least-distance program by NNLS.

The loads are the minimum of sum F^2 / (2 K) + q F (the energy's dual) with F >= 0 and the three balances.
With y = F / sqrt K + sqrt K q that is the shortest y in a slice of a shifted cone, which Lawson and
Hanson (Solving Least Squares Problems, 1974, ch. 23) reduce to one nonnegative least squares problem.
"""

import numpy as np
from scipy.optimize import nnls

from model.values.arrays import FloatArray

RANK = 1e-10


def oracle_loads(feet: FloatArray, stiffness: FloatArray, load: float) -> FloatArray | None:
    """Loads, (N,) [N]; None if no loads balance (the robot tips)."""
    root = np.sqrt(stiffness)
    size = max(float(np.abs(feet[:, :2]).max()), 1e-12)
    rows = np.stack([np.ones(len(feet)), feet[:, 0] / size, feet[:, 1] / size]) * root
    right = np.array([load, 0.0, 0.0]) + rows @ (root * feet[:, 2])
    left, values, across = np.linalg.svd(rows, full_matrices=True)
    rank = int((values > RANK * values[0]).sum())
    along = left.T @ right
    if np.abs(along[rank:]).max(initial=0.0) > 1e-9 * load:
        return None  # a balance that no loads can meet
    shortest = across[:rank].T @ (along[:rank] / values[:rank])
    free = across[rank:].T  # (N, N - rank)
    least = root * feet[:, 2] - shortest
    active = np.zeros(len(feet), dtype=bool)
    if free.shape[1] == 0:
        if (least > 1e-9 * np.linalg.norm(shortest)).any():
            return None
    else:
        unit = max(float(np.abs(least).max()), 1e-300)
        matrix = np.vstack([free.T, least / unit])
        multipliers, distance = nnls(matrix, np.append(np.zeros(free.shape[1]), 1.0), maxiter=2000)
        if distance < 1e-9:
            return None
        active = multipliers > 0
    # the feet that are up are known: solve the balance of the others once more, exactly
    down = ~active
    pressed = rows[:, down]
    sums = right - rows[:, active] @ (root * feet[:, 2])[active]
    y = np.linalg.pinv(pressed, rcond=RANK) @ sums
    loads = np.zeros(len(feet))
    loads[down] = root[down] * (y - (root * feet[:, 2])[down])
    return loads
