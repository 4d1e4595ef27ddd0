"""Random and degenerate poses of robots with many legs."""

from collections.abc import Iterator

import numpy as np

from model.values.arrays import FloatArray

KINDS = (
    "random", "flat", "lattice", "polygon", "line", "pairs", "stiff", "edge", "far", "tilted",
)  # fmt: skip


def pose(kind: str, count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
    """Feet (N, 3) [m] and stiffness (N,) [N/m]."""
    feet = rng.uniform([-0.3, -0.3, -0.16], [0.3, 0.3, -0.14], (count, 3))
    stiffness = rng.uniform(1000.0, 4000.0, count)
    if kind == "flat":
        feet[:, 2] = -0.15
    elif kind == "lattice":  # ties everywhere: heights, places and stiffness on a coarse grid
        feet = np.round(feet * [10.0, 10.0, 200.0]) / [10.0, 10.0, 200.0]
        stiffness[:] = 2000.0
    elif kind == "polygon":
        angle = 2 * np.pi * np.arange(count) / count
        feet[:, 0], feet[:, 1] = 0.3 * np.cos(angle), 0.3 * np.sin(angle)
        feet[:, 2] = -0.15 - 0.01 * (np.arange(count) % 2)
        stiffness[:] = 2000.0
    elif kind == "line":  # all feet in a row below the centre of mass
        feet[:, 1] = 0.0
    elif kind == "pairs":  # feet that share places
        feet[count // 2 :] = feet[: count - count // 2]
    elif kind == "stiff":
        stiffness = 10.0 ** rng.uniform(2, 6, count)
    elif kind == "edge":  # the centre of mass near or beyond the edge of the feet
        feet[:, 0] += 0.28
    elif kind == "far":  # many feet never come down
        feet[:, 2] = -0.15 + rng.exponential(0.05, count)
    elif kind == "tilted":
        feet[:, 2] = -0.15 + 0.3 * feet[:, 0] - 0.2 * feet[:, 1]
    return feet, stiffness


def poses(total: int, seed: int) -> Iterator[tuple[str, FloatArray, FloatArray]]:
    """Yield poses of every kind with 3 to 50 legs, few legs more often than many."""
    rng = np.random.default_rng(seed)
    for i in range(total):
        kind = KINDS[i % len(KINDS)]
        count = 3 + int(47 * rng.random() ** 3 + 0.5)
        yield kind, *pose(kind, count, rng)
