"""A horizontal force that wanders: gusts, or a hand on the robot."""

import numpy as np

from model.values.arrays import FloatArray
from sim_hw.plant.parameters import Disturbance


class Gusts:
    """A first-order random process, the same for the same seed.

    Args:
        disturbance: Its size and correlation time.
        dt_s: Step.
        seed: Seed.
    """

    def __init__(self, disturbance: Disturbance, dt_s: float, seed: int) -> None:
        self.blow = disturbance.gust > 0
        self._keep = np.exp(-dt_s / disturbance.gust_time)
        self._kick = disturbance.gust * np.sqrt(1 - self._keep**2)
        self._random = np.random.default_rng([seed, 0x67])
        self._force = np.zeros(2)

    def next(self) -> FloatArray:
        """Return the force in the next step, world x and y, (2,) [N]."""
        self._force = self._keep * self._force + self._kick * self._random.standard_normal(2)
        return self._force
