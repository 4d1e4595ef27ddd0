"""Random and degenerate frames for Coulomb's law: feet, speeds, loads."""

import numpy as np

from model.values.arrays import FloatArray
from model.values.legs import FootMotion

KINDS = ("random", "rigid", "nearly", "ahead", "grid", "mixed", "one", "uneven", "turning", "row")


def frames(kind: str, count: int, legs: int, rng: np.random.Generator) -> FootMotion:
    """``count`` frames of a robot whose feet stand about a circle, (F, N, 3)."""
    angle = 2 * np.pi * (np.arange(legs) + 0.5) / legs
    ring = 0.3 * np.stack([np.cos(angle), np.sin(angle), -0.5 * np.ones(legs)], axis=1)
    feet = ring + rng.uniform([-0.05, -0.05, -0.004], [0.05, 0.05, 0.004], (count, legs, 3))
    speed = rng.normal(scale=0.1, size=(count, legs, 3))
    twist = rng.normal(scale=[0.1, 0.1, 0.3], size=(count, 3))
    carried = np.stack(
        [
            twist[:, None, 0] - twist[:, None, 2] * feet[..., 1],
            twist[:, None, 1] + twist[:, None, 2] * feet[..., 0],
            np.zeros((count, legs)),
        ],
        axis=2,
    )
    if kind == "rigid":  # a body that could roll over the ground without any slip
        speed = carried
    elif kind == "nearly":
        speed = carried + 10.0 ** rng.uniform(-12, -3, (count, 1, 1)) * speed
    elif kind == "ahead":  # a straight walk: every foot along x
        speed[..., 1] = 0.0
    elif kind == "grid":  # ties: equal loads, few speeds, along x
        feet = np.broadcast_to(ring, feet.shape).copy()
        speed = np.round(speed * [20.0, 0.0, 0.0]) / 20.0
    elif kind == "mixed":  # some feet move together, some do not
        together = rng.random((count, legs, 1)) < 0.6
        speed = np.where(together, carried, speed)
    elif kind == "one":  # a single foot moves against all others
        speed = carried.copy()
        speed[:, 0] += rng.normal(scale=0.1, size=(count, 3))
    elif kind == "uneven":  # speeds of very different size
        speed *= 10.0 ** rng.uniform(-6, 0, (count, legs, 1))
    elif kind == "turning":  # opposite sides push against each other
        speed = np.zeros_like(speed)
        speed[..., 0] = np.sign(feet[..., 1]) * 0.1
    elif kind == "row":  # feet almost in a line
        feet[..., 1] *= 1e-3
    speed[..., 2] = 0.0
    return FootMotion(feet, speed)


def trouble(
    feet: FloatArray, load: FloatArray, mu: FloatArray, slip: FloatArray, force: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """What is wrong with answers, as shares of the weight: balance, cone, dissipation, (F,) each.

    The last is sum mu N |slip| + F . slip over its scale: 0 exactly where each sliding foot is braked
    by the whole of mu N straight against its slip.
    """
    weight = load.sum(axis=1)
    arm = np.sqrt((feet[..., :2] ** 2).sum(axis=2).mean(axis=1))
    moment = (feet[..., 0] * force[..., 1] - feet[..., 1] * force[..., 0]).sum(axis=1) / arm
    balance = np.maximum(np.abs(force.sum(axis=1)).max(axis=1), np.abs(moment)) / weight
    limit = mu * load
    size = np.linalg.norm(force, axis=2)
    cone = np.maximum(size - limit, 0.0).max(axis=1) / weight
    speed = np.linalg.norm(slip, axis=2)
    power = limit * speed + (force * slip).sum(axis=2)
    scale = (limit * speed).sum(axis=1)
    lost = np.abs(power).max(axis=1) / np.where(scale > 0, scale, 1.0)
    return balance, cone, lost
